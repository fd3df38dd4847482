"""Teeth with play beside cogging: against matrix exponentials and an integrator, event by event, and by hand."""

from itertools import pairwise
from math import inf
from random import Random
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.general.cogging import FALLEN, RISEN, TURNED
from hknob_cli.engine.general.columns import Columns
from hknob_cli.engine.general.flanks import play_chart, play_columns, play_many
from hknob_cli.engine.general.teeth import (
    APART,
    BACK,
    ON_STABLE,
    ON_UNSTABLE,
    SPRUNG,
    STUCK_APART,
    STUCK_BACK,
    direction,
    flank,
    pressing,
    teeth_pull,
    teeth_rate,
)
from hknob_cli.engine.general.teeth_ends import Mode, press

from .toothed import SCENES, Integrated, Toothed, begun_on, body_of

CLOSE = 1e-8  # of the size of the state: far above roundings, far below any event that is missed
SEEDS = range(14)


class Case:
    """One motion over a time of so many 64ths of a sample, and what the exponentials make of it."""

    def __init__(self, name: str, seed: int) -> None:
        self.body = body_of(name)
        chance = Random(f"{name} {seed}")
        self.z, self.u = begun_on(self.body, chance)
        self.steps = chance.choice([1, 24, 63, 64, 64, 64, 64, 64])
        self.gear = Toothed(self.body)
        self.end, self.events = self.gear.move(self.z, self.u, self.steps)
        self.size = 1.0 + max(map(abs, self.end))
        self.pad = [0.0] * (2 * self.body.order)

    @property
    def span(self) -> float:
        return self.steps / 64.0

    @property
    def first(self) -> tuple[int, int, float]:
        """Flank, way and slope at the start."""
        gear = Toothed(self.body)
        gear.move(self.z, self.u, 0)
        return (*gear.now, gear.slope)

    def near(self, found: Any, expected: Any) -> bool:
        n = self.body.order
        return bool(np.abs(np.array(found[:n]) - np.array(expected[:n])).max() <= CLOSE * self.size)


@pytest.mark.parametrize("name", SCENES)
def test_rates_and_pulls_are_those_of_the_parts(name: str) -> None:
    """On both kinds of slope, far from their middle; friction holds the motor whatever cogging pulls it by."""
    body = body_of(name)
    gear, n = Toothed(body), body.order
    chance = Random(name)
    for slope in (0.0, 1.0, -1.0, 4.0, -7.0):
        gear.on(slope)
        for side in (1, 0, -1):
            for way in (1, 0, -1) if body.friction > 0.0 else (0,):
                z, u = [chance.gauss(0.0, 1.0) for _ in range(n)], chance.gauss(0.0, 1.0)
                if way == 0 and body.friction > 0.0:
                    z[1] = 0.0
                whole = np.array([*z, 1.0, u])
                out = [9.0] * (n + 1)
                teeth_rate(z, u, side, way, body, out, slope)
                expected = (gear.rates[side, way] @ whole)[:n]
                size = np.abs(gear.rates[side, way][:n]) @ np.abs(whole)
                assert (np.abs(np.array(out[:n]) - expected) <= 1e-12 * size).all()
                assert out[n] == 9.0
                pull = gear.pulls[side] @ whole
                size = 1e-12 * np.abs(gear.pulls[side]) @ np.abs(whole)
                for given, at in ((z, 0), ([5.0, 7.0, *z], 2)):
                    assert teeth_pull(given, at, u, side, body, slope) == pytest.approx(pull, rel=1e-9, abs=size)
                z[1] = 0.0
                pull = gear.pulls[side] @ np.array([*z, 1.0, u])
                then = 0 if 0.0 < body.friction >= abs(pull) else 1 if pull > 0.0 else -1
                assert direction(z, u, side, body, slope) == then


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", SCENES)
def test_a_motion_and_its_chart_go_from_event_to_event(name: str) -> None:
    """The same ends, in the same order; a chart has a piece for each, with its mode."""
    kinds = {"corner": 0, "spring": 0}
    for seed in SEEDS:
        case = Case(name, seed)
        body, n = case.body, case.body.order
        z = list(case.z)
        play_many(z, case.u, case.span, body, case.pad)
        assert case.near(z, case.end)
        pieces = SimpleNamespace(spans=[0.0] * 60, modes=[99] * 60, commands=[0.0] * 60, states=[0.0] * (61 * n))
        z = list(case.z)
        rows = play_chart(z, case.u, case.span, body, case.pad, 2, pieces)
        assert case.near(z, case.end)
        assert pieces.states[rows * n : rows * n + n] == z
        assert sum(pieces.spans) == pytest.approx(case.span, rel=1e-12)
        assert pieces.commands == [0.0] * 2 + [case.u] * (rows - 2) + [0.0] * (60 - rows)
        seen = np.cumsum(pieces.spans[2:rows])
        starts = [0.0, *(one.time for one in case.events)]
        modes = [case.first, *((one.flank, one.way, one.slope) for one in case.events)]
        for before, after in pairwise(modes):
            kinds["corner"] += before[2] != after[2]
            kinds["spring"] += before[0] != after[0]
        assert all(min(abs(t - one) for one in [*starts, case.span]) < 1e-8 for t in seen)
        assert all(min([abs(one - t) for t in [0.0, *seen]]) < 1e-8 for one in starts)
        for row in range(2, rows):
            if pieces.spans[row] < 1e-7:
                continue
            at = 0.0 if row == 2 else seen[row - 3]
            now = next(mode for mode, one in reversed(list(zip(modes, starts, strict=True))) if one < at + 1e-8)
            side, way, slope = now
            if body.friction > 0.0 and way == 0:
                expected = {1: 0, 0: STUCK_APART, -1: STUCK_BACK}[side]
            else:
                add = ON_STABLE if slope % 2.0 == 0.0 else ON_UNSTABLE
                expected = ({1: 1, 0: APART, -1: BACK}[side] + add) * way
            assert pieces.modes[row] == expected
    assert min(kinds.values()) >= 2


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", SCENES)
def test_a_motion_is_that_of_an_integrator(name: str) -> None:
    """To 1e-8: an event is found to 1e-12, and the shortest step beyond it has no larger error."""
    for seed in range(3):
        case = Case(name, seed)
        z = list(case.z)
        play_many(z, case.u, case.span, case.body, case.pad)
        assert case.near(z, Integrated(case.body).move(case.z, case.u, case.span))


@pytest.mark.parametrize("name", SCENES)
def test_one_mode_is_left_at_its_end_and_bounds_its_torque(name: str) -> None:
    """Where it ends, as what, and a bound from below on the torque of the mesh that is near it."""
    for seed in range(12):
        case = Case(name, seed + 100)
        body, gear = case.body, case.gear
        z, side = list(case.z), flank(case.z, case.body)
        _, way, slope = case.first
        t, ended, least = press(z, case.u, Mode(side, way, slope), case.span, False, body, case.pad)
        if not case.events:
            assert (t, ended) == (case.span, 0)
            assert case.near(z, case.end)
            if side:
                true = min(gear.least, pressing(case.z, 0, side, body))
                assert 0.75 * true <= least <= true * (1.0 + 1e-9)
            continue
        first = case.events[0]
        assert t == pytest.approx(first.time, abs=1e-9)
        assert case.near(z, first.state)
        if first.slope != slope:
            assert ended == (RISEN if first.slope > slope else FALLEN)
        else:
            assert ended == (SPRUNG if first.flank != side else TURNED)
        if ended == SPRUNG:
            assert least == -1.0 or side == 0


@pytest.mark.one_in(8)
@pytest.mark.parametrize("name", SCENES)
def test_columns_are_the_derivative_and_marks_what_decides(name: str) -> None:
    """Against differences of the motion itself, of states 1e-6 apart, where no neighbour goes another way."""
    compared = 0
    for seed in SEEDS:
        case = Case(name, seed)
        body, n = case.body, case.body.order
        width = n + 2
        cols = [0.0] * (width * (width + 2))
        for c in range(n + 1):
            for i in range(n):
                cols[c * width + i] = float(i == c)
        command = width * width
        cols[command + n] = 1.0  # the last column is that of the command itself
        marks = [inf] * 4
        z = list(case.z)
        play_columns(z, case.u, case.span, body, case.pad, Columns(cols, command, n + 1, width), marks)
        assert case.near(z, case.end)
        check_marks(case, marks)
        if min(marks[:2]) < 1e-4:
            continue
        for c in range(n + 1):
            ends, kinds = [], []
            for nudge in (1e-6, -1e-6):
                other, u = list(case.z), case.u
                if c < n:
                    other[c] += nudge
                else:
                    u += nudge
                _, events = Toothed(body).move(other, u, case.steps)
                kinds.append([(one.flank, one.way, one.slope) for one in events])
                play_many(other, u, case.span, body, case.pad)
                ends.append(np.array(other))
            if kinds[0] != kinds[1] or (c == 1 and case.z[1] == 0.0 and body.friction > 0.0):
                continue
            slope = (ends[0] - ends[1]) / 2e-6
            np.testing.assert_allclose(cols[c * width : c * width + n], slope, atol=2e-5 * (1.0 + np.abs(slope).max()))
            compared += 1
    assert compared >= 5


def check_marks(case: Case, marks: list[float]) -> None:
    """Distances from the friction level where that decides, a speed at the end, torque of the mesh, and corners."""
    body, gear = case.body, case.gear
    side, way, slope = case.first
    start, least = np.array([*case.z, 1.0, case.u]), gear.least
    known = Toothed(body)
    known.on(slope)
    room, at, levels = known.room(case.z[0]), side, []
    if case.z[1] == 0.0:
        levels.append(abs(known.pulls[side] @ start))
    parted = side == 0
    for one in case.events:
        if one.slope != known.slope:
            room = -1.0
        elif one.state[1] == 0.0 and (way != 0 or one.flank != at):
            levels.append(abs(known.pulls[one.flank] @ np.array([*one.state, 1.0, case.u])))
        known.on(one.slope)
        room = min(room, known.room(one.state[0]))
        parted = parted or one.flank != side
        way, at = one.way, one.flank
    assert marks[3] == pytest.approx(-1.0 if room < 0.0 else min(room, known.room(case.end[0])), rel=1e-7, abs=1e-8)
    if body.friction == 0.0:
        assert marks[:2] == [inf, inf]
    else:
        found = min((abs(level - body.friction) for level in levels), default=inf)
        assert marks[0] == pytest.approx(found, rel=1e-6, abs=1e-7)
        assert marks[1] == (pytest.approx(abs(case.end[1]), abs=CLOSE * case.size) if way != 0 else inf)
    if parted:
        assert marks[2] <= -1.0  # a step in which a corner ends the mode may be bounded from further below
    else:
        assert marks[2] <= least * (1.0 + 1e-9) + 1e-9
        assert marks[2] > 0.0 or least < 0.1 * abs(pressing(case.z, 0, side, body))
