"""Phase-estimation damping: torque against a velocity that is guessed from when the edge was crossed.

Dissertation, Section 11.3. On the way in the velocity is largest at the crossing; a cosine of the time since, with
the period of the last cycles, is applied against it over ``degrees`` of phase. ``both``: the way out resets the phase
as well, and the times inside and outside are estimated apart. ``kalman``: the times are estimated by a Kalman filter
of a constant with drift; otherwise the last is taken. The edge is where the wall's torque crosses its own running
mean, so that the knob may buzz on any count.
"""

from math import cos, pi
from typing import Any

from hknob_cli.controllers.controller import ControlLaw, Fading, Plant
from hknob_cli.engine.general.laws.step import depth_of
from hknob_cli.specs.controller import Controller

MEAN_SAMPLES = 64.0  # of the running mean
LONGEST = 4096.0  # samples of a cycle that is timed
UNSURE = 1.0 / 6.0  # variance of a time between two crossings that are seen at samples
DRIFT = 0.05  # variance by which a time changes from cycle to cycle
KALMAN = 4.0  # units in the last place of an estimate, at most, by the roundings of its updates, times a turn
MEAN, SINCE, VAR_IN, VAR_OUT = 1, 2, 5, 6  # rows of its memory


def take_time(past: Any, row: int, variance: int, time: float, kalman: float) -> None:
    """Take a time between crossings into its estimate."""
    if not time < LONGEST:
        return
    if kalman == 0.0:
        past[row] = time
        return
    spread = past[variance] + DRIFT
    gain = spread / (spread + UNSURE)
    past[row] = past[row] + gain * (time - past[row])
    past[variance] = (1.0 - gain) * spread


def phase_damping(shown: float, speed: float, past: Any, fixed: Any, out: Any) -> float:
    """Memory: torque, its mean, samples since a crossing, estimates inside and outside, their variances, the way.

    Fixed: offset, height, part of a turn, both crossings, Kalman filter.
    """
    before: float = past[0]
    last_mean: float = past[1]
    now: float = depth_of(shown, fixed[0])
    mean = last_mean + (now - last_mean) / MEAN_SAMPLES
    since = min(past[2] + 1.0, LONGEST)
    entered = now > mean and before <= last_mean
    left = now <= mean and before > last_mean
    way = 1.0
    if fixed[3] > 0.0:
        if entered:
            take_time(past, 4, 6, since, fixed[4])
            past[7] = 1.0
        if left:
            take_time(past, 3, 5, since, fixed[4])
            past[7] = -1.0
        if entered or left:
            since = 0.0
        way = past[7]
        half = past[3] if way > 0.0 else past[4]
        known = half > 0.0 and way != 0.0
        turn = 0.5 * (since + 0.5) / half if known else 0.0
    else:
        if entered:
            take_time(past, 3, 5, since, fixed[4])
            past[7] = 1.0
            since = 0.0
        known = past[3] > 0.0 and past[7] != 0.0
        turn = (since + 0.5) / past[3] if known else 0.0
    torque = now
    if known and turn <= fixed[2]:
        torque = now + fixed[1] * way * cos(2.0 * pi * turn)
    past[0], past[1], past[2] = now, mean, since
    out[0] = torque
    return min(abs(now - mean), abs(before - last_mean))


class PhaseDamping(ControlLaw):
    """``torque``: height in steps of the wall; over ``degrees`` of phase after a crossing."""

    act = staticmethod(phase_damping)
    rows = 8

    def __init__(self, torque: float, degrees: float, *, both: bool, kalman: bool) -> None:
        self.torque = torque
        self.reach = degrees / 360.0
        self.both = both
        self.kalman = kalman

    @classmethod
    def of(cls, plan: Controller) -> "PhaseDamping":
        """With the numbers of a spec."""
        return cls(plan.height, plan.degrees, both=plan.crossings == "both", kalman=plan.estimate == "kalman")

    def numbers(self, plant: Plant) -> list[float]:
        """Where counts lie, height, part of a turn, both crossings, Kalman filter."""
        return [plant.offset, self.torque, self.reach, float(self.both), float(self.kalman)]

    def first(self) -> list[float]:
        """Nothing crossed yet."""
        memory = [0.0] * self.rows
        memory[SINCE] = LONGEST
        memory[VAR_IN] = memory[VAR_OUT] = 1e3
        return memory

    def settling(self, plant: Plant) -> float:
        """The running mean's."""
        del plant
        return MEAN_SAMPLES

    def fading(self, plant: Plant) -> Fading:
        """The running mean."""
        del plant
        return Fading(MEAN, (MEAN_SAMPLES - 1.0) / MEAN_SAMPLES, 0.0, guarded=True)

    def coarseness(self, plant: Plant) -> float:
        """A phase is as wrong as an estimate."""
        del plant
        return 1.0 + KALMAN * self.torque if self.kalman else 1.0
