"""Virtual damping beside the wall, against the velocity: differenced from the counts, or from a sensor.

Dissertation, Sections 10.2 and 11: a velocity sensor makes virtual damping meaningful where counts are too coarse to
difference. Below 0 the damping drives: to take back physical damping outside the wall (Colgate & Schenkel 1994).
Firmware differences over several samples, or filters: y += a (x - y), a = 1 - exp(-T / time constant), as a Hapkit does
(main1DOF.cpp of Longhorn Hapkit). A SmartKnob commands no torque above a speed (its motor_task.cpp). Other estimates
are in `estimated_velocity`.
"""

import numpy as np

from hknob_cli.controllers.controller import Action, Differencing, Reading
from hknob_cli.controllers.estimated_velocity import EstimatedVelocity
from hknob_cli.controllers.plant_batch import Array, PlantBatch
from hknob_cli.specs.controller import Controller


class VelocityDamping(Differencing):
    """``damping`` in N·m·s/rad; ``sensor``: the velocity is sensed; ``everywhere``: outside the wall, too.

    ``window`` in samples, ``low_pass`` in s, 0 for none, ``cut_off`` in rad/s.
    """

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
        self.places = window
        self.rows = window + (low_pass > 0.0)
        self.counted = tuple(range(window))

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

    def settling(self, lanes: PlantBatch) -> Array:
        """The low-pass's time constant."""
        return self.low_pass / lanes.period_s

    def constants(self, lanes: PlantBatch) -> tuple[Array, ...]:
        """Offset of the counts, steps of the wall per count a sample, the low-pass's part of the way, the cut-off."""
        goes = -np.expm1(-lanes.period_s / self.low_pass) if self.low_pass > 0.0 else np.zeros(len(lanes.alpha))
        gain = -self.damping / (lanes.stiffness * lanes.period_s)
        return lanes.offset, gain, goes, self.cut_off * lanes.period_s / lanes.quantum_rad

    def act(self, reading: Reading, memory: Array, fixed: tuple[Array, ...]) -> Action:
        """The wall's torque and the damper's."""
        offset, gain, goes, most = fixed
        at = reading.level + offset
        speed = (at - memory[self.places - 1]) / self.places if reading.speed is None else reading.speed
        kept = [at[None], memory[: self.places - 1]]
        if self.low_pass > 0.0:
            speed = memory[-1] + goes * (speed - memory[-1])
            kept.append(speed[None])
        damper = gain * speed
        acts = damper if self.everywhere else np.where(reading.level < 0.0, damper, 0.0)
        torque = reading.depth + acts
        memory = np.concatenate(kept)
        if self.cut_off == np.inf:
            return Action((torque,), memory)
        guards = () if self.low_pass == 0.0 and not self.senses_speed else (most - np.abs(speed),)
        return Action((np.where(np.abs(speed) > most, 0.0, torque),), memory, guards)
