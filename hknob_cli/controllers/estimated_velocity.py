"""Virtual damping beside the wall on a speed that is estimated from counts as firmware does it, and a filtered angle.

Timed: counts over the time between changes of the count, "fixed position", which a Hall sensor of SimpleFOC has
(HallSensor.cpp); the counts of a sample over the time from the last change before it to the last in it, as its
Encoder.cpp. Adaptive: the longest line that is within a count of all readings that it passes and ends in the newest
(Janabi-Sharifi, Hayward & Chen 2000, end-fit-FOAW). Tracking: a second-order filter, critically damped, that predicts
the angle by its speed and corrects both, as moteus (aux_port and motor_position.h) has it; an ODrive compares with its
own angle in whole counts, which is not linear. Kalman: the same filter with the gains of a stationary Kalman filter,
as Belanger (1992) proposed for shaft encoders; in closed form by Kalata (1984). The laws are in
`engine.general.laws.speeds`.
"""

from math import exp, expm1, inf, log, sqrt
from typing import NamedTuple

import numpy as np

from hknob_cli.controllers.controller import Plain
from hknob_cli.controllers.fading_pair import make_pair
from hknob_cli.controllers.plant_batch import Array, PlantBatch
from hknob_cli.specs.controller import Controller

LONGEST = 1.0 - 2.0**-50  # part of a mean that stays in a sample: beyond it a double knows none that goes
LEAST = 2.0**-100  # of what fades: a weight of 0 would mean that its guards cannot matter at rest
# Functions of `engine.general.laws.speeds`.
LAWS = {
    "timed": "timed_velocity",
    "adaptive": "adaptive_velocity",
    "tracking": "tracked_velocity",
    "kalman": "tracked_velocity",
}


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


class Fading(NamedTuple):
    """What fades: its first row, the factor in a sample, steps of the wall by it, guards on it, and numbers of two."""

    row: int = -1
    fade: float = 0.0
    weight: float = 0.0
    guarded: bool = False
    pair: tuple[float, ...] = ()


class EstimatedVelocity(Plain):
    """The controller ``plan``, of kind velocity_damping, as the compiled general loop alone has it."""

    reads_outside = True

    def __init__(self, plan: Controller) -> None:
        self.plan = plan
        self.law = LAWS.get(plan.velocity, "differenced_velocity")
        timed = plan.velocity == "timed"
        self.looks = tuple(k / plan.detections for k in range(1, plan.detections)) if timed else ()
        self.filtered = plan.angle == "filtered"
        self.counted_rows = 0 if self.tracks else 2 if timed else plan.window - 1
        self.rows = self.counted_rows + (2 if self.tracks else (plan.low_pass > 0.0) * (1 + self.filtered))

    @property
    def tracks(self) -> bool:
        """Whether the estimate is a tracking filter's, Kalman's or another."""
        return self.law == "tracked_velocity"

    def settling(self, lanes: PlantBatch) -> Array:
        """Time constant of the filter."""
        fade = self.fading(lanes).fade
        return np.full(len(lanes.alpha), -1.0 / log(fade) if 0.0 < fade < 1.0 else 0.0)

    def numbers(self, lanes: PlantBatch) -> list[float]:
        """The law's numbers, of the first lane."""
        plan, period = self.plan, float(lanes.period_s[0])
        goes = -expm1(-period / plan.low_pass) if plan.low_pass > 0.0 else 0.0
        most = inf if plan.cut_off is None else plan.cut_off * period / float(lanes.quantum_rad[0])
        shared = [float(lanes.offset[0]), self._gain(lanes), float(plan.everywhere), goes, most, float(self.filtered)]
        turn = plan.bandwidth * period
        gains = (2.0 * turn, turn * turn)
        if plan.velocity == "kalman":
            gains = kalman_gains(plan.acceleration, period, float(lanes.quantum_rad[0]))
        still = float(plan.detections * max(1, round(plan.time_out / period)))
        own = {
            "timed_velocity": [float(plan.detections), still],
            "tracked_velocity": [*gains],
        }.get(self.law, [float(plan.window)])
        return [*shared, float(self.rows), *own]

    def fading(self, lanes: PlantBatch) -> Fading:
        """What of the memory fades; ``fade`` is not below 1 where no norm is known in which it does."""
        plan, gain = self.plan, abs(self._gain(lanes))
        if not self.tracks and plan.low_pass == 0.0:
            return Fading()
        weight = gain + self.filtered
        switch = self.filtered and plan.damping != 0.0 and not plan.everywhere
        guarded = plan.cut_off is not None or switch
        if guarded:
            weight = max(weight, LEAST)
        if self.tracks:
            one, two = self.numbers(lanes)[-2:]
            pair = make_pair(np.array([[1.0 - one, 1.0 - one], [-two, 1.0 - two]]), (0, 1) if self.filtered else (1,))
            return Fading(0, pair.fade, weight, guarded, pair.numbers)
        stays = min(exp(-float(lanes.period_s[0]) / plan.low_pass), LONGEST)
        if not self.filtered:
            return Fading(self.counted_rows, stays, weight, guarded)
        pair = make_pair(np.diag([stays, stays]), (0, 1))
        return Fading(self.counted_rows, pair.fade, weight, guarded, pair.numbers)

    def _gain(self, lanes: PlantBatch) -> float:
        """Steps of the wall per count a sample."""
        return -self.plan.damping / float(lanes.stiffness[0] * lanes.period_s[0])
