"""Virtual damping beside the wall on a speed that is estimated from counts as firmware does it, and a filtered angle.

Timed: counts over the time between changes of the count, "fixed position", which a Hall sensor of SimpleFOC has
(HallSensor.cpp); the counts of a sample over the time from the last change before it to the last in it, as its
Encoder.cpp. Adaptive: the longest line that is within a count of all readings that it passes and ends in the newest
(Janabi-Sharifi, Hayward & Chen 2000, end-fit-FOAW). Tracking: a second-order filter, critically damped, that predicts
the angle by its speed and corrects both, as moteus (aux_port and motor_position.h) has it; an ODrive compares with its
own angle in whole counts, which is not linear. Kalman: the same filter with the gains of a stationary Kalman filter,
as Belanger (1992) proposed for shaft encoders; in closed form by Kalata (1984).

The laws' memory is in counts and samples, and begins with zeros: the knob has stood where it is. Fixed numbers of all:
offset, gain of the damper in steps of the wall per count a sample, outside the wall too (2: there is no wall), the
low-pass's part of the way or 0, the pace above which there is no torque, the spring at the filtered angle, where the
last reading is in ``past``, and from `OWN` on those of the estimate. Above that pace what is returned is negative.

Two numbers of a memory fade together: there is a norm in which they shrink by one factor a sample. It is found in
floats, from eigenvectors. Those of a filter that is far slower than the clock are nearly one, and what is found may be
wrong by more than its factor is below 1. So what a proof needs of it is checked in fractions.
"""

from fractions import Fraction
from math import exp, expm1, inf, log, sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hknob_cli.controllers.controller import LEAST, LONGEST, ControlLaw, Fading, Plant, reach_of
from hknob_cli.engine.general.laws.step import depth_of
from hknob_cli.specs.controller import Controller

ROUNDING = 1.0 + 2.0**-40  # of the norm of a matrix of two rows, far beyond its condition times the rounding of one


class FadingPair(NamedTuple):
    """``numbers`` as `Law.pair` has them; ``fade``: by which the norm of a difference shrinks in a sample, if < 1.

    The norm is never less than the difference in a row that was asked for. Where that is not so, ``fade`` is infinite.
    """

    numbers: tuple[float, ...]
    fade: float


def make_pair(a: NDArray[np.float64], rows: tuple[int, ...]) -> FadingPair:
    """A norm for the map ``a``, (2, 2), of a difference in a sample; ``rows``: those that the norm must be above.

    In the coordinates of its eigenvectors, of a complex one its two parts, a map is its eigenvalues, or a turn and a
    factor: its Euclidean norm there is the largest of them.
    """
    values, vectors = np.linalg.eig(a)
    turns = bool(abs(values[0].imag) > 0.0)
    basis = np.column_stack([vectors[:, 0].real, vectors[:, 0].imag]) if turns else vectors.real
    forms = np.linalg.inv(basis)
    fade = float(np.linalg.norm(forms @ a @ basis, 2)) * ROUNDING
    forms = forms * max(float(np.linalg.norm(basis[row])) for row in rows) * ROUNDING
    across = float(np.linalg.norm(forms, 2)) * ROUNDING
    if not is_proven(a.tolist(), forms.tolist(), fade, rows):
        fade = inf
    return FadingPair((*map(float, a.ravel()), *map(float, forms.ravel()), across), fade)


def is_proven(a: list[list[float]], forms: list[list[float]], fade: float, rows: tuple[int, ...]) -> bool:
    """Whether |F A d| <= fade |F d| and |d[row]| <= |F d| for all d, with the rows F of ``forms``; by fractions."""
    f, g = _exact(forms), _times(_exact(forms), _exact(a))
    size, after, factor = _squares(f), _squares(g), Fraction(fade) ** 2
    falls = [factor * one - other for one, other in zip(size, after, strict=True)]
    above = [[one - (k == 2 * row) for k, one in enumerate(size)] for row in rows]
    return all(p >= 0 and r >= 0 and p * r >= q * q for p, q, r in (falls, *above))


def _exact(matrix: list[list[float]]) -> list[list[Fraction]]:
    return [[Fraction(entry) for entry in row] for row in matrix]


def _times(a: list[list[Fraction]], b: list[list[Fraction]]) -> list[list[Fraction]]:
    return [[row[0] * b[0][j] + row[1] * b[1][j] for j in range(2)] for row in a]


def _squares(f: list[list[Fraction]]) -> list[Fraction]:
    """The quadratic form |F d|^2: its entries for d0^2, half of d0 d1, and d1^2."""
    return [f[0][i] * f[0][j] + f[1][i] * f[1][j] for i, j in ((0, 0), (0, 1), (1, 1))]


OFFSET, GAIN, EVERYWHERE, GOES, MOST, FILTERED, LAST, OWN, NEXT = range(9)  # of the fixed numbers


def spring_and_damper(shown: float, pace: float, behind: float, room: float, fixed: Any, out: Any) -> float:
    """Set the torque for a pace; ``behind``: filtered angle less the count's; ``room``: to the nearest guard so far."""
    deep, inside = 0.0 if fixed[EVERYWHERE] > 1.0 else depth_of(shown, fixed[OFFSET]), shown < 0.0
    if fixed[FILTERED] > 0.0:
        at = shown + fixed[OFFSET] + behind
        deep, inside = max(-at, 0.0), at < 0.0
        if fixed[GAIN] != 0.0 and fixed[EVERYWHERE] == 0.0:
            room = min(room, abs(at))
    if fixed[EVERYWHERE] > 0.0 or inside:
        deep = deep + fixed[GAIN] * pace
    if abs(pace) > fixed[MOST]:
        out[0] = 0.0
        return -room
    out[0] = deep
    return room


def filter_and_act(shown: float, pace: float, moved: float, past: Any, row: int, fixed: Any, out: Any) -> float:
    """Pass a pace, and the angle if the spring acts on it, through the low-pass, whose memory begins at ``row``."""
    if fixed[GOES] == 0.0:
        return spring_and_damper(shown, pace, 0.0, inf, fixed, out)
    pace = past[row] + fixed[GOES] * (pace - past[row])
    past[row] = pace
    behind = 0.0
    if fixed[FILTERED] > 0.0:
        behind = (1.0 - fixed[GOES]) * (past[row + 1] - moved)
        past[row + 1] = behind
    return spring_and_damper(shown, pace, behind, abs(fixed[MOST] - abs(pace)), fixed, out)


def differenced_velocity(shown: float, speed: float, past: Any, fixed: Any, out: Any) -> float:
    """Counts moved over a window. Memory: counts moved in the last samples, the newest first; then the low-pass's.

    Own: samples of the window.
    """
    moved = shown - past[int(fixed[LAST])]
    window = int(fixed[OWN])
    total = moved
    for j in range(window - 2, -1, -1):
        total += past[j]
        past[j] = past[j - 1] if j > 0 else moved
    return filter_and_act(shown, total / window, moved, past, window - 1, fixed, out)


def timed_velocity(shown: float, speed: float, past: Any, fixed: Any, out: Any) -> float:
    """Counts over the time between changes. Memory: time since the last change, pace; then the low-pass's.

    Own: encoder readings an interval, and the time after which nothing moves, in these.
    """
    last = int(fixed[LAST])
    ticks = int(fixed[OWN])
    before, time, changed = past[last], past[0], 0.0
    moved = shown - before
    for i in range(ticks):
        now = past[last + 1 + i] if i < ticks - 1 else shown
        time = min(time + 1.0, fixed[NEXT])
        if now != before:
            changed += time
            time = 0.0
        before = now
    if changed > 0.0:
        past[1] = moved * ticks / min(changed, fixed[NEXT])
    past[0] = time
    if time > 0.0:  # a count more would have been seen
        past[1] = min(max(past[1], -ticks / time), ticks / time)
    if time >= fixed[NEXT]:
        past[1] = 0.0
    return filter_and_act(shown, past[1], moved, past, 2, fixed, out)


def adaptive_velocity(shown: float, speed: float, past: Any, fixed: Any, out: Any) -> float:
    """Slope of the longest line, to the newest reading, that is within a count of all readings that it passes.

    Memory: counts moved in the last samples, the newest first; then the low-pass's. Own: samples of the longest line.
    """
    moved = shown - past[int(fixed[LAST])]
    longest = int(fixed[OWN])
    total = pace = moved
    # Slopes that pass within a count of the readings so far: bounds as fractions of whole numbers, which are exact.
    low, low_over, high, high_over = -1.0, 0.0, 1.0, 0.0
    for n in range(2, longest + 1):
        if (total - 1.0) * low_over > low * (n - 1):
            low, low_over = total - 1.0, n - 1.0
        if (total + 1.0) * high_over < high * (n - 1):
            high, high_over = total + 1.0, n - 1.0
        total += past[n - 2]
        if total * low_over < low * n or total * high_over > high * n:
            break
        pace = total / n
    for j in range(longest - 2, -1, -1):
        past[j] = past[j - 1] if j > 0 else moved
    return filter_and_act(shown, pace, moved, past, longest - 1, fixed, out)


def tracked_velocity(shown: float, speed: float, past: Any, fixed: Any, out: Any) -> float:
    """Pace of an angle that follows the count. Memory: that angle less the count, its pace. Own: gains on both."""
    ahead = past[0] + past[1] - (shown - past[int(fixed[LAST])])
    past[0] = (1.0 - fixed[OWN]) * ahead
    past[1] = past[1] - fixed[NEXT] * ahead
    return spring_and_damper(shown, past[1], past[0], abs(fixed[MOST] - abs(past[1])), fixed, out)


def kalman_gains(acceleration: float, period_s: float, quantum_rad: float) -> tuple[float, float]:
    """Gains on angle and pace of the stationary Kalman filter of an angle with a random acceleration.

    The acceleration (rad/s^2, root mean square) is constant in a sample and drawn anew for each; the reading's error is
    that of a uniform rounding, a count over sqrt(12). P. R. Kalata, "The tracking index", IEEE Trans. Aerospace and
    Electronic Systems 20 (1984) 174-182: alpha = d (2 - d), beta = 2 d^2, d = (sqrt(8 g + g^2) - g)/4 with the index
    g = acceleration * period^2 / error.
    """
    index = acceleration * period_s * period_s * sqrt(12.0) / quantum_rad
    way = 2.0 * index / (sqrt(index * (8.0 + index)) + index)
    return way * (2.0 - way), 2.0 * way * way


LAWS = {
    "timed": timed_velocity,
    "adaptive": adaptive_velocity,
    "tracking": tracked_velocity,
    "kalman": tracked_velocity,
}


class EstimatedVelocity(ControlLaw):
    """The controller ``plan``, of kind velocity_damping, on an estimated speed."""

    reads_outside = True

    def __init__(self, plan: Controller) -> None:
        self.plan = plan
        self.act = LAWS.get(plan.velocity, differenced_velocity)
        timed = plan.velocity == "timed"
        self.looks = tuple(k / plan.detections for k in range(1, plan.detections)) if timed else ()
        self.filtered = plan.angle == "filtered"
        self.cuts = plan.cut_off is not None
        self.counted_rows = 0 if self.tracks else 2 if timed else plan.window - 1
        self.rows = self.counted_rows + (2 if self.tracks else (plan.low_pass > 0.0) * (1 + self.filtered))

    @property
    def tracks(self) -> bool:
        """Whether the estimate is a tracking filter's, Kalman's or another."""
        return bool(self.act is tracked_velocity)

    def settling(self, plant: Plant) -> float:
        """Time constant of the filter."""
        fade = self.fading(plant).fade
        return -1.0 / log(fade) if 0.0 < fade < 1.0 else 0.0

    def coarseness(self, plant: Plant) -> float:
        """The gain; a filter adds up what its updates round."""
        fading = self.fading(plant)
        return 1.0 + abs(self._gain(plant)) * (1.0 / (1.0 - fading.fade) if fading.row >= 0 else 1.0)

    def numbers(self, plant: Plant) -> list[float]:
        """The law's numbers."""
        plan, period = self.plan, plant.period_s
        goes = -expm1(-period / plan.low_pass) if plan.low_pass > 0.0 else 0.0
        most = inf if plan.cut_off is None else plan.cut_off * period / plant.quantum_rad
        acts = reach_of(plant, everywhere=plan.everywhere)
        shared = [plant.offset, self._gain(plant), acts, goes, most, float(self.filtered)]
        turn = plan.bandwidth * period
        gains = (2.0 * turn, turn * turn)
        if plan.velocity == "kalman":
            gains = kalman_gains(plan.acceleration, period, plant.quantum_rad)
        still = float(plan.detections * max(1, round(plan.time_out / period)))
        own = [float(plan.window)]
        if self.tracks:
            own = [*gains]
        elif plan.velocity == "timed":
            own = [float(plan.detections), still]
        return [*shared, float(self.rows), *own]

    def fading(self, plant: Plant) -> Fading:
        """What of the memory fades; ``fade`` is not below 1 where no norm is known in which it does."""
        plan, gain = self.plan, abs(self._gain(plant))
        if not self.tracks and plan.low_pass == 0.0:
            return Fading()
        weight = gain + self.filtered
        switch = self.filtered and plan.damping != 0.0 and not plan.everywhere
        guarded = plan.cut_off is not None or switch
        if guarded:
            weight = max(weight, LEAST)
        if self.tracks:
            one, two = self.numbers(plant)[-2:]
            pair = make_pair(np.array([[1.0 - one, 1.0 - one], [-two, 1.0 - two]]), (0, 1) if self.filtered else (1,))
            return Fading(0, pair.fade, weight, guarded, pair.numbers)
        stays = min(exp(-plant.period_s / plan.low_pass), LONGEST)
        if not self.filtered:
            return Fading(self.counted_rows, stays, weight, guarded)
        pair = make_pair(np.diag([stays, stays]), (0, 1))
        return Fading(self.counted_rows, pair.fade, weight, guarded, pair.numbers)

    def _gain(self, plant: Plant) -> float:
        """Steps of the wall per count a sample."""
        return -self.plan.damping / (plant.stiffness * plant.period_s)
