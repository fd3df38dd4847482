"""Tests of `engine.general.sets.readings`: what acts alike gets the same commands, and no more."""

from math import inf

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hknob_cli.engine.general.controller import Controller, command, read
from hknob_cli.engine.general.search import as_list
from hknob_cli.engine.general.sets.readings import (
    acting,
    count_levels,
    deepest_level,
    highest,
    lowest,
    next_level,
    remembered,
    steps_deeper,
)
from tests.engine.general.bodies import knob

from .cells import FREE, KINDS, OVER_ANGLE, cell

walls = st.builds(
    Controller,
    kappa=st.floats(1e-4, 10.0),
    table=st.none(),
    damping=st.sampled_from([0.0, 0.0, 0.3]),
    sense=st.sampled_from([1.0, -1.0]),
    truncate=st.just(0.0),
    offset=st.sampled_from([0.0, 0.25, 0.9]),
    analog=st.just(0.0),
    step=st.sampled_from([0.0, 0.07, 2.0]),
    limit=st.sampled_from([inf, 0.0, 0.5, 7.3]),
    split=st.just(0.0),
    band=st.sampled_from([0.0, 0.0, 0.3, 9.0]),
    clock=st.none(),
    curve=st.none(),
).flatmap(lambda wall: st.sampled_from([wall, wall._replace(sense=-1.0, truncate=1.0)]))
positions = st.one_of(st.floats(-50.0, 50.0), st.integers(-50, 50).map(float))


@settings(deadline=None)
@given(wall=walls, x=positions, before=st.integers(-20, 20).map(float))
def test_positions_that_act_alike_get_one_command(wall: Controller, x: float, before: float) -> None:
    """Now, by any last reading; and at the next sample, by what is remembered of this one."""
    bottom = deepest_level(wall)
    level = acting(x, bottom, wall)
    last = remembered(before, wall)
    assert command(read(x, wall), before, wall) == command(level, last, wall)
    following = -3.0
    assert command(following, read(x, wall), wall) == command(following, remembered(level, wall), wall)


@settings(deadline=None)
@given(wall=walls, x=positions)
def test_the_edges_of_a_reading(wall: Controller, x: float) -> None:
    """A position lies between those of its own, and beyond those of the neighbours; on an edge it may lie on both."""
    bottom = deepest_level(wall)
    level = acting(x, bottom, wall)
    low, high = lowest(level, bottom, wall), highest(level, wall)
    assert low <= x <= high
    if low < x < high:
        for other in (level - 1.0, level + 1.0):
            if bottom <= other and not (other > 0.0 and wall.damping == 0.0):
                assert not lowest(other, bottom, wall) < x < highest(other, wall)
    for edge, beyond in ((low, -1e-6), (high, 1e-6)):
        if abs(edge) < inf:
            assert acting(edge + beyond, bottom, wall) != level
            assert acting(edge - beyond, bottom, wall) == level


@pytest.mark.parametrize("kind", sorted(KINDS))
def test_saturation_alone_makes_readings_alike(kind: str) -> None:
    """The deepest level is saturated and the one above it is not; without a limit there is none."""
    wall = cell(kind).wall
    bottom = deepest_level(wall)
    if wall.limit == inf or wall.damping > 0.0:
        assert bottom == -inf
    else:
        assert command(bottom, bottom, wall) == wall.limit
        assert bottom == -1.0 or command(bottom + 1.0, bottom + 1.0, wall) < wall.limit


def test_the_deepest_level_is_the_first_that_is_saturated() -> None:
    """Counted down from the wall's edge; without stiffness nothing saturates."""
    wall = cell("limit").wall._replace(step=0.0)
    for kappa in (0.05, 0.3, 1.0, 10.0):
        for limit in (0.0, 0.5, 7.3):
            for offset in (0.0, 0.25, 0.9):
                one, level = wall._replace(kappa=kappa, limit=limit, offset=offset), -1.0
                while command(level, level, one) < limit:
                    level -= 1.0
                assert deepest_level(one) == level
    assert deepest_level(wall._replace(kappa=0.0, limit=1.0)) == -inf
    assert deepest_level(wall._replace(kappa=1.0, limit=1.0, damping=1.0)) == -inf
    assert deepest_level(wall._replace(kappa=1.0, limit=inf)) == -inf


@pytest.mark.parametrize(("sense", "truncate"), [(1.0, 0.0), (-1.0, 0.0), (-1.0, 1.0)])
@pytest.mark.parametrize("damping", [0.0, 0.5])
def test_levels_and_their_edges_one_by_one(sense: float, truncate: float, damping: float) -> None:
    """From -5 to 5 by eighths: a level's edges are the least and the most position that act as it does."""
    wall = cell("limit").wall._replace(sense=sense, truncate=truncate, damping=damping, limit=inf)
    for bottom in (-inf, -3.0):
        bottom = -inf if damping > 0.0 else bottom
        spots: dict[float, list[float]] = {}
        for k in range(-40, 41):
            shown = read(k / 8.0, wall)
            level = shown if damping > 0.0 else max(bottom, min(shown, 0.0))
            assert acting(k / 8.0, bottom, wall) == level
            assert remembered(level, wall) == (shown if damping > 0.0 else 0.0)
            spots.setdefault(level, []).append(k / 8.0)
        for level, held in spots.items():
            low, high = lowest(level, bottom, wall), highest(level, wall)
            assert low in (held[0], held[0] - 0.125) or (held[0] == -5.0 and low in (-inf, -6.0))
            assert high in (held[-1], held[-1] + 0.125) or (held[-1] == 5.0 and high in (inf, 6.0))
            assert (low == -inf) == (level == bottom)
            assert (high == inf) == (level == 0.0 and damping == 0.0)


SHAPED = {
    **OVER_ANGLE,
    "free": {"wall": {"stiffness": 0.0}, "profile": {"points": [[0.0, 1e-3]]}},
    "one step": {
        "wall": {"stiffness": 0.0},
        "profile": {"points": [[0.0, -1e-3], [0.02, 1e-3]], "interpolation": "stepped"},
    },
}


@pytest.mark.one_in(12)
@pytest.mark.parametrize("damping", [0.0, 1e-3])
@pytest.mark.parametrize("rounding", ["floor", "ceil", "truncate"])
@pytest.mark.parametrize("name", SHAPED)
def test_what_acts_alike_under_a_torque_over_the_angle(name: str, rounding: str, damping: float) -> None:
    """Count by count and half a count: runs of equal torque, each with one reading that stands for it, in order."""
    made = knob(counts=256, knob=FREE, **{**SHAPED[name], "encoder": {"rounding": rounding}})
    wall = as_list(made.wall)._replace(damping=damping, limit=inf, step=0.0)
    assert deepest_level(wall) == -inf
    assert deepest_level(wall._replace(limit=1.0, kappa=1.0)) == -inf
    levels: list[float] = []
    far = 300
    for x in (k / 2.0 for k in range(-2 * far, 2 * far + 1)):
        shown, level = read(x, wall), acting(x, -inf, wall)
        assert command(level, remembered(level, wall), wall) == command(shown, remembered(shown, wall), wall)
        low, high = lowest(level, -inf, wall), highest(level, wall)
        assert low <= x <= high
        for edge, beyond in ((low, -1.0), (high, 1.0)):
            if abs(edge) < inf:
                assert (acting(edge + 1e-6 * beyond, -inf, wall) - level) * beyond > 0.0
                assert acting(edge - 1e-6 * beyond, -inf, wall) == level
        if not levels or level != levels[-1]:
            if levels:
                assert next_level(levels[-1], wall) == level
                assert steps_deeper(levels[-1], level, wall)
                assert not steps_deeper(level, levels[-1], wall)
                if damping == 0.0:
                    assert command(level, level, wall) != command(levels[-1], levels[-1], wall)
            levels.append(level)
        assert not steps_deeper(level, level, wall)
    for first in (0, len(levels) // 3):
        for last in range(first, len(levels)):
            assert count_levels(levels[first], levels[last], wall) == last - first + 1
    if damping > 0.0:
        assert len(levels) >= 2 * far
    elif name in ("free", "one step"):
        assert len(levels) == (1 if name == "free" else 2)
        assert (highest(levels[-1], wall), lowest(levels[0], -inf, wall)) == (inf, -inf)
        assert next_level(levels[-1], wall) == inf


def test_a_wall_is_stepped_into_below_its_edge_alone() -> None:
    """Outside, where virtual damping tells readings apart, none of them is deeper."""
    wall = cell("virtual damping").wall
    assert [steps_deeper(level, last, wall) for level, last in ((-1, 0), (-1, 1), (-3, -2))] == [True] * 3
    assert [steps_deeper(level, last, wall) for level, last in ((0, 1), (1, 2), (-1, -1), (-1, -2))] == [False] * 4
    assert [next_level(level, wall) for level in (-2.0, 0.0, 3.0)] == [-1.0, 1.0, 4.0]
    assert [count_levels(-3.0, high, wall) for high in (-3.0, -2.0, 4.0)] == [1, 2, 8]
