"""Tests of `engine.general.sets.friction_arc_counts`: no state of an arc counts otherwise than is told."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hknob_cli.engine.general.advance import rub_many
from hknob_cli.engine.general.body import acceleration, copy_to, norm
from hknob_cli.engine.general.controller import read, read_after
from hknob_cli.engine.general.hysteresis import turn_and_count
from hknob_cli.engine.general.sets.friction_arc import COUNT, COUNT_TO, ERROR, begin_ball, rub_arc
from hknob_cli.engine.general.sets.friction_arc_counts import (
    begin_counts,
    count_turns,
    keep_start,
    pass_window,
    tells_counts,
    window_of,
)
from hknob_cli.engine.general.sets.friction_arc_search import make_rub_room, rub_drift
from hknob_cli.engine.general.slide_many import slide_many
from hknob_cli.engine.general.slide_two import way
from hknob_cli.scene.general_knob import GeneralKnob

from .cells import zeros
from .test_friction_arc import KINDS, LEVELS, arc_of, held_by, rubbing

TURNS = object()  # there is hysteresis
DETENTS: dict[str, Any] = {"detents": {"per_revolution": 24, "torque": 3e-3}}  # each count is told, outside, too


def behind(kind: str, level: float, width: float) -> GeneralKnob:
    """A cell of this kind behind hysteresis of so many counts, its knob with so much friction, N·m."""
    return rubbing(kind, level, 464.2, encoder={"hysteresis_counts": width}, **DETENTS)


def random_arc(one: GeneralKnob, size: float, chance: np.random.Generator) -> tuple[Any, Any, list[list[float]]]:
    """An arc of half this length and half as much beside it, about a place, moving or not; and states in it."""
    body, n = one.body, one.body.order
    drift, room = rub_drift(body, one.wall), make_rub_room(zeros, list, body, one.wall, 0, None)
    free = n - (body.lag > 0.0)
    spans = np.array(list(room.spans))[:free]

    def some() -> list[float]:
        away = [*(spans * chance.normal(size=free)).tolist(), *([0.0] * (n - free))]
        return [value / norm(away, body) for value in away]

    centre, line = [float(chance.choice([1.0, 0.1])) * value for value in some()], [size * value for value in some()]
    centre[0] += float(chance.uniform(-2.0, 1.0))
    if n > 2:
        centre[2] = 0.0
    for j in range(n):
        room.z[j], room.columns[j] = centre[j], line[j]
    room.arc[ERROR] = 1e-15 * norm([abs(value) for value in centre], body)
    begin_ball(room, 0.5 * size, body)
    states = []
    for part in np.linspace(-1.0, 1.0, 7):
        more = some()
        states.append([centre[j] + float(part) * line[j] + 0.5 * size * more[j] for j in range(n)])
    return room, drift, states


def torque(one: GeneralKnob, room: Any, u: float, chance: np.random.Generator) -> float:
    """The one before, another, or about as much as friction can hold."""
    if chance.random() < 0.3 and one.body.friction > 0.0:
        return float(chance.uniform(-1.3, 1.3)) * one.body.friction - acceleration(room.z, 0.0, one.body)
    if chance.random() < 0.5:
        return float((one.wall.kappa + one.body.friction) * chance.normal())
    return u


COUNTED_ARCS = {
    "kind": st.sampled_from(sorted(KINDS)),
    "level": st.sampled_from(LEVELS),
    "width": st.sampled_from([0.02, 0.5, 3.0]),
    "seed": st.integers(0, 2**32 - 1),
    "length": st.floats(-6.0, 0.0),
}


@settings(deadline=None, max_examples=12)
@given(**COUNTED_ARCS)
def test_no_state_counts_otherwise(kind: str, level: float, width: float, seed: int, length: float) -> None:
    """Each of 7, moved by itself, reads after every hold what one of the counts of the arc reads at its place."""
    one, chance = behind(kind, level, width), np.random.default_rng(seed)
    body, wall = one.body, one.wall
    room, drift, states = random_arc(one, 10.0**length, chance)
    counts = [read(z[0], wall) for z in states]
    room.arc[COUNT], room.arc[COUNT_TO] = min(counts), max(counts)
    u = 0.0
    for _ in range(16):
        u = torque(one, room, u, chance)
        span = float(chance.choice([1.0, 0.5, chance.uniform(0.01, 1.0)]))
        wide = keep_start(TURNS, room, body)
        alike = rub_arc(room, room.z, u, span, drift, body)
        count_turns(TURNS, room, u, span, alike, wide, body, wall)
        for number, z in enumerate(states):
            counts[number], _ = turn_and_count(z, u, span, counts[number], body, wall, zeros(2 * body.order))
            shown = read_after(z[0], counts[number], wall)
            assert read_after(z[0], room.arc[COUNT], wall) <= shown <= read_after(z[0], room.arc[COUNT_TO], wall)


@pytest.mark.long
@settings(deadline=None, max_examples=40)
@given(**COUNTED_ARCS)
def test_no_state_counts_otherwise_of_more(**drawn: Any) -> None:
    test_no_state_counts_otherwise.hypothesis.inner_test(**drawn)


@pytest.mark.parametrize("level", LEVELS)
@pytest.mark.parametrize("kind", ["finger", "winding", "teeth", "winding, finger, lag"])
def test_an_arc_of_one_state_counts_as_it_does(kind: str, level: float) -> None:
    """Unless a turning point is within rounding of an edge, which none of these is."""
    one, chance = behind(kind, level, 0.5), np.random.default_rng(3)
    body, wall = one.body, one.wall
    room, drift, _ = random_arc(one, 1e-12, chance)
    z = list(room.z)
    count = read(z[0], wall)
    begin_counts(TURNS, count, room.arc)
    u, changes = 0.0, 0
    for _ in range(48):
        u = torque(one, room, u, chance)
        wide, before = keep_start(TURNS, room, body), count
        alike = rub_arc(room, room.z, u, 1.0, drift, body)
        count_turns(TURNS, room, u, 1.0, alike, wide, body, wall)
        count, _ = turn_and_count(z, u, 1.0, count, body, wall, zeros(2 * body.order))
        changes += count != before
        assert tells_counts(TURNS, room.arc)
        assert read_after(z[0], room.arc[COUNT], wall) == read_after(z[0], count, wall)
    assert changes > 0


def test_a_window_lets_counts_be_those_of_its_places() -> None:
    """From a place up past an edge and back: some have passed it, or none, or all, by how far they may come."""
    one = behind("finger", 1e-4, 0.5)
    room = make_rub_room(zeros, list, one.body, one.wall, 0, None)
    for far, expected in ((0.1, (0.0, 1.0)), (0.01, (0.0, 0.0))):
        begin_counts(TURNS, 0.0, room.arc)
        pass_window(0.7, 1.0, (0.7, 1.2), far, room.arc, one.wall)  # 1 is passed at 1.25 on the way up
        assert (room.arc[COUNT], room.arc[COUNT_TO]) == expected
    begin_counts(TURNS, 0.0, room.arc)
    pass_window(1.4, 1.0, (1.0, 1.4), 0.01, room.arc, one.wall)
    assert (room.arc[COUNT], room.arc[COUNT_TO]) == (1.0, 1.0)
    begin_counts(TURNS, 1.0, room.arc)
    pass_window(0.9, 0.9, (0.7, 0.9), 0.01, room.arc, one.wall)  # and at 0.75 on the way down
    assert (room.arc[COUNT], room.arc[COUNT_TO]) == (0.0, 1.0)


def moved(one: GeneralKnob, count: float, centre: list[float], line: list[float], u: float) -> tuple[Any, Any]:
    """A straight arc with a count, moved over a hold under ``u``; and whether its states did alike."""
    room, drift = arc_of(one, centre, line)
    begin_counts(TURNS, count, room.arc)
    wide = keep_start(TURNS, room, one.body)
    alike = rub_arc(room, room.z, u, 1.0, drift, one.body)
    count_turns(TURNS, room, u, 1.0, alike, wide, one.body, one.wall)
    return room, alike


def test_a_state_turns_whose_centre_does_not() -> None:
    """It has moved down by 0.07, past the edge at -0.25, and has come back where it still counts as there."""
    one = rubbing("finger", 0.0, 10_000.0, encoder={"hysteresis_counts": 0.5})
    centre, line = [-0.182, 0.02, 0.0, 0.0], [0.0, 0.3, 0.0, 0.0]
    state, u = [p - q for p, q in zip(centre, line, strict=True)], held_by(one, 0.55)
    count, _ = turn_and_count(state, u, 1.0, 0.0, one.body, one.wall, zeros(8))
    assert (count, read_after(state[0], count, one.wall)) == (-1.0, -1.0)
    room, _ = moved(one, 0.0, centre, line, u)
    assert room.z[1] > centre[1]
    assert (room.arc[COUNT], room.arc[COUNT_TO]) == (-1.0, 0.0)


@pytest.mark.parametrize(("short", "most"), [(0.01, 0.0), (0.04, -1.0)])
def test_states_that_stop_alike_are_told_by_their_line(short: float, most: float) -> None:
    """The centre stops ``short`` of the edge of 0 on the way up, which is at 0.25; the farthest 0.02 beyond that."""
    one = rubbing("finger", 5.6e-4, 10_000.0, encoder={"hysteresis_counts": 0.5})
    u = held_by(one, 0.0)
    centre, line = [-0.75, 0.7 * one.body.friction, 0.0, 0.0], [0.02, 0.0, 0.0, 0.0]
    centre[3] = centre[1]  # the finger stands
    probe = list(centre)
    rub_many(probe, u, 1.0, one.body, zeros(8))
    centre[0] += 0.25 - short - probe[0]
    room, alike = moved(one, -1.0, centre, line, u)
    assert alike
    assert room.z[1] == 0.0
    assert (room.arc[COUNT], room.arc[COUNT_TO]) == (-1.0, most)


@settings(deadline=None, max_examples=40)
@given(
    kind=st.sampled_from(sorted(KINDS)),
    level=st.sampled_from(LEVELS),
    seed=st.integers(0, 2**32 - 1),
    length=st.floats(-4.0, -0.5),
)
def test_a_slide_is_faster_than_states_differ_outside_of_its_window(
    kind: str, level: float, seed: int, length: float
) -> None:
    """At 65 times of a slide; and places are those of the centre at the window's ends."""
    one, chance = behind(kind, level, 0.5), np.random.default_rng(seed)
    body, apart = one.body, 10.0**length
    room, _, _ = random_arc(one, 0.0, chance)
    u = torque(one, room, 0.0, chance)
    copy_to(room.first, room.z)
    mode = way(room.z[1], acceleration(room.z, u, body), body.friction)
    if mode == 0:
        return
    time, stops, _ = slide_many(room.z, u, mode, 1.0, body, room.pad)
    begins, ends, first, last = window_of(room, u, mode, (time, stops), apart, body)
    assert 0.0 <= begins <= ends <= time
    for share in np.linspace(0.0, 1.0, 65):
        at = list(room.first)
        slide_many(at, u, mode, float(share) * time, body, zeros(2 * body.order))
        if not begins <= share * time <= ends:
            assert abs(at[1]) > apart
    for when, place in ((begins, first), (ends, last)):
        if begins < ends:
            at = list(room.first)
            slide_many(at, u, mode, when, body, zeros(2 * body.order))
            assert place == pytest.approx(at[0], abs=1e-12)
