"""Rest of a piece under friction, on its margins: dyadic numbers, and what the parts are asked written down.

A count of the wall is [-2, -1), say; friction holds what stands in a zone of it.
"""

from math import inf, nextafter, sqrt
from types import SimpleNamespace
from typing import Any

import pytest

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.follow import REST_PROVEN
from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.captured import FIELDS
from hknob_cli.engine.general.controller import read
from hknob_cli.engine.general.inner_region import hold_zone
from hknob_cli.engine.general.search import make_space
from hknob_cli.engine.general.sets import friction_rest
from hknob_cli.engine.general.sets.cell import Cell, Centre
from hknob_cli.engine.general.sets.ends import Known, make_known
from hknob_cli.engine.general.sets.friction_rest import (
    UNKNOWN,
    balance_rest,
    enter_rest,
    held_rest,
    near_rest,
    resting_piece,
)
from hknob_cli.engine.general.sets.known import FULL
from hknob_cli.engine.general.slide_two import coefficients, step_with_friction
from hknob_cli.scene.general_knob import make_body
from hknob_cli.specs.plan import Actuator, Bias, Hand, Knob, Scene, Wall

from .friction_work import drift_of, wall_of, zeros

ROUNDED = 8.0 * EPSILON


def body_of(friction: float = 0.0, beta: float = 1.0, push: float = 1.5, lag: float = 0.0, alpha: float = 1.0) -> Body:
    """Unit inertia, damping, period and quantum: level -1 rests at -1/2 without friction."""
    scene = Scene(
        knob=Knob(inertia=1.0, damping=alpha, coulomb_torque=friction),
        wall=Wall(stiffness=1.0),
        hand=Hand(stiffness=beta),
        bias=Bias(torque=push),
        encoder=None,
        actuator=Actuator(time_constant=1.0 / lag) if lag else None,
    )
    return make_body(scene, period=1.0, quantum=1.0, shift=0.0, split=0.0)[0]


def ends_of(delay: int = 0, order: int = 2, law: Any = None) -> Known:
    return make_known(zeros, order, delay, make_space(order, delay, zeros), law)


def centre_of(z: Any, ring: Any, level: float = 0.0) -> Centre:
    """A state that a set is told from; the bound on its error is told beside it."""
    return Centre(z, 0.0, ring, 0, 0.0, level, 0.0, 1.0)


def cell_of(known: Any, body: Any, bottom: float = -inf, wall: Any = None) -> Cell:
    return Cell(drift_of(bottom=bottom), known, body, wall or wall_of())


def rest_of_piece(
    z: list[float], error: float, radius: float, level: float, corners: list[float], ends: Any, body: Body,
) -> int:  # fmt: skip
    """Row of the rest of a piece with these corners, which acts as ``level``, no command under way."""
    cell = cell_of(ends, body)
    return int(resting_piece(centre_of(z, [], level=level), error, radius, corners, len(corners) // 2, cell))


# What is entered.


def test_a_rest_is_entered_with_its_reading_and_what_is_remembered() -> None:
    ends = ends_of(2)
    here, cell = centre_of([9.0, 9.0], [3.0, 4.0], level=9.0), cell_of(ends, body_of(0.5))
    assert enter_rest(-1.5, -2.0, 7.0, here, cell) == 0
    assert ends.table[:2] == [REST_PROVEN, 1]
    assert ends.table[FIELDS - 1] == -2.0
    assert (ends.states[:2], ends.lines[:2], ends.counts[0]) == ([-1.5, 0.0], [3.0, 4.0], 1.0)
    assert enter_rest(-1.25, -2.0, 7.0, here, cell) == 0  # one of a reading
    assert enter_rest(-0.5, -1.0, 7.0, here, cell) == 1


def test_a_torque_that_lags_has_come_to_its_command() -> None:
    ends = ends_of(0, 3)
    here, cell = centre_of([9.0, 9.0, 9.0], [], level=9.0), cell_of(ends, body_of(0.5, lag=0.5))
    assert enter_rest(-1.5, -2.0, 7.0, here, cell) == 0
    assert ends.states[:3] == [-1.5, 0.0, 7.0]


# States that stand.


class Entered:
    """Stands for `enter_rest`: which rests are entered, under rows as told."""

    def __init__(self, *rows: int) -> None:
        self.rows, self.at = list(rows), []  # type: list[int], list[tuple[float, float, float]]

    def __call__(self, x: float, shown: float, u: float, centre: Centre, cell: Cell) -> int:
        self.at.append((x, shown, u))
        return self.rows.pop(0) if self.rows else len(self.at) - 1


def held(
    low: float, high: float, zone: tuple[float, float], *, shift: float = 0.0, level: float = -2.0, reach: float = 0.0,
    bottom: float = -inf, sense: float = 1.0, blur: float = 0.0,
) -> list[tuple[float, float]] | int:  # fmt: skip
    """Places and readings of the rests that states from ``low`` to ``high`` stay at; the row where there are none."""
    given, wall = Entered(), wall_of(sense=sense)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(friction_rest, "enter_rest", given)
        cell = cell_of(SimpleNamespace(law=None, turns=None), None, bottom, wall)
        row = held_rest((low, high), (*zone, blur), shift, reach, 7.0, centre_of(None, [], level=level), cell)
    assert all(u == 7.0 for _, _, u in given.at)
    if row == UNKNOWN:
        return int(row)
    assert row == len(given.at) - 1
    return [(x, shown) for x, shown, _ in given.at]


def test_what_stands_in_the_zone_stays() -> None:
    assert held(-1.75, -1.5, (-1.875, -1.125)) == [(-1.625, -2.0)]
    assert held(-1.5, -1.5, (-1.5, -1.5)) == [(-1.5, -2.0)]
    assert held(-1.875, -1.125, (-1.875, -1.125)) == [(-1.5, -2.0)]
    assert held(-5.0, 7.0, (-9.0, 9.0)) == [(-1.5, -2.0)]  # what acts as another level is another's


def test_what_stands_beside_the_zone_gets_no_farther_from_its_end() -> None:
    """Neither back beyond where it stands nor on by as much; at the very edge of the count nothing is known."""
    for zone_end, apart in ((-1.75, 0.25), (-1.5, 0.5), (-1.25, 0.25)):
        for away, kept in ((apart, False), (apart - 2.0**-40, True), (0.125, True)):
            assert isinstance(held(zone_end, zone_end + away, (-1.9375, zone_end)), list) == kept
            assert isinstance(held(zone_end - away, zone_end, (zone_end, -1.0625)), list) == kept


def test_where_it_may_come_to_is_where_it_rests() -> None:
    """From beyond an end of the zone: as far into it as it was out of it. All else stays."""
    assert held(-1.875, -1.75, (-1.625, -1.0)) == [(0.5 * (-1.625 - 1.375), -2.0)]
    assert held(-1.25, -1.125, (-3.0, -1.375)) == [(0.5 * (-1.625 - 1.375), -2.0)]
    assert held(-1.875, -1.25, (-1.75, -1.375)) == [(0.5 * (-1.75 - 1.375), -2.0)]
    assert held(-1.875, -1.75, (-1.8125, -1.0)) == [(0.5 * (-1.8125 - 1.6875), -2.0)]
    # To where the zone ends on its other side, at most.
    assert held(-1.875, -1.75, (-1.625, -1.5625)) == [(0.5 * (-1.625 - 1.5625), -2.0)]
    assert held(-1.375, -1.25, (-1.5625, -1.5)) == [(0.5 * (-1.5625 - 1.5), -2.0)]


def test_every_reading_that_it_can_rest_in_is_entered() -> None:
    """Outside the wall readings act alike, and a rest is in one of them; each a rounding inside its own count."""
    for reach, slack in ((0.0, ROUNDED), (2.0**-6, 2.0**-5 + ROUNDED)):
        right = [(1.0 - slack, 0.0), (1.25, 1.0), (2.0 + slack, 2.0)]
        assert held(0.125, 2.375, (0.0, 9.0), level=0.0, reach=reach) == right
        assert held(0.125, 2.375, (0.0625, 9.0), level=0.0, reach=reach) == right
    # No farther than the zone, and from below its end on as far as it may go.
    assert held(0.5, 0.5625, (0.625, 9.0), level=0.0) == [(0.6875, 0.0)]
    assert held(0.25, 0.625, (0.75, 9.0), level=0.0) == [(1.0 - ROUNDED, 0.0), (1.0 + ROUNDED, 1.0)]
    assert held(0.25, 0.875, (0.75, 9.0), level=0.0) == [(1.0 - ROUNDED, 0.0), (1.0625, 1.0)]
    assert held(0.25, 0.25, (0.75, 9.0), level=0.0) == [(1.0 - ROUNDED, 0.0), (1.0 + ROUNDED, 1.0)]
    assert held(2.25, 2.25, (0.5, 1.75), level=0.0) == [(1.5, 1.0)]
    assert held(2.75, 2.75, (0.5, 1.75), level=0.0) == [(1.0 - ROUNDED, 0.0), (1.25, 1.0)]
    assert held(1.5, 2.25, (-9.0, 1.75), level=0.0) == [(1.375, 1.0)]
    assert held(1.5, 2.75, (-9.0, 1.75), level=0.0) == [(1.0 - ROUNDED, 0.0), (1.125, 1.0)]
    assert held(0.25, 2.75, (-9.0, 0.125), level=0.0) == UNKNOWN  # it may come into the wall


@pytest.mark.parametrize("x", [0.25, 0.5, 4.5, 5.25, 6.0])
def test_one_state_beside_the_zone_rests_in_a_reading_that_is_entered(x: float) -> None:
    """Where little damps it, it swings to as far into the zone, from 3/4 to 17/4, as it stood beside it."""
    body = body_of(0.875, beta=0.5, alpha=1e-3)._replace(drive=1.25)
    ends, wall, z = ends_of(), wall_of(), [x, 0.0]
    assert hold_zone(0.0, 0.0, body, wall)[1:] == pytest.approx((0.75, 4.25))
    assert rest_of_piece(z, 0.0, 0.0, 0.0, [0.0, 0.0], ends, body) >= 0
    span = coefficients(1.0, body)
    for _ in range(40):
        z = list(step_with_friction(z[0], z[1], 0.0, 1.0, *span, body))
    assert z[1] == 0.0
    assert abs(z[0] - x) > 1.9 * max(0.75 - x, x - 4.25)
    readings = {ends.table[FIELDS * row + FIELDS - 1] for row in range(int(ends.counts[0]))}
    assert read(z[0], wall) in readings


def test_no_rest_is_entered_in_a_count_that_acts_otherwise() -> None:
    """What stands in the zone near an edge stays, however far others come: held to 2, say, and down to -2."""
    assert held(-1.9375, -1.25, (-3.0, -1.375)) == [(0.5 * (-1.9375 - 0.125 - 1.375), -2.0)]
    # Where a count ends on its edge.
    middle = 0.5 * (-1.9375 - 0.125 - 1.375)
    assert held(-1.9375, -1.25, (-3.0, -1.375), level=-1.0, sense=-1.0) == [(middle, -1.0)]
    assert held(-1.75, -1.0625, (-1.625, 5.0)) == [(0.5 * (-1.625 - 1.0625 + 0.125), -2.0)]
    assert [shown for _, shown in held(0.0625, 1.25, (-3.0, 1.125), level=0.0)] == [0.0, 1.0]  # type: ignore[union-attr]
    body, ends = body_of(0.40625, beta=0.5)._replace(drive=-3.09375), ends_of()
    assert hold_zone(2.0, -2.0, body, wall_of())[1:] == pytest.approx((-3.0, -1.375))
    corners = [-0.4375, 0.0, 0.25, 0.0]
    assert rest_of_piece([-1.5, 0.0], 0.0, 1.0, -2.0, corners, ends, body) == 0
    assert (ends.counts[0], ends.table[FIELDS - 1]) == (1.0, -2.0)


def test_a_count_that_the_zone_may_reach_is_not_left_out() -> None:
    """Within roundings of its end: whether friction holds a state there is not known, where one may come there."""
    assert held(1.0, 1.0, (0.25, 0.9375), level=0.0, blur=0.0625) == UNKNOWN
    assert held(1.0, 1.0, (0.25, 0.9375), level=0.0, blur=0.03125) == [(0.90625, 0.0)]
    assert held(0.5, 1.25, (0.25, 0.9375), level=0.0, blur=0.0625) == UNKNOWN
    assert held(0.5, 0.75, (0.25, 0.9375), level=0.0, blur=0.0625) == [(0.625, 0.0)]
    assert held(0.25, 0.25, (0.3125, 9.0), level=0.0, blur=0.0625)
    assert held(0.75, 0.875, (1.0625, 9.0), level=0.0, blur=0.0625) == [(1.21875, 1.0)]
    assert held(0.75, 0.875, (1.0625, 9.0), level=0.0, blur=0.125) == UNKNOWN
    assert held(1.0, 1.5, (1.0625, 9.0), level=0.0, blur=0.125) == [(1.3125, 1.0)]
    # No state acts so beyond the ends of the level.
    assert held(-1.5, -1.25, (-1.9375, -1.0625), blur=0.125) == [(-1.375, -2.0)]
    assert held(-1.96875, -1.03125, (-1.9375, -1.0625), blur=0.125) == [(-1.5, -2.0)]
    # Nor where the zone reaches into it by less than a rounding.
    assert held(0.75, 1.0, (0.5, 1.0 + 0.5 * ROUNDED), level=0.0) == UNKNOWN
    assert held(0.75, 1.0, (0.5, 1.0 + ROUNDED), level=0.0) == [(0.875, 0.0), (1.0 + ROUNDED, 1.0)]


def test_a_state_that_the_very_end_of_the_zone_holds_is_not_said_to_rest_elsewhere() -> None:
    """Friction of 1/2 just holds it at 2, where the count 2 begins."""
    body, wall = body_of(0.5, beta=0.5)._replace(drive=0.5), wall_of()
    assert hold_zone(0.0, 0.0, body, wall)[2] < 2.0
    assert step_with_friction(2.0, 0.0, 0.0, 1.0, *coefficients(1.0, body), body) == (2.0, 0.0)
    for corners in ([0.0, 0.0], [-0.5, 0.0, 0.0, 0.0]):
        assert rest_of_piece([2.0, 0.0], 0.0, 0.5, 0.0, corners, ends_of(), body) == UNKNOWN
    assert rest_of_piece([1.5, 0.0], 0.0, 0.0, 0.0, [0.0, 0.0], ends_of(), body) == 0


def test_a_count_that_the_zone_does_not_hold_has_no_rest() -> None:
    """Within a rounding of its edge nothing is said: its place there is no place of the zone."""
    thin = 0.5 * ROUNDED
    assert held(-1.0 - thin, -1.0, (-1.0 - thin, 5.0)) == UNKNOWN
    assert held(-2.0, -2.0 + thin, (-5.0, -2.0 + thin)) == UNKNOWN
    assert held(-1.0 - 2.0 * thin, -1.0, (-1.0 - 2.0 * thin, 5.0)) == [(-1.0 - 2.0 * thin, -2.0)]
    assert held(-2.0, -2.0 + 2.0 * thin, (-5.0, -2.0 + 2.0 * thin)) == [(-2.0 + 2.0 * thin, -2.0)]


def test_what_stands_within_a_rounding_of_an_edge_rests_beside_it() -> None:
    thin = 0.5 * ROUNDED
    assert held(-1.0 - thin, -1.0 + thin, (-3.0, 3.0)) == [(-1.0 - ROUNDED, -2.0)]
    assert held(-2.0 - thin, -2.0 + thin, (-3.0, 3.0)) == [(-2.0 + ROUNDED, -2.0)]
    for beyond in (0.0, thin, 3.0 * ROUNDED):
        assert held(-1.0 + beyond, -1.0 + beyond, (-3.0, 3.0)) == [(-1.0 - ROUNDED, -2.0)]
        assert held(-2.0 - beyond, -2.0 - beyond, (-3.0, 3.0)) == [(-2.0 + ROUNDED, -2.0)]
        # Where a count ends on its edge.
        assert held(-1.0 + beyond, -1.0 + beyond, (-3.0, 3.0), level=-1.0, sense=-1.0) == [(-1.0 - ROUNDED, -1.0)]
        assert held(-2.0 - beyond, -2.0 - beyond, (-3.0, 3.0), level=-1.0, sense=-1.0) == [(-2.0 + ROUNDED, -1.0)]
    reach = 2.0**-6
    assert held(-1.0, -1.0, (-3.0, 3.0), reach=reach) == [(-1.0 - 2.0 * reach - ROUNDED, -2.0)]
    assert held(-2.0, -2.0, (-3.0, 3.0), reach=reach) == [(-2.0 + 2.0 * reach + ROUNDED, -2.0)]


def test_an_error_of_a_place_is_taken_from_what_is_held() -> None:
    reach = 2.0**-6
    for low, kept in ((-1.75, True), (-1.9375 + reach, True), (-2.0 + 0.25 * reach, False)):
        assert isinstance(held(low, -1.5, (-1.5, -1.25), reach=reach), list) == kept
    for high, kept in ((-1.25, True), (-1.0625 - reach, True), (-1.0 - 0.25 * reach, False)):
        assert isinstance(held(-1.5, high, (-1.75, -1.5), reach=reach), list) == kept


def test_where_the_zone_still_moves_all_must_stand_in_what_is_left_of_it() -> None:
    zone, shift = (-1.875, -1.125), 0.125
    for low, high, kept in (
        (-1.75, -1.25, True), (nextafter(-1.75, -2.0), -1.25, False), (-1.75, nextafter(-1.25, 0.0), False),
    ):  # fmt: skip
        assert isinstance(held(low, high, zone, shift=shift), list) == kept
        assert isinstance(held(low, high, zone), list)
    reach = 2.0**-6
    assert isinstance(held(-1.75 + reach, -1.25 - reach, zone, shift=shift, reach=reach), list)
    assert held(-1.75 + 0.5 * reach, -1.5, zone, shift=shift, reach=reach) == UNKNOWN
    assert held(-1.5, -1.25 - 0.5 * reach, zone, shift=shift, reach=reach) == UNKNOWN
    assert held(-1.9375, -1.5, zone, shift=5e-324) == UNKNOWN
    assert held(-1.9, -1.5, (-1.875, 5.0), shift=2.0) == UNKNOWN


def test_no_room_for_a_reading_is_said() -> None:
    entered = Entered(0, FULL)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(friction_rest, "enter_rest", entered)
        cell = cell_of(SimpleNamespace(law=None, turns=None), None)
        row = held_rest((0.125, 2.375), (0.0, 9.0, 0.0), 0.0, 0.0, 7.0, centre_of(None, []), cell)
    assert (row, len(entered.at)) == (FULL, 2)


# Without friction.


def balance(
    z: list[float], reach: float, *, u: float = 1.0, wrong: float = 0.0, level: float = -1.0, bottom: float = -inf,
    ends: Known | None = None, body: Body | None = None,
) -> int:  # fmt: skip
    one = body or body_of()
    known = ends or ends_of(order=len(z))
    return int(balance_rest(centre_of(z, [], level=level), reach, u, wrong, cell_of(known, one, bottom)))


def rounding(x: float, rest: float, torques: float) -> float:
    """64 units of all that enters the place of a rest."""
    return 64.0 * EPSILON * (1.0 + abs(rest) + abs(x) + torques)


def test_a_rest_without_friction_captures_below_its_margin_less_all_roundings() -> None:
    """Half a count less a part in 10^9, 10^-12, and roundings: torques of 1 and 1.5 balance."""
    for x, v, away in ((-0.5, 0.0, 0.0), (-0.25, 0.0, 0.25), (-0.75, 0.0, 0.25), (-0.5, 0.25, 0.25), (-0.2, 0.4, 0.5)):
        reach = (0.5 - 1e-12 - rounding(x, -0.5, 2.5)) / (1.0 + 1e-9) - away
        ends = ends_of()
        if reach > 0.0:
            assert balance([x, v], reach - 1e-14, ends=ends) == 0
            assert ends.table[:2] == [REST_PROVEN, 1]
            assert ends.states[:2] == [-0.5, 0.0]
        assert balance([x, v], max(0.0, reach) + 2e-14) == UNKNOWN


def test_a_rest_captures_nothing_that_reaches_its_very_margin() -> None:
    reach, room = 0.49999999949, rounding(-0.5, -0.5, 2.5)
    while reach * (1.0 + 1e-9) + 1e-12 + room < 0.5:
        reach += 1e-14
    while reach * (1.0 + 1e-9) + 1e-12 + room >= 0.5:
        reach = nextafter(reach, 0.0)
    assert balance([-0.5, 0.0], reach) == 0
    reach = nextafter(reach, 1.0)
    assert reach * (1.0 + 1e-9) + 1e-12 + room == 0.5
    assert balance([-0.5, 0.0], reach) == UNKNOWN


def test_the_gap_of_a_rest_is_to_the_nearest_edge_of_what_acts_alike() -> None:
    """Rests at -3/4, -1/4 and 5/2; deeper than the amplifier tells, and outside the wall, there is no edge."""
    for push in (1.25, 1.75):
        for part, row in ((0.999, 0), (1.001, UNKNOWN)):
            assert balance([1.0 - push, 0.0], 0.25 * part, body=body_of(push=push)) == row
    out, deep = body_of()._replace(drive=2.5), body_of(push=4.75)
    for part, row in ((0.999, 0), (1.001, UNKNOWN)):
        assert balance([2.5, 0.0], 2.5 * part, u=0.0, level=0.0, body=out) == row
        assert balance([-2.75, 0.0], 1.75 * part, u=2.0, level=-2.0, bottom=-2.0, body=deep) == row


def test_a_torque_may_be_wrong_by_more_than_a_rounding() -> None:
    """A torque that is wrong by 1/8 leaves three eighths of a count."""
    for reach, row in ((0.374, 0), (0.376, UNKNOWN)):
        assert balance([-0.5, 0.0], reach, wrong=0.125) == row
    stiff = body_of(beta=4.0, push=3.0)
    for wrong, left in ((0.5, 0.375), (1.0, 0.25)):
        for part, row in ((0.999, 0), (1.001, UNKNOWN)):
            assert balance([-0.5, 0.0], part * left, wrong=wrong, body=stiff) == row


def test_what_a_torque_may_be_wrong_by_counts_in_units_of_a_rounding(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []

    def rest_rounding(*given: Any) -> float:
        asked.append(given)
        return 0.25

    monkeypatch.setattr(friction_rest, "rest_rounding", rest_rounding)
    for u in (1.0, -1.0):
        body = body_of()._replace(drive=-0.5 - u)
        for reach, row in ((0.2499, 0), (0.2501, UNKNOWN)):
            assert balance([-0.25, 0.25], max(0.0, reach - sqrt(0.125)), u=u, wrong=2.0**-40, body=body) == UNKNOWN
            assert balance([-0.5, 0.0], reach, u=u, wrong=2.0**-40, body=body) == row
            assert asked[-1] == ([-0.5, 0.0], -0.5, 1.0 + 2.0**6, body)


def test_reach_counts_by_the_stiffness() -> None:
    """A norm of 1 is half a count; a speed of 1/4 is an eighth."""
    stiff = body_of(beta=4.0, push=3.0)
    for z, left in (([-0.5, 0.0], 0.5), ([-0.5, 0.25], 0.375), ([-0.375, 0.0], 0.375)):
        for part, row in ((0.999, 0), (1.001, UNKNOWN)):
            assert balance(z, part * left, body=stiff) == row


def test_what_a_lag_still_adds_is_counted_by_the_caller() -> None:
    lagging = body_of(lag=0.5)
    for late in (1.0, -7.0, 100.0):
        for reach, row in ((0.499, 0), (0.501, UNKNOWN)):
            ends = ends_of(order=3)
            ends.space.away[:] = [7.0] * len(ends.space.away)
            assert balance([-0.5, 0.0, late], reach, body=lagging, ends=ends) == row
            if row == 0:
                assert ends.states[:3] == [-0.5, 0.0, 1.0]


# Near a rest that friction holds.


def near(
    z: list[float], reach: float, zone: tuple[float, float], *, level: float = -1.0, u: float = 1.0,
    body: Body | None = None, ends: Known | None = None,
) -> int:  # fmt: skip
    cell = cell_of(ends or ends_of(order=len(z)), body or body_of(0.25))
    return int(near_rest(centre_of(z, [], level=level), reach, u, zone, cell))


def place_of(z: list[float], reach: float, zone: tuple[float, float], **more: Any) -> float | None:
    """Place of the rest that is entered; None if none is."""
    ends = ends_of(order=len(z))
    return ends.states[0] if near(z, reach, zone, ends=ends, **more) == 0 else None


def test_the_nearest_rest_is_taken_or_else_the_middle_one() -> None:
    """Either captures what is nearer to it than it is to an edge of its count."""
    assert place_of([-0.625, 0.0], 0.25, (-0.75, -0.25)) == -0.625
    assert place_of([-0.625, 0.0], 0.3749, (-0.75, -0.25)) == -0.625
    assert place_of([-0.625, 0.0], 0.376, (-0.75, -0.25)) is None
    # From -3/4 the gap is a quarter; from the middle it is half a count, a quarter away.
    assert place_of([-0.75, 0.125], 0.1249, (-0.75, -0.25)) == -0.75
    assert place_of([-0.75, 0.125], 0.2, (-0.75, -0.25)) == -0.5
    assert place_of([-0.75, 0.125], 0.2, (-0.75, -0.625)) is None
    assert place_of([-2.75, 0.125], 0.2, (-2.75, -2.25), level=-3.0, u=3.0) == -2.5
    assert place_of([-0.9375, 0.0], 0.0624, (-0.9375, -0.75)) == -0.9375
    assert place_of([-0.9375, 0.0], 0.0624, (-0.75, -0.75)) == -0.75  # the nearest of the zone
    assert place_of([-0.0625, 0.0], 0.0624, (-0.25, -0.25)) == -0.25
    assert place_of([-0.9375, 0.0], 0.0626, (-0.75, -0.75)) is None
    assert place_of([-0.0625, 0.0], 0.0626, (-0.25, -0.25)) is None


def test_no_zone_in_this_count_is_no_rest_in_it() -> None:
    for zone in ((-3.0, -1.0), (0.0, 3.0), (-3.0, -2.0), (1.0, 2.0), (-1.0, -1.0)):
        assert near([-0.5, 0.0], 0.0, zone) == UNKNOWN


def test_a_rest_that_is_held_captures_below_its_margin_less_all_roundings() -> None:
    """A part in 10^9 of the distance, and 64 units of the place."""
    for x, v, away in ((-0.5, 0.0, 0.0), (-0.5, 0.25, 0.25), (-0.5, -0.25, 0.25)):
        reach = (0.5 - 64.0 * EPSILON * 1.5) / (1.0 + 1e-9) - away
        assert near([x, v], reach - 1e-15, (-0.5, -0.5)) == 0
        assert near([x, v], reach + 1e-15, (-0.5, -0.5)) == UNKNOWN
    reach = (0.5 - 64.0 * EPSILON * 100.5) / (1.0 + 1e-9)
    body = body_of(0.25, push=0.0)
    assert near([-99.5, 0.0], reach - 1e-15, (-99.5, -99.5), level=-100.0, u=100.0, body=body) == 0
    assert near([-99.5, 0.0], reach + 1e-15, (-99.5, -99.5), level=-100.0, u=100.0, body=body) == UNKNOWN


def test_a_held_rest_captures_nothing_that_reaches_its_very_margin() -> None:
    reach, room = 0.49999999949, 64.0 * EPSILON * 1.5
    while reach * (1.0 + 1e-9) + room < 0.5:
        reach += 1e-14
    while reach * (1.0 + 1e-9) + room >= 0.5:
        reach = nextafter(reach, 0.0)
    assert near([-0.5, 0.0], reach, (-0.5, -0.5)) == 0
    reach = nextafter(reach, 1.0)
    assert reach * (1.0 + 1e-9) + room == 0.5
    assert near([-0.5, 0.0], reach, (-0.5, -0.5)) == UNKNOWN


def test_a_held_rest_is_of_the_torque_that_is_commanded() -> None:
    assert near([-0.5, 0.0], 0.1, (-0.75, -0.25), level=-2.0, u=2.0) == UNKNOWN
    stiff = body_of(0.25, beta=4.0, push=3.0)
    for z, left in (([-0.5, 0.0], 0.5), ([-0.5, 0.25], 0.375)):
        for part, row in ((0.999, 0), (1.001, UNKNOWN)):
            assert near(z, part * left, (-0.5, -0.5), body=stiff) == row
    ends = ends_of(order=3)
    ends.space.away[:] = [7.0] * len(ends.space.away)
    assert near([-0.5, 0.0, 50.0], 0.499, (-0.5, -0.5), body=body_of(0.25, lag=0.5), ends=ends) == 0
    assert ends.states[:3] == [-0.5, 0.0, 1.0]


# A piece.


class Asked:
    """A piece whose torque ends as told; what the three ways of rest are asked, and what they answer."""

    def __init__(self, patch: pytest.MonkeyPatch, **told: Any) -> None:
        self.told = {"still": True, "u": 1.0, "wrong": 0.0, "left": 0.0, "zone": (4.0, -0.75, -0.25), **told}
        self.calls: list[tuple[str, tuple[Any, ...]]] = []
        self.row = {"held_rest": UNKNOWN, "near_rest": 5, "balance_rest": 6}
        patch.setattr(friction_rest, "settle_memory", self._settle)
        patch.setattr(friction_rest, "hold_zone", lambda u, level, body, wall: self.told["zone"])
        for name in self.row:
            patch.setattr(friction_rest, name, lambda *given, name=name: self._note(name, given))

    def _settle(self, law: Any, x: float, level: float, before: float, ring: Any, wall: Any) -> tuple[Any, ...]:
        return self.told["still"], self.told["u"], self.told["wrong"], self.told["left"]

    def _note(self, name: str, given: tuple[Any, ...]) -> int:
        self.calls.append((name, given))
        return self.row[name]

    def row_of(
        self, body: Body, *, z: tuple[float, ...] = (-0.5, 0.0), error: float = 0.0, radius: float = 0.0,
        corners: tuple[float, ...] = (0.0, 0.0),
    ) -> int:  # fmt: skip
        return rest_of_piece(list(z), error, radius, -1.0, list(corners), SimpleNamespace(law=None, turns=None), body)


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> Any:
    return lambda **told: Asked(monkeypatch, **told)


HOLDS = body_of(0.25, beta=4.0)  # a norm of 1 is half a count
LAGS = body_of(0.25, beta=4.0, lag=0.5)


def test_a_torque_that_goes_on_changing_is_no_rest(asked: Any) -> None:
    one = asked(still=False)
    assert (one.row_of(HOLDS), one.calls) == (UNKNOWN, [])


def test_distances_grow_by_what_torques_still_differ(asked: Any) -> None:
    """By the sum of what commands do, and of a lag that is late until it has gone: by its difference over its rate."""
    for body, z, added in ((HOLDS, (-0.5, 0.5), 0.0), (LAGS, (-0.5, 0.5, 4.0), 6.0), (LAGS, (-0.5, 0.5, -2.0), 6.0)):
        for friction in (True, False):
            one = asked(left=1.0)
            plain = body if friction else body._replace(friction=0.0)
            row = one.row_of(plain, z=z, error=0.25, radius=0.5)
            name, given = one.calls[-1]
            assert (row, name) == ((5, "near_rest") if friction else (6, "balance_rest"))
            away = 0.5 * (0.5 + 0.25 + 1.0 + added)
            assert given[1] == away
            assert len(one.calls) == 1
    one = asked(wrong=0.125)
    one.row_of(HOLDS._replace(friction=0.0))
    centre, _, u, wrong = one.calls[-1][1][:4]
    assert (centre.z, u, wrong) == ([-0.5, 0.0], 1.0, 0.125)


def test_the_zone_is_narrower_by_what_a_torque_may_be_wrong_by(asked: Any) -> None:
    """Over its stiffness; none is left where that is more than its half."""
    for wrong, zone in ((0.0, (-0.75, -0.25)), (0.5, (-0.625, -0.375)), (1.0, (-0.5, -0.5)), (1.0001, None)):
        one = asked(wrong=wrong)
        row = one.row_of(HOLDS, z=(-0.5, 0.5))
        if zone is None:
            assert (row, one.calls) == (UNKNOWN, [])
        else:
            assert (row, one.calls[-1][0], one.calls[-1][1][3][:2]) == (5, "near_rest", zone)
    one = asked(zone=(0.0, 1.0, 0.0))
    assert (one.row_of(HOLDS, z=(-0.5, 0.5)), one.calls) == (UNKNOWN, [])


def test_a_piece_that_stands_is_held_from_its_least_to_its_greatest_place(asked: Any) -> None:
    """However its corners are turned; its own error counts, its radius does not."""
    for corners in ((-0.25, 0.0, 0.125, 0.0), (0.125, 0.0, -0.25, 0.0), (0.0, 0.0, -0.25, 0.0, 0.125, 0.0)):
        for row, last in ((3, "held_rest"), (FULL, "held_rest"), (UNKNOWN, "near_rest"), (0, "held_rest")):
            one = asked()
            one.row["held_rest"] = row
            assert one.row_of(HOLDS, error=0.25, radius=0.5, corners=corners) == (5 if row == UNKNOWN else row)
            assert one.calls[-1][0] == last
            span, zone, shift, reach, u, centre = one.calls[0][1][:6]
            assert (span, zone[:2], shift) == ((-0.75, -0.375), (-0.75, -0.25), 0.0)
            assert (centre.level, u) == (-1.0, 1.0)
            assert reach == 0.125 + 8.0 * EPSILON * 0.5
    one = asked()
    assert one.row_of(HOLDS, corners=(0.0, 0.0, 0.0, 1e-300)) == 5
    assert [name for name, _ in one.calls] == ["near_rest"]


def test_the_zone_of_what_stands_moves_with_its_torque(asked: Any) -> None:
    """By all that commands still differ, and by what the torque is late now and may be until it has come there."""
    for body, z, shift in (
        (HOLDS, (-0.5, 0.0), 0.25), (LAGS, (-0.5, 0.0, 1.5), (1.0 + 1.0 + 0.5) / 4.0),
        (LAGS, (-0.5, 0.0, 0.5), (1.0 + 1.0 + 0.5) / 4.0), (LAGS, (-0.5, 0.0, 1.0), 0.25),
    ):  # fmt: skip
        one = asked(left=1.0)
        one.row_of(body, z=z)
        assert one.calls[0][0] == "held_rest"
        assert one.calls[0][1][2] == shift


def test_the_zone_may_go_on_by_all_that_it_is_narrower(asked: Any) -> None:
    """On either side: friction of 1/4 over a stiffness of 4 holds an eighth of a count."""
    for wrong, narrow in ((0.0, 0.0), (0.0, 2.0**-10), (0.125, 0.0), (0.125, 2.0**-10)):
        one = asked(wrong=wrong, zone=(4.0, -0.5625 + narrow, -0.4375 - narrow))
        one.row_of(HOLDS)
        by = narrow + wrong / 4.0
        assert one.calls[0][1][1] == (-0.5625 + by, -0.4375 - by, 2.0 * by)


def test_the_norm_of_these_tests() -> None:
    assert (HOLDS.reach, LAGS.reach, body_of(0.25).reach) == (0.5, 0.5, 1.0)
    assert sqrt(HOLDS.beta) == 2.0
