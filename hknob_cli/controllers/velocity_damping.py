"""Virtual damping beside the wall, against the velocity: differenced from the counts, or from a sensor.

Dissertation, Sections 10.2 and 11: a velocity sensor makes virtual damping meaningful where counts are too coarse to
difference. Below 0 the damping drives: to take back physical damping outside the wall (Colgate & Schenkel 1994).
Firmware differences over several samples, or filters: y += a (x - y), a = 1 - exp(-T / time constant), as a Hapkit does
(main1DOF.cpp of Longhorn Hapkit). A SmartKnob commands no torque above a speed (its motor_task.cpp). Other estimates
are in `estimated_velocity`.
"""

from math import inf
from typing import Any

import numpy as np

from hknob_cli.controllers.controller import LEAST, LONGEST, ControlLaw, Fading, Plant, reach_of
from hknob_cli.controllers.estimated_velocity import EstimatedVelocity
from hknob_cli.engine.general.laws.step import depth_of
from hknob_cli.specs.controller import Controller


def velocity_damping(shown: float, speed: float, past: Any, fixed: Any, out: Any) -> float:
    """Memory: the last places, the newest first, and the filtered pace if there is a filter.

    Fixed: offset, steps of the wall per count a sample, a sensor, outside the wall too (2: there is no wall), samples
    of the window, the filter's part of the way or 0, the pace above which there is no torque. Above that what is
    returned is negative.
    """
    at = shown + fixed[0]
    window = int(fixed[4])
    pace = speed if fixed[2] > 0.0 else (at - past[window - 1]) / window
    for j in range(window - 1, 0, -1):
        past[j] = past[j - 1]
    past[0] = at
    room = inf
    if fixed[5] > 0.0:
        pace = past[window] + fixed[5] * (pace - past[window])
        past[window] = pace
    if fixed[5] > 0.0 or fixed[2] > 0.0:
        room = abs(fixed[6] - abs(pace))
    out[0], out[1] = 0.0 if fixed[3] > 1.0 else depth_of(shown, fixed[0]), 0.0
    if fixed[3] > 0.0 or shown < 0.0:
        out[0], out[1] = out[0] + fixed[1] * pace, fixed[1]
    if abs(pace) > fixed[6]:
        out[0], out[1] = 0.0, 0.0
        return -room
    return room


class VelocityDamping(ControlLaw):
    """``damping`` in N·m·s/rad; ``sensor``: the velocity is sensed; ``everywhere``: outside the wall, too.

    ``window`` in samples, ``low_pass`` in s, 0 for none, ``cut_off`` in rad/s, infinite for none.
    """

    act = staticmethod(velocity_damping)
    reads_outside = True

    def __init__(
        self,
        damping: float,
        *,
        sensor: bool,
        everywhere: bool,
        window: int = 1,
        low_pass: float = 0.0,
        cut_off: float | None = None,
    ) -> None:
        self.damping = damping
        self.senses_speed = sensor
        self.everywhere = everywhere
        self.low_pass = low_pass
        self.cut_off = np.inf if cut_off is None else cut_off
        self.cuts = cut_off is not None
        self.places = window
        self.rows = window + (low_pass > 0.0)

    @classmethod
    def of(cls, plan: Controller) -> "VelocityDamping | EstimatedVelocity":
        """With the numbers of a spec."""
        if plan.estimates:
            return EstimatedVelocity(plan)
        return cls(
            plan.damping,
            sensor=plan.velocity == "sensor",
            everywhere=plan.everywhere,
            window=plan.window,
            low_pass=plan.low_pass,
            cut_off=plan.cut_off,
        )

    def _gain(self, plant: Plant) -> float:
        """Steps of the wall per count a sample."""
        return -self.damping / (plant.stiffness * plant.period_s)

    def numbers(self, plant: Plant) -> list[float]:
        """Where counts lie, gain, sensor, everywhere, window, the low-pass's part of the way, and the cut-off."""
        goes = float(-np.expm1(-plant.period_s / self.low_pass)) if self.low_pass > 0.0 else 0.0
        most = self.cut_off * plant.period_s / plant.quantum_rad
        acts = reach_of(plant, everywhere=self.everywhere)
        shared = [plant.offset, self._gain(plant), float(self.senses_speed), acts]
        return [*shared, float(self.places), goes, most]

    def settling(self, plant: Plant) -> float:
        """The low-pass's time constant."""
        return self.low_pass / plant.period_s

    def fading(self, plant: Plant) -> Fading:
        """The filtered speed."""
        if self.low_pass == 0.0:
            return Fading()
        stays, gain = min(float(np.exp(-plant.period_s / self.low_pass)), LONGEST), abs(self._gain(plant))
        if self.cut_off == np.inf:
            return Fading(self.places, stays, gain)
        return Fading(self.places, stays, max(gain, LEAST), guarded=True)

    def coarseness(self, plant: Plant) -> float:
        """The gain; a filter adds up what its updates round."""
        fading = self.fading(plant)
        return 1.0 + abs(self._gain(plant)) * (1.0 / (1.0 - fading.fade) if fading.row >= 0 else 1.0)
