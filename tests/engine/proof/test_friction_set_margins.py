"""Sets within an interval of a knob with friction: whose velocity is 0, what measure a part has, and how one is cut.

A state on an edge is in both parts, each part goes beyond its edges by what rounding may come to, and shares of areas
add up to the whole.
"""

from math import inf, nan, nextafter
from typing import Any

import pytest

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.general.sets import friction_piece
from hknob_cli.engine.general.sets.convex import MOST_CORNERS, area_of, widen
from hknob_cli.engine.general.sets.friction_piece import TINY, begin_halves, cut_set, look_at_set, stands
from hknob_cli.engine.general.sets.friction_set import (
    CORNERS,
    COUNT,
    CUTS,
    LEAST_PART,
    LEAST_WEIGHT,
    PART,
    SET,
    WEIGHT,
    begin_set,
    part_weight,
)
from hknob_cli.engine.general.sets.friction_set import V as SPEED
from hknob_cli.engine.general.sets.friction_set import X as PLACE

from .friction_work import SQUARE, body_of, cell_of, drift_of, law_of, room_of, wall_of, work_of, zeros
from .test_friction_rounding import apart

HUGE = 2.0**40


def set_at(work: Any, at: int, looks: int = 0) -> tuple[float, ...]:
    """Part, cuts, x, v and weight of a set that waits within an interval; its corners; and what it has read."""
    one = work.sets[at * (SET + looks) : (at + 1) * (SET + looks)]
    corners = one[CORNERS : CORNERS + 2 * int(one[COUNT])]
    return one[PART], one[CUTS], one[PLACE], one[SPEED], one[WEIGHT], corners, one[SET:]


def pairs_of(corners: list[float]) -> list[tuple[float, float]]:
    return list(zip(corners[::2], corners[1::2], strict=True))


def ring_of(count: int) -> list[float]:
    """A convex polygon of so many corners: on a parabola, closed by its chord. Areas of it are exact."""
    return [value for k in range(count) for value in (float(k), float(k * k))]


# Whose velocity is 0.


def test_a_set_stands_where_every_velocity_is_exactly_0() -> None:
    """The centre's and the corner's add up to 0; whatever the positions are, and what is beyond the last corner."""
    assert stands(0.5, [1.0, -0.5, 2.0, -0.5, 0.0, 9.0], 2)
    assert stands(0.0, [1.0, 0.0, -1.0, -0.0], 2)
    for speed in (0.5, -0.5, 1.0, -1.0, 2.0, 5e-324):
        assert not stands(0.0, [0.0, speed], 1)
        assert not stands(speed, [0.0, 0.0], 1)
    for wrong in range(3):
        corners = [0.0, -0.5, 0.0, -0.5, 0.0, -0.5]
        corners[2 * wrong + 1] = nextafter(-0.5, 0.0)
        assert not stands(0.5, corners, 3)
    assert not stands(0.5, [0.0, 0.5], 1)
    assert not stands(-1.0, [0.0, 0.0], 1)


# Its measure.


def test_a_part_has_its_share_of_the_area_where_nothing_rubs() -> None:
    assert part_weight(0.5, 4.0, SQUARE, 4, body_of()) == 0.25
    assert part_weight(0.5, 0.5, SQUARE, 4, body_of()) == 0.5  # rounding makes no part more than the whole
    assert part_weight(0.5, 2.0, SQUARE, 4, body_of()) == 0.5
    assert part_weight(0.5, 4e28, SQUARE, 4, body_of()) == pytest.approx(0.25e-28, rel=1e-15, abs=0.0)
    assert part_weight(0.5, 4e290, SQUARE, 4, body_of()) == 0.5 * LEAST_PART


def test_a_part_of_a_part_of_a_part_has_a_weight_still() -> None:
    """Eleven cuts to the least share would round to no weight, and an end without proof would not be counted."""
    weight = 1.0
    for _ in range(40):
        weight = part_weight(weight, 1e300, SQUARE, 4, body_of())
        assert weight > 0.0
    assert weight == LEAST_WEIGHT
    assert part_weight(10.0 * LEAST_WEIGHT, 4.0, SQUARE, 4, body_of()) == 5.0 * LEAST_WEIGHT


def test_a_part_without_an_area_counts_as_something() -> None:
    """An end that any state reaches has a share; where the whole has no area nothing is known of it."""
    assert part_weight(0.5, 4.0, [0.0, 0.0, 1.0, 0.0], 2, body_of()) == 0.5 * 1e-30
    assert part_weight(0.5, 0.25, [0.0, 0.0, 1.0, 0.0], 2, body_of()) == 0.5 * 1e-30
    for whole in (0.0, nan):
        assert part_weight(0.5, whole, SQUARE, 4, body_of()) == 0.5


def test_a_part_counts_whole_where_friction_keeps_no_areas() -> None:
    for friction in (1e-300, 0.5, 1.0, 2.0):
        assert part_weight(0.5, 4.0, SQUARE, 4, body_of(friction)) == 0.5


# How it is written down.


def test_a_set_is_written_down_whole() -> None:
    for looks in (0, 2):
        work = work_of(looks=looks)
        work.seen[:] = [-3.0, -4.0][:looks]
        begin_set(work, 3, (5.0, 1.5, 2.5, 0.125), 7, SQUARE, 4)
        assert set_at(work, 3, looks) == (5.0, 7.0, 1.5, 2.5, 0.125, SQUARE, [-3.0, -4.0][:looks])


def test_a_set_of_few_corners_stays_as_it_is() -> None:
    """With a share of its own; it has not been cut in the part of the interval that it begins."""
    for friction in (0.0, 0.5):
        for count in (4, MOST_CORNERS):
            room, work = room_of(), work_of()
            room.halves[: 2 * count] = ring_of(count)
            assert begin_halves(room, work, 2, (3.0, 1.5, 2.5, 0.5), count, body_of(friction)) == 3
            assert set_at(work, 2) == (3.0, 0.0, 1.5, 2.5, 0.5, ring_of(count), [])
            assert not any(work.sets[: 2 * SET])
            assert not any(work.sets[3 * SET :])


@pytest.mark.parametrize("count", [MOST_CORNERS + 1, 17, 20])
@pytest.mark.parametrize("friction", [1e-300, 0.5, 2.0])
def test_with_friction_a_simpler_set_around_it_is_one(count: int, friction: float) -> None:
    """It holds all corners, and counts as much."""
    room, work = room_of(), work_of()
    room.halves[: 2 * count] = ring_of(count)
    assert begin_halves(room, work, 2, (3.0, 1.5, 2.5, 0.5), count, body_of(friction)) == 3
    *head, corners, seen = set_at(work, 2)
    assert (head, seen) == ([3.0, 0.0, 1.5, 2.5, 0.5], [])
    assert len(corners) == 2 * MOST_CORNERS
    for k in range(count):
        assert apart(k, k * k, pairs_of(corners), 1.0) < 1e-9
    assert not any(work.sets[3 * SET :])


@pytest.mark.parametrize("count", [MOST_CORNERS + 1, 17, 20])
def test_where_nothing_rubs_it_is_in_two_halves(count: int) -> None:
    """By a line from corner to corner: no state is lost or in both, and each counts by its area."""
    room, work = room_of(), work_of()
    whole = ring_of(count)
    room.halves[: 2 * count] = whole
    assert begin_halves(room, work, 2, (3.0, 1.5, 2.5, 0.5), count, body_of()) == 4
    one, two = set_at(work, 2), set_at(work, 3)
    assert one[:4] == two[:4] == (3.0, 0.0, 1.5, 2.5)
    areas = [area_of(each[5], len(each[5]) // 2) for each in (one, two)]
    assert sum(areas) == area_of(whole, count)
    for each, area in zip((one, two), areas, strict=True):
        assert len(each[5]) // 2 <= count // 2 + 2 <= MOST_CORNERS
        assert each[4] == pytest.approx(0.5 * area / sum(areas), rel=1e-15)
        assert len(set(pairs_of(each[5]))) == len(each[5]) // 2
        assert set(pairs_of(each[5])) < set(pairs_of(whole))
    assert len(set(pairs_of(one[5])) & set(pairs_of(two[5]))) == 2


# How it is cut by a line.


def test_both_sides_of_a_line_are_sets() -> None:
    """Each has been cut once more, and counts as much as the whole: with friction nothing tells how much less."""
    for line, over, under in (
        ([1.0, 0.0, 0.5], [0.5, -0.5, 1.0, -0.5, 1.0, 0.5, 0.5, 0.5], [-1.0, -0.5, 0.5, -0.5, 0.5, 0.5, -1.0, 0.5]),
        ([0.0, 1.0, 0.0], [1.0, 0.0, 1.0, 0.5, -1.0, 0.5, -1.0, 0.0], [-1.0, -0.5, 1.0, -0.5, 1.0, 0.0, -1.0, 0.0]),
    ):  # fmt: skip
        work = work_of(line=line)
        work.corners[:8] = SQUARE
        assert cut_set(work, 4, (5.0, 1.5, 2.5, 0.5), 2, 4) == 6
        for at, corners in ((4, over), (5, under)):
            found = set_at(work, at)
            assert found[:5] == (5.0, 3.0, 1.5, 2.5, 0.5)
            assert sorted(pairs_of(found[5])) == sorted(pairs_of(corners))
        assert work.corners[:8] == SQUARE
        assert not any(work.sets[: 4 * SET])
        assert not any(work.sets[6 * SET :])


@pytest.mark.parametrize(
    "line", [[1.0, 0.0, 1.5], [-1.0, 0.0, 1.5], [0.0, 1.0, 0.75], [0.0, -1.0, 0.75], [1.0, 2.0, 2.5], [-1.0, 2.0, 2.5]]
)
def test_a_line_beside_a_set_does_not_cut_it(line: list[float]) -> None:
    """Whichever side of it the set is on."""
    for sign in (1.0, -1.0):
        work = work_of(line=[sign * one for one in line])
        work.corners[:8] = SQUARE
        assert cut_set(work, 4, (5.0, 1.5, 2.5, 0.5), 2, 4) == 0
        assert not any(work.sets)
        assert work.corners[:8] == SQUARE


def test_states_on_the_line_are_in_both_sides() -> None:
    work = work_of(line=[1.0, 0.0, 1.0])
    work.corners[:8] = SQUARE
    assert cut_set(work, 0, (0.0, 0.0, 0.0, 1.0), 0, 4) == 2
    assert set_at(work, 0)[5] == [1.0, -0.5, 1.0, 0.5]
    assert len(set_at(work, 1)[5]) == 8


# How it is cut where a look within the interval tells readings apart.


def look(
    corners: list[float], x: float, error: float = 0.0, *, friction: float = 0.0, sets: int = 32, at: int = 1,
    bottom: float = -inf, sense: float = 1.0, reach: float = 2.0,
) -> tuple[int, list[tuple[float, ...]]]:  # fmt: skip
    """Cut a set of these corners about ``x``: what is returned, and the sets."""
    room, work = room_of(), work_of(sets=sets, looks=2)
    work.seen[:] = [-7.0, -8.0]
    count = len(corners) // 2
    work.corners[: 2 * count] = corners
    body, drift = body_of(friction, reach), drift_of(bottom=bottom)
    # Not by the command's own controller, which here would tell no readings apart.
    wall = wall_of(kappa=0.0, limit=0.0)
    cell = cell_of(body, drift, wall, law_of(2, wall_of(sense=sense)))
    found = look_at_set(room, work, at, (3.0, x, 2.5, 0.5), count, error, 1, cell)
    assert not any(work.sets[: at * (SET + 2)])
    return found, [set_at(work, k, 2) for k in range(at, max(at, found))]


def span(one: tuple[Any, ...]) -> tuple[float, float]:
    """Least and largest position of a set, from its centre."""
    return min(one[5][::2]), max(one[5][::2])


def turned(corners: list[float], by: int) -> list[float]:
    return corners[2 * by :] + corners[: 2 * by]


@pytest.mark.parametrize("by", range(4))
@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_set_is_cut_into_its_readings(by: int, sense: float) -> None:
    """From -1.75 to 0.25: as it reads at this look, from then on. Shares are of the area; outside the wall is one."""
    found, sets = look(turned(SQUARE, by), -0.75, sense=sense)
    levels = [-2.0, -1.0, 0.0] if sense > 0.0 else [-1.0, 0.0]
    lows, highs = ([-1.0, -0.25, 0.75], [-0.25, 0.75, 1.0]) if sense > 0.0 else ([-1.0, -0.25], [-0.25, 1.0])
    assert found == 1 + len(levels)
    for level, low, high, one in zip(levels, lows, highs, sets, strict=True):
        assert one[:4] == (3.0, 0.0, -0.75, 2.5)
        assert one[6] == [-7.0, level]
        assert span(one) == pytest.approx((low, high), abs=1e-14)
        assert one[4] == pytest.approx(0.5 * (high - low) / 2.0, abs=1e-14)


def test_each_part_goes_beyond_its_edges_by_what_rounding_may_come_to() -> None:
    """By what an error may move a position, and what reading it may round: that is 2^-9 at 2^40."""
    assert 8.0 * EPSILON * HUGE == 2.0**-9
    for x, error, reach in (
        (-0.75, 0.0625, 0.125), (-0.75, 0.03125, 0.0625), (-HUGE, 0.0, 2.0**-9), (-HUGE, 2.0**-10, 3.0 * 2.0**-9),
    ):  # fmt: skip
        found, sets = look(SQUARE, x, error, reach=4.0 if x == -HUGE else 2.0)
        assert found == 1 + len(sets) > 2
        for one in sets:
            level = one[6][1]
            right = max(-1.0, level - x - reach), min(1.0, (level + 1.0 if level < 0.0 else inf) - x + reach)
            assert span(one) == (right if x == -HUGE else pytest.approx(right, abs=1e-14))


STEP = 2.0**-12  # between two doubles at 2^40


@pytest.mark.parametrize("by", range(4))
@pytest.mark.parametrize(
    ("beside", "readings"),
    [
        (-0.25 - 2.0**-9 - STEP, [-1.0]),
        (-0.25 - 2.0**-9, [-1.0, 0.0]),
        (0.0, [-1.0, 0.0]),
        (0.25 + 2.0**-9 - STEP, [-1.0, 0.0]),
        (0.25 + 2.0**-9, [0.0]),
    ],
)
def test_a_set_within_reach_of_an_edge_is_in_both_readings(by: int, beside: float, readings: list[float]) -> None:
    """``beside``: place of its middle, from the edge; it is half a count wide. A count begins on its edge."""
    _, sets = look(turned([0.25 * value for value in SQUARE], by), -HUGE + beside)
    assert [one[6][1] + HUGE for one in sets] == readings


def test_an_error_brings_edges_within_reach() -> None:
    for x, readings in ((-1.376, [-2.0]), (-1.374, [-2.0, -1.0]), (-0.626, [-2.0, -1.0]), (-0.624, [-1.0])):
        _, sets = look([0.25 * value for value in SQUARE], x, 0.0625)
        assert [one[6][1] for one in sets] == readings


def test_deeper_than_the_amplifier_tells_all_is_one_reading() -> None:
    _, sets = look(SQUARE, -3.75, bottom=-4.0)
    assert [one[6][1] for one in sets] == [-4.0, -3.0]
    assert span(sets[0]) == pytest.approx((-1.0, 0.75), abs=1e-14)


def test_with_friction_every_part_counts_whole() -> None:
    found, sets = look(SQUARE, -0.75, friction=0.5)
    assert found == 4
    assert [one[4] for one in sets] == [0.5] * 3


def test_a_state_on_an_edge_is_a_part() -> None:
    """A set that is one state, as far beyond an edge as a part goes, is one state of that part, too."""
    found, sets = look([0.0, 0.0], -1.0, 0.0, reach=0.0)
    assert found >= 2
    assert sets[-1][5] == [0.0, 0.0]
    assert [one[6][1] for one in sets][-1] == -1.0


def test_sets_for_which_there_is_no_room_are_not_lost_silently() -> None:
    """Room is left for a half of each: three parts from set 1 on need five."""
    for sets, found in ((32, 4), (5, 4), (4, -1), (3, -1), (2, -1)):
        assert look(SQUARE, -0.75, sets=sets)[0] == found
    for at, found in ((56, 59), (57, -1)):  # what it has read takes room, too
        assert look(SQUARE, -0.75, sets=60, at=at)[0] == found


def test_a_reading_that_rounding_alone_brings_in_has_no_part(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(friction_piece, "within", lambda *given: 0)
    assert look(SQUARE, -0.75, sets=2) == (1, [])


def test_what_is_as_slow_as_nothing_is_not_taken_to_stand() -> None:
    """A velocity that is 0 by chance is widened until it is not, whatever its centre's is."""
    for v in (0.0, 0.5, -0.75, 3.0, 1e-200, 1e9):
        corners = [0.0, -v, 1.0, -v, *zeros(64)]
        count = widen(corners, 2, 0.0, TINY + EPSILON * abs(v), zeros(64))
        assert not stands(v, corners, count)
