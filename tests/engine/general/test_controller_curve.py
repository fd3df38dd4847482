"""What a controller commands by a curve, how it follows the angle, and how far until that changes: by hand.

End stops of 4 at -2 and 5, and a wall of 2 below 0; numbers are small whole ones, so that all is exact.
"""

from math import inf, pi
from typing import Any

import pytest

from hknob_cli.engine.general.controller import (
    bends,
    command,
    count_gap,
    curve_wanted,
    edge_gap,
    follows,
    goes_on,
    is_sent,
    sent_gap,
    slopes,
    table_size,
)
from hknob_cli.engine.general.torque_curve import (
    DETENT,
    FAR,
    HEAD,
    HIGH,
    HIGHEST,
    LOW,
    LOWEST,
    SHAPE,
    SINE,
    SPACING,
    STOP,
    TRIANGLE,
)

from .test_controller import wall


def curve(**numbers: float) -> list[float]:
    values = [0.0] * HEAD
    places = {"stop": STOP, "low": LOWEST, "high": HIGHEST, "detent": DETENT, "spacing": SPACING, "shape": SHAPE}
    for name, value in {"low": -inf, "high": inf, "spacing": 1.0, **numbers}.items():
        values[places[name]] = value
    values[LOW], values[HIGH], values[FAR] = -inf, inf, 8.0
    return values


STOPS = curve(stop=4.0, low=-2.0, high=5.0)


def stopped(**more: Any) -> Any:
    return wall(analog=1.0, curve=STOPS, **{"kappa": 2.0, **more})


# Angle, the one before, virtual damping; torque, slope, room, steepest slope, damping where it acts.
WANTED = [
    ((6.0, 6.0, 0.0), (-4.0, -4.0, 1.0, 4.0, 0.0)),
    ((6.0, 4.0, 0.5), (-4.0, -4.0, 1.0, 4.0, 0.0)),  # damping acts inside the wall
    ((4.0, 4.0, 0.0), (0.0, 0.0, 1.0, 0.0, 0.0)),
    ((0.5, 0.5, 0.0), (0.0, 0.0, 0.5, 0.0, 0.0)),  # to the wall's edge
    ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0, 0.0)),
    ((-0.5, -0.5, 0.0), (1.0, -2.0, 0.5, 2.0, 0.0)),
    ((-1.5, -1.5, 0.0), (3.0, -2.0, 0.5, 2.0, 0.0)),
    ((-3.0, -3.0, 0.0), (10.0, -6.0, 1.0, 6.0, 0.0)),
    ((-3.0, -2.5, 0.5), (10.25, -6.0, 1.0, 6.0, 0.5)),
]


@pytest.mark.parametrize(("at", "wanted"), WANTED)
def test_what_is_wanted_how_it_follows_and_how_far(at: tuple[float, float, float], wanted: tuple[float, ...]) -> None:
    shown, before, damping = at
    u, slope, room, _, acting = wanted
    one = stopped(damping=damping)
    assert curve_wanted(shown, before, one) == wanted
    assert command(shown, before, one) == u
    assert slopes(shown, before, one) == (slope - acting, acting)
    assert follows(shown, one) == (slope != 0.0)
    assert edge_gap(shown, shown, before, one) == count_gap(shown, one) == room
    assert not goes_on(1.0, shown, one)
    assert not goes_on(-1.0, shown, one)


@pytest.mark.parametrize(("parts", "room"), [({}, 0.5), ({"kappa": 0.0}, 2.5), ({"kappa": 0.0, "damping": 0.5}, 0.5)])
def test_an_edge_at_0_is_there_for_a_wall_alone(parts: dict[str, float], room: float) -> None:
    assert curve_wanted(0.5, 0.5, stopped(**parts))[2] == room


def test_damping_alone_follows_the_angle() -> None:
    one = stopped(kappa=0.0, damping=0.5)
    assert follows(-0.5, one)
    assert not follows(0.5, one)
    assert slopes(-0.5, -0.25, one) == (-0.5, 0.5)


# Of 10.25 at -3, whose slope is at most 6, and 1 more by the damping's two readings: what is sent of it.
LIMITS: list[tuple[dict[str, float], bool, float]] = [
    ({"limit": 12.0}, True, 1.75 / 7.0),
    ({"limit": 10.25}, False, 0.0),
    ({"limit": 9.25}, False, 1.0 / 7.0),
    ({"band": 10.25}, True, 0.0),
    ({"band": 9.5}, True, 0.75 / 7.0),
    ({"band": 11.0}, False, 0.75 / 7.0),
    ({"step": 4.0}, False, 0.25 / 7.0),  # from 10 on it is 12
    ({"step": 40.0}, False, 9.75 / 7.0),
]


@pytest.mark.parametrize(("parts", "sent", "gap"), LIMITS)
def test_what_is_sent_ends_a_slope(parts: dict[str, float], sent: bool, gap: float) -> None:
    one = stopped(damping=0.5, **parts)
    assert is_sent(10.25, one) == is_sent(-10.25, one) == sent
    assert sent_gap(10.25, 7.0, one) == pytest.approx(gap)
    assert edge_gap(-3.0, -3.0, -2.5, one) == pytest.approx(min(gap, 1.0))
    assert slopes(-3.0, -2.5, one) == ((-6.5, 0.5) if sent else (0.0, 0.0))
    if sent and "band" not in parts:
        assert follows(-3.0, one)
    if parts.get("band") == 11.0 or "step" in parts:
        assert not follows(-3.0, one)


def test_what_follows_is_judged_without_a_speed() -> None:
    """A knob that stands: 10 at -3."""
    assert follows(-3.0, stopped(damping=0.5, band=10.0))
    assert not follows(-3.0, stopped(damping=0.5, band=10.1))
    assert not follows(-3.0, stopped(damping=0.5, limit=10.0))


def test_only_a_sine_bends() -> None:
    sine, triangle = (curve(detent=3.0, spacing=4.0, shape=shape) for shape in (SINE, TRIANGLE))
    assert bends(stopped()._replace(curve=sine)) == pytest.approx(3.0 * (2.0 * pi / 4.0) ** 2)
    assert bends(stopped()._replace(curve=triangle)) == 0.0
    assert bends(stopped()._replace(curve=sine, step=0.1)) == 0.0
    assert bends(wall()) == 0.0


def test_size_of_what_is_rounded() -> None:
    """Of 4 (5 - 6) the 20 and 24, and of the angles 6 and 8 four times."""
    assert table_size(6.0, stopped()) == 4.0 * (5.0 + 6.0) + 4.0 * (6.0 + 8.0)


def test_a_wall_that_is_no_spring_follows_nothing() -> None:
    one = wall(analog=1.0)
    assert follows(-1.0, one)
    assert not follows(1.0, one)
    assert not follows(-1.0, one._replace(kappa=0.0))
    assert not follows(-1.0, wall())


def test_a_soft_spring_comes_to_its_limit_late() -> None:
    assert edge_gap(-1.5, -1.5, -1.5, stopped(kappa=0.25, limit=0.4)) == pytest.approx(0.025 / 0.25)
