"""The proof of a cycle under a law on its margins: a map of known matrix and memory stands in for a period's motion."""

from itertools import product
from math import inf, nextafter, sqrt
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
import pytest

from hknob_cli.engine.certificate import DIFFERENT, EPSILON, NEUTRAL, NOT_CAPTURED, ON_EDGE, PROVEN
from hknob_cli.engine.general import cogging
from hknob_cli.engine.general.body import Body, distance, norm, stiffness
from hknob_cli.engine.general.cogging import far_around
from hknob_cli.engine.general.columns import TURN_ROOM
from hknob_cli.engine.general.controller import count_gap, edge_gap, read, read_after
from hknob_cli.engine.general.laws import period as proof
from hknob_cli.engine.general.laws.cascade import apart
from hknob_cli.engine.general.laws.law import LOOK, PIECE
from hknob_cli.engine.general.laws.period import AT_EVENT, AT_SWITCH, EXPANDS
from hknob_cli.engine.general.laws.period import PARTS as PARTED
from hknob_cli.engine.general.laws.step import FREE
from hknob_cli.engine.general.search import make_space
from tests.engine.general.bodies import fresh_marks

from .test_period_map_margins import most_of
from .test_standstill_margins import FINGER, LAGGING, WALL, body

UNIT = 2.0**-20  # of a rounding, here
QUICK = np.array([[0.3, 0.4], [-0.2, 0.1]])
PLACE = (-2.5, 0.25)
# A number that is counted, one that fades (with the next, as a pair), one that is a sum or an anchor, the last reading,
# and the torques of three samples, two parts each.
COUNTED, FADES, SUM, LINE, PARTS, AGES = 0, 1, 3, 5, 2, 3
PAST = [4.0, 1.5, -0.75, -6.0, -3.0, 0.5, -0.25, 1.0, -2.0, 0.75, -1.25]
PAIR = [0.5, 0.25, -0.25, 0.5, 1.0, 0.5, -0.25, 2.0, 3.0]


def law_of(**more: Any) -> Any:
    one = {
        "unit": 1.0,
        "provable": True, "senses": False, "line": LINE, "parts": PARTS, "ages": AGES, "pieces": 2, "fading": -1,
        "fade": 0.0, "weight": 0.0, "coarse": 2.0, "guarded": False, "anchor": -1, "drifts": -1, "pair": [],
        "watch": WALL, "room": [7.0], "beside": [7.0] * len(PAST), "periodic": [7.0] * len(PAST), "sched": [],
    }  # fmt: skip
    return SimpleNamespace(**(one | more))


def fading(**more: Any) -> Any:
    return law_of(**({"fading": FADES, "fade": 0.5, "weight": 0.25} | more))


class Stage(NamedTuple):
    """What a period is made to be: w -> w + (1 - matrix) (place - w) + off, with these margins; what it remembers."""

    matrix: np.ndarray = QUICK
    place: tuple[float, ...] = PLACE
    off: tuple[float, ...] = ()
    margin: float = 1e9
    reach: float = 3.0
    pace: float = 0.5
    guard: float = 1e9
    strength: float = 5.0
    anchored: bool = True
    marks: tuple[float, ...] = tuple(fresh_marks())
    missed: float | None = None  # by which what fades is not back, wherever it begins; else it fades to 2
    late: tuple[float, ...] = (0.0,) * (PARTS * AGES)
    sinks: float = 0.0
    counted: float = 0.0
    repeats: bool = True
    solves: float = 1.0  # part of its way that a step goes


class Result(NamedTuple):
    """What `certify_with_law` gives, and leaves."""

    status: int
    margin: float
    edge: float
    closure: float
    bound: float
    space: Any
    seen: list[list[float]]  # where each turn began
    residual: np.ndarray  # of the last turn
    asked: list[tuple[float, int]]  # scale and samples that `dissipates` is asked with


def prove(
    stage: Stage,
    law: Any,
    *,
    one: Body | None = None,
    wall: Any = WALL,
    z: Any = None,
    past: list[float] | None = None,
    period: int = 4,
    unit: float = UNIT,
) -> Result:
    one = one or body()
    n, m = one.order, len(stage.matrix)
    space = make_space(n, len(PAST), lambda count: [7.0] * count)
    seen: list[list[float]] = []
    asked: list[tuple[float, int]] = []
    residual: list[float] = []
    place = np.array(stage.place)

    def turn(beside: Any, samples: int, _: Any, __: Any, ___: Any, room: Any, count: int) -> Any:
        assert (samples, count) == (period, n)
        assert beside == law.periodic
        assert beside is not law.periodic
        w = np.array(room.orbit)
        seen.append(w.tolist())
        out = w + stage.solves * (np.eye(m) - stage.matrix) @ (place - w) + (np.array(stage.off) if stage.off else 0.0)
        for c, i in product(range(n), range(n)):
            room.cols[c * room.width + i] = float(stage.matrix[i, c])
        residual[:] = (out - w).tolist()
        room.state[:] = out.tolist()
        room.marks[:] = list(stage.marks)
        beside[COUNTED] += stage.counted
        if law.fading >= 0:
            if stage.missed is None:
                beside[law.fading] = 2.0 + law.fade**period * (beside[law.fading] - 2.0)
            else:
                beside[law.fading] += stage.missed
        if law.drifts >= 0:
            beside[law.drifts] -= stage.sinks
        for j, late in enumerate(stage.late):
            beside[LINE + j] += late
        return stage.margin, 0.3, stage.reach, stage.pace, stage.guard, stage.strength, stage.anchored

    def find(z: Any, past: Any, samples: int, *_: Any) -> bool:
        assert samples == period
        law.periodic[:] = PAST
        return stage.repeats

    true = proof.dissipates

    def dissipates(cols: Any, stride: int, power: Any, spare: Any, m: int, scale: float, samples: int) -> bool:
        asked.append((scale, samples))
        return bool(true(cols, stride, power, spare, m, scale, samples))

    memory, start = list(past or PAST), [float(x) for x in (stage.place if z is None else z)]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(proof, "EPSILON", unit)
        patch.setattr(proof, "turn_with_law", turn)
        patch.setattr(proof, "find_periodic_past", find)
        patch.setattr(proof, "dissipates", dissipates)
        found = proof.certify_with_law(list(start), memory, period, one, wall, law, space)
    assert memory == (past or PAST)
    return Result(*found, space, seen, np.array(residual), asked)


def wrong_of(stage: Stage, law: Any, wall: Any = WALL, period: int = 4) -> tuple[float, float]:
    """By how much a torque may be wrong, and what fades: in full, from the sentences of the source."""
    worn = 0.0
    if law.fading >= 0:
        size, swell = abs(law.periodic[law.fading]), 1.0
        if len(law.pair):
            size, swell = size + abs(law.periodic[FADES + 1]), law.pair[8]
        worn = abs(stage.missed or 0.0) / (1.0 - law.fade**period)
        worn += 16.0 * UNIT * (size + stage.strength / law.unit + stage.reach) * swell / (1.0 - law.fade)
    terms = law.coarse * (stage.strength + law.unit * (1.0 + stage.reach))
    wrong = law.weight * worn + max(abs(x) for x in stage.late[PARTS:]) + 16.0 * UNIT * terms
    if law.anchor >= 0 and stage.anchored:
        wrong += 16.0 * UNIT * terms * period**2 * (1.0 + stage.pace)
    return wrong, worn


def errors(
    stage: Stage, law: Any, one: Body, residual: np.ndarray, wall: Any = WALL, period: int = 4
) -> tuple[np.ndarray, float]:
    """Of the state at the first sample, and by how much a torque may be wrong."""
    n = one.order
    wrong, _ = wrong_of(stage, law, wall, period)
    drift = wrong * period * (1.0 + sqrt(one.ratio))
    each = 8.0 * UNIT * period * law.pieces
    parts = []
    for j in range(n):
        speed = j % 2 == 1 and not (one.lag > 0.0 and j == n - 1)
        shift = drift * max(1.0, min(period, one.reach))
        parts.append(2.0 * stage.pace * each + drift if speed else (stage.reach + stage.pace) * each + shift)
    return np.abs(np.linalg.inv(np.eye(n) - stage.matrix)) @ (np.abs(residual) + parts), wrong


# The bound.


LAWS = {
    "plain": law_of(),
    "fading": fading(),
    "fading slowly": fading(fade=0.875, weight=3.0),
    "first row": fading(fading=0),
    "pair": fading(pair=PAIR),
    "anchor": law_of(anchor=SUM),
    "coarse": law_of(coarse=64.0, pieces=3),
}
BODIES = {
    "planar": body(),
    "soft": body(beta=0.01),
    "stiff": body(beta=9.0),
    "finger": FINGER._replace(order=4, lag=0.0, friction=0.0, reach=1.25),
    "coil and lag": LAGGING._replace(order=4, coil=2.0, coil_rate=1.0, friction=0.0, reach=1.5),
}


@pytest.mark.parametrize("period", [1, 4, 30])
@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("form", BODIES)
def test_the_bound_is_of_every_error_through_the_inverse(form: str, name: str, period: int) -> None:
    one, law, wall = BODIES[form], SimpleNamespace(**(vars(LAWS[name]) | {"unit": 0.25})), WALL
    n = one.order
    numbers = np.random.default_rng(n)
    matrix = QUICK if n == 2 else 0.3 * numbers.normal(size=(n, n))
    for missed, late, signed in ((0.0, 0.0, 1.0), (0.001, 0.0, 1.0), (-0.001, 0.002, -1.0)):
        torques = (9.0, 9.0, 0.0, signed * 0.5 * late, signed * late, 0.0)
        stage = Stage(matrix, (*PLACE, *([0.5] * (n - 2))), missed=missed, late=torques)
        if law.pair:
            stage = stage._replace(missed=0.0)
        found = prove(stage, law, one=one, wall=wall, period=period)
        away, wrong = errors(stage, law, one, found.residual, wall, period)
        np.testing.assert_allclose(found.space.away[:n], away, rtol=1e-12)
        later = most_of(distance, away, one) + one.reach * wrong * period
        assert later > away[0]
        assert found.bound == pytest.approx(later, rel=1e-12)
        assert (found.margin, found.edge, found.closure) == (1e9, 0.3, 0.0)


def test_torques_under_way_count_one_by_one() -> None:
    """All but those of the oldest sample, which have acted."""
    law = law_of()
    for at, sign in product(range(PARTS * AGES), (1.0, -1.0)):
        late = [0.0] * (PARTS * AGES)
        late[at] = sign * 0.125
        stage = Stage(late=tuple(late))
        found = prove(stage, law)
        plain = prove(Stage(), law)
        assert (found.bound > plain.bound + 0.1) is (at >= PARTS)
        np.testing.assert_allclose(found.space.away[:2], errors(stage, law, body(), found.residual)[0], rtol=1e-12)


def test_what_is_left_of_a_residual_counts_in_full() -> None:
    law = law_of()
    for off in ((1e-6, 0.0), (-1e-6, 0.0), (0.0, 2e-6), (0.0, -2e-6), (1e-6, -1e-6)):
        stage = Stage(off=off)
        found = prove(stage, law)
        away, _ = errors(stage, law, body(), np.array(off))
        assert found.closure == pytest.approx(sqrt(off[0] ** 2 + off[1] ** 2), rel=1e-8)
        np.testing.assert_allclose(found.space.away[:2], away, rtol=1e-9)


def test_only_a_law_that_begins_anew_pays_for_its_sum_and_only_if_it_does() -> None:
    bounds = {
        (anchor, anchored): prove(Stage(anchored=anchored), law_of(anchor=anchor, drifts=-1)).bound
        for anchor, anchored in product((-1, 0, SUM), (True, False))
    }
    assert bounds[0, True] == bounds[SUM, True] > 2.0 * bounds[-1, True]
    assert bounds[-1, False] == bounds[-1, True] == bounds[0, False] == bounds[SUM, False]


@pytest.mark.parametrize(
    ("reach", "pace", "scale"), [(3.0, 1.0, 0.25), (1.0, 0.0, 1.0), (1.0, 1e-5, 1e-3), (1.0, 0.002, 0.002 / 1.002)]
)
def test_the_unit_of_speeds_is_the_pace_of_the_orbit(reach: float, pace: float, scale: float) -> None:
    assert prove(Stage(reach=reach, pace=pace), law_of()).asked == [(pytest.approx(scale, rel=1e-15), 4)]


# Newton's method.


@pytest.mark.parametrize("name", ["plain", "fading", "pair"])
def test_the_orbit_is_the_fixed_point_and_so_is_what_fades(name: str) -> None:
    one, law = LAGGING._replace(reach=1.0, friction=0.0), LAWS[name]
    numbers = np.random.default_rng(3)
    stage = Stage(0.3 * numbers.normal(size=(3, 3)), (-2.5, 0.25, 1.0), missed=0.0 if name == "pair" else None)
    z = np.array(stage.place) + 1e-3 * numbers.normal(size=3)
    found = prove(stage, law, one=one, z=z, unit=EPSILON)
    assert (found.status, found.margin, found.edge) == (PROVEN, 1e9, 0.3)
    np.testing.assert_allclose(found.space.orbit, stage.place, atol=1e-14)
    assert found.space.orbit == found.seen[-1]
    assert 2 <= len(found.seen) <= 4
    assert found.closure <= 4.0 * EPSILON * 3.5
    if name == "fading":
        assert law.periodic[FADES] == pytest.approx(2.0, abs=1e-15)
        assert law.beside[FADES] == pytest.approx(2.0, abs=1e-15)
    kept = [j for j in range(len(PAST)) if j != FADES]
    assert [law.periodic[j] for j in kept] == [PAST[j] for j in kept]


def test_the_residual_is_that_of_the_orbit_that_is_left() -> None:
    """Of a map whose derivative is not the given one, so that each step takes off two thirds alone."""
    stage = Stage(solves=2.0 / 3.0)
    found = prove(stage, law_of(), z=[-2.49, 0.25], unit=EPSILON)
    assert (found.status, len(found.seen)) == (PROVEN, proof.NEWTON_STEPS)
    assert found.space.orbit == found.seen[-1]
    assert found.closure == pytest.approx(float(np.linalg.norm(found.residual)), rel=1e-9)
    inverse = np.linalg.inv(np.eye(2) - QUICK)
    np.testing.assert_allclose(found.space.away[:2], np.abs(inverse) @ np.abs(found.residual), rtol=1e-6)


def test_a_step_that_takes_off_less_than_half_is_the_last() -> None:
    for part, turns in ((0.4, 2), (0.6, proof.NEWTON_STEPS)):
        assert len(prove(Stage(solves=part), law_of(), z=[-2.499, 0.25], unit=EPSILON).seen) == turns


def test_a_motion_that_does_not_close_is_another() -> None:
    """A singular derivative ends the search at once: 1e-6 of reach and pace decides."""
    for off, status in (
        ((0.6, 0.8), NEUTRAL), ((0.9, 0.1), NEUTRAL), ((-0.9, -0.1), NEUTRAL),
        ((1.01, 0.0), DIFFERENT), ((0.0, -1.01), DIFFERENT), ((0.8, 0.8), DIFFERENT),
    ):  # fmt: skip
        stage = Stage(np.eye(2), off=tuple(3.499e-6 * x for x in off))
        found = prove(stage, law_of(), unit=EPSILON)
        assert found.status == status
        assert len(found.seen) == 1
        if status == NEUTRAL:
            assert found.closure == pytest.approx(3.499e-6 * sqrt(off[0] ** 2 + off[1] ** 2), rel=1e-8)
            assert (found.margin, found.edge, found.bound) == (1e9, 0.3, 0.0)
        else:
            assert found[1:5] == (0.0, 0.0, 0.0, 0.0)
    for closure, status in ((1e-6, DIFFERENT), (nextafter(1e-6, 0.0), NEUTRAL)):
        stage = Stage(np.eye(2), place=(0.0, 0.0), off=(closure, 0.0), reach=0.5)
        assert prove(stage, law_of()).status == status


def test_readings_and_counts_that_do_not_come_back_are_no_orbit() -> None:
    for stage in (Stage(repeats=False), Stage(counted=1.0)):
        assert prove(stage, fading())[:5] == (DIFFERENT, 0.0, 0.0, 0.0, 0.0)


# What refuses a proof.


@pytest.mark.parametrize("form", ["planar", "stiff", "finger", "lag"])
def test_a_standstill_within_the_error_is_not_decided(form: str) -> None:
    """A torque that the error may change twice over, and a speed that it may turn round."""
    one = LAGGING._replace(reach=1.0) if form == "lag" else BODIES[form]
    law, n = fading(weight=1.0), one.order
    matrix = np.diag([0.5, -0.25, 0.25, 0.5][:n]) + 0.05
    stage = Stage(matrix, (*PLACE, *([0.5] * (n - 2))), missed=0.001)
    found = prove(stage, law, one=one._replace(friction=1.0))
    wrong, _ = wrong_of(stage, law)
    speed = most_of(norm, found.space.away[:n], one) + wrong * 4
    late = found.space.away[2] if form == "lag" else 0.0
    torque = 2.0 * (stiffness(one) * speed + late + wrong)
    for marks, status in (
        ((1.0001 * torque, 1.0001 * speed), PROVEN), ((0.9999 * torque, inf), AT_EVENT),
        ((inf, 0.9999 * speed), AT_EVENT), ((0.0, inf), AT_EVENT), ((inf, 0.0), AT_EVENT), ((0.0, 0.0), AT_EVENT),
    ):  # fmt: skip
        for friction in (1.0, 1e-9):
            again = prove(stage._replace(marks=marks), law, one=one._replace(friction=friction))
            assert again.status == status
            assert (again.margin, again.edge, again.bound) == (1e9, 0.3, found.bound)
        assert prove(stage._replace(marks=marks), law, one=one._replace(friction=0.0)).status == PROVEN


def test_a_standstill_beside_cogging_has_its_spring_too() -> None:
    """The root of a slope of 4 counts the error of a place as a speed, and speeds as torques."""
    one = body(beta=1.0, alpha=1.0)._replace(cogs=[4.0, 8.0, -2.5, 16.0, 2.0, 0.0])
    law, stage = fading(weight=1.0), Stage(missed=0.001)
    found = prove(stage._replace(marks=(inf, inf, inf, inf)), law, one=one._replace(friction=1.0))
    assert found.status == PROVEN
    wrong, _ = wrong_of(stage, law)
    speed = norm(found.space.away, one) + 2.0 * found.space.away[0] + wrong * 4
    torque = 2.0 * ((stiffness(one) + 2.0) * speed + wrong)
    for marks, status in (
        ((1.0001 * torque, 1.0001 * speed, inf, inf), PROVEN),
        ((0.9999 * torque, inf, inf, inf), AT_EVENT),
        ((inf, 0.9999 * speed, inf, inf), AT_EVENT),
    ):
        assert prove(stage._replace(marks=marks), law, one=one._replace(friction=1.0)).status == status


def test_a_cycle_is_proven_where_springs_hold_the_knob_or_there_is_room(monkeypatch: pytest.MonkeyPatch) -> None:
    """By a slope of a quarter alone; on the next one, and where hand and slope cancel, with room to corners."""
    monkeypatch.setattr(cogging, "SPRINGS", 0.0)
    free, soft = body(beta=0.0)._replace(reach=inf), body(beta=0.25)._replace(reach=2.0)
    near = fresh_marks()
    near[TURN_ROOM] = -1.0
    for one, centre, holds in ((free, -2.5, True), (free, 5.5, False), (soft, -2.5, True), (soft, 5.5, False)):
        beside = one._replace(cogs=[0.25, 8.0, centre, 1.0, 0.5, 0.0])
        found = prove(Stage(), law_of(), one=beside, unit=EPSILON)
        assert found.status == PROVEN
        assert found.bound < 1.0
        assert (found.margin < 1.0) == (not holds)
        found = prove(Stage(marks=tuple(near)), law_of(), one=beside, unit=EPSILON)
        assert found.status == (PROVEN if holds else PARTED)


def over_corners(monkeypatch: pytest.MonkeyPatch, room: float, one: Body, **more: Any) -> tuple[Result, list[Any]]:
    """The proof where `room_over_corners` is what it is said to be, with a growth of 4; what that is asked with."""
    asked: list[Any] = []

    def stand_in(*given: Any) -> tuple[float, float, float]:
        asked.append(given)
        return room, 0.0625, 4.0

    with monkeypatch.context() as patch:
        patch.setattr(proof, "room_over_corners", stand_in)
        stage = Stage(marks=(inf, inf, inf, -1.0), margin=0.4, **more.pop("stage", {}))
        return prove(stage, more.pop("law", law_of()), one=one, unit=EPSILON, **more), asked


def test_the_room_over_corners_is_less_by_a_growth(monkeypatch: pytest.MonkeyPatch) -> None:
    """Which torques under way that are not the orbit's may have; it must be above what nothing comes nearer than."""
    one, nearest = body(beta=0.0)._replace(reach=inf, cogs=[0.25, 8.0, 5.5, 1.0, 0.5, 0.0]), 1e-13 * 3.5
    for room, status in ((2.0, PROVEN), (nextafter(nearest, inf), PROVEN), (nearest, PARTED), (-1.0, PARTED)):
        found, asked = over_corners(monkeypatch, room, one)
        assert (found.status == PARTED) == (status == PARTED)
        assert found.edge == 0.3
        assert (found.bound == 0.0625) is (status == PROVEN)
        assert found.margin == (0.4 if status == PARTED else room / 4.0 + 0.0625)
        ((fast, slow, margin, late, period, body_asked, space, scale),) = asked
        wrong, _ = wrong_of(Stage(), law_of())
        wrong *= EPSILON / UNIT
        rounding = 8.0 * EPSILON * 4 * 2
        assert fast == pytest.approx(rounding * 3.5 + wrong * 4 * 2.0, rel=1e-12)
        assert slow == pytest.approx(rounding * 1.0 + wrong * 4, rel=1e-12)
        assert (margin, late, period, body_asked, space) == (0.4, 1.0, 4, one, found.space)
        assert scale == 0.5 / 3.5
    away = far_around(one.cogs, [1.0, 0.0], PLACE[0], one)
    for part, status in ((0.999, PROVEN), (1.001, NOT_CAPTURED)):
        z = [PLACE[0] + part * 0.5 / away, PLACE[1]]
        assert over_corners(monkeypatch, 2.0, one, z=z)[0].status == status
    found, asked = over_corners(monkeypatch, 2.0, one._replace(friction=1.0, play=0.0), law=law_of())
    assert (found.status, len(asked)) == (PROVEN, 1)
    monkeypatch.setattr(proof, "goes_over", lambda _: False)
    found, asked = over_corners(monkeypatch, 2.0, one)
    assert (found.status, found.margin, asked) == (PARTED, 0.4, [])


def test_at_the_very_limit_of_a_standstill_nothing_is_proven() -> None:
    one, law, stage = body(friction=1.0), law_of(), Stage()
    found = prove(stage, law, one=one)
    wrong, _ = wrong_of(stage, law)
    speed = norm(found.space.away, one) + wrong * 4
    torque = 2.0 * (stiffness(one) * speed + 0.0 + wrong)
    for marks, status in (
        ((torque, inf), AT_EVENT), ((nextafter(torque, inf), inf), PROVEN),
        ((inf, speed), AT_EVENT), ((inf, nextafter(speed, inf)), PROVEN),
    ):  # fmt: skip
        assert prove(stage._replace(marks=marks), law, one=one).status == status


def test_an_orbit_within_its_error_of_an_edge_is_not_decided() -> None:
    z = [PLACE[0] + 1e-3, PLACE[1]]
    bound = prove(Stage(), law_of(), z=z).bound
    for margin, status in ((0.999 * bound, ON_EDGE), (bound, ON_EDGE), (-1.0, ON_EDGE), (1.1 * bound, NOT_CAPTURED)):
        found = prove(Stage(margin=margin), law_of(), z=z)
        assert (found.status, found.margin, found.edge, found.bound) == (status, margin, 0.3, bound)


def test_a_guard_must_clear_what_is_worn() -> None:
    for law in (fading(guarded=True), fading(guarded=True, weight=0.0)):
        stage = Stage(missed=2.0**-10)
        prove(stage, law, period=1)
        _, worn = wrong_of(stage, law, period=1)
        for guard, status in (
            (worn, AT_SWITCH),
            (0.5 * worn, AT_SWITCH),
            (0.0, AT_SWITCH),
            (nextafter(worn, 1.0), PROVEN),
        ):
            found = prove(stage._replace(guard=guard), law, period=1)
            assert (found.status, found.margin, found.edge) == (status, 1e9, 0.3)
            assert found.bound > 0.0
            assert law.room[0] == guard - worn
        law.guarded = False
        assert prove(stage._replace(guard=0.0), law, period=1).status == PROVEN


def test_the_room_is_the_guard_less_what_is_worn() -> None:
    """Of a sum, in whichever row, it is what that may rise by instead."""
    for law, less in ((law_of(), 0.0), (fading(), wrong_of(Stage(), fading(periodic=PAST))[1])):
        prove(Stage(guard=3.0, missed=0.0), law)
        assert law.room == [3.0 - less]
    law = law_of(drifts=0)
    prove(Stage(guard=3.0), law)
    assert law.room == [-inf]


def test_nothing_is_proven_of_a_knob_that_nothing_holds() -> None:
    assert prove(Stage(), law_of(), one=body(beta=0.0))[0] == ON_EDGE


def test_a_map_that_does_not_contract_proves_nothing() -> None:
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    for matrix, status in ((turn, EXPANDS), (1.5 * turn, EXPANDS), (0.9 * turn, PROVEN)):
        found = prove(Stage(matrix), law_of(), period=1, unit=EPSILON)
        assert (found.status, found.margin, found.edge) == (status, 1e9, 0.3)
        assert found.bound > 0.0


# Sums.


def test_a_sum_must_come_back_or_sink() -> None:
    """One that has begun anew comes back to the last bit; one that has not must sink far enough below its guard."""
    law, still = law_of(drifts=SUM), law_of(drifts=-1)
    for anchored, sinks, guard, status in (
        (True, 0.0, 1e9, PROVEN), (True, 1e-9, 1e9, DIFFERENT), (True, 0.5, 1e9, DIFFERENT),
        (False, 0.5, 1e9, PROVEN), (False, 0.0, 1e9, EXPANDS), (False, -0.5, 1e9, EXPANDS), (False, 0.5, 0.0, EXPANDS),
        (False, -0.5, 0.1, EXPANDS),
    ):  # fmt: skip
        found = prove(Stage(anchored=anchored, sinks=sinks, guard=guard), law)
        assert found.status == status
        if status == DIFFERENT:
            assert found[1:5] == (0.0, 0.0, 0.0, 0.0)
        else:
            assert found.bound > 0.0
    assert prove(Stage(anchored=False), still).status == EXPANDS
    assert prove(Stage(anchored=True), still).status == PROVEN


def test_the_room_of_a_sum_is_what_it_may_rise_by() -> None:
    law = law_of(drifts=SUM)
    prove(Stage(anchored=False, sinks=0.5, guard=3.0), law)
    settled, spare = proof.drift_of(3.0, 5.0, 0.5, 4, law)
    assert settled
    assert law.room == [spare]
    for above, status in ((0.999, PROVEN), (1.001, NOT_CAPTURED)):
        other = Stage(anchored=False, sinks=0.5, guard=3.0)
        assert captured(other, law, {SUM: above * spare}) == status
    assert captured(Stage(anchored=True), law, {SUM: 0.0}) == PROVEN
    assert law.room == [-inf]
    assert captured(Stage(anchored=True), law, {SUM: -1.0}) == NOT_CAPTURED


@pytest.mark.parametrize("signs", list(product((1.0, -1.0), repeat=2)))
def test_a_sum_sinks_by_more_than_its_roundings(signs: tuple[float, float]) -> None:
    """16 of them a sample, of 1, of what it was and is, and of torques times ways; and SURE of that is left free."""
    law = law_of(drifts=SUM, unit=0.5)
    before, after = sorted((signs[0] * 3.0, signs[1] * 2.0), reverse=True)
    size = 1.0 + 5.0 + 6.0 / 0.5 * 0.25
    for unit, sinks in (((before - after) / (16.0 * 7 * size), False), ((before - after) / (16.1 * 7 * size), True)):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(proof, "EPSILON", unit)
            patch.setattr(proof, "SURE", 2.0**-4)
            law.periodic[SUM], law.beside[SUM] = before, after
            for guard in (size / 16.0, nextafter(size / 16.0, inf), 2.0):
                found, spare = proof.drift_of(guard, 6.0, 0.25, 7, law)
                assert spare == guard - size / 16.0
                assert found is (sinks and spare > 0.0)
            law.periodic[SUM], law.beside[SUM] = after, before
            assert not proof.drift_of(2.0, 6.0, 0.25, 7, law)[0]
    assert proof.drift_of(2.0, 6.0, 0.25, 7, law_of()) == (False, -inf)
    first = law_of(drifts=0)
    first.periodic[0], first.beside[0] = 2.0, 1.0
    assert proof.drift_of(2.0, 6.0, 0.25, 7, first)[0]


# What is captured.


def moved(by: dict[int, float]) -> list[float]:
    past = list(PAST)
    for at, one in by.items():
        past[at] += one
    return past


def captured(stage: Stage, law: Any, by: dict[int, float], **more: Any) -> int:
    """Status of a trial whose memory differs from the orbit's by so much."""
    return prove(stage, law, past=moved(by), **more).status


@pytest.mark.parametrize("form", ["planar", "soft"])
def test_a_trial_is_captured_within_the_margin(form: str) -> None:
    """By state, by what fades, by torques under way; the orbit's own error counts, too."""
    one, law = BODIES[form], fading()
    for direction, by in (
        ((1.0, 0.0), {}), ((-1.0, 0.0), {}), ((0.0, 1.0), {}), ((0.6, -0.8), {}), ((0.0, 0.0), {FADES: 1.0}),
        ((0.0, 0.0), {FADES: -1.0}), ((0.0, 0.0), {LINE + PARTS: 1.0}), ((0.0, 0.1), {LINE + 5: -2.0, FADES: 1.0}),
    ):  # fmt: skip
        stage, z = Stage(missed=1e-4), [x + d for x, d in zip(PLACE, direction, strict=True)]
        near = prove(stage, law, one=one, z=z, past=moved(by), unit=EPSILON)
        assert near.status == PROVEN
        off = [x - y for x, y in zip(z, near.space.orbit, strict=True)]
        limit = apart(off, near.space.orbit[0], moved(by), law.periodic, one, law) + near.bound
        assert limit > 0.4
        for margin, status in ((limit, NOT_CAPTURED), (nextafter(limit, inf), PROVEN)):
            found = prove(stage._replace(margin=margin), law, one=one, z=z, past=moved(by), unit=EPSILON)
            assert (found.status, found.margin, found.edge, found.bound) == (status, margin, 0.3, near.bound)


def test_what_fades_must_clear_the_guard_with_what_is_worn() -> None:
    law = fading(guarded=True, weight=0.0)
    prove(Stage(guard=3.0, missed=0.0), law)
    room = law.room[0]
    assert 2.9 < room < 3.0
    for by, status in (
        (room, NOT_CAPTURED),
        (-room, NOT_CAPTURED),
        (room - 2.0**-40, PROVEN),
        (2.0**-40 - room, PROVEN),
    ):
        assert captured(Stage(guard=3.0, missed=0.0), law, {FADES: by}) == status
    law.guarded = False
    assert captured(Stage(guard=3.0, missed=0.0), law, {FADES: 2.0 * room}) == PROVEN


# A law that cannot be proven, and one that reads the speed.


def test_a_law_is_proven_by_what_it_reads(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(proof, "certify_repeat", lambda *_: (11, 1.0, 2.0, 3.0, 4.0))
    monkeypatch.setattr(proof, "certify_sensed", lambda *_: (12, 1.0, 2.0, 3.0, 4.0))
    assert prove(Stage(), law_of()).status == PROVEN
    assert prove(Stage(), law_of(senses=True)).status == 12
    assert prove(Stage(), law_of(senses=True, provable=False)).status == 11


@pytest.mark.parametrize("order", [2, 3])
def test_what_cannot_be_proven_comes_back_to_eight_digits(monkeypatch: pytest.MonkeyPatch, order: int) -> None:
    """Of reach and pace, in every entry of the state; in what is remembered, of 1 and the number itself."""
    monkeypatch.setattr(proof, "REPEATS", 2.0**-20)
    one = LAGGING._replace(order=order)
    space = make_space(order, len(PAST), lambda count: [7.0] * count)
    law = law_of(provable=False, drifts=SUM)
    start = [-2.5, 0.25, 1.0][:order]
    for at, sign, part in product(range(order), (1.0, -1.0), (1.0, 1.0 + 2.0**-20)):
        off = sign * part * 2.0**-18

        def turn(past: Any, period: int, *rest: Any, at: int = at, off: float = off) -> Any:
            room, count = rest[-2:]
            assert (past, period, count) == (law.beside, 4, order)
            assert (room.orbit, past) == (start, PAST)
            room.state[:] = start
            room.state[at] += off
            return 0.4, 0.3, 3.5, 0.5, 0.0, 0.0, True

        monkeypatch.setattr(proof, "turn_with_law", turn)
        law.periodic = [7.0] * len(PAST)
        found = proof.certify_with_law(list(start), list(PAST), 4, one, WALL, law, space)
        if part == 1.0:
            assert found == (EXPANDS, 0.4, 0.3, 2.0**-18, 2.0**-18)
            assert law.periodic == PAST
        else:
            assert found == (DIFFERENT, 0.0, 0.0, 0.0, 0.0)
    for at, part in product((COUNTED, LINE - 1, SUM), (1.0, 1.001)):

        def changed(past: Any, period: int, *rest: Any, at: int = at, part: float = part) -> Any:
            rest[-2].state[:] = start
            past[at] += part * 2.0**-20 * (1.0 + abs(past[at]))
            return 0.4, 0.3, 3.5, 0.5, 0.0, 0.0, True

        monkeypatch.setattr(proof, "turn_with_law", changed)
        found = proof.certify_with_law(list(start), list(PAST), 4, one, WALL, law, space)
        assert found[0] == (EXPANDS if part == 1.0 or at == SUM else DIFFERENT)


# What is remembered at the start of a period.


@pytest.mark.parametrize(("period", "laps"), [(1, 3), (2, 2), (3, 1), (5, 1)])
def test_what_fades_settles_and_then_the_torques_under_way(
    monkeypatch: pytest.MonkeyPatch, period: int, laps: int
) -> None:
    """From the same state at the start of each lap, for as many laps as torques are under way."""
    law, z, states = fading(), [-2.5, 0.25], []
    space = make_space(2, len(PAST), lambda count: [7.0] * count)
    spoilt: dict[str, int] = {}

    def advance(state: Any, past: Any, *_: Any) -> float:
        states.append(list(state))
        state[0] += 1.0
        past[FADES] = 0.5 * past[FADES] + 1.0 + 0.125 * (len(states) % period)
        past[LINE:-PARTS] = past[LINE + PARTS :]
        past[-PARTS:] = [past[FADES], -past[FADES]]
        if len(states) == spoilt.get("at"):
            past[COUNTED] += 1.0
        return FREE

    monkeypatch.setattr(proof, "advance_with_law", advance)
    assert proof.find_periodic_past(z, PAST, period, body(), WALL, law, space)
    assert states == [[-2.5 + k, 0.25] for k in range(period)] * (1 + laps)
    kept = list(law.periodic)
    for _ in range(period):
        advance([0.0, 0.0], kept)
    assert kept == pytest.approx(law.periodic, abs=1e-12)
    for at, found in ((period, False), (period + 1, False), (period * (1 + laps), False), (-1, True)):
        states.clear()
        spoilt["at"] = at
        assert proof.find_periodic_past(z, PAST, period, body(), WALL, law, space) is found


@pytest.mark.parametrize(
    ("more", "laps"),
    [
        ({}, 1),
        ({"fading": FADES, "fade": 0.5}, 2),
        ({"fading": 0, "fade": 0.5}, 2),
        ({"drifts": SUM}, 2),
        ({"drifts": 0}, 2),
        ({"ages": 2}, 2),
        ({"ages": 3}, 2),
    ],
)
def test_another_lap_is_run_where_it_is_not_the_first_one_again(
    monkeypatch: pytest.MonkeyPatch, more: dict[str, Any], laps: int
) -> None:
    """For what fades or is a sum, and torques under way: without them what is remembered decides all of a lap."""
    law, samples = law_of(**({"ages": 1} | more)), []
    space = make_space(2, len(PAST), lambda count: [7.0] * count)
    monkeypatch.setattr(proof, "advance_with_law", lambda *_: samples.append(0) or FREE)
    assert proof.find_periodic_past([-2.5, 0.25], PAST, 4, body(), WALL, law, space)
    assert len(samples) == 4 * laps


# A period run.


@pytest.mark.parametrize("seed", range(12))
def test_a_turn_sees_every_sample_and_every_look(monkeypatch: pytest.MonkeyPatch, seed: int) -> None:
    """Least gaps and guard, and largest position, way, speed and torque, of a scripted motion, each where it is."""
    numbers, period, pieces = np.random.default_rng(seed), 4, 2
    wall = WALL._replace(damping=0.5) if seed % 2 else WALL
    script = numbers.uniform(-3.0, 1.0, (period * pieces + 1, 2)) * ([1.0, 0.2] if seed % 3 else [0.3, 5.0])
    torques, guards = numbers.normal(size=(period, PARTS)), numbers.uniform(1.0, 2.0, period)
    look_at = 0 if seed % 4 == 0 else 2
    law = law_of(watch=wall, anchor=seed % 3 - 1, sched=[0.0] * (pieces * PIECE))
    for piece in range(pieces):
        law.sched[piece * PIECE + LOOK] = -1.0 if piece else float(look_at)
    begun = seed % 5 if seed % 2 else 9
    space = make_space(2, len(PAST), lambda count: [7.0] * count)
    space.orbit[:] = script[0].tolist()
    shown: list[float] = []
    moves: list[int] = []

    def decide(what: float, speed: float, past: Any, _: Any, __: Any) -> float:
        k = len(shown)
        assert space.state == script[k * pieces].tolist()
        assert speed == space.state[1]
        shown.append(what)
        past[-PARTS:] = torques[k].tolist()
        if law.anchor >= 0:
            past[law.anchor] = 1.0 if k == begun else 0.0
        return float(guards[k])

    def move(past: Any, at: int, _: Any, __: Any, room: Any, count: int) -> None:
        assert (at, count) == (len(moves) % pieces * PIECE, 2)
        if not moves:
            assert room.marks == fresh_marks()
            assert [room.cols[c * room.width + i] for c in range(2) for i in range(2)] == [1.0, 0.0, 0.0, 1.0]
            assert [room.cols[room.width**2 + c] for c in range(2)] == [0.0, 0.0]
        moves.append(at)
        room.state[:] = script[len(moves)].tolist()

    monkeypatch.setattr(proof, "decide", decide)
    monkeypatch.setattr(proof, "move_piece_columns", move)
    # Beside a torque over the angle what is decided is a sum with that.
    monkeypatch.setattr(proof, "table_size", lambda what, one: 0.5 * abs(what) if one is WALL and seed % 2 else 0.0)
    past = list(PAST)
    if law.anchor >= 0:
        past[law.anchor] = 0.0
    found = proof.turn_with_law(past, period, body(), WALL, law, space, 2)
    places = [float(x) for x in script[:-1:pieces, 0]]
    looks = [float(x) for x in script[1::pieces, 0]]
    every = places + looks
    assert shown == [read(x, WALL) for x in places]
    assert found == (
        min(edge_gap(x, read(x, WALL), read(x, WALL), wall) for x in every),
        min(count_gap(x, WALL) for x in places),
        max(abs(x) for x in places),
        max(*(abs(float(v)) for v in script[:-1:pieces, 1]), *(abs(x) for x in np.diff(script[::pieces, 0]))),
        min(guards),
        max(np.abs(torques[k]).max() + (0.5 * abs(what) if seed % 2 else 0.0) for k, what in enumerate(shown)),
        law.anchor < 0 or begun < period,
    )
    assert law.anchor == look_at or past[look_at] == read(looks[-1], WALL)


@pytest.mark.parametrize("width", [0.0, 0.5, 1.5])
def test_with_hysteresis_a_turn_counts_between_samples(monkeypatch: pytest.MonkeyPatch, width: float) -> None:
    """Turning points have margins of their own, on a copy of the state; the count goes on with them."""
    wall = WALL._replace(hysteresis=width)
    law = law_of(watch=wall, sched=[0.0] * (2 * PIECE))
    for piece in range(2):
        law.sched[piece * PIECE + LOOK] = -1.0
    script = [[-2.5, 0.25], [-1.75, 0.25], [-0.625, 0.5], [-1.25, 0.0], [-2.125, -0.5]]
    moves: list[int] = []
    counted: list[Any] = []
    shown: list[float] = []

    def move(past: Any, at: int, one: Any, _: Any, room: Any, count: int) -> None:
        moves.append(at)
        room.state[:] = script[len(moves)]

    def count(z: Any, past: Any, piece: int, one: Any, watch: Any, _: Any, pad: Any) -> float:
        assert z[:2] == script[len(moves)]
        z[0] = 99.0
        counted.append(piece)
        past[LINE - 1] -= 0.0 if piece else 1.0
        return margins[len(counted) - 1]

    monkeypatch.setattr(proof, "decide", lambda what, *_: shown.append(what) or 1.0)
    monkeypatch.setattr(proof, "move_piece_columns", move)
    monkeypatch.setattr(proof, "count_piece", count)
    for margins in ([9.0, 0.03125, 9.0, 9.0], [9.0, 9.0, 9.0, 0.0625], [0.015625, 9.0, 9.0, 9.0], [9.0] * 4):
        for kept in (moves, counted, shown):
            kept.clear()
        space = make_space(2, len(PAST), lambda count: [7.0] * count)
        space.orbit[:] = script[0]
        past = list(PAST)
        found = proof.turn_with_law(past, 2, body(), wall, law, space, 2)
        before, gaps = -3.0, []
        for k in range(2):
            x, first = script[2 * k][0], before
            before = read_after(x, first, wall)
            assert shown[k] == before
            gaps.append(edge_gap(x, before, first, wall))
            before = before - 1.0 if width else first
        assert counted == ([0, 1, 0, 1] if width else [])
        assert found[0] == min(*gaps, *(margins if width else []))
        assert past[LINE - 1] == before
