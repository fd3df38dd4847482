"""The region in which a knob with friction keeps its reading, on its margins."""

from math import sqrt

import pytest

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.controller import Controller, read
from hknob_cli.engine.general.inner_region import come_to_rest, hold_zone, keeps_reading

from .test_standstill_margins import FINGER, LAGGING, WALL, body

UNIT = 64.0 * EPSILON
# Behind each other 2 and 8, at half the knob's inertia: 2 * 8 / (0.5 * 2 + 8) = 16 / 9.
CHAIN = FINGER._replace(order=4, lag=0.0, ratio=0.5, push=1.0, drive=-1.0, friction=0.25, shift=0.5, reach=1.0)
STIFF = 16.0 / 9.0
CONTINUOUS = WALL._replace(analog=1.0)


def keeps(
    z: list[float], one: Body, wall: Controller = WALL, delay: int = 0, u: float | None = None
) -> tuple[bool, float, list[float]]:
    shown = read(z[0], wall)
    orbit, away = [7.0] * one.order, [7.0] * one.order
    push = u if u is not None else (-wall.kappa * shown if shown < 0.0 else 0.0)
    return *keeps_reading(z, shown, push, one, wall, delay, orbit, away), orbit


@pytest.mark.parametrize("shift", [-0.5, 0.5])
@pytest.mark.parametrize("u", [-3.0, 3.0])
def test_the_zone_of_a_finger_is_narrowed_by_all_that_is_rounded(shift: float, u: float) -> None:
    """64 units of command, bias, friction, and what the springs pull at the neutral angle."""
    stiffness, low, high = hold_zone(u, 0.0, CHAIN._replace(shift=1e6 * shift), WALL)
    middle = (u - 1.0) / STIFF - 1e6 * shift
    slack = UNIT * (3.0 + 1.0 + 0.25 + STIFF * 5e5)
    assert stiffness == pytest.approx(STIFF, rel=1e-15)
    assert 0.5 * (low + high) == pytest.approx(middle, rel=1e-12)
    assert high - low == pytest.approx((0.5 - 2.0 * slack) / STIFF, abs=2.0 * abs(middle) * EPSILON)
    _, low, high = hold_zone(-3e6, 0.0, CHAIN._replace(shift=0.0), WALL)
    assert high - low == pytest.approx((0.5 - 2.0 * UNIT * 3e6) / STIFF, abs=4e6 * EPSILON)


@pytest.mark.parametrize("missing", ["pad_stiffness", "finger_stiffness"])
def test_a_finger_that_one_spring_does_not_hold_has_no_zone(missing: str) -> None:
    _, low, high = hold_zone(0.0, 0.0, CHAIN._replace(**{missing: 0.0}), WALL)
    assert low > high
    _, low, high = hold_zone(1.0, -1.0, CHAIN._replace(**{missing: 0.0}), CONTINUOUS)  # which the wall does not replace
    assert low > high
    for stiffness in (1.0, 2.0):
        _, low, high = hold_zone(0.0, 0.0, CHAIN._replace(**{missing: stiffness}), WALL)
        assert low < high


def test_a_finger_settles_behind_the_knob_if_anything_damps_it() -> None:
    """At -0.5 the wall's 1 is the bias's; the finger is where its part of the springs, 16 / 9 / 2 of nothing, is."""
    at_rest = [-0.5, 0.0, 0.0, 0.0]
    found, gap, orbit = keeps(at_rest, CHAIN)
    assert (found, gap) == (True, pytest.approx(0.5))
    assert orbit == at_rest
    off = CHAIN._replace(shift=0.6)  # the pull of a tenth of a count is less than the friction
    assert keeps(at_rest, off)[2] == [-0.5, 0.0, pytest.approx(STIFF * 0.1 / 2.0), 0.0]
    for pad, finger, settles in (
        (0.25, 0.25, True),
        (0.25, 0.0, True),
        (0.0, 0.25, True),
        (0.5, 0.5, True),
        (0.0, 0.0, False),
    ):
        assert keeps(at_rest, CHAIN._replace(pad_damping=pad, finger_damping=finger))[0] is settles
    assert keeps([-0.5, 0.4, 0.0, 0.4], CHAIN)[0]
    assert not keeps([-0.5, 0.6, 0.0, 0.6], CHAIN)[0]


def test_a_lag_settles_at_the_command() -> None:
    slow = LAGGING._replace(lag=0.5, reach=1.0, beta=1.0, drive=-1.5, push=1.5, friction=0.1)
    found, gap, orbit = keeps([-0.5, 0.0, 1.0], slow)
    assert (found, gap, orbit) == (True, pytest.approx(0.5), [-0.5, 0.0, 1.0])
    for late, settles in ((0.24, True), (0.26, False)):
        assert keeps([-0.5, 0.0, 1.0 + late], slow)[0] is settles


def test_the_wall_of_a_continuous_sensor_is_a_spring_beside_the_hand() -> None:
    """1 and 0.25 hold it from -2.08 to -1.92; the wall's edge is 2.08 counts from the farther end."""
    one = body(alpha=0.5, beta=0.25, friction=0.1, push=2.5)
    for far, speed in ((2.07, 0.0), (2.09, 0.0), (0.0, 2.32), (0.0, 2.33), (1.5, 1.5), (1.5, 1.7), (1.5, -1.7)):
        z = [-2.08 - far, speed]
        found, gap, orbit = keeps(z, one, CONTINUOUS)
        assert orbit[0] == pytest.approx(-2.08)
        assert gap == pytest.approx(2.08)
        assert found is (sqrt(far * far + speed * speed / 1.25) < 2.08)
    slow = one._replace(order=3, lag=0.5)
    assert not keeps([-2.0, 0.0, 2.0], slow, CONTINUOUS, u=2.0)[
        0
    ]  # a command that follows late is none that dissipates


def test_the_reading_is_kept_only_beyond_all_roundings() -> None:
    """Held where it stands, as far above an edge as 64 units of 1 and twice its place; 1000 counts deep, too."""
    for level in (0.0, -1000.0):
        one = body(beta=1e-9, friction=0.5, push=-level)
        least = UNIT * (1.0 + 2.0 * abs(level))
        for part, settles in ((0.97, False), (1.03, True)):
            z = [level + part * least, 0.0]
            assert keeps(z, one)[0] is settles
    one, gap = body(beta=1.0, friction=0.1), UNIT
    for _ in range(5):
        gap = UNIT * ((1.0 + gap) + gap)
    assert not keeps([gap, 0.0], one)[0]
    assert keeps([gap + 2.0**-90, 0.0], one)[0]


def test_where_it_ends_is_told_of_second_order_under_a_steady_command_alone() -> None:
    """Elsewhere what `keeps_reading` has left stands."""
    slow, one = LAGGING._replace(lag=0.5, reach=1.0), body(alpha=0.5, beta=0.25, friction=0.1, push=2.5)
    for z, bodied, wall in (([-0.5, 0.0, 1.0], slow, WALL), ([-2.0, 0.3], one, CONTINUOUS)):
        orbit = [7.0] * bodied.order
        come_to_rest(z, read(z[0], wall), 1.0, bodied, wall, orbit)
        assert orbit == [7.0] * bodied.order
