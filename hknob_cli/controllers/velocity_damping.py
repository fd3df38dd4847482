"""Virtual damping beside the wall, against the velocity: differenced from the counts, or from a sensor.

Dissertation, Sections 10.2 and 11: a velocity sensor makes virtual damping meaningful where counts are too coarse to
difference. Below 0 the damping drives: to take back physical damping outside the wall (Colgate & Schenkel 1994).
"""

import numpy as np

from hknob_cli.controllers.controller import Action, Differencing, Reading
from hknob_cli.controllers.plant_batch import Array, PlantBatch
from hknob_cli.specs.controller_plan import Controller


class VelocityDamping(Differencing):
    """``damping`` in N·m·s/rad; ``sensor``: the velocity is sensed; ``everywhere``: outside the wall, too."""

    def __init__(self, damping: float, *, sensor: bool, everywhere: bool) -> None:
        self.damping = damping
        self.senses_speed = sensor
        self.everywhere = everywhere

    @classmethod
    def of(cls, plan: Controller) -> "VelocityDamping":
        """With the numbers of a spec."""
        return cls(plan.damping, sensor=plan.velocity == "sensor", everywhere=plan.everywhere)

    def constants(self, lanes: PlantBatch) -> tuple[Array, ...]:
        """Where counts lie, and steps of the wall per count a sample."""
        return lanes.offset, -self.damping / (lanes.stiffness * lanes.period_s)

    def act(self, reading: Reading, memory: Array, fixed: tuple[Array, ...]) -> Action:
        """The wall's torque and the damper's."""
        offset, gain = fixed
        at = reading.level + offset
        speed = at - memory[0] if reading.speed is None else reading.speed
        damper = gain * speed
        acts = damper if self.everywhere else np.where(reading.level < 0.0, damper, 0.0)
        return Action((reading.depth + acts,), at[None])
