"""Rest under a law where its end is written down: torques, zone and roundings of dyadic numbers, each on its margin."""

from math import nextafter
from types import SimpleNamespace
from typing import Any

import pytest

from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.laws import rest
from hknob_cli.engine.general.laws.rest import settled_past, settles_with_law
from hknob_cli.engine.general.standstill import SETTLING
from hknob_cli.engine.rest import AT_REST, MOVING, REST_ON_EDGE, RINGS

from .test_law_trial_margins import law_of
from .test_standstill_margins import FINGER, LAGGING, WALL, body

UNIT = 2.0**-10  # of a rounding, here
WRONG = 6.75 * UNIT  # a quarter of 2 (1 + 0.5 + 2) units, and twice 1 + 1.5
ROOM = 2.0**-4  # for the roundings of a rest


class Stage:
    """What is remembered goes on to ``end``, under the torque ``u``; what the torques part by now is ``late``."""

    def __init__(self, patch: pytest.MonkeyPatch, *, guard: float = 9.0, end: float = 2.0, u: float = 1.0) -> None:
        self.u, self.guard, self.end = u, guard, end
        self.zone, self.apart, self.held = (0.25, -0.75, -0.25), 0.0, (False, False)
        self.asked: list[float] = []
        self.bounds: list[tuple[float, float]] = []
        self.away: list[float] = []
        self.room, self.real = ROOM, rest.distance
        patch.setattr(rest, "ROUNDINGS", 1.0)
        patch.setattr(rest, "EPSILON", UNIT)
        for name in ("settled_past", "rest_rounding", "stays_held", "hold_zone"):
            patch.setattr(rest, name, getattr(self, name))
        patch.setattr(rest, "distance", self.distance)

    def settled_past(self, past: Any, shown: float, wall: Any, law: Any) -> tuple[bool, float]:
        law.periodic[:] = [1.0, self.end, 3.0, 5.0, self.u, self.u]
        return True, self.guard

    def rest_rounding(self, z: Any, place: float, u: float, one: Body) -> float:
        self.bounds.append((place, u))
        return self.room

    def stays_held(self, z: Any, u: float, one: Body) -> bool:
        self.asked.append(u)
        return self.held[0 if u < self.u else 1]

    def hold_zone(self, u: float, shown: float, one: Body, watch: Any) -> tuple[float, float, float]:
        assert u == self.u
        return self.zone

    def distance(self, away: Any, one: Body) -> float:
        self.away = list(away)
        return self.apart if self.apart else float(self.real(away, one))

    def fate(self, z: list[float], one: Body, *, late: float = 0.0, mean: float | None = None, **more: Any) -> int:
        law = law_of(
            **(
                {"line": 3, "fading": 1, "fade": 0.5, "weight": 0.25, "ages": 3, "coarse": 2.0, "periodic": [0.0] * 6}
                | more
            )
        )
        past = [1.0, self.end if mean is None else mean, 3.0, 7.0, self.u, self.u + late]
        return int(settles_with_law(z, -1.0, past, one, WALL, law, [7.0] * one.order, [7.0] * one.order))


@pytest.fixture
def stage(monkeypatch: pytest.MonkeyPatch) -> Any:
    return lambda **more: Stage(monkeypatch, **more)


HELD = body(beta=0.25, push=1.125)  # rests at -0.5 under 1


def test_a_guard_must_clear_what_still_fades_and_what_is_worn(stage: Any) -> None:
    """A quarter of a count, and seven units; of a law whose torque does not depend on it, none."""
    edge = 0.25 + 7.0 * UNIT
    for end in (2.0, -2.0):
        for side in (0.25, -0.25):
            for guard, clears in ((edge, False), (nextafter(edge, 1.0), True)):
                one = stage(guard=guard, end=end)
                found = one.fate([-0.5, 0.0], HELD, mean=end + side, weight=0.03125)
                assert (found == AT_REST) == clears
    assert stage(guard=0.0).fate([-0.5, 0.0], HELD, weight=0.0) == AT_REST
    for weight in (0.03125, 0.0625):
        assert stage(guard=0.0).fate([-0.5, 0.0], HELD, weight=weight) == MOVING
    assert stage().fate([-0.5, 0.0], HELD, provable=False) == MOVING
    assert stage().fate([-0.5, 0.0], HELD, senses=True) == MOVING
    assert stage().fate([-0.5, 0.0], HELD, senses=True, provable=False) == MOVING


def test_the_place_of_a_rest_is_moved_by_what_a_torque_may_be_wrong_by(stage: Any) -> None:
    """In units of a rounding beside the torque itself; twice, as the knob may swing about the rest that it then has."""
    for u, place, end in ((1.0, -0.5, 2.0), (-1.0, -8.5, 2.0), (1.0, -0.5, -2.0)):
        one = stage(u=u, end=end)
        one.fate([-0.5, 0.0], HELD)
        assert one.bounds == [(place, 1.0 + 2.0 * 6.75)]
    one = stage()
    one.fate([-0.5, 0.0], HELD, fading=-1, fade=0.0)
    assert one.bounds == [(-0.5, 1.0 + 2.0 * 5.0)]  # nothing fades


def test_a_rest_is_one_where_distance_and_torques_stay_within_its_gap(stage: Any) -> None:
    """Half a count: a sixteenth for roundings, one for torques under way, and 0.1875 in speed under a soft spring."""
    for v, fate in ((0.1875, MOVING), (nextafter(0.1875, 0.0), AT_REST), (-0.1875, MOVING), (-0.18, AT_REST)):
        assert stage().fate([-0.5, v], HELD, late=2.0**-5) == fate
        assert stage().fate([-0.5, v], HELD, late=-(2.0**-5)) == fate
    assert stage().fate([-0.5, 0.0], HELD._replace(damped=False)) == RINGS
    assert stage().fate([-0.5, 0.0], body(beta=0.0)) == MOVING


def test_a_rest_within_its_rounding_of_an_edge_is_on_it(stage: Any) -> None:
    """A 32nd beyond the wall's edge; and the knob must have come there, to a millionth of a count."""
    one = body(beta=0.25, push=1.0 - 2.0**-7)
    for room, v, fate in (
        (2.0**-5, 0.0, REST_ON_EDGE),
        (nextafter(2.0**-5, 0.0), 0.0, MOVING),
        (1.0, 4.9e-7, REST_ON_EDGE),
        (1.0, -4.9e-7, REST_ON_EDGE),
        (1.0, 2.6e-7, REST_ON_EDGE),
        (1.0, 5e-7, MOVING),
        (1.0, 9e-7, MOVING),
    ):
        at = stage()
        at.room = room
        assert at.fate([2.0**-5, v], one) == fate


def test_friction_holds_all_that_torques_will_ever_be(stage: Any) -> None:
    """An eighth now, a 32nd under way, and what the last torque may be wrong by; a lag settles behind it."""
    most = 0.125 + 2.0**-5 + WRONG
    for friction, late, held in (
        (most, 2.0**-5, True),
        (most, -(2.0**-5), True),
        (nextafter(most, 0.0), 2.0**-5, False),
        (most - 2.0**-5, 0.0, True),
    ):
        one = body(beta=0.25, push=1.0, friction=friction)
        at = stage()
        assert (at.fate([-0.5, 0.0], one, late=late) == AT_REST) == held
        assert at.asked == []
        for v in (1.0, -1.0, 1e-300):
            assert stage().fate([-0.5, v], one, late=late) != AT_REST
    for held in ((True, True), (True, False), (False, True)):
        at = stage()
        at.held = held
        assert (at.fate([-0.5, 0.0, 1.0], LAGGING) == AT_REST) == (held == (True, True))
        assert at.asked == [1.0 - WRONG, 1.0 + WRONG][: len(at.asked)]
        late = stage()
        late.held = (True, True)
        assert late.fate([-0.5, 0.0, 1.0], LAGGING._replace(friction=99.0), late=2.0**-5) != AT_REST
        assert late.asked == []


def test_a_held_knob_is_told_from_an_edge_by_its_rounding(stage: Any) -> None:
    for edge, to in ((-1.0, 1.0), (0.0, -1.0)):
        for near, fate in ((1.0 + 1e-6, AT_REST), (1.0 - 1e-6, REST_ON_EDGE)):
            # A gap g of UNIT (1 + |z|), where z is g from its edge.
            gap = UNIT / (1.0 - UNIT) if edge == 0.0 else 2.0 * UNIT / (1.0 + UNIT)
            at = stage()
            at.held = (True, True)
            assert at.fate([edge + to * gap * near, 0.0, 1.0], LAGGING) == fate


def less_at(depth: float) -> float:
    """By how much the zone is narrower, at a place so deep: what a torque may be wrong by there, over a quarter."""
    return UNIT * (0.25 * 2.0 * (3.0 + depth) + 2.0 * (2.0 + depth)) / 0.25


def test_a_held_knob_exactly_its_rounding_from_an_edge_is_on_it(stage: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """A seventh of 1.75, rounded, is a quarter."""
    at = stage()
    monkeypatch.setattr(rest, "EPSILON", 1.0 / 7.0)
    at.held = (True, True)
    assert at.fate([-0.75, 0.0, 1.0], LAGGING) == REST_ON_EDGE
    monkeypatch.setattr(rest, "EPSILON", 0.99 / 7.0)
    assert at.fate([-0.75, 0.0, 1.0], LAGGING) == AT_REST


def test_without_lag_the_last_number_is_the_fingers(stage: Any) -> None:
    at = stage()
    at.fate([-0.5, 0.5, 0.75, 0.25], FINGER._replace(order=4, lag=0.0))
    assert at.away == [0.0, 0.5, 0.75, 0.25]


def test_a_rest_in_the_zone_that_friction_holds_is_the_nearest(stage: Any) -> None:
    """Of the zone less what the torque may be wrong by, over its stiffness; finger and lag have settled there."""
    narrow = WRONG / 0.25
    for x, place in ((-0.875, -0.75 + less_at(0.875)), (-0.125, -0.25 - less_at(0.125)), (-0.5, -0.5)):
        at = stage()
        at.fate([x, 0.5, 0.75], LAGGING)
        assert at.away == [x - place, 0.5, -0.25]
        for one in (FINGER, FINGER._replace(ratio=0.5)):
            at.fate([x, 0.5, 0.75, 0.25, 0.625], one)
            # Behind a pad of 2, under a quarter of -0.5 and the neutral angle.
            assert at.away == [x - place, 0.5, 0.75 - 0.25 * (place + 0.5) / 2.0, 0.25, -0.375]
    at = stage()
    at.apart = 0.0625
    for half, fate in ((narrow, SETTLING), (narrow - 2.0**-40, MOVING)):
        at.zone = (0.25, -0.5 - half, -0.5 + half)
        assert at.fate([-0.5, 0.0, 1.0], LAGGING) == fate
    at.zone = (0.0, 1.0, 0.0)
    assert at.fate([-0.5, 0.0, 1.0], LAGGING) == MOVING
    at.zone = (4.0, -0.5 - WRONG / 4.0, -0.5 + WRONG / 4.0)
    assert at.fate([-0.5, 0.0, 1.0], LAGGING) == SETTLING


def test_a_finger_that_nothing_damps_swings_on(stage: Any) -> None:
    for pad, finger, fate in ((0.0, 0.0, MOVING), (0.5, 0.0, SETTLING), (0.0, 0.5, SETTLING), (0.5, 0.5, SETTLING)):
        at = stage()
        at.apart = 0.0625
        for ratio in (0.5, 4.0):
            one = FINGER._replace(pad_damping=pad, finger_damping=finger, ratio=ratio)
            assert at.fate([-0.5, 0.0, 0.0, 0.0, 1.0], one) == fate
        assert at.fate([-0.5, 0.0, 1.0], LAGGING._replace(pad_damping=0.0)) == SETTLING


def test_a_motion_about_a_rest_keeps_within_its_gap(stage: Any) -> None:
    """Distance, torques under way, and a unit for each of one, rest and place."""
    one = LAGGING._replace(reach=2.0)
    right, left = -0.75 + less_at(0.875), -0.25 - less_at(0.125)
    for x, place, late in ((-0.5, -0.5, 2.0**-5), (-0.5, -0.5, 0.0), (-0.875, right, 2.0**-5), (-0.125, left, 0.0)):
        for near, fate in ((1.0 + 1e-9, MOVING), (1.0 - 1e-9, SETTLING)):
            at = stage()
            gap = min(place + 1.0, -place)
            at.apart = near * (gap - 2.0 * late - UNIT * (1.0 + abs(place) + abs(x)))
            assert at.fate([x, 0.0, 1.0], one, late=late) == fate
    at = stage()
    at.apart = 0.5 - 2.0 * UNIT
    assert at.fate([-0.5, 0.0, 1.0], one) == MOVING  # exactly its gap


def test_torques_of_an_interval_must_be_one() -> None:
    """Where the law cuts an interval in two; however many are under way."""
    for ages in (1, 2, 3):
        for torques, still in (([0.5, 0.5], True), ([0.5, 0.75], False)):

            def act(shown: float, speed: float, past: Any, fixed: Any, out: Any, torques: Any = torques) -> float:
                out[:] = torques
                return 0.375

            law = SimpleNamespace(
                act=act, cuts=False, unit=1.0,
                fixed=[], rows=2, line=3, parts=2, ages=ages, fading=-1, fade=0.0, weight=0.0,
                pair=[], drifts=-1, senses=False, out=[0.0, 0.0], periodic=[0.0] * (3 + 2 * ages),
            )  # fmt: skip
            past = [5.0, 6.0, -1.0, *[0.5, 0.5] * ages]
            assert settled_past(past, -1.0, WALL, law) == (still, 0.375)
            assert law.periodic == [5.0, 6.0, -1.0, *torques * ages]
