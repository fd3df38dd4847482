"""Tests of `engine.general.sets.turns`, `swings`, `parts` and `arc_parts`: no motion loses its count behind hysteresis.

A state, moved by itself from turning point to turning point, must read at the next sample what its piece reads there.
"""

import random
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from hknob_cli.engine.general.advance import advance_span
from hknob_cli.engine.general.captured import FIELDS
from hknob_cli.engine.general.controller import read, read_after, told
from hknob_cli.engine.general.interval import advance
from hknob_cli.engine.general.sets.arc import fill_arcs, follow_arcs
from hknob_cli.engine.general.sets.cell import Cell
from hknob_cli.engine.general.sets.ends import Known
from hknob_cli.engine.general.sets.known import seek
from hknob_cli.engine.general.sets.parts import next_edge, part
from hknob_cli.engine.general.sets.piece import BEFORE, CORNERS, ERROR, STATE
from hknob_cli.engine.general.sets.room import make_arc_room, make_piece_room, make_turn_room
from hknob_cli.engine.general.sets.scope import make_scope
from hknob_cli.engine.general.sets.search import GeneralSetEngine
from hknob_cli.engine.general.sets.turns import (
    CLEAR,
    DOWN,
    OPEN,
    UP,
    half_of,
    highest_at,
    level_at,
    levels_between,
    lowest_at,
    next_at,
    turned_count,
)
from hknob_cli.engine.outcome import Reason
from hknob_cli.scene.general_knob import GeneralKnob

from .cells import FREE, KINDS, WHOLE, bounds, centre, knob, nothing_known, zeros
from .test_piece import members, off, pieces_of, polygon

PLAIN = [kind for kind, parts in KINDS.items() if "damping" not in parts.get("wall", {})]
WIDTHS = (0.02, 0.3, 1.0, 2.6)
ANGLE = 0.02


def behind(kind: str, width: float, rate: float = 464.2) -> GeneralKnob:
    """A cell of this kind, its encoder with hysteresis, in counts."""
    parts = KINDS[kind]
    return knob(rate, knob=FREE, **{**parts, "encoder": {**parts.get("encoder", {}), "hysteresis_counts": width}})


def behind_known(one: GeneralKnob) -> Known:
    """Room for its attractors and turning points."""
    turns = make_turn_room(zeros, one.body.order, one.delay_line, one.wall, None)
    return nothing_known(one)._replace(turns=turns)


@settings(deadline=None, max_examples=60)
@example(kind="profile", width=1.0, rate=4641.0, seed=336, corners=15)  # past an edge without a turning point
@given(
    kind=st.sampled_from(PLAIN),
    width=st.sampled_from(WIDTHS),
    rate=st.sampled_from([100.0, 464.2, 4641.0]),
    seed=st.integers(0, 2**32 - 1),
    corners=st.integers(2, CORNERS),
)
def test_cutting_at_turning_points_loses_no_state(
    kind: str, width: float, rate: float, seed: int, corners: int
) -> None:
    """Of a polygon that reads several things, and turns within the interval: each state is in a piece of its count."""
    one, chance = behind(kind, width, rate), np.random.default_rng(seed)
    body, wall, drift, n, delay = one.body, one.wall, bounds(one), one.body.order, one.delay_line
    room, known = make_piece_room(zeros, n, delay, lattice=4, deep=4096), behind_known(one)
    z = [float(chance.uniform(-6.0, 3.0)), *(float(v) for v in 0.1 * chance.normal(size=n - 1) / body.reach)]
    shape = polygon(one, chance, corners, 10.0 ** chance.uniform(-3.0, 0.5))
    ring = [float(wall.kappa * chance.integers(0, 5)) for _ in range(delay)]
    before = told(read(z[0] + chance.uniform(-0.5, 0.5) * width, wall), wall)
    least, most = (z[0] + value for value in (shape[:, 0].min(), shape[:, 0].max()))
    half = half_of(known.turns, False, wall)
    low, high = (level_at(known.turns, at, before, half, drift.bottom, wall) for at in (least - 1e-9, most + 1e-9))
    error = 1e-10 / body.reach
    room.corners[: n * corners] = shape.ravel().tolist()
    told_from = centre(z, ring, before, error=error)
    waiting = part(room, 0, told_from, corners, low, high, 1e-10, Cell(drift, known, body, wall))
    assert waiting >= 1
    found, units = pieces_of(room, waiting, one), np.array(drift.units)
    for member in members(shape, chance, 20):
        state, line = [float(v) for v in np.array(z) + member], list(ring)
        count, to = advance(state, before, line, 0, body, wall, zeros(2 * n))
        line = [line[(to + j) % delay] for j in range(delay)]
        reads = told(read_after(state[0], count, wall), wall)
        near = [
            (off(np.array(state) - centre, corners_of, units), piece)
            for centre, corners_of, piece in found
            if piece[STATE + n : STATE + n + delay] == line
            and level_at(known.turns, state[0], piece[BEFORE], half, drift.bottom, wall) == reads
        ]
        assert near, "no piece has these commands, and reads this next"
        assert any(away <= 2.0 * piece[ERROR] + 1e-9 / body.reach for away, piece in near)


@pytest.mark.one_in(7)
@pytest.mark.parametrize("width", [0.1, 1.3])
@pytest.mark.parametrize("kind", PLAIN)
def test_arcs_hold_every_phase_and_end_as_it_does(kind: str, width: float) -> None:
    """They leave no gap; trials of random phases end in the attractor of their arc."""
    one = behind(kind, width)
    body, wall, n, drift = one.body, one.wall, one.body.order, bounds(one)
    known, room = behind_known(one), make_arc_room(zeros, n, one.delay_line)
    totals, scope = [0.0, 0.0, 1.0, 0.0], make_scope(body, wall, one.position(ANGLE), 0.0, one.rate, None)
    slack = fill_arcs(one.start(ANGLE, 0.0), room, drift, body)
    cell = Cell(drift, known, body, wall)
    waiting, _ = follow_arcs(1, slack, 10**7, totals, scope, room, cell)
    assert waiting == 0
    assert totals[1] == 0.0
    arcs = sorted(tuple(room.ended[3 * k : 3 * k + 3]) for k in range(int(totals[0])))
    assert (arcs[0][0], arcs[-1][1]) == (0.0, 1.0)
    assert all(-1e-4 < right[0] - left[1] <= 0.0 for left, right in pairwise(arcs))
    assert sum(known.table[k * FIELDS + 6] for k in range(int(known.counts[0]))) == pytest.approx(totals[3])
    chance = random.Random(kind)
    for phase in [chance.random() for _ in range(8)]:
        own = {row for low, high, row in arcs if low <= phase <= high}
        z = one.start(ANGLE, 0.0)
        advance_span(z, 0.0, phase, body, zeros(2 * n))
        row, _ = seek(centre(z, zeros(one.delay_line), read(z[0], wall)), WHOLE, cell)
        assert row in own


def test_a_search_behind_hysteresis_is_complete() -> None:
    one = behind("finger", 0.4)
    found = GeneralSetEngine().search_phases(
        one.body, one.wall, one.start(ANGLE, 0.0), rate=one.rate, delay_line=0, max_samples=None
    )
    assert found is not None
    assert (found.complete, found.why) == (True, Reason.NONE)
    assert found.share_error is not None
    assert found.share_error < 1e-4


def test_edges_lie_half_the_width_later_on_either_way() -> None:
    """After count -3: up to -2 at -2 + 1/4, down to -4 at -3 - 1/4; outside of the wall all is one, from +1/4 on."""
    one = behind("limit", 0.5)
    turns, wall = behind_known(one).turns, one.wall
    assert (half_of(turns, True, wall), half_of(turns, False, wall)) == (0.0, 0.25)
    assert half_of(None, False, wall) == 0.0
    for x, level in ((-1.8, -3.0), (-1.7, -2.0), (-3.2, -3.0), (-3.3, -4.0), (0.2, -1.0), (0.3, 0.0), (7.0, 0.0)):
        assert level_at(turns, x, -3.0, 0.25, -9.0, wall) == level
    ends = [(lowest_at(turns, k, -3.0, 0.25, -9.0, wall), highest_at(turns, k, -3.0, 0.25, wall)) for k in (-4, -3, -2)]
    assert ends == [(-4.25, -3.25), (-3.25, -1.75), (-1.75, -0.75)]
    assert highest_at(turns, 0.0, -3.0, 0.25, wall) == np.inf
    assert (next_at(turns, -3.0, wall), levels_between(turns, -5.0, -2.0, wall)) == (-2.0, 4)
    assert [next_edge(x, wall) for x in (-2.9, -2.75, -2.3, -2.25)] == [-2.75, -2.25, -2.25, -1.75]


def test_what_a_turning_point_does_to_a_count() -> None:
    """Count -3, a quarter to either side: nothing before -1.75, and nothing that the next sample is past as well."""
    wall = behind("limit", 0.5).wall

    def turned(high: float, top: float, bottom: float, low: float, least: float, most: float, *ways: bool) -> Any:
        return turned_count(-3.0, [top, high, bottom, low, least, most], *ways, wall)

    flat = -2.5, -2.5  # the lowest
    for top, least, what in ((-1.8, -2.5, CLEAR), (-1.7, -2.5, UP), (-1.7, -1.74, CLEAR), (-0.7, -1.74, UP)):
        found = turned(top, top, *flat, least, least, True, False)
        assert found == (what, -3.0 if what == CLEAR else told(read(top - 0.25, wall), wall))
        assert turned(top, top, *flat, least, least, False, False) == (CLEAR, -3.0)
    assert turned(-2.0, -1.7, -2.5, -2.5, -2.5, -2.5, True, False) == (OPEN, -3.0)
    for bottom, most, what in ((-3.2, -2.5, CLEAR), (-3.3, -2.5, DOWN), (-3.3, -3.26, CLEAR), (-4.3, -3.26, DOWN)):
        found = turned(-2.5, -2.5, bottom, bottom, most, most, False, True)
        assert found == (what, -3.0 if what == CLEAR else told(read(bottom + 0.25, wall), wall))
    assert turned(-2.5, -2.5, -3.3, -3.0, -2.5, -2.5, False, True) == (OPEN, -3.0)
    assert turned(-1.7, -1.7, -3.3, -3.3, -2.5, -2.5, True, True) == (OPEN, -3.0)  # in what order?
