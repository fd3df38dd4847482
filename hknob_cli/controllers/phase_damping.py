"""Phase-estimation damping: torque against a velocity that is guessed from when the edge was crossed.

Dissertation, Section 11.3. On the way in the velocity is largest at the crossing; a cosine of the time since, with
the period of the last cycles, is applied against it over ``degrees`` of phase. ``both``: the way out resets the phase
as well, and the times inside and outside are estimated apart. ``kalman``: the times are estimated by a Kalman filter
of a constant with drift; otherwise the last is taken. The edge is where the wall's torque crosses its own running
mean, so that the knob may buzz on any count.
"""

from math import pi

import numpy as np

from hknob_cli.controllers.controller import Action, Plain, Reading
from hknob_cli.controllers.plant_batch import Array, PlantBatch
from hknob_cli.specs.controller import Controller

MEAN_SAMPLES = 64.0  # of the running mean
LONGEST = 4096.0  # samples of a cycle
UNSURE = 1.0 / 6.0  # variance of a time between two crossings that are seen at samples
DRIFT = 0.05  # variance by which a time changes from cycle to cycle

BEFORE, MEAN, SINCE, INSIDE, OUTSIDE, VAR_IN, VAR_OUT, WAY = range(8)


class PhaseDamping(Plain):
    """``torque``: height in steps of the wall; over ``degrees`` of phase after a crossing."""

    rows = 8
    counted: tuple[int, ...] = (BEFORE, SINCE, INSIDE, OUTSIDE, VAR_IN, VAR_OUT, WAY)

    def __init__(self, torque: float, degrees: float, *, both: bool, kalman: bool) -> None:
        self.torque = torque
        self.reach = degrees / 360.0
        self.both = both
        self.kalman = kalman
        self.provable = not kalman

    @classmethod
    def of(cls, plan: Controller) -> "PhaseDamping":
        """With the numbers of a spec."""
        return cls(plan.height, plan.degrees, both=plan.crossings == "both", kalman=plan.estimate == "kalman")

    def settling(self, lanes: PlantBatch) -> Array:
        """The running mean's."""
        return np.full(len(lanes.alpha), MEAN_SAMPLES)

    def recall(self, lanes: PlantBatch, count: Array) -> Array:
        """Nothing crossed yet."""
        del count
        memory = np.zeros((8, len(lanes.alpha)))
        memory[SINCE] = LONGEST
        memory[[VAR_IN, VAR_OUT]] = 1e3
        return memory

    def act(self, reading: Reading, memory: Array, fixed: tuple[Array, ...]) -> Action:
        """The wall, and a cosine of the guessed phase against the guessed velocity."""
        del fixed
        now = reading.depth
        m = memory.copy()
        mean = m[MEAN] + (now - m[MEAN]) / MEAN_SAMPLES
        since = np.minimum(m[SINCE] + 1.0, LONGEST)
        entered = (now > mean) & (m[BEFORE] <= m[MEAN])
        left = (now <= mean) & (m[BEFORE] > m[MEAN])
        if self.both:
            self._time(m, OUTSIDE, VAR_OUT, since, entered)
            self._time(m, INSIDE, VAR_IN, since, left)
            m[WAY] = np.where(entered, 1.0, np.where(left, -1.0, m[WAY]))
            since = np.where(entered | left, 0.0, since)
            half = np.where(m[WAY] > 0.0, m[INSIDE], m[OUTSIDE])
            known = (half > 0.0) & (m[WAY] != 0.0)
            turn = 0.5 * (since + 0.5) / np.where(known, half, 1.0)
            way = m[WAY]
        else:
            self._time(m, INSIDE, VAR_IN, since, entered)
            m[WAY] = np.where(entered, 1.0, m[WAY])
            since = np.where(entered, 0.0, since)
            known = (m[INSIDE] > 0.0) & (m[WAY] != 0.0)
            turn = (since + 0.5) / np.where(known, m[INSIDE], 1.0)
            way = np.ones_like(now)
        acts = known & (turn <= self.reach)
        torque = now + np.where(acts, self.torque * way * np.cos(2.0 * pi * turn), 0.0)
        guards = (now - mean, m[BEFORE] - m[MEAN])
        m[BEFORE], m[MEAN], m[SINCE] = now, mean, since
        return Action((torque,), m, guards)

    def _time(self, m: Array, row: int, variance: int, time: Array, when: np.ndarray) -> None:
        """Take a time between crossings into its estimate."""
        usable = when & (time < LONGEST)
        if not self.kalman:
            m[row] = np.where(usable, time, m[row])
            return
        spread = m[variance] + DRIFT
        gain = spread / (spread + UNSURE)
        m[row] = np.where(usable, m[row] + gain * (time - m[row]), m[row])
        m[variance] = np.where(usable, (1.0 - gain) * spread, m[variance])
