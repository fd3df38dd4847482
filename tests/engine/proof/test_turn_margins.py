"""A period run with its derivative, and the readings that differences keep: against motions run state by state."""

from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.general.controller import count_gap, edge_gap, read
from hknob_cli.engine.general.interval import advance
from hknob_cli.engine.general.period_map import turn, turn_lines, within
from hknob_cli.engine.general.search import make_space
from hknob_cli.scene.general_knob import GeneralKnob
from tests.engine.general.bodies import knob

FREE = {"inertia": 1.9e-6}
BARE: dict[str, Any] = {"encoder": "none", "counts": None, "knob": FREE}
LOOPS: dict[str, dict[str, Any]] = {
    "counts": {"knob": FREE},
    "friction": {},
    "counts, delay, damping": {
        "knob": FREE,
        "wall": {"stiffness": 0.27, "damping": 3e-5},
        "actuator": {"delay_samples": 2.4},
    },
    "lag": {"knob": FREE, "actuator": {"time_constant": 1e-3}},
    "no encoder": BARE,
    "no encoder, damping": {**BARE, "wall": {"stiffness": 0.27, "damping": 3e-5}},
    "no encoder, damping, delay": {
        **BARE,
        "wall": {"stiffness": 0.27, "damping": 3e-5},
        "actuator": {"delay_samples": 2.4},
    },
}
STILL = ["no encoder", "no encoder, damping", "no encoder, damping, delay"]


def begin(one: GeneralKnob, seed: int) -> tuple[list[float], list[float], float]:
    """State, delay line, and reading before, inside the wall."""
    numbers = np.random.default_rng(seed)
    n, delay = one.body.order, one.delay_line
    z = [float(numbers.uniform(-3.0, -1.0)), float(numbers.uniform(-0.3, 0.3)), *([0.1] * (n - 2))]
    ring = [float(x) for x in numbers.uniform(0.05, 0.15, delay)]
    return z, ring, read(z[0] - z[1], one.wall)


def prepared(one: GeneralKnob, z: list[float], ring: list[float]) -> Any:
    space = make_space(one.body.order, one.delay_line, lambda count: [7.0] * count)
    space.orbit[:] = z
    space.orbit_line[:] = ring
    return space


def test_a_line_is_turned_back_with_its_derivatives() -> None:
    """Oldest command first at where it began, in every column, and nothing else is moved."""
    numbers, n = np.random.default_rng(1), 2
    for delay in (1, 2, 3, 5):
        m = n + delay + 1
        for first in range(delay):
            for head in range(delay):
                line, cols = numbers.normal(size=delay), numbers.normal(size=(m + 2, m))
                turned, flat = line.tolist(), cols.ravel().tolist()
                turn_lines(turned, flat, [7.0] * m, m, delay, first, head)
                by = first - head
                assert turned == np.roll(line, by).tolist()
                after = cols.copy()
                after[:m, n : n + delay] = np.roll(cols[:m, n : n + delay], by, axis=1)
                assert flat == after.ravel().tolist()


@pytest.mark.parametrize("period", [1, 3, 10])
@pytest.mark.parametrize("name", LOOPS)
def test_a_turn_is_the_motion_sample_by_sample(name: str, period: int) -> None:
    one = knob(**LOOPS[name])
    n, delay = one.body.order, one.delay_line
    for seed in range(6):
        z, ring, before = begin(one, seed)
        for head in range(max(1, delay)):
            space = prepared(one, z, ring)
            m = space.width if one.wall.analog else n
            line = list(ring)
            margin, edge, reach, pace, last, at = turn(before, line, head, period, one.body, one.wall, space, m)
            assert (space.orbit, space.orbit_line, line) == (z, ring, ring)
            state, seen, under_way, place = list(z), before, list(ring), head
            gaps, edges, places, speeds = [], [], [], []
            for _ in range(period):
                x = state[0]
                gaps.append(edge_gap(x, read(x, one.wall), seen, one.wall))
                edges.append(count_gap(x, one.wall))
                places.append(abs(x))
                speeds.append(abs(state[1]))
                seen, place = advance(state, seen, under_way, place, one.body, one.wall, [0.0] * (2 * n))
                speeds.append(abs(state[0] - x))
            sizes = [min(gaps), min(edges), max(places), max(speeds)]
            assert [margin, edge, reach, pace] == pytest.approx(sizes, rel=1e-12, abs=1e-14)
            assert (last, at) == (pytest.approx(seen, rel=1e-13), place)
            assert space.state == pytest.approx(state, rel=1e-13)
            if not one.wall.analog:
                assert space.line == under_way
            elif delay:
                line = [under_way[(place + j - head) % delay] for j in range(delay)]
                assert space.line == pytest.approx(line, rel=1e-13)
            assert space.marks[1] <= abs(state[1]) * (1.0 + 1e-12)


def outcome(one: GeneralKnob, values: list[float], head: int, period: int) -> np.ndarray:
    n, delay = one.body.order, one.delay_line
    z, ring, before = values[:n], values[n : n + delay], values[-1]
    begun = head
    for _ in range(period):
        before, head = advance(z, before, ring, head, one.body, one.wall, [0.0] * (2 * n))
    line = [ring[(head + j - begun) % delay] for j in range(delay)]
    return np.array([*z, *line, before])


@pytest.mark.parametrize("name", LOOPS)
def test_the_columns_are_differences_of_motions(name: str) -> None:
    """Between events the motion is affine: differences of any size are exact to rounding."""
    if name == "friction":
        pytest.skip("not affine; tests/engine/general/test_columns.py")
    one, h = knob(**LOOPS[name]), 1e-5
    n, delay = one.body.order, one.delay_line
    for period in (1, 3, 5):
        z, ring, before = begin(one, period)
        for head in range(max(1, delay)):
            space = prepared(one, z, ring)
            width = space.width
            m = width if one.wall.analog else n
            turn(before, list(ring), head, period, one.body, one.wall, space, m)
            values = [*z, *ring, before]
            for c in range(m):
                moved = list(values)
                moved[c] += h
                slope = (outcome(one, moved, head, period) - outcome(one, values, head, period)) / h
                np.testing.assert_allclose(space.cols[c * width : c * width + m], slope[:m], atol=1e-9)


@pytest.mark.parametrize("rate_hz", [1000.0, 250.0])
@pytest.mark.parametrize("name", STILL)
def test_differences_keep_every_reading_up_to_the_nearest_edge(name: str, rate_hz: float) -> None:
    """At each sample what all entries may add up to, and its own and the last reading, are below the gap."""
    one = knob(**{"rate_hz": rate_hz, **LOOPS[name]})
    n, delay, period = one.body.order, one.delay_line, 6
    tight = set()
    for seed in range(8):
        z, ring, before = begin(one, seed)
        z[0] -= 3.0
        values, head = [*z, *ring, before], seed % max(1, delay)
        width = len(values)
        numbers = np.random.default_rng(100 + seed)
        away = np.abs(numbers.normal(size=width)) * ([1.0] * n + [0.1] * delay + [1.0 if seed % 2 else 50.0])
        error = np.abs(numbers.normal(size=width))
        reaches, errors, gaps = [away[-1]], [], []
        for k in range(period):
            state = outcome(one, list(values), head, k) if k else np.array(values)
            columns = []
            for c in range(width):
                moved = list(values)
                moved[c] += 1e-5
                columns.append(((outcome(one, moved, head, k)[0] if k else moved[0]) - state[0]) / 1e-5)
            reaches.append(float(np.abs(columns) @ away))
            errors.append(float(np.abs(columns) @ error))
            x = float(state[0])
            gaps.append(edge_gap(x, read(x, one.wall), float(state[-1]), one.wall))
        parts = [max(reaches[k + 1], reaches[k]) / gaps[k] for k in range(period)]
        tight.add(int(np.argmax(parts)))
        for part, kept in ((0.999, True), (1.001, False)):
            space = prepared(one, z, ring)
            space.away[:] = (away * part / max(parts)).tolist()
            space.power[:width] = error.tolist()
            found, bound = within(before, list(ring), head, period, one.body, one.wall, space, width)
            assert found is kept
            assert (space.orbit, space.orbit_line) == (z, ring)
            if kept:
                assert bound == pytest.approx(max(errors), rel=1e-6)
                assert space.away == (away * part / max(parts)).tolist()
            else:
                first = next(k for k in range(period) if parts[k] * part / max(parts) >= 1.0)
                assert bound == pytest.approx(max(errors[: first + 1]), rel=1e-6)
    assert len(tight) > 1


def test_a_difference_as_large_as_the_gap_is_too_large() -> None:
    one = knob(**LOOPS["no encoder"])
    z, ring = [-2.0, 0.0], list[float]()
    gap = edge_gap(-2.0, -2.0, -2.0, one.wall)
    assert gap == 2.0
    for away, kept in (
        ((2.0, 0.0, 0.0), False),
        ((1.999, 0.0, 0.0), True),
        ((0.0, 0.0, 2.0), False),
        ((0.0, 0.0, 1.999), True),
    ):
        space = prepared(one, z, ring)
        space.away[:] = list(away)
        assert within(-2.0, ring, 0, 1, one.body, one.wall, space, 3)[0] is kept
