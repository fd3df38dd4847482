"""Rest beside cogging, exactly on its margins: on a slope of dyadic numbers, with roundings as large as is written."""

from fractions import Fraction
from math import nextafter, sqrt
from random import Random
from types import SimpleNamespace
from typing import Any

import pytest

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general import cog_rest, cogging
from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.cog_rest import (
    LastTorque,
    is_carried,
    keeps_to_slope,
    settles_free,
    stays_on_slope,
    zone_on,
)
from hknob_cli.engine.general.cogging import far_apart, hold_stiffness, middle_of, own_stiffness
from hknob_cli.engine.general.laws import rest as law_rest
from hknob_cli.engine.general.laws.rest import settles_with_law
from hknob_cli.engine.general.standstill import SETTLING, settles
from hknob_cli.engine.general.torque_curve import HEAD, HIGHEST, LOWEST, STOP
from hknob_cli.engine.rest import AT_REST, MOVING, REST_ON_EDGE, RINGS

from .test_standstill_margins import FINGER, WALL, body

UNIT = 2.0**-10  # of a rounding, here
# A hand of 0.25, neutral at -2, and a bias of 0.5; slopes of 0.75, 8 counts long, one about a place of rest at -20.5.
COGS = [0.75, 8.0, -20.5, 3.0, sqrt(0.75), 28.5]
KNOB = body(beta=0.25)._replace(reach=2.0, shift=2.0, push=0.5, cogs=COGS)
BALANCE = 0.5 + 0.25 * (-20.5 + 2.0)  # torque under which it stands at the place of rest
BEHIND = FINGER._replace(order=4, lag=0.0, friction=0.0, reach=sqrt(0.5 + 0.5), shift=2.0, push=0.5, cogs=COGS)


@pytest.fixture
def exact(monkeypatch: pytest.MonkeyPatch) -> pytest.MonkeyPatch:
    """No roundings at all."""
    monkeypatch.setattr(cog_rest, "EPSILON", 0.0)
    monkeypatch.setattr(cogging, "EPSILON", 0.0)
    return monkeypatch


@pytest.fixture
def rounded(exact: pytest.MonkeyPatch) -> None:
    """Those of a place, of a unit each."""
    exact.setattr(cog_rest, "EPSILON", UNIT)
    exact.setattr(cog_rest, "ROUNDINGS", 1.0)


def free(
    z: list[float], u: float, one: Body = KNOB, *, shown: float = -21.0, wrong: float = 0.0, push: float = 0.0
) -> tuple[int, float, list[float]]:
    orbit, away = [7.0] * one.order, [7.0] * one.order
    found, gap = settles_free(one.cogs, z, LastTorque(u, wrong, push), shown, one, WALL, orbit, away)
    return found, gap, orbit


def test_a_balance_of_all_torques_is_a_rest(exact: pytest.MonkeyPatch) -> None:
    """Both springs together are 1: a torque of 0.25 more is a quarter of a count farther; and its reading goes on."""
    assert hold_stiffness(COGS, -20.5, KNOB) == 1.0
    for more, gap in ((0.0, 0.5), (0.25, 0.25), (-0.25, 0.25)):
        at = -20.5 + more
        assert free([at, 0.0], BALANCE + more) == (AT_REST, gap, [at, 0.0])
        for v, fate in ((gap, MOVING), (nextafter(gap, 0.0), AT_REST), (-gap, MOVING), (-0.99 * gap, AT_REST)):
            assert free([at, v], BALANCE + more)[0] == fate
        assert free([at, 0.5 * gap], BALANCE + more, KNOB._replace(damped=False))[0] == RINGS
    assert free([-20.25, 0.0], BALANCE)[2] == [-20.5, 0.0]
    assert free([-20.5, 0.0], BALANCE + 0.75, shown=-20.0)[0] == MOVING  # nearer to it than it is to its edge
    assert free([-19.75, 0.0], BALANCE + 0.75, shown=-20.0) == (AT_REST, 0.25, [-19.75, 0.0])


def test_without_cogging_another_proof_is_asked() -> None:
    torque = LastTorque(0.0, 0.0, 0.0)
    assert settles_free(None, [0.0, 0.0], torque, 0.0, KNOB, WALL, [0.0] * 2, [0.0] * 2) == (MOVING, 0.0)
    assert keeps_to_slope(None, [0.0, 0.0], torque, 0.0, KNOB, WALL, [0.0] * 2, [0.0] * 2) == (False, 0.0)


def test_beside_a_curve_the_way_to_its_next_knee_is_measured_from_the_rest(exact: pytest.MonkeyPatch) -> None:
    """Not from where the trial is: 4 counts and 4.25 to the end stop at -24.5. Nothing else is near."""
    stops = [0.0] * HEAD
    stops[STOP], stops[LOWEST], stops[HIGHEST] = 1.0, -24.5, 90.0
    wall, orbit, away = WALL._replace(analog=1.0, kappa=0.0, curve=stops), [7.0] * 2, [7.0] * 2
    found = settles_free(COGS, [-20.25, 0.0], LastTorque(BALANCE, 0.0, 0.0), -20.25, KNOB, wall, orbit, away)
    assert (found, orbit) == ((AT_REST, 4.0), [-20.5, 0.0])
    rubs = KNOB._replace(friction=0.25)
    held = keeps_to_slope(COGS, [-20.0, 0.0], LastTorque(BALANCE, 0.0, 0.0), -20.0, rubs, wall, orbit, away)
    assert (held, orbit) == ((True, 4.25), [-20.25, 0.0])


def test_a_corner_is_not_reached(exact: pytest.MonkeyPatch) -> None:
    """Outside the wall, where no count matters: 4 counts from the place of rest at 20, 2.5 from the rest beside it."""
    one = KNOB._replace(cogs=[0.75, 8.0, 20.0, 3.0, sqrt(0.75), 28.0])
    u = 0.5 + 0.25 * 22.0 + 1.5
    for v, fate in ((2.5, MOVING), (nextafter(2.5, 0.0), AT_REST), (-2.5, MOVING), (-2.49, AT_REST)):
        assert free([21.5, v], u, one, shown=21.0) == (fate, 21.5, [21.5, 0.0])
    # From its own slope, although both are equally far from the rest.
    assert free([19.5, 0.0], u, one, shown=19.0)[0] == AT_REST
    assert free([24.5, 0.0], u, one, shown=24.0)[0] == MOVING
    # Beyond the corner there is no rest.
    assert free([21.5, 0.0], u + 2.75, one, shown=21.0)[0] == MOVING


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_of_two_slopes_the_one_that_is_come_from_is_meant(exact: pytest.MonkeyPatch, side: float) -> None:
    """A motion on the other side of the corner is on another slope, however near."""
    orbit, away = [23.0, 0.0], [0.0, 0.0]
    one = KNOB._replace(cogs=[0.75, 8.0, 20.0, 3.0, sqrt(0.75), 28.0])
    assert stays_on_slope([23.5, 0.0], 9.0, 0.25, one, orbit, away) == (True, 0.5)
    assert away == [0.5, 0.0]
    assert stays_on_slope([23.5, side * 0.5], 9.0, 0.0, one, orbit, away) == (True, sqrt(0.5))
    assert stays_on_slope([23.5, 0.0], 9.0, 0.5, one, orbit, away) == (False, 0.5)  # to the corner, and no further
    assert stays_on_slope([23.5, 0.0], 0.75, 0.25, one, orbit, away) == (False, 0.5)
    assert stays_on_slope([23.5, 0.0], 0.76, 0.25, one, orbit, away) == (True, 0.5)
    assert stays_on_slope([24.5, 0.0], 9.0, -1.0, one, orbit, away) == (False, 1.5)


@pytest.mark.parametrize("play", [0.0, 2.0**-20, 2.0])
def test_teeth_that_may_part_prove_no_rest(exact: pytest.MonkeyPatch, play: float) -> None:
    """The room is that of the mesh's torque at the rest, stiffness times its angle; without play none is asked."""
    asked, room = [], [0.75]
    exact.setattr(cog_rest, "flank_room_on", lambda *given: asked.append(given[1:]) or room[0])
    one = BEHIND._replace(play=play, pad_stiffness=4.0, reach=1.0)
    orbit, away = [-20.5, 0.0, 0.25, 0.0], [0.0] * 4
    far = far_apart(COGS, [0.5, 0.0, 0.0, 0.0], -20.5, one)
    for room[0], stays in ((far + 0.25, False), (nextafter(far + 0.25, 9.0), True), (0.0, False)):
        found = stays_on_slope([-20.0, 0.0, 0.25, 0.0], 9.0, 0.25, one, orbit, away)
        assert found == (stays or play == 0.0, far)
    assert asked == ([(1.0, -20.5, one)] * 3 if play else [])


@pytest.mark.parametrize(("play", "fate"), [(0.0, REST_ON_EDGE), (2.0**-20, MOVING)])
def test_a_rest_on_an_edge_is_none_where_teeth_may_part(exact: pytest.MonkeyPatch, play: float, fate: int) -> None:
    exact.setattr(cog_rest, "flank_room_on", lambda *_: 9.0)
    exact.setattr(cog_rest, "edge_gap", lambda *_: 0.0)
    one, balance = BEHIND._replace(play=play), 0.5 + (-20.5 + 2.0)  # its own springs are 1
    orbit, away = [0.0] * 4, [0.0] * 4
    settles_free(COGS, [-20.0, 0.0, 0.0, 0.0], LastTorque(balance, 0.0, 0.0), -21.0, one, WALL, orbit, away)
    assert orbit[0] == -20.5
    for place, found in ((-20.5, fate), (-20.4, MOVING)):
        z = [place, *orbit[1:]]
        assert settles_free(COGS, z, LastTorque(balance, 0.0, 0.0), -21.0, one, WALL, list(orbit), away)[0] == found


def test_where_no_springs_hold_nothing_rests(exact: pytest.MonkeyPatch) -> None:
    """On the unstable slope about -12.5; with a slope as stiff as the hand there is no balance at all."""
    u = 0.5 + 0.25 * (-12.5 + 2.0)
    for slope, fate in ((0.1875, AT_REST), (0.25, MOVING), (0.75, MOVING)):
        one = KNOB._replace(cogs=[slope, *COGS[1:]])
        assert free([-12.5, 0.0], u, one, shown=-13.0)[0] == fate
        assert free([-12.5, 0.0], u + 1.0, one, shown=-13.0)[0] == MOVING
    soft = KNOB._replace(cogs=[0.1875, *COGS[1:]])
    assert free([-12.25, 0.0], u + 0.015625, soft, shown=-13.0) == (AT_REST, 0.25, [-12.25, 0.0])


def test_a_lag_and_a_finger_rest_beside_it(exact: pytest.MonkeyPatch) -> None:
    """The lag where the command is; the finger where its springs balance, 1 together as the knob feels them."""
    lag = KNOB._replace(order=3, lag=0.5)
    assert free([-20.5, 0.0, BALANCE], BALANCE, lag) == (AT_REST, 0.5, [-20.5, 0.0, BALANCE])
    for late, fate in ((0.25, MOVING), (0.2499, AT_REST), (-0.25, MOVING)):
        assert free([-20.5, 0.0, BALANCE + late], BALANCE, lag)[0] == fate
    assert own_stiffness(BEHIND) == 1.0
    for ratio, finger in ((4.0, 8.0), (0.5, 1.0)):
        one = BEHIND._replace(ratio=ratio, finger_stiffness=finger)
        depth = (-20.25 + 2.0) / 2.0  # of the pad: it carries what both springs carry
        u = 0.5 + (-20.25 + 2.0) + 0.25 * 0.75
        found = free([-20.25, 0.0, depth, 0.0], u, one)
        assert found == (AT_REST, 0.25, [-20.25, 0.0, depth, 0.0])
        both = one._replace(order=5, lag=0.5)
        assert free([-20.25, 0.0, depth, 0.0, u], u, both) == (AT_REST, 0.25, [-20.25, 0.0, depth, 0.0, u])


def test_a_finger_that_nothing_holds_is_carried_nowhere(exact: pytest.MonkeyPatch) -> None:
    for pad, own, carried in ((2.0, 8.0, True), (0.0, 8.0, False), (2.0, 0.0, False), (0.0, 0.0, False)):
        for size in (1.0, 2.0**-6):
            one = BEHIND._replace(pad_stiffness=size * pad, finger_stiffness=size * own)
            assert is_carried(one) == carried
            assert is_carried(one._replace(ratio=0.0))
    z = [-20.5, 0.0, -9.25, 0.0]
    assert free(z, 0.5 - 18.5, BEHIND)[0] == AT_REST
    assert free(z, 0.5 - 18.5, BEHIND._replace(finger_stiffness=0.0)) == (MOVING, 0.0, [7.0] * 4)
    rubbing = BEHIND._replace(friction=1.0)
    assert zone_on(COGS, -20.5, 0.5 - 18.5, 0.0, rubbing)[0] < -20.5
    assert zone_on(COGS, -20.5, 0.5 - 18.5, 0.0, rubbing._replace(finger_stiffness=0.0)) == (1.0, 0.0)


def test_a_torque_known_to_within_so_much_moves_the_knob_twice_as_far(exact: pytest.MonkeyPatch) -> None:
    """As it does, where nothing damps it: it swings about where it would stand. Impulses count by energy, once."""
    for wrong, fate in ((0.1875, MOVING), (nextafter(0.1875, 0.0), AT_REST)):
        assert free([-20.5, 0.125], BALANCE, wrong=wrong)[0] == fate
    for push, fate in ((0.5, MOVING), (nextafter(0.5, 0.0), AT_REST)):
        assert free([-20.5, 0.0], BALANCE, push=push)[0] == fate
    assert free([-20.5, 0.125], BALANCE, wrong=0.0625, push=0.25)[0] == MOVING
    assert free([-20.5, 0.125], BALANCE, wrong=0.0624, push=0.25)[0] == AT_REST
    # Of springs of 4 an impulse moves it half as far, and a torque a quarter.
    stiff = KNOB._replace(cogs=[3.75, *COGS[1:]])
    for wrong, push, fate in ((0.75, 0.0, MOVING), (0.74, 0.0, AT_REST), (0.0, 0.75, MOVING), (0.0, 0.74, AT_REST)):
        assert free([-20.5, 0.25], BALANCE, stiff, wrong=wrong, push=push)[0] == fate


@pytest.mark.parametrize("middle", [-20.5, 20.5])
@pytest.mark.parametrize("off", [0.0, 0.25, -0.25])
@pytest.mark.parametrize(("push", "shift"), [(0.5, 2.0), (0.5, -2.0), (0.25, -82.0), (0.0, 0.0), (8.0, 3.0)])
def test_roundings_of_a_rest_are_those_of_all_that_balances(
    exact: pytest.MonkeyPatch, middle: float, off: float, push: float, shift: float
) -> None:
    """A unit of 1, of its place and of the slope's, of the torques over their stiffness, and of its place on the slope.

    Where the hand's spring and an unstable slope leave a sixteenth, the last counts 7 times.
    """
    exact.setattr(cog_rest, "ROUNDINGS", 1.0)
    for slope, cogs, hold, times in (
        (0.0, [0.75, 8.0, middle, 3.0, sqrt(0.75), 28.5], 1.0, 1.0),
        (1.0, [0.1875, 8.0, middle - 8.0, 0.75, sqrt(0.1875), 20.5], 0.0625, 7.0),
    ):
        unit = hold * UNIT / 64.0
        exact.setattr(cog_rest, "EPSILON", unit)
        one = KNOB._replace(push=push, shift=shift, cogs=cogs)
        assert middle_of(slope, cogs) == middle
        u = push + 0.25 * (middle + shift) + hold * off
        gap = (0.5 if middle < 0.0 else 4.0) - abs(off)  # to the edge of the count; outside the wall to the corner
        size = 20.5 + (abs(u) + push + 0.25 * (20.5 + abs(shift))) / hold + abs(off) * times
        slack = unit * (1.0 + abs(middle + off) + size)
        v = sqrt(hold) * (gap - slack)
        assert free([middle + off, v], u, one, shown=middle // 1.0)[0] == MOVING
        assert free([middle + off, v - 2.0**-40], u, one, shown=middle // 1.0)[0] == AT_REST


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_rest_within_its_roundings_of_an_edge_is_on_it(exact: pytest.MonkeyPatch, side: float) -> None:
    """On either side of the edge at -21, to where the knob must have come to a millionth of a count."""
    exact.setattr(cog_rest, "ROUNDINGS", 1.0)
    exact.setattr(cog_rest, "EPSILON", UNIT / 64.0)
    off = 2.0**-8
    at = -21.0 + side * off
    u = BALANCE - 0.5 + side * off
    slack = UNIT / 64.0 * (1.0 + abs(at) + 20.5 + abs(u) + 0.5 + 0.25 * 22.5 + abs(at + 20.5))
    missing = 0.5 * (off - slack)  # as a torque that is not known
    assert missing > 0.0
    for wrong, fate in ((missing, REST_ON_EDGE), (missing - 2.0**-40, AT_REST if side > 0.0 else MOVING)):
        assert free([at, 0.0], u, wrong=wrong)[0] == fate
    for v, fate in ((9.9e-7, REST_ON_EDGE), (-6e-7, REST_ON_EDGE), (1e-6, MOVING), (1.9e-6, MOVING), (-1e-6, MOVING)):
        assert free([at, v], u, wrong=missing)[0] == fate
        assert free([at, v], u, wrong=missing)[1] == (side * off if fate == MOVING else 0.0)


def test_a_knob_that_nothing_damps_comes_as_far_as_that() -> None:
    """Under a torque that is a quarter more than is known, over a spring of 1, it swings by half a count."""
    from hknob_cli.engine.general.cogging import cog_pull

    x, v, farthest, step = -20.5, 0.0, -20.5, 1e-3
    for _ in range(7000):  # a leapfrog, of the torques as they are named
        v += step * (BALANCE + 0.25 - 0.5 - 0.25 * (x + 2.0) + cog_pull(COGS, x))
        x += step * v
        farthest = max(farthest, x)
    assert farthest == pytest.approx(-20.0, abs=1e-3)


def test_springs_that_nearly_cancel_hold_no_more_than_they_do() -> None:
    """From below: of random hands and slopes, exactly. From above: four roundings of the hand's spring are needed."""
    chance, close = Random(3), 0
    for _ in range(4000):
        beta = chance.uniform(0.5, 2.0) * 10.0 ** chance.uniform(-6.0, 1.0)
        slope = beta * (1.0 - 10.0 ** chance.uniform(-16.0, -1.0))
        one = KNOB._replace(beta=beta, reach=1.0 / sqrt(beta), cogs=[slope, *COGS[1:]])
        truly = Fraction(beta) - Fraction(slope)
        found = hold_stiffness(one.cogs, -12.5, one)
        assert Fraction(found) <= truly
        assert truly - Fraction(found) <= Fraction(4 * 4.0 * EPSILON * beta) + Fraction(4.0 * EPSILON * beta)
        close += found > 0.0
    assert close > 2000


def test_a_rest_between_springs_that_nearly_cancel_is_in_its_count() -> None:
    """Exactly, by rational numbers: the place is known to the roundings of both springs over what is left of them."""
    chance, called, near = Random(5), 0, 0
    for _ in range(4000):
        beta = chance.uniform(0.5, 2.0)
        part = 10.0 ** chance.uniform(-7.0, -2.0)
        cogs = [beta * (1.0 - part), 4000.0, -4000.0, 0.0, 0.0, 0.0]
        aim = -600.0 + chance.choice([-1.0, 1.0]) * 600.0 * EPSILON / part * 10.0 ** chance.uniform(-2.0, 4.0)
        one = KNOB._replace(beta=beta, reach=1.0 / sqrt(beta), push=0.0, shift=0.0, cogs=cogs)
        hold = Fraction(beta) - Fraction(cogs[0])
        u = float(hold * Fraction(aim))  # both springs are at ease at 0
        truly = Fraction(u) / hold
        _, _, orbit = free([-600.0, 0.0], u, one, shown=-600.0)
        found, _, _ = free(orbit, u, one, shown=-600.0)  # of a knob that stands where it is said to rest
        called += found == AT_REST
        near += found != AT_REST
        if found == AT_REST:
            assert -600 < truly < -599
    assert called > 100
    assert near > 100


RUBBING = KNOB._replace(friction=1.0)


def test_friction_holds_to_its_level_on_either_side(exact: pytest.MonkeyPatch) -> None:
    """A count, over springs of 1, about the balance; less what the torque may be wrong by; and to the corners."""
    for more in (0.0, 0.5, -0.5):
        assert zone_on(COGS, -20.5, BALANCE + more, 0.0, RUBBING) == (-21.5 + more, -19.5 + more)
        assert zone_on(COGS, -23.0, BALANCE + more, 0.25, RUBBING) == (-21.25 + more, -19.75 + more)
    assert zone_on(COGS, -20.5, BALANCE, 2.0, RUBBING) == (-19.5, -21.5)  # none
    stiff = RUBBING._replace(cogs=[3.75, *COGS[1:]])
    assert zone_on(stiff.cogs, -20.5, BALANCE + 1.0, 0.0, stiff) == (-20.5, -20.0)
    for u, low, high in ((BALANCE + 3.5, -18.0, -16.5), (BALANCE - 3.5, -24.5, -23.0)):
        assert zone_on(COGS, -20.5, u, 0.0, RUBBING) == (low, high)
    soft = RUBBING._replace(cogs=[0.1875, *COGS[1:]])
    assert zone_on(soft.cogs, -12.5, 0.5 - 0.25 * 10.5, 0.875, soft) == (-14.5, -10.5)
    level = RUBBING._replace(cogs=[0.25, *COGS[1:]])
    for one in (RUBBING, level):
        assert zone_on(one.cogs, -12.5, 0.5 - 0.25 * 10.5, 0.0, one) == (1.0, 0.0)  # no springs hold it


def test_a_finger_beside_a_held_knob_must_be_damped(exact: pytest.MonkeyPatch) -> None:
    u = 0.5 + (-20.5 + 2.0)
    for pad, own, none in ((0.0, 0.0, True), (0.25, 0.0, False), (0.0, 0.25, False), (0.5, 0.5, False)):
        for ratio in (4.0, 0.5):
            one = BEHIND._replace(friction=1.75, pad_damping=pad, finger_damping=own, ratio=ratio)
            assert zone_on(COGS, -20.5, u, 0.0, one) == ((1.0, 0.0) if none else (-21.5, -19.5))
    lone = KNOB._replace(friction=1.0, pad_damping=0.0, finger_damping=0.0)
    assert zone_on(COGS, -20.5, BALANCE, 0.0, lone) == (-21.5, -19.5)


@pytest.mark.parametrize("middle", [-20.5, 20.5])
@pytest.mark.parametrize("off", [0.0, 0.25, -0.25])
@pytest.mark.parametrize(("push", "shift"), [(0.5, 2.0), (0.5, -2.0), (0.25, -82.0), (0.0, 0.0), (8.0, 3.0)])
def test_roundings_of_a_zone_are_those_of_all_torques(
    exact: pytest.MonkeyPatch, middle: float, off: float, push: float, shift: float
) -> None:
    """A unit of each torque, of what the springs make of the slope's place, and of what they balance.

    The last counts 7 times where the hand's spring and an unstable slope leave a sixteenth.
    """
    exact.setattr(cog_rest, "ROUNDINGS", 1.0)
    exact.setattr(cog_rest, "EPSILON", UNIT)
    for cogs, hold, times in (
        ([0.75, 16.0, middle, 3.0, sqrt(0.75), 28.5], 1.0, 1.0),
        ([0.1875, 64.0, middle - 64.0, 0.75, sqrt(0.1875), 20.5], 0.0625, 7.0),
    ):
        one = KNOB._replace(push=push, shift=shift, cogs=cogs, friction=1.0)
        pull = 0.25 * off
        u = push + 0.25 * (middle + shift) + pull
        size = abs(u) + push + 1.0 + 0.25 * (20.5 + abs(shift)) + hold * 20.5 + (abs(pull) + 1.0) * times
        held = 1.0 - UNIT * size
        found = zone_on(cogs, middle, u, 0.0, one)
        assert found == (middle + (pull - held) / hold, middle + (pull + held) / hold)


def keeps(
    z: list[float], u: float, one: Body = RUBBING, *, shown: float = -21.0, wrong: float = 0.0, push: float = 0.0
) -> tuple[bool, float, list[float]]:
    orbit, away = [7.0] * one.order, [7.0] * one.order
    found, gap = keeps_to_slope(one.cogs, z, LastTorque(u, wrong, push), shown, one, WALL, orbit, away)
    return found, gap, orbit


def test_a_knob_is_compared_with_the_nearest_place_that_friction_holds(exact: pytest.MonkeyPatch) -> None:
    """From -20.75 to -20.25, where friction is a quarter."""
    one = KNOB._replace(friction=0.25)
    for x, rest, gap in (
        (-20.5, -20.5, 0.5),
        (-20.75, -20.75, 0.25),
        (-20.875, -20.75, 0.25),
        (-20.125, -20.25, 0.25),
        (-20.25, -20.25, 0.25),
    ):
        room = sqrt(gap * gap - (x - rest) ** 2)
        for part, found in ((1.001, False), (0.999, True), (-1.001, False), (-0.999, True)):
            assert keeps([x, part * room], BALANCE, one) == (found, gap, [rest, 0.0])
    # One place that friction holds is enough; none is not.
    assert keeps([-20.375, 0.0], BALANCE, one, wrong=0.25) == (True, 0.5, [-20.5, 0.0])
    assert keeps([-20.375, 0.0], BALANCE, one, wrong=0.2500001) == (False, 0.0, [7.0, 7.0])
    # A balance beyond the corner, and friction that reaches it.
    assert keeps([-16.75, 0.0], BALANCE + 4.5, RUBBING, shown=-17.0)[0]
    assert not keeps([-16.5 - 2.0**-40, 0.0], BALANCE + 5.0, RUBBING, shown=-17.0)[0]


@pytest.mark.parametrize("under_a_law", [False, True])
def test_a_trial_rests_by_these_proofs(exact: pytest.MonkeyPatch, *, under_a_law: bool) -> None:
    """Beside the wall's torque of 21, and beside that of a law, which comes to an end and is known."""
    one = KNOB._replace(push=21.0 - BALANCE + 0.5, drive=-(21.0 - BALANCE + 1.0))
    exact.setattr(law_rest, "settled_torque", lambda *_: (True, LastTorque(21.0, 0.0, 0.0)))
    law: Any = SimpleNamespace(watch=WALL)

    def told(z: list[float], friction: float) -> int:
        body, orbit, away = one._replace(friction=friction), [7.0] * 2, [7.0] * 2
        if under_a_law:
            return int(settles_with_law(z, -21.0, [], body, WALL, law, orbit, away))
        fate, gap = settles(z, -21.0, -21.0, [], body, WALL, orbit, away)
        assert gap == 0.5 or z[0] != -20.5
        return int(fate)

    for v, fate in ((0.5, MOVING), (nextafter(0.5, 0.0), AT_REST), (-0.5, MOVING)):
        assert told([-20.5, v], 0.0) == fate
    for v, fate in ((0.501, MOVING), (0.499, SETTLING), (-0.501, MOVING), (-0.499, SETTLING)):
        assert told([-20.5, v], 0.25) == fate
    # A quarter of a count off, a hand of a quarter and cogging of three pull together by a quarter.
    for friction, fate in ((0.25, AT_REST), (nextafter(0.25, 0.0), SETTLING), (0.2, SETTLING)):
        assert told([-20.25, 0.0], friction) == fate


def test_a_zone_that_ends_at_a_corner_ends_there(exact: pytest.MonkeyPatch) -> None:
    """The place of rest nearest to a knob that is thrown back from beyond is the corner: nothing is proven there."""
    found = keeps([-24.5, 0.0], BALANCE - 4.0, RUBBING, shown=-25.0)
    assert not found[0]
    # Where the next slope is as stiff as the hand, the corner is held by nothing.
    level = RUBBING._replace(cogs=[0.25, *COGS[1:]])
    assert keeps([-17.0, 0.0], BALANCE + 3.0, level, shown=-17.0) == (False, 0.5, [-16.5, 0.0])
    # Where a hand of 1 holds the knob on either slope, the corner is a place of its own, without any room.
    firm = RUBBING._replace(beta=1.0, reach=1.0)
    u = 0.5 + 1.0 * (-20.5 + 2.0)
    assert not keeps([-16.5, 0.0], u + 1.75 * 4.0, firm, shown=-17.0)[0]


def test_an_impulse_counts_beside_friction_by_energy(exact: pytest.MonkeyPatch) -> None:
    for push, found in ((0.25, False), (0.2499, True)):
        assert keeps([-20.5, 0.25], BALANCE, push=push)[0] == found
    stiff = RUBBING._replace(cogs=[3.75, *COGS[1:]])
    for push, found in ((0.5, False), (0.499, True)):
        assert keeps([-20.5, 0.5], BALANCE, stiff, push=push)[0] == found


@pytest.mark.parametrize("place", [-20.5, 20.5])
def test_roundings_beside_friction_are_those_of_two_places(exact: pytest.MonkeyPatch, place: float) -> None:
    """The zone is known: a unit of 1, of the rest and of the knob."""
    exact.setattr(cog_rest, "ROUNDINGS", 1.0)
    exact.setattr(cog_rest, "zone_on", lambda *given: (place - 0.25, place + 0.25))
    exact.setattr(cog_rest, "EPSILON", UNIT / 16.0)
    one = RUBBING._replace(cogs=[0.75, 8.0, place, 3.0, sqrt(0.75), 28.5])
    gap = 0.5 if place < 0.0 else 4.0
    slack = UNIT / 16.0 * (1.0 + 2.0 * abs(place))
    for v, found in ((gap - slack, False), (gap - slack - 2.0**-30, True)):
        assert keeps([place, v], 0.0, one, shown=place // 1.0)[0] == found
    rest, x = place + 0.25, place + 0.5
    gap -= 0.25
    slack = UNIT / 16.0 * (1.0 + abs(rest) + abs(x))
    for v2, found in (((gap - slack) ** 2 - 0.0625 + 1e-12, False), ((gap - slack) ** 2 - 0.0625 - 1e-12, True)):
        if v2 > 0.0:
            assert keeps([x, sqrt(v2)], 0.0, one, shown=place // 1.0)[0] == found


def test_a_rounding_is_64_units() -> None:
    """Half a count from the edge; of all that balances there, 1, twice its place, and torques over springs of 1."""
    slack = 64.0 * EPSILON * (1.0 + 20.5 + 20.5 + abs(BALANCE) + 0.5 + 0.25 * 22.5)
    for part, fate in ((1.01, AT_REST), (0.99, MOVING)):
        assert free([-20.5, 0.5 - part * slack], BALANCE)[0] == fate
