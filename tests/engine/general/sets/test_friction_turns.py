"""Tests of `engine.general.sets.friction_turns`: behind hysteresis friction stops no motion with a count that is lost.

A state, moved by itself from stop to stop, must read at the next sample what its piece reads there.
"""

from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from hknob_cli.engine.general.controller import read, read_after, told
from hknob_cli.engine.general.interval import advance
from hknob_cli.engine.general.laws.step import advance_with_law, begin_past
from hknob_cli.engine.general.sets.cell import Cell
from hknob_cli.engine.general.sets.convex import keep_side
from hknob_cli.engine.general.sets.friction_piece import move_piece
from hknob_cli.engine.general.sets.friction_room import make_friction_room
from hknob_cli.engine.general.sets.friction_search import FrictionSetEngine
from hknob_cli.engine.general.sets.friction_step import Hold, Shape
from hknob_cli.engine.general.sets.friction_turns import Ahead, counts_after, farthest, may_stop, measure_stops
from hknob_cli.engine.general.sets.law_search import LawSetEngine
from hknob_cli.engine.general.sets.piece import BEFORE, COUNT, STATE
from hknob_cli.engine.general.sets.turns import highest_at, level_at, lowest_at
from hknob_cli.engine.general.slide_two import coefficients
from hknob_cli.engine.outcome import Outcome
from hknob_cli.engine.sets.search import Box
from hknob_cli.scene.general_knob import GeneralKnob
from tests.engine.general.bodies import knob
from tests.engine.sets.test_polygon import states_of

from .cells import all_phases, centre
from .test_law_search import BEHIND, RUBS, first_state
from .test_law_search import cell as law_cell

HALF = {"half_quantum": True}
WIDTHS = (0.02, 0.3, 1.0, 2.6)
ACTUATORS: tuple[dict[str, float], ...] = (
    {},
    {"delay_samples": 0.5},
    {"delay_samples": 1.0},
    {"time_constant": 5e-5},
    {"time_constant": 1e-3, "delay_samples": 0.5},
)


def behind(width: float, rate: float, counts: int, friction: float, actuator: dict[str, float]) -> GeneralKnob:
    """A knob with friction, its encoder with hysteresis, in counts."""
    return knob(
        rate,
        counts,
        knob={"inertia": 1.9e-6, "coulomb_torque": friction},
        bias=HALF,
        actuator=actuator,
        encoder={"hysteresis_counts": width},
    )


def outside(point: Any, corners: Any) -> float:
    """How far a point is outside a convex polygon, a chord or a point; 0 inside."""
    away, sides = np.inf, []
    for k in range(len(corners)):
        a, b = corners[k], corners[(k + 1) % len(corners)]
        way = b - a
        part = np.clip(np.dot(point - a, way) / max(np.dot(way, way), 1e-300), 0.0, 1.0)
        away = min(away, float(np.linalg.norm(a + part * way - point)))
        sides.append(way[0] * (point - a)[1] - way[1] * (point - a)[0])
    within = len(corners) > 2 and (min(sides) >= -1e-12 or max(sides) <= 1e-12)
    return 0.0 if within else away


@settings(deadline=None, max_examples=20)
@example(width=0.3, rate=4641.0, counts=2048, friction=5.6e-4, actuator=ACTUATORS[0], seed=174, corners=7)
@given(
    width=st.sampled_from(WIDTHS),
    rate=st.sampled_from([100.0, 455.0, 2000.0, 4641.0]),
    counts=st.sampled_from([256, 2048]),
    friction=st.sampled_from([1e-4, 5.6e-4]),
    actuator=st.sampled_from(ACTUATORS),
    seed=st.integers(0, 2**32 - 1),
    corners=st.integers(3, 10),
)
def test_no_state_loses_its_count_where_it_stops(
    width: float, rate: float, counts: int, friction: float, actuator: dict[str, float], seed: int, corners: int
) -> None:
    """Of a polygon that acts as one count: each state is in a piece that reads as it does."""
    one, chance, engine = (
        behind(width, rate, counts, friction, actuator),
        np.random.default_rng(seed),
        FrictionSetEngine(),
    )
    cell: Cell = engine.ready(one.body, one.wall, one.delay_line)
    body, wall, turns, half = one.body, one.wall, cell.known.turns, 0.5 * width
    room = engine.room(body, one.delay_line)
    work = make_friction_room(engine._zeros, engine._filled, one.delay_line, body, wall)
    x = float(chance.uniform(-6.0, 3.0))
    v = float(chance.choice([0.0, 0.01, 0.1, 0.5]) * chance.normal() / body.reach)
    level = told(read(x + chance.uniform(-0.5, 0.5) * width, wall), wall)
    size, angles = 10.0 ** chance.uniform(-3.0, 0.3), np.sort(chance.uniform(0.0, 2.0 * np.pi, corners))
    shape = (size * np.stack([np.cos(angles), np.sin(angles) / body.reach], 1)).ravel().tolist()
    low, high = lowest_at(turns, level, level, half, -1e9, wall) - x, highest_at(turns, level, level, half, wall) - x
    cut = [0.0] * 64
    kept = keep_side(shape, corners, 1.0, 0.0, low, cut)
    if kept > 0 and high < np.inf:
        kept = keep_side(cut[: 2 * kept], kept, -1.0, 0.0, -high, cut)
    if kept < 2:
        return
    late = [float(wall.kappa * chance.uniform(0.0, 5.0))] if body.lag > 0.0 else []
    ring = [float(wall.kappa * chance.integers(0, 5)) for _ in range(one.delay_line)]
    room.corners[: 2 * kept] = cut[: 2 * kept]
    begun = centre([x, v, *late], list(ring), before=level, error=1e-11 / body.reach, level=level)
    waiting = move_piece(room, work, 0, begun, kept, cell)
    if waiting < 0:
        return  # no room: then all of it is undecided
    order, wide, found = len(begun.z), len(room.own), []
    for k in range(waiting):
        piece = room.stack[k * wide : (k + 1) * wide]
        first = STATE + order + one.delay_line
        corners_of = np.array(piece[first : first + 2 * int(piece[COUNT])]).reshape(-1, 2)
        found.append((np.array(piece[STATE : STATE + 2]), piece[BEFORE], corners_of, piece[STATE + order : first]))
    scale = np.array([1.0, body.reach])
    for dx, dv in states_of(cut[: 2 * kept], kept, seed):
        if told(read_after(x + dx, level, wall), wall) != level:
            continue  # on the edge of what acts so
        state, line = [x + dx, v + dv, *late], list(ring)
        before, head = advance(state, level, line, 0, body, wall, [0.0] * 6)
        line = [line[(head + j) % len(line)] for j in range(len(line))]
        reads = told(read_after(state[0], before, wall), wall)
        assert any(
            memory == line
            and level_at(turns, state[0], count, half, -1e9, wall) == reads
            and outside((np.array(state[:2]) - at) * scale, corners_of * scale) < 1e-6
            for at, count, corners_of, memory in found
        )


@pytest.mark.parametrize("seed", range(8))
def test_the_highest_place_of_each_state_is_between_the_bounds_of_its_set(seed: int) -> None:
    """Slid on in small steps until it stops, under torques anywhere between the least and the most."""
    chance, body = np.random.default_rng(seed), behind(0.3, 1000.0, 1024, 2e-4, {}).body
    span = float(chance.uniform(0.1, 0.9))
    hold = Hold(span, *coefficients(span, body))
    corners = (chance.uniform(0.01, 1.0) * chance.normal(size=(4, 2))).ravel().tolist()
    shape, low = Shape(-1.5, 0.2, corners, 4), float(chance.uniform(-3.0, 3.0) * body.friction)
    high = low + float(chance.uniform(0.0, 1.0)) * body.friction
    for sign in (1.0, -1.0):
        near, far = sorted((sign * low, sign * high))
        some, most, least = measure_stops(sign, shape, Ahead(hold, (low, high)), 0.0, body, [0.0] * 20)
        for dx, dv in states_of(corners, 4, seed):
            px, pv = sign * (shape.x + dx), sign * (shape.v + dv)
            if pv < 0.0:
                continue
            torque = float(chance.uniform(near, far)) - body.friction
            stops = farthest(px, pv, torque - body.beta * px, hold, body)
            assert some or not stops[1] < span
            if some:
                assert least - 1e-12 <= stops[0] <= most + 1e-12
                places = [px]
                for time in np.linspace(0.0, span, 200)[1:]:
                    s, g, f = coefficients(float(time), body)
                    if f * pv + s * (torque - body.beta * px) < 0.0:
                        break
                    places.append(px + (s * pv + g * (torque - body.beta * px)))
                assert max(places) <= stops[0] + 1e-12


def test_only_what_moves_that_way_or_stands_stops_there() -> None:
    """And only where it does so before the hold ends."""
    body = behind(0.3, 1000.0, 1024, 2e-4, {}).body
    hold, still = Hold(0.5, *coefficients(0.5, body)), body.beta * -1.5
    for velocity, pull, up, down in ((0.5, 0.0, False, False), (0.001, -10.0, True, False), (0.0, 0.0, True, True),
                                     (-0.001, 10.0, False, True), (-0.5, 0.0, False, False)):  # fmt: skip
        shape, free = Shape(-1.5, velocity, [0.0, 0.0], 1), still + pull
        assert may_stop(1.0, shape, free - body.friction, 1e-12, hold, body) == up
        assert may_stop(-1.0, shape, -free - body.friction, 1e-12, hold, body) == down


def test_a_count_follows_a_stop_by_half_of_the_hysteresis() -> None:
    """And never goes the other way; counts outside the wall are told as one."""
    wall = behind(0.5, 1000.0, 1024, 2e-4, {}).wall
    for place, count, after in ((-1.76, -3.0, -3.0), (-1.74, -3.0, -2.0), (-2.5, -2.0, -2.0), (3.5, -2.0, 0.0)):
        assert counts_after(1.0, (True, place, place), count, 0.0, wall) == (after, after)
    for place, count, after in ((-2.24, -2.0, -2.0), (-2.26, -2.0, -3.0), (-2.0, -3.0, -3.0)):
        assert counts_after(-1.0, (True, -place, -place), count, 0.0, wall) == (after, after)
    assert counts_after(1.0, (True, -1.74, -1.8), -3.0, 0.02, wall) == (-3.0, -2.0)
    assert counts_after(1.0, (True, -1.76, -1.8), -3.0, 0.02, wall) == (-3.0, -2.0)
    assert counts_after(1.0, (False, 9.0, 9.0), -3.0, 0.0, wall) == (-3.0, -3.0)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("actuator", ACTUATORS[:4])
def test_all_phases_are_complete(actuator: dict[str, float]) -> None:
    """Trials of some of them end in the cycles that are listed."""
    one = behind(0.3, 455.0, 256, 1e-4, actuator)
    phases = all_phases(FrictionSetEngine(), one)
    assert phases.complete
    assert sum(each.trials for each in phases.attractors) == pytest.approx(1.0, abs=1e-6)
    cycles = {(each.period, round(each.x, 6)) for each in phases.attractors if each.trials > 0.0}
    for trial in range(12):
        z, ring, head = one.start(0.02, 0.0), [0.0] * one.delay_line, 0
        before = read(z[0], one.wall)
        lowest: list[float] = []
        for sample in range(400 + trial):
            before, head = advance(z, before, ring, head, one.body, one.wall, [0.0] * 6)
            lowest = [*lowest[-60:], z[0]] if sample > 300 else []
        assert any(abs(min(lowest) - x) < 1e-5 for _, x in cycles)


def test_a_knob_that_friction_stops_rests_outside_the_wall_as_one() -> None:
    """However many counts the rests are apart: one row, told as 0."""
    one = behind(0.3, 4641.0, 4096, 5.6e-4, {})
    found = all_phases(FrictionSetEngine(), one)
    assert found.complete
    assert [(each.outcome, each.before) for each in found.attractors] == [(Outcome.REST, 0.0)]


def test_ranges_behind_hysteresis_are_complete() -> None:
    one = behind(0.3, 455.0, 256, 5.6e-4, {})
    box = Box(one.position(-0.01), one.position(0.01), one.speed(-0.5), one.speed(0.5))
    limits: dict[str, Any] = {"rate": one.rate, "delay_line": one.delay_line, "max_samples": None}
    found = FrictionSetEngine().search_box(one.body, one.wall, box, **limits)
    assert found.complete
    assert {each.outcome for each in found.attractors if each.trials > 0.0} <= {Outcome.CYCLE, Outcome.REST}


@pytest.mark.parametrize(
    "name", ["speed, timed, filtered", "bounded lag", "impulse, short", "speed and angle, tracked"]
)
def test_a_set_of_one_state_remembers_what_a_trial_does(name: str) -> None:
    """To the last bit, under a law: its counts, also where it reads its encoder within an interval."""
    made, law, length = law_cell(name, **RUBS, **BEHIND)
    one, engine = made.knob, LawSetEngine(law)
    cell = engine.ready(one.body, one.wall, length)
    room = engine.room(one.body, length)
    work = make_friction_room(engine._zeros, engine._filled, length, one.body, one.wall, law)
    z, past = first_state(made, 0.3), [0.0] * length
    begin_past(past, read(z[0], one.wall), law)
    for _ in range(120):
        level = read_after(z[0], past[law.line - 1], law.watch)
        room.own[:], room.corners[:2] = [0.0] * len(room.own), [0.0, 0.0]
        waiting = move_piece(room, work, 0, centre(list(z), list(past), error=1e-14, level=level), 1, cell)
        advance_with_law(z, past, one.body, one.wall, law, [0.0] * 6)
        begins = [k * len(room.own) + STATE for k in range(waiting)]
        found = [room.stack[at : at + len(z) + length] for at in begins]
        assert any(abs(piece[0] - z[0]) < 1e-9 and list(piece[len(z) :]) == list(past) for piece in found)
