"""Which knobs are followed as sets with friction, by which parts of an interval, and what each part may round."""

from math import inf, sqrt
from types import SimpleNamespace
from typing import Any

import pytest

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.controller import Controller
from hknob_cli.engine.general.laws.law import LOOK, PIECE, SPAN, TORQUE
from hknob_cli.engine.general.sets.convex import MOST_CORNERS
from hknob_cli.engine.general.sets.friction_room import _course, can_rub, friction_drift, make_friction_room
from hknob_cli.engine.general.sets.friction_set import LEG, MOST, SET, SETS, SETS_LOOKED
from hknob_cli.engine.general.sets.friction_step import MOST_CUTS, MOST_PARTS
from hknob_cli.engine.general.slide_two import coefficients

from .friction_work import wall_of, zeros
from .test_friction_rounding import body_of

WALL = wall_of()
RUBS, SLIPS = body_of(0.25, 0.04, 0.5, -0.75, 0.0), body_of(0.25, 0.04, 0.0, -0.75, 0.0)


def law_of(*holds: tuple[int, float, int], provable: bool = True, senses: bool = False, rows: int = 2) -> Any:
    """A law whose interval has these holds: where its torque stands, how long, and where its look goes."""
    sched = [0.0] * (PIECE * len(holds))
    for k, (torque, span, look) in enumerate(holds):
        at = k * PIECE
        sched[at + TORQUE], sched[at + SPAN], sched[at + LOOK] = float(torque), span, float(look)
    looks = sum(look >= 0 for _, _, look in holds)
    return SimpleNamespace(
        pieces=len(holds), sched=sched, rows=rows, looks=looks, provable=provable, senses=senses, watch=WALL
    )


def test_knob_and_hand_with_friction_are_followed() -> None:
    """Of second order, damped, held by a spring, with an encoder; each of these is needed."""
    assert can_rub(RUBS, WALL)
    assert can_rub(RUBS._replace(friction=5e-324), WALL)
    assert can_rub(RUBS._replace(reach=1e300), WALL)
    for body in (
        RUBS._replace(order=3), RUBS._replace(order=1), RUBS._replace(damped=False), RUBS._replace(reach=inf), SLIPS,
    ):  # fmt: skip
        assert not can_rub(body, WALL)
    assert not can_rub(RUBS, wall_of(analog=1.0))
    assert not can_rub(RUBS, wall_of(analog=0.5))


def test_a_law_is_followed_with_and_without_friction_if_it_is_proven_and_feels_no_speed() -> None:
    for body in (RUBS, SLIPS):
        assert can_rub(body, WALL, law_of((0, 1.0, -1)))
        assert not can_rub(body, WALL, law_of((0, 1.0, -1), provable=False))
        assert not can_rub(body, WALL, law_of((0, 1.0, -1), senses=True))
        assert not can_rub(body, WALL, law_of((0, 1.0, -1), provable=False, senses=True))
        assert not can_rub(body._replace(order=3), WALL, law_of((0, 1.0, -1)))
        assert not can_rub(body, wall_of(analog=1.0), law_of((0, 1.0, -1)))


def stiff(turn: float) -> Body:
    """A body whose spring turns its motion by so much in an interval, in radians, without damping."""
    return body_of(0.0, turn * turn, 0.5, 0.0, 0.0)._replace(damped=True)


def test_a_hand_too_stiff_for_its_rate_is_not_followed() -> None:
    """A quarter of a radian in each of 256 parts, at most."""
    assert MOST_PARTS == 256
    assert can_rub(stiff(63.9), WALL)
    assert not can_rub(stiff(64.1), WALL)
    assert _course(stiff(64.1), WALL, None) == []
    assert _course(stiff(100.0), wall_of(split=0.5), None) != []
    assert _course(stiff(100.0), wall_of(split=0.125), None) == []  # the rest of it is too long
    assert _course(stiff(64.1), WALL, law_of((0, 0.5, -1), (1, 1.0, -1))) == []


def legs(course: list[float]) -> list[list[float]]:
    return [course[k : k + LEG] for k in range(0, len(course), LEG)]


@pytest.mark.parametrize("split", [0.0, 0.25, 0.75])
@pytest.mark.parametrize(("turn", "ways"), [(0.2, {1.0: 1, 0.25: 1, 0.75: 1}), (0.9, {1.0: 4, 0.25: 1, 0.75: 4})])
def test_an_interval_is_the_older_torque_and_then_the_newer(split: float, turn: float, ways: dict[float, int]) -> None:
    """In parts in each of which the spring turns the motion by a quarter of a radian at most, and no look."""
    body = stiff(turn)
    right = []
    for torque, span in ((0.0, split), (1.0, 1.0 - split)):
        if span > 0.0:
            n = ways[span]
            right += n * [[torque, span / n, *coefficients(span / n, body), -1.0]]
    assert legs(_course(body, wall_of(split=split), None)) == right
    assert sum(one[1] for one in right) == 1.0


def test_under_a_law_an_interval_is_its_own_and_a_look_is_at_the_end_of_a_hold() -> None:
    """A look is told by which of them it is: its reading goes after the rows and the last sample's."""
    body = stiff(0.9)
    for rows in (0, 2):
        law = law_of((4, 0.5, -1), (5, 0.0, -1), (3, 0.25, rows + 1), (4, 0.25, rows + 2), rows=rows)
        course = legs(_course(body, wall_of(split=0.75), law))
        assert [(one[0], one[1], one[-1]) for one in course] == [
            (4.0, 0.25, -1.0), (4.0, 0.25, -1.0), (3.0, 0.25, 0.0), (4.0, 0.25, 1.0),
        ]  # fmt: skip
        assert all(one[2:5] == list(coefficients(0.25, body)) for one in course)
        late = legs(_course(body, WALL, law_of((3, 1.0, rows + 1), rows=rows)))
        assert [one[-1] for one in late] == [-1.0, -1.0, -1.0, 0.0]


def test_there_is_room_for_all_that_a_set_may_become() -> None:
    """Corners: as many as a piece has, one more a cut, two more at the edges of a reading and two of a widening's."""
    assert MOST == MOST_CORNERS + 2 + MOST_CUTS + 2
    for looks, law in ((0, None), (0, law_of((0, 1.0, -1))), (2, law_of((0, 0.5, 3), (1, 0.5, 4)))):
        for delay in (0, 1, 2, 5):
            room = make_friction_room(zeros, list, delay, RUBS, WALL, law)
            assert room.course == _course(RUBS, WALL, law)
            assert room.least == [1e-10]
            assert len(room.sets) == (SET + looks) * (SETS_LOOKED if looks else SETS)
            assert len(room.seen) == looks
            assert len(room.corners) == len(room.space) == 2 * (4 * MOST + 2)
            assert len(room.one) == len(room.other) == 2 * MOST
            assert (len(room.line), len(room.z), len(room.ring)) == (3, 2, delay)
            assert len(room.torques) == (delay if delay > 2 else 2)


def drift_of(alpha: float, beta: float, friction: float, push: float, wall: Controller, law: Any = None) -> Any:
    body = body_of(alpha, beta, friction, push, wall.split)
    return body, friction_drift(body, wall, law), len(_course(body, wall, law)) // LEG


@pytest.mark.parametrize("split", [0.0, 0.25])
@pytest.mark.parametrize("numbers", [(0.25, 0.04, 0.5, 0.75), (0.25, 0.04, 0.0, -0.5), (3.0, 4.0, 2.0, 0.0)])
def test_roundings_are_of_all_terms_of_each_part(numbers: tuple[float, float, float, float], split: float) -> None:
    """256 units in the last place of each term, as position and as velocity, in each part of an interval."""
    body, drift, parts = drift_of(*numbers, wall_of(split=split))
    assert parts == (1 if numbers[1] < 1.0 else 8) + (split > 0.0) * (1 if numbers[1] < 1.0 else 2)
    root, unit = sqrt(numbers[1]), 256.0 * EPSILON * parts
    pull = abs(body.drive) + numbers[2]
    right = [
        unit * (1.0 + root) * pull,  # bias and friction move a speed, and with it a position
        unit * (1.0 + root),  # a torque: the same of each
        unit * (root + (1.0 + root) * numbers[1]),  # a position, and the spring's pull there
        unit * (1.0 + root),  # a velocity, and the way that it makes
    ]
    assert drift.once == pytest.approx(right, rel=1e-15, abs=0.0)
    assert drift.blur == pytest.approx(unit, rel=1e-15, abs=0.0)
    assert (drift.units, drift.powers, drift.coast) == ([root, 1.0], [0.0], 0.0)


def test_the_amplifier_tells_nothing_apart_below_where_it_is_full() -> None:
    """Without a law, whose torque need not be that of a reading."""
    wall = wall_of(limit=3.0)
    assert drift_of(0.25, 0.04, 0.5, 0.75, wall)[1].bottom == -3.0
    assert drift_of(0.25, 0.04, 0.5, 0.75, WALL)[1].bottom == -inf
    assert drift_of(0.25, 0.04, 0.5, 0.75, wall, law_of((0, 1.0, -1)))[1].bottom == -inf
