"""Random starts of one cell, each simulated until it is on a cycle; cycles are found and named here, by their levels.

A trial is over when it stays with a known cycle for ever: at a sample its distance to a state of the cycle, in the
energy of the difference, is less than half of what any sample of the cycle is from an edge that matters. That distance
never grows while both read the same levels, and they do as long as it is less. A trial that has not come to that is
followed until its state repeats to 1e-12 of a count; the levels of that period are a new cycle.
"""

from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tests.crosscheck.every_start.plain_knob import PlainKnob

LOOK_EVERY = 8  # samples between two looks for a known cycle
SETTLED = 40.0  # time constants after which a trial near no known cycle is looked at closely
GIVE_UP = 2_000_000  # samples in which a settled motion must repeat


@dataclass(frozen=True)
class Cycle:
    """A cycle of a cell: the levels of one period, its states at samples, and how near a sample comes to an edge."""

    levels: tuple[int, ...]
    states: NDArray
    margin: float  # rad
    least: float  # rad
    largest: float  # rad

    @property
    def period(self) -> int:
        """Samples."""
        return len(self.levels)


@dataclass
class Found:
    """Cycles of a cell, and how many starts ended in each."""

    knob: PlainKnob
    cycles: list[Cycle] = field(default_factory=list)
    ends: list[int] = field(default_factory=list)
    samples: int = 0

    def follow(self, theta: NDArray, omega: NDArray) -> None:
        """Simulate one trial from each start [rad, rad/s] to its end."""
        run, at = _compiled(), 0
        while at < len(theta):
            ends = np.zeros(len(self.cycles), dtype=np.int64)
            at, samples, a, w = run(*self._numbers(), *self._near(), ends, theta, omega, at)
            self.ends = [one + int(more) for one, more in zip(self.ends, ends, strict=True)]
            self.samples += samples
            if at < len(theta):  # this one is near nothing known
                self.ends[self._learn(a, w)] += 1
                at += 1

    def _numbers(self) -> tuple[Any, ...]:
        knob = self.knob
        settled = int(SETTLED * slowest(knob) / knob.period) + 200
        return knob.hold, knob.quantum, knob.wall, knob.push, settled, LOOK_EVERY, knob.distance_scale()

    def _near(self) -> tuple[NDArray, ...]:
        """States of all cycles by angle, whose they are, and how near is near enough."""
        states = np.array([state for one in self.cycles for state in one.states]).reshape(-1, 2)
        whose = np.array([i for i, one in enumerate(self.cycles) for _ in one.states], dtype=np.int64)
        order = np.argsort(states[:, 0])
        near = np.array([0.5 * one.margin for one in self.cycles])
        return np.ascontiguousarray(states[order]), whose[order], near

    def _learn(self, theta: float, omega: float) -> int:
        """Number of the cycle that a settled motion has come to, which is new unless it was hard to come near."""
        knob = self.knob
        period, theta, omega = _compiled_repeat()(
            knob.hold, knob.quantum, knob.wall, knob.push, theta, omega, GIVE_UP, 1e-12 * knob.quantum
        )
        if not period:
            raise ArithmeticError(f"no period after {GIVE_UP} samples: {knob}, at {theta!r} rad, {omega!r} rad/s")
        levels = []
        for _ in range(period):
            levels.append(min(int(np.floor(theta / knob.quantum)), 0))
            theta, omega = knob.hold[:2] @ np.array([theta, omega, knob.torque(levels[-1])])
        cycle = cycle_of(knob, levels)
        known = [turned(one.levels) for one in self.cycles]
        if turned(cycle.levels) in known:
            return known.index(turned(cycle.levels))
        self.cycles.append(cycle)
        self.ends.append(0)
        return len(self.cycles) - 1


def cycle_of(knob: PlainKnob, levels: list[int]) -> Cycle:
    """The cycle that reads ``levels``, checked to do so.

    Raises:
        ArithmeticError: Its samples read other levels.
    """
    n = next(d for d in range(1, len(levels) + 1) if len(levels) % d == 0 and levels[:d] * (len(levels) // d) == levels)
    states = knob.cycle(levels[:n])
    read = [min(int(np.floor(angle / knob.quantum)), 0) for angle in states[:, 0]]
    if read != levels[:n]:
        raise ArithmeticError(f"levels that no motion reads: {knob}, {levels[:n]}")
    counts = states[:, 0] / knob.quantum
    margin = np.where(counts >= 0.0, counts, np.minimum(counts - np.floor(counts), np.floor(counts) + 1.0 - counts))
    return Cycle(tuple(read), states, float(margin.min()) * knob.quantum, *knob.extremes(states, read))


def turned(levels: tuple[int, ...]) -> tuple[int, ...]:
    """One period of levels, so that every turn of it is the same."""
    return min(levels[i:] + levels[:i] for i in range(len(levels)))


def slowest(knob: PlainKnob) -> float:
    """The slowest time constant of the free motion [s]."""
    return float(-1.0 / np.linalg.eigvals(knob.flow[:2, :2]).real.max())


@cache
def _compiled() -> Any:
    from numba import njit

    return njit(cache=False)(_follow_all)


@cache
def _compiled_repeat() -> Any:
    from numba import njit

    return njit(cache=False)(_repeat)


def _follow_all(hold, quantum, wall, push, settled, look_every, scale, states, whose, near, ends, theta, omega, first):
    """Follow starts from number ``first`` on; ``ends`` counts.

    Returns the number of the first start that ended in no known cycle (or how many starts there are), the samples that
    were simulated, and the state of that start, settled.
    """
    h00, h01, h02, h10, h11, h12 = hold[0, 0], hold[0, 1], hold[0, 2], hold[1, 0], hold[1, 1], hold[1, 2]
    step, inverse, widest, known, samples = wall * quantum, 1.0 / quantum, 0.0, len(whose), 0
    for one in near:
        widest = max(widest, one)
    for i in range(first, len(theta)):
        a, w, end = theta[i], omega[i], -1
        for n in range(settled):
            torque = -step * min(np.floor(a * inverse), 0.0) - push
            a, w = h00 * a + h01 * w + h02 * torque, h10 * a + h11 * w + h12 * torque
            if n % look_every == 0 and known > 0:
                low, high = 0, known  # the first state whose angle is not below a - widest
                while low < high:
                    middle = (low + high) // 2
                    if states[middle, 0] < a - widest:
                        low = middle + 1
                    else:
                        high = middle
                while low < known and states[low, 0] < a + widest:
                    da, dw, r = states[low, 0] - a, states[low, 1] - w, near[whose[low]]
                    if da * da + scale * dw * dw < r * r:
                        end = whose[low]
                        break
                    low += 1
                if end >= 0:
                    samples += n
                    break
        if end < 0:
            return i, samples + settled, a, w
        ends[end] += 1
    return len(theta), samples, 0.0, 0.0


def _repeat(hold, quantum, wall, push, a, w, most, near):
    """Samples after which the state repeats to ``near`` [rad, and per sample], and the state; 0 if it does not.

    Brent's search: the state is held against one that is moved on after 1, 2, 4, ... samples.
    """
    period = hold[0, 1]  # about T: a speed times it is an angle
    at_a, at_w, power, lap = a, w, 1, 0
    for _ in range(most):
        torque = -wall * quantum * min(np.floor(a / quantum), 0.0) - push
        a, w = (
            hold[0, 0] * a + hold[0, 1] * w + hold[0, 2] * torque,
            hold[1, 0] * a + hold[1, 1] * w + hold[1, 2] * torque,
        )
        lap += 1
        if abs(a - at_a) < near and abs(w - at_w) * period < near:
            return lap, a, w
        if lap == power:
            at_a, at_w, power, lap = a, w, 2 * power, 0
    return 0, a, w
