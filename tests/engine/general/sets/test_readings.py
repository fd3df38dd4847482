"""Tests of `engine.general.sets.readings`: what acts alike gets the same commands, and no more."""

from math import inf

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hknob_cli.engine.general.controller import Controller, command, read
from hknob_cli.engine.general.sets.readings import acting, deepest_level, highest, lowest, remembered

from .cells import KINDS, cell

walls = st.builds(
    Controller,
    kappa=st.floats(1e-4, 10.0),
    damping=st.sampled_from([0.0, 0.0, 0.3]),
    sense=st.sampled_from([1.0, -1.0]),
    truncate=st.just(0.0),
    offset=st.sampled_from([0.0, 0.25, 0.9]),
    analog=st.just(0.0),
    step=st.sampled_from([0.0, 0.07, 2.0]),
    limit=st.sampled_from([inf, 0.0, 0.5, 7.3]),
    split=st.just(0.0),
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
