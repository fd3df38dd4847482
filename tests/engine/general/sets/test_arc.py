"""Tests of `engine.general.sets.arc`, `curve` and `known`: whatever a phase truly ends in, its arc says."""

import random
from itertools import pairwise

import numpy as np
import pytest

from hknob_cli.engine.follow import CYCLE_PROVEN
from hknob_cli.engine.general.advance import advance_span
from hknob_cli.engine.general.body import distance, norm
from hknob_cli.engine.general.captured import FIELDS
from hknob_cli.engine.general.controller import read
from hknob_cli.engine.general.interval import advance
from hknob_cli.engine.general.sets.arc import fill_arcs, follow_arcs
from hknob_cli.engine.general.sets.cell import Cell
from hknob_cli.engine.general.sets.curve import measure_arc, place_on
from hknob_cli.engine.general.sets.ends import Known
from hknob_cli.engine.general.sets.known import captor, resting, seek
from hknob_cli.engine.general.sets.readings import remembered
from hknob_cli.engine.general.sets.room import ArcRoom, make_arc_room
from hknob_cli.engine.general.sets.scope import make_scope
from hknob_cli.scene.general_knob import GeneralKnob

from .cells import KINDS, WHOLE, bounds, cell, centre, nothing_known, zeros

ANGLE = 0.02


def followed(knob: GeneralKnob) -> tuple[Known, ArcRoom, list[float]]:
    """All phases of one start, followed."""
    body, wall, drift, known = knob.body, knob.wall, bounds(knob), nothing_known(knob)
    room, totals = make_arc_room(zeros, body.order, knob.delay_line), [0.0, 0.0, 1.0, 0.0]
    scope = make_scope(body, wall, knob.position(ANGLE), 0.0, knob.rate, None)
    slack = fill_arcs(knob.start(ANGLE, 0.0), room, drift, body)
    waiting, _ = follow_arcs(1, slack, 10**7, totals, scope, room, Cell(drift, known, body, wall))
    assert waiting == 0
    return known, room, totals


@pytest.mark.one_in(4)
@pytest.mark.parametrize("kind", sorted(KINDS))
def test_arcs_hold_every_phase_and_end_as_it_does(kind: str) -> None:
    """They leave no gap and overlap by rounding alone; trials of random phases end in the attractor of their arc."""
    knob = cell(kind)
    body, wall, n = knob.body, knob.wall, knob.body.order
    known, room, totals = followed(knob)
    assert totals[1] == 0.0
    arcs = sorted(tuple(room.ended[3 * k : 3 * k + 3]) for k in range(int(totals[0])))
    assert arcs[0][0] == 0.0
    assert arcs[-1][1] == 1.0
    assert all(-1e-6 < right[0] - left[1] <= 0.0 for left, right in pairwise(arcs))
    assert sum(known.table[k * FIELDS + 6] for k in range(int(known.counts[0]))) == pytest.approx(totals[3])
    chance = random.Random(kind)
    for phase in [chance.random() for _ in range(8)]:
        own = {row for low, high, row in arcs if low <= phase <= high}
        z, ring = knob.start(ANGLE, 0.0), zeros(knob.delay_line)
        advance_span(z, 0.0, phase, body, zeros(2 * n))
        one, whole = centre(z, ring, read(z[0], wall)), Cell(bounds(knob), known, body, wall)
        row, used = seek(one, WHOLE, whole)
        assert row in own
        assert seek(one._replace(sample=WHOLE.budget - 0.5 * used), WHOLE, whole)[0] < 0  # half is not enough


@pytest.mark.parametrize("kind", ["limit", "lag", "stiff finger, late"])
def test_an_arc_lies_within_its_radius_and_its_bulge(kind: str) -> None:
    """States of random phases, moved by the plant, are no farther from the middle, and from the chord, than is said."""
    knob, chance = cell(kind), random.Random(kind)
    body, drift, n = knob.body, bounds(knob), knob.body.order
    room, start = make_arc_room(zeros, n, knob.delay_line), knob.start(ANGLE, -1.0)
    place_on(0.5, start, zeros(n), room, body)
    phi = np.array(drift.powers[: n * n]).reshape(n, n)
    for samples in (0, 1, 7):
        for _ in range(5):
            low, high = sorted((chance.random(), chance.random()))
            radius, bulge = measure_arc(low, high, samples, room, drift, body)
            states = []
            for phase in (0.5 * (low + high), low, high, chance.uniform(low, high)):
                z = zeros(n)
                place_on(phase, start, z, room, body)
                states.append((phase, np.linalg.matrix_power(phi, samples) @ np.array(z)))
            middle, (_, first), (_, last), (phase, one) = states
            assert norm(list(one - middle[1]), body) <= radius + 1e-9
            chord = first + (phase - low) / (high - low) * (last - first)
            assert norm(list(one - chord), body) <= bulge + 1e-9
            assert list(last - middle[1]) == pytest.approx(list(room.above), abs=1e-7)
            assert list(first - middle[1]) == pytest.approx(list(room.below), abs=1e-7)


@pytest.mark.parametrize("kind", ["whole delay", "virtual damping", "lag", "finger", "all of second order"])
def test_what_is_captured_keeps_the_readings_of_the_orbit(kind: str) -> None:
    """Up to the margin, and not beyond; only with the same commands under way and the same last reading."""
    knob, chance = cell(kind), random.Random(kind)
    body, wall, n, delay = knob.body, knob.wall, knob.body.order, knob.delay_line
    known, _, _ = followed(knob)
    width = n + delay + 2
    rows = [int(known.points[k * width]) for k in range(int(known.counts[1]))]
    assert rows
    row = rows[0]
    assert known.table[row * FIELDS] == CYCLE_PROVEN
    margin = known.table[row * FIELDS + 2] - known.table[row * FIELDS + 5]
    point = known.points[:width]
    before, orbit, ring = point[1], list(point[2 : 2 + n]), list(point[2 + n :])
    assert captor(orbit, before, ring, 0, 0.99 * margin / body.reach, known, body, wall) == row
    # Two orbits may lie side by side, but none within the other's margin.
    assert captor(orbit, before, ring, 0, 1.01 * margin / body.reach, known, body, wall) != row
    if delay:
        assert captor(orbit, before, [value + 1.0 for value in ring], 0, 0.0, known, body, wall) == -1
    if wall.damping > 0.0:
        assert captor(orbit, before + 1.0, ring, 0, 0.0, known, body, wall) == -1
    for _ in range(5):
        away = [chance.gauss(0.0, 1.0) for _ in range(n)]
        size = 0.99 * margin / distance(away, body)
        other = [z + size * one for z, one in zip(orbit, away, strict=True)]
        pairs = [[list(orbit), list(ring), before, 0], [other, list(ring), before, 0]]
        for _ in range(300):
            assert read(pairs[0][0][0], wall) == read(pairs[1][0][0], wall)
            for one in pairs:
                one[2], one[3] = advance(one[0], one[2], one[1], one[3], body, wall, zeros(2 * n))


def test_rest_captures_up_to_its_margin() -> None:
    """A knob that settles inside one reading: a set around it ends there where none of it can leave the reading."""
    knob = cell("truncated")._replace()
    body = knob.body._replace(drive=-0.6 * knob.body.beta - 0.0, push=0.6 * knob.body.beta)
    wall, known = knob.wall, nothing_known(knob)
    rest = body.drive / body.beta
    assert -1.0 < rest < 0.0
    shown = read(rest, wall)
    assert shown == 0.0
    reach = min(rest + 1.0, 1.0 - rest) / body.reach
    assert resting([rest, 0.0], remembered(shown, wall), [], 1.01 * reach, shown, known, body, wall) == -1
    assert resting([rest, 0.0], shown + 1.0, [], 0.9 * reach, shown, known, body, wall) == -1
    assert resting([rest, 0.0], remembered(shown, wall), [], 0.98 * reach, shown, known, body, wall) == 0
