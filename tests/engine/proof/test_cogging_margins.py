"""Cogging on its margins: the triangle, energies on one slope, and what can be told of a step, of dyadic numbers."""

from math import asin, asinh, cos, cosh, inf, nextafter, pi, sin, sinh, sqrt
from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general import cogging
from hknob_cli.engine.general.body import Body, norm
from hknob_cli.engine.general.cogging import (
    FALLEN,
    FREE,
    RISEN,
    TURNED,
    cog_number,
    cog_pull,
    energy_apart,
    far_apart,
    far_around,
    gap_apart,
    hold_stiffness,
    is_stable,
    middle_of,
    own_stiffness,
    pull_on,
    reach_on,
    room_on,
    slope_at,
    spring_of,
)
from hknob_cli.engine.general.slopes import over, roll, told
from hknob_cli.scene.increments import halves
from tests.engine.general.cogs import by_hand

from .test_standstill_margins import FINGER

# Slopes of 1/4, 8 counts long: the stable one about a place of rest at -3, the next one about 5.
COGS = [0.25, 8.0, -3.0, 1.0, 0.5, 11.0]
PLAIN = by_hand(alpha=0.5, beta=0.25, cogs=COGS)._replace(reach=2.0)
FIRM = PLAIN._replace(beta=1.0, reach=1.0)
LAGGED = PLAIN._replace(
    order=3, lag=0.25, friction=2.0, drive=-1.0, matrices=[0.0, 1.0, 0.0, -0.25, -0.5, 1.0, 0.0, 0.0, -0.25]
)
BEHIND = FINGER._replace(order=4, lag=0.0, reach=1.0, cogs=COGS, matrices=[*[0.0] * 6, -2.0, -0.25], drive=-1.0)


def test_the_triangle_has_corners_every_eight_counts() -> None:
    for x, slope, pull in (
        (-3.0, 0.0, 0.0),
        (-2.0, 0.0, -0.25),
        (-6.0, 0.0, 0.75),
        (-7.0, 0.0, 1.0),  # a corner belongs to the slope above it
        (-7.0 - 2.0**-48, -1.0, 1.0),
        (1.0 - 2.0**-50, 0.0, -1.0),
        (1.0, 1.0, -1.0),
        (2.0, 1.0, -0.75),
        (5.0, 1.0, 0.0),
        (7.0, 1.0, 0.5),
        (13.0, 2.0, 0.0),
        (15.0, 2.0, -0.5),
        (-11.0, -1.0, 0.0),
        (-10.0, -1.0, 0.25),
    ):
        assert slope_at(x, COGS) == slope
        assert cog_pull(COGS, x) == pytest.approx(pull, abs=1e-15)
        assert pull_on(x, slope, COGS) == cog_pull(COGS, x)
        assert middle_of(slope, COGS) == -3.0 + 8.0 * slope
        assert is_stable(slope) == (slope in (0.0, 2.0))
        assert spring_of(slope, COGS) == (0.25 if slope in (0.0, 2.0) else -0.25)
        assert room_on(x, slope, COGS) == 4.0 - abs(x - (-3.0 + 8.0 * slope))
    assert room_on(6.0, 0.0, COGS) == -5.0
    assert pull_on(2.0, 0.0, COGS) == -1.25  # of a slope that goes on
    assert cog_pull(None, 1.0) == 0.0
    assert [cog_number(COGS, k) for k in range(6)] == COGS
    assert cog_number(None, 3) == 0.0


def test_springs_of_hand_and_slope_hold_the_knob_together(monkeypatch: pytest.MonkeyPatch) -> None:
    """A sixteen-fold rounding of the hand's is taken off where they may cancel, and nowhere else."""
    assert own_stiffness(PLAIN) == 0.25
    assert own_stiffness(PLAIN._replace(reach=inf)) == 0.0
    assert own_stiffness(PLAIN._replace(reach=0.5)) == 4.0
    assert hold_stiffness(None, 0.0, PLAIN) == inf
    assert hold_stiffness(COGS, 0.0, PLAIN) == 0.5
    assert hold_stiffness(COGS, 0.0, PLAIN._replace(reach=inf)) == 0.25
    assert hold_stiffness(COGS, 2.0, PLAIN._replace(reach=inf)) == -0.25
    assert hold_stiffness(COGS, 2.0, FIRM) == 0.75 - 16.0 * EPSILON
    assert hold_stiffness(COGS, 2.0, PLAIN) == -4.0 * EPSILON
    steep = [4.0, *COGS[1:]]
    assert hold_stiffness(steep, 0.0, FIRM) == 5.0
    assert hold_stiffness(steep, 2.0, FIRM) == -3.0 - 16.0 * EPSILON


@pytest.fixture
def exact(monkeypatch: pytest.MonkeyPatch) -> None:
    """No roundings."""
    monkeypatch.setattr(cogging, "EPSILON", 0.0)


def test_the_energy_of_a_difference_has_the_spring_of_its_slope(exact: None) -> None:
    """1.5² of the speed, and a quarter, or one, of 2² counts: a quarter more, or less, for the slope."""
    dz = [2.0, 1.5]
    for one, x, square in ((PLAIN, 0.0, 4.25), (FIRM, 0.0, 7.25), (FIRM, 2.0, 5.25), (FIRM, -9.0, 5.25)):
        for first in (2.0, -2.0):
            assert energy_apart(COGS, [first, 1.5], x, one) == sqrt(square)
        hold = hold_stiffness(COGS, x, one)
        assert far_apart(COGS, dz, x, one) == sqrt(square) / sqrt(hold)
    assert far_apart(COGS, [2.0, 0.0], 2.0, FIRM) == 2.0
    late = LAGGED._replace(beta=1.0, reach=1.0)
    for wait in (0.5, -0.5):  # in a quarter of a sample's lag it still adds twice
        assert energy_apart(COGS, [2.0, 1.5, wait], 0.0, late) == pytest.approx(sqrt(7.25) + 2.0, rel=1e-15)
        assert energy_apart(COGS, [2.0, 1.5, wait], 2.0, late) == pytest.approx(sqrt(5.25) + 2.0, rel=1e-15)
        quick = late._replace(lag=4.0)
        assert energy_apart(COGS, [2.0, 1.5, wait], 0.0, quick) == pytest.approx(sqrt(7.25) + 0.125, rel=1e-15)
    # Where no springs hold the knob there is no energy; it is 0, and not below.
    assert energy_apart([4.0, *COGS[1:]], [2.0, 1.5], 2.0, FIRM) == 0.0
    # Of other numbers than the first two it is as without cogging.
    behind = [0.0, 0.5, 0.75, -0.25]
    assert energy_apart(COGS, behind, 0.0, BEHIND) == pytest.approx(norm(behind, BEHIND), rel=1e-15)


def test_an_energy_counts_its_roundings(monkeypatch: pytest.MonkeyPatch) -> None:
    """64 units of both parts, which may cancel; from below at 60 digits."""
    monkeypatch.setattr(cogging, "EPSILON", 2.0**-10)
    for x, square in ((0.0, 7.25), (2.0, 5.25)):
        for first in (2.0, -2.0):
            found = energy_apart(COGS, [first, 1.5], x, FIRM)
            assert found == sqrt(square + 64.0 * 2.0**-10 * (6.25 + 1.0))
    steep = [4.0, *COGS[1:]]
    assert energy_apart(steep, [2.0, 1.5], 2.0, FIRM) == sqrt(64.0 * 2.0**-10 * (6.25 + 16.0))


def test_two_motions_are_apart_as_far_as_springs_allow(exact: None) -> None:
    dz = [2.0, 1.5]
    assert far_apart(None, dz, 0.0, FIRM) == norm(dz, FIRM)
    assert far_apart(None, dz, 0.0, PLAIN) == 2.0 * norm(dz, PLAIN)
    assert far_apart(COGS, dz, 2.0, PLAIN) == inf  # a spring of 0
    assert far_apart(COGS, dz, 2.0, PLAIN._replace(reach=4.0)) == inf
    assert far_apart(COGS, dz, 2.0, PLAIN._replace(beta=0.5, reach=sqrt(2.0))) < 9.0
    assert reach_on(None, 0.0, PLAIN) == 2.0
    assert reach_on(COGS, 0.0, PLAIN) == 1.0 / sqrt(0.5)
    assert reach_on(COGS, 2.0, FIRM) == 1.0 / sqrt(0.75)
    assert reach_on([0.75, *COGS[1:]], 2.0, FIRM) == 2.0
    for reach, hold in ((2.0, 0.5), (4.0, 0.3125), (inf, 0.25)):  # not held there: as on a stable slope
        assert reach_on(COGS, 2.0, PLAIN._replace(reach=reach)) == 1.0 / sqrt(hold)
    assert gap_apart(None, dz, FIRM) == norm(dz, FIRM)
    for first in (2.0, -2.0):
        assert gap_apart(COGS, [first, 1.5], FIRM) == (2.5 + 1.0) / sqrt(1.25)
        assert gap_apart(COGS, [first, 1.5], PLAIN) == (norm(dz, PLAIN) + 1.0) / sqrt(0.5)
        assert gap_apart(COGS, [first, 1.5], PLAIN._replace(reach=inf)) == (norm(dz, PLAIN) + 1.0) / 0.5


def test_motions_around_an_orbit_are_apart_by_the_energy_of_a_stable_slope_where_nothing_holds_it(exact: None) -> None:
    """Where springs hold it that is no more than the energy of the slope itself says."""
    for one, x, holds in ((FIRM, 0.0, True), (FIRM, 2.0, True), (PLAIN, 0.0, True), (PLAIN, 2.0, False),
                          (PLAIN._replace(reach=4.0), 2.0, False)):  # fmt: skip
        assert (hold_stiffness(COGS, x, one) > 0.0) == holds
        for dz in ([2.0, 1.5], [-2.0, 1.5], [0.0, 1.0], [1.0, 0.0]):
            near = sqrt(dz[1] ** 2 + (one.beta + 0.25) * dz[0] ** 2) / sqrt(own_stiffness(one) + 0.25)
            if holds:
                assert far_around(COGS, dz, x, one) == far_apart(COGS, dz, x, one)
                if one is FIRM:
                    assert far_around(COGS, dz, x, one) >= near * (1.0 - 1e-15)
            else:
                assert far_apart(COGS, dz, x, one) == inf
                assert far_around(COGS, dz, x, one) == gap_apart(COGS, dz, one)
                assert near * (1.0 - 1e-15) <= far_around(COGS, dz, x, one) <= sqrt(2.0) * near * (1.0 + 1e-15)


# What can be told of a step.

SPEED, HOLD = 0.5, 1.0


def can_tell(
    z: list[float],
    rates: list[float],
    mode: int,
    h: float,
    size: float,
    *,
    slope: float = 0.0,
    body: Body = PLAIN,
    u: float = 0.0,
) -> bool:
    return bool(told(z, u, [*rates, *[9.0] * body.order], slope, mode, h, size, body))


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_corner_is_passed_once_by_a_speed_that_keeps_its_sign(side: float) -> None:
    """A speed of 1/2 falls by 1 in a sample: in half of one it may turn, a hair less and it does not."""
    for x in (-3.0, 0.99, -6.99, 2.0):
        assert can_tell([x, 0.0], [side * nextafter(0.5, 1.0), 0.0], FREE, 0.5, 1.0)
        assert can_tell([x, 0.0], [side * 0.5, 0.0], FREE, 0.49, 1.0)
        assert can_tell([x, 0.0], [side * 0.5, 0.0], FREE, 0.5, 0.99)
    for x in (2.0, -8.0):  # beyond a corner nothing is told otherwise
        for speed, size in ((0.5, 1.0), (0.0, 1.0), (-0.5, 1.0), (0.0, 5e-324)):
            assert not can_tell([x, 0.0], [speed, 0.0], FREE, 0.5, size)
    assert not can_tell([0.8, 0.0], [0.5, 0.0], FREE, 0.5, 1.0)
    # 3/8 from the corner: a quarter by its speed, an eighth by what bounds its acceleration.
    for off, clear in ((0.375, False), (0.376, True)):
        assert can_tell([-3.0 + side * (4.0 - off), 0.0], [side * 0.5, 0.0], FREE, 0.5, 1.0) == clear
    # Away from it an eighth is enough.
    for off, clear in ((0.125, False), (0.126, True)):
        assert can_tell([-3.0 + side * (4.0 - off), 0.0], [-side * 0.5, 0.0], FREE, 0.5, 1.0) == clear
    # Of another stable slope too.
    for off, clear in ((0.375, False), (0.376, True)):
        assert can_tell([13.0 + side * (4.0 - off), 0.0], [side * 0.5, 0.0], FREE, 0.5, 1.0, slope=2.0) == clear


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_on_an_unstable_slope_what_bounds_rates_grows(side: float) -> None:
    """By exp(h/2) at most; that is told up to half of it, and taken as 1 / (1 - h/2): in half a sample 4/3."""
    pace = 4.0 / 3.0
    for off, clear in ((0.25 + 0.125 * pace - 1e-9, False), (0.25 + 0.125 * pace + 1e-9, True)):
        assert can_tell([5.0 + side * (4.0 - off), 0.0], [side * 0.5, 0.0], FREE, 0.5, 1.0, slope=1.0) == clear
    for speed, clear in ((0.5 * pace - 1e-9, False), (0.5 * pace + 1e-9, True)):
        assert can_tell([5.0 + side * 3.8, 0.0], [side * speed, 0.0], FREE, 0.5, 1.0, slope=1.0) == clear
    for h, clear in ((1.0, True), (1.001, False)):
        assert can_tell([5.0, 0.0], [side * 9.0, 0.0], FREE, h, 1.0, slope=1.0) == clear
        assert can_tell([-3.0, 0.0], [side * 9.0, 0.0], FREE, h, 1.0)
        steep = PLAIN._replace(cogs=[1.0, 8.0, -3.0, 4.0, 1.0, 11.0])
        assert can_tell([5.0, 0.0], [side * 9.0, 0.0], FREE, 0.5 * h, 1.0, slope=1.0, body=steep) == clear


@pytest.mark.parametrize("mode", [FREE, 1, -1])
def test_nothing_becomes_of_a_knob_that_does_not_move(mode: int) -> None:
    """However long, and wherever it is: a torque that is left by roundings alone moves nothing."""
    for x, slope in ((-3.0, 0.0), (2.0, 0.0), (1.0, 1.0), (5.0, 1.0)):
        for h in (2.0**-52, 1.0, 9.0):
            assert can_tell([x, 0.0], [0.0, 0.0], mode, h, 0.0, slope=slope)
    assert not can_tell([2.0, 0.0], [0.0, 0.0], mode, 1.0, 1.0)


@pytest.mark.parametrize("way", [1, -1])
def test_a_knob_that_slides_meets_corners_ahead_alone(way: int) -> None:
    """And turns where its speed may change its sign: by 1 + 1/2 times the rates' size at most, in the second rate."""
    for side in (1, -1):
        z = [-3.0 + side * 3.9, way * 9.0]
        assert can_tell(z, [way * 0.5, 0.0], way, 0.5, 1.0) == (side != way)
    # Of a speed v: v - 3/4 h² > 0; or a rate above 3/2 h; or both.
    h = 0.5
    for v, rate, clear in (
        (0.1875, 0.0, False),
        (0.1876, 0.0, True),
        (0.1875, 0.75, False),
        (0.0, 0.7501, True),
        (0.0, -0.7501, True),
        (0.0, 0.75, False),
        (0.5625, -0.75, False),
        (0.5626, -0.75, True),
        (0.3, -0.75, False),
    ):
        assert can_tell([-3.0, way * v], [0.0, way * rate], way, h, 1.0) == clear
        assert can_tell([-3.0, way * v], [0.0, way * rate], FREE, h, 1.0)
    twice = by_hand(alpha=1.0, beta=1.0, cogs=[1.0, 8.0, -3.0, 4.0, 1.0, 11.0])
    for rate, clear in ((1.5, False), (1.501, True)):
        assert can_tell([-3.0, 0.0], [0.0, way * rate], way, 0.5, 1.0, body=twice) == clear
    # What a lag still changes, an eighth, counts beside that.
    for last in (0.125, -0.125):
        for rate, clear in ((0.75 + 0.0625, False), (0.8126, True)):
            assert can_tell([-3.0, 0.0, 0.0], [0.0, way * rate, last], way, 0.5, 1.0, body=LAGGED) == clear
    for rate, clear in ((0.75, False), (0.7501, True)):  # without one the last number is the speed's
        assert can_tell([-3.0, 0.0], [0.0, way * rate], way, 0.5, 1.0) == clear
    # On an unstable slope 4/3 of it.
    for rate, clear in ((0.999, False), (1.001, True)):
        assert can_tell([5.0, 0.0], [0.0, way * rate], way, 0.5, 1.0, slope=1.0) == clear


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_held_knob_is_released_once_or_not(sign: float) -> None:
    """By a lag of a quarter: a torque that changes by 1 a sample, and that by a quarter, is monotone up to 4 samples.

    At -1 cogging pulls by -1/2, the hand by 1/4, and -1 drives it: -1.25, which leaves 0.75.
    """
    z = [-1.0, 0.0, 0.0]
    for h, clear in ((nextafter(4.0, 0.0), True), (4.0, False), (9.0, False)):
        assert can_tell(z, [0.0, 0.0, sign], 0, h, 9.0, body=LAGGED) == clear
    for rate, clear in ((0.125, False), (0.1249, True)):  # 4 rates, and a half of 16 quarters of one
        assert can_tell(z, [0.0, 0.0, sign * rate], 0, 4.0, 9.0, body=LAGGED) == clear
    for place, slope, left in ((-1.0, 0.0, 0.75), (-5.0, 0.0, 1.25), (-10.0, -1.0, 0.25)):
        for part, clear in ((0.99, True), (1.01, False)):
            rates = [0.0, 0.0, sign * part * left / 6.0]
            assert can_tell([place, 0.0, 0.0], rates, 0, 4.0, 9.0, slope=slope, body=LAGGED) == clear
    assert can_tell([-1.0, 0.0, -7.0], [0.0, 0.0, 0.0], 0, 4.0, 9.0, body=LAGGED)  # nothing changes, whatever holds it


def test_a_finger_that_swings_may_let_go_later() -> None:
    """A torque that does not change now, as spring and damper of the pad cancel, may change soon."""
    one = BEHIND._replace(friction=0.75)
    rates = [0.0, 0.0, 0.125, -1.0]
    at_level = [-1.0, 0.0, -0.375, 0.0]  # -1 - 0.5 + 0.75
    assert abs(-1.0 - 0.5 + 0.75) == one.friction
    assert not can_tell(at_level, rates, 0, 2.0**-20, 9.0, body=one)
    assert can_tell(at_level, [0.0] * 4, 0, 2.0**-20, 9.0, body=one)
    assert can_tell(at_level, rates, 0, 2.0**-10, 9.0, body=one._replace(friction=0.76))
    # No bound without springs and dampers: nothing is said of a rate of 0, or 1.
    assert can_tell(at_level, [0.0, 0.0, 0.125, 0.0], 0, 2.0**-20, 9.0, body=one)
    wound = one._replace(order=3, coil=1.0, coil_rate=0.0, ratio=0.0, matrices=[0.0] * 6)
    for rate in (0.5, -0.5, 1.0, -1.0):  # of a current that nothing slows: it goes on as it goes
        assert can_tell(
            [-1.0, 0.0, 0.75], [0.0, 0.0, rate], 0, 9.0, 9.0, body=wound._replace(order=3, matrices=[0.0] * 6)
        )


# Where a mode is over.


def past(state: list[float], mode: int, *, slope: float = 0.0, body: Body = PLAIN, u: float = 0.0) -> int:
    return int(over([*[9.0] * body.order, *state], u, slope, mode, body))


def test_a_state_is_past_an_end_where_it_goes_on_so() -> None:
    for slope, middle in ((0.0, -3.0), (1.0, 5.0)):
        for mode in (FREE, 1, -1):
            for x in (4.0, -4.0, 3.9):
                assert past([middle + x, 0.5 if mode == 1 else -0.5], mode, slope=slope) == 0
            if mode != -1:
                assert past([middle + 4.001, 0.5], mode, slope=slope) == RISEN
                assert past([middle - 4.001, 0.5], mode, slope=slope) == 0
            if mode != 1:
                assert past([middle - 4.001, -0.5], mode, slope=slope) == FALLEN
                assert past([middle + 4.001, -0.5], mode, slope=slope) == 0
            assert past([middle + 4.001, 0.0], mode, slope=slope) == 0
            assert past([middle - 4.001, 0.0], mode, slope=slope) == 0
    for way in (1, -1):
        for x in (-3.0, 1.5, -7.5):
            assert past([x, -1e-300 * way], way) == TURNED
        assert past([-3.0, 0.0], way) == 0
        assert past([-3.0, 1e-300 * way], way) == 0
        assert past([-3.0, -0.5], FREE) == past([-3.0, 0.5], FREE) == 0


def test_a_knob_is_held_up_to_the_level_of_friction() -> None:
    """At -1: cogging -1/2, the hand 1/4, a drive of -1; and the torque of a lag, or the command."""
    one = PLAIN._replace(friction=2.0, drive=-1.0, vectors=[0.0, -1.0, *PLAIN.vectors[2:]])
    lagged = LAGGED._replace(vectors=[0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0])
    for torque, end in ((3.25, 0), (nextafter(3.25, 4.0), TURNED), (-0.75, 0), (-0.7501, TURNED)):
        assert past([-1.0, 0.0], 0, body=one, u=torque) == end
        assert past([-1.0, 0.0, torque], 0, body=lagged, u=7.0) == end
    for torque, end in ((3.75, 0), (3.751, TURNED), (-0.25, 0), (-0.251, TURNED)):
        assert past([3.0, 0.0], 0, slope=0.0, body=one, u=torque + 1.5) == end
        assert past([3.0, 0.0], 0, slope=1.0, body=one, u=torque + 0.5) == end


# A motion until its mode is over.


def rolling(one: Body) -> Body:
    """With matrices of the motion, of its own numbers; of second order, or with a lag."""
    n = one.order
    a, held, entry = np.zeros((n, n)), np.zeros((n, n)), np.zeros(n)
    a[0, 1] = entry[1] = 1.0
    a[1, :2] = -one.beta, -one.alpha
    if n == 3:
        a[1, 2] = 1.0
        a[2, 2] = held[2, 2] = -one.lag
    slopes = []
    for spring in (one.cogs[0], -one.cogs[0]):
        slopes.append(a.copy())
        slopes[-1][1, 0] -= spring
    parts = [a, held, a, a, halves(a), halves(held), *slopes, *(halves(part) for part in slopes)]
    constant = np.zeros(n)
    constant[1] = one.drive
    vectors = np.concatenate([constant, np.zeros(n), entry]).tolist()
    return one._replace(matrices=np.concatenate([part.ravel() for part in parts]).tolist(), vectors=vectors)


def cogs_of(slope: float, length: float, centre: float = 0.0) -> list[float]:
    return [slope, length, centre, 0.5 * slope * length, sqrt(slope), abs(centre) + length]


def bare(slope: float, length: float, **more: Any) -> Body:
    """Without hand and damping: nothing but cogging."""
    return rolling(by_hand(alpha=0.0, beta=0.0, cogs=cogs_of(slope, length))._replace(reach=inf, **more))


def rolled(
    one: Body, z: list[float], u: float = 0.0, *, mode: int = FREE, left: float = 1.0, fresh: bool = False
) -> tuple[float, int, list[float]]:
    """On the slope that the knob is on, or comes from."""
    state = list(z)
    slope = slope_at(z[0] - 1e-9, one.cogs)
    t, end = roll(state, u, slope, mode, left, fresh, one, [0.0] * (2 * one.order))
    return t, end, state


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_an_oscillation_is_left_at_the_corner(side: float) -> None:
    """Which it comes back from within the sample: two counts of 2.2 from its middle, or thrown from it by a torque."""
    rate = 0.9 * pi
    one = bare(rate * rate, 4.0)
    t, end, z = rolled(one, [0.0, side * 2.2 * rate])
    assert (t, end) == (pytest.approx(asin(2.0 / 2.2) / rate, abs=1e-14), RISEN if side > 0.0 else FALLEN)
    assert z[0] == pytest.approx(side * 2.0, abs=1e-13)
    assert rolled(one, [0.0, side * 1.99 * rate])[:2] == (1.0, 0)
    rate = 2.0 * pi
    one = bare(rate * rate, 4.0)
    for most, expected in ((2.2, RISEN if side > 0.0 else FALLEN), (1.99, 0)):
        t, end, _ = rolled(one, [0.0, 0.0], side * 0.5 * most * rate * rate)
        assert end == expected
        if end:
            assert cos(rate * t) == pytest.approx(1.0 - 2.0 * 2.0 / most, abs=1e-12)
            assert t < 0.5


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_an_unstable_slope_is_left_as_an_exponential_says(side: float) -> None:
    """From its top, at 4 counts, by a speed of 1: sinh(t/2) / (1/2)."""
    one = bare(0.25, 4.0)
    for speed, first in ((3.0, 0.0), (9.0, 0.0), (0.0, 1.9)):
        t, end, z = rolled(one, [4.0 + side * first, side * speed])
        if speed:
            assert t == pytest.approx(2.0 * asinh(2.0 * 0.5 / speed), abs=1e-14)
        else:
            assert first * cosh(0.5 * t) == pytest.approx(2.0, abs=1e-14)
        assert end == (RISEN if side > 0.0 else FALLEN)
        assert z[1] == pytest.approx(side * (speed * cosh(0.5 * t) + 0.5 * first * sinh(0.5 * t)), rel=1e-13)
    t, end, z = rolled(one, [4.0, side * 1.0])
    assert (t, end) == (1.0, 0)
    assert z == [pytest.approx(4.0 + side * 2.0 * sinh(0.5), rel=1e-15), pytest.approx(side * cosh(0.5), rel=1e-15)]


@pytest.mark.parametrize("fresh", [True, False])
def test_a_motion_that_only_just_comes_past_a_corner_has_passed_it(fresh: bool) -> None:
    """And is beyond it for less than 2^-20 of a sample; a step before that, which is told, is no longer fresh."""
    one = bare(0.25, 8.0)  # which pulls back by 1 at the corner at 4
    for seed in range(20):
        early = 0.001 + 1e-5 * seed  # before it turns
        for beyond in (2.0**-43, -(2.0**-43)):
            most = 4.0 + beyond
            z = [most - 2.0 * most * sin(0.25 * early) ** 2, 0.5 * most * sin(0.5 * early)]
            t, end, _ = rolled(one, z, fresh=fresh, left=0.5)
            assert end == (RISEN if beyond > 0.0 else 0)
            if end:
                assert t == pytest.approx(early - 4.0 * asin(sqrt(0.5 * beyond / most)), abs=3e-8)
            else:
                assert t == 0.5


def test_an_end_is_left_past_it_by_the_last_bit_of_a_sample() -> None:
    """Nothing acts on a knob so fast that a last bit moves it by 2^-28 counts, and all sums are exact."""
    speed = 2.0**24
    for part in (0.3, 0.7123, 0.9999):
        one = bare(2.0**-300, 2.0 * part * speed)
        bits = int(part * 2.0**52) + 1
        for way in (1, -1):
            t, end, z = rolled(one, [0.0, way * speed])
            assert (t, end) == (bits * 2.0**-52, RISEN if way > 0 else FALLEN)
            assert z == [way * bits * 2.0**-28, way * speed]


def test_a_motion_from_a_corner_takes_no_longer_steps_than_are_known() -> None:
    """At rest on the corner at 4, and drawn back: no step can be told at first, and the shortest are taken."""
    one = bare(0.25, 8.0)
    t, end, z = rolled(one, [4.0, 0.0])
    assert (t, end) == (1.0, 0)
    assert z == [pytest.approx(4.0 * cos(0.5), rel=1e-14), pytest.approx(-2.0 * sin(0.5), rel=1e-14)]


def test_what_begins_fresh_and_turns_at_once_is_left_after_a_short_step() -> None:
    """A release that roundings put a little early: the torque falls again, and friction holds the knob."""
    one = rolling(by_hand(alpha=0.0, beta=0.0, friction=1.0, cogs=COGS)._replace(order=3, lag=0.25, reach=inf))
    short = 2.0**-20
    torque = 1.0 - 1e-7
    t, end, z = rolled(one, [-3.0, 0.0, torque], torque - 4.0, mode=1, fresh=True)
    assert (t, end) == (short, TURNED)
    assert -1.1 * (1e-7 * short + 0.5 * short * short) < z[1] < -0.9 * (1e-7 * short + 0.5 * short * short)
    # If it rises, it goes on.
    t, end, z = rolled(one, [-3.0, 0.0, torque], torque + 4.0, mode=1, fresh=True)
    assert (t, end) == (1.0, 0)
    assert z[1] > 0.1
    # What is not fresh is left by the last bit.
    t, end, _ = rolled(one, [-3.0, 1e-9, torque], torque - 4.0, mode=1)
    assert end == TURNED
    assert t == pytest.approx(sqrt(1e-14 + 2e-9) - 1e-7, rel=1e-4)


def test_a_motion_that_is_given_up_is_left_where_it_is() -> None:
    for halt, time in ((0.0, 1.0), (0.5, 0.0), (1.0, 0.0)):
        one = bare(0.25, 8.0, halt=[halt])
        t, end, z = rolled(one, [0.0, 1.0])
        assert (t, end) == (time, 0)
        assert (z == [0.0, 1.0]) == (time == 0.0)
