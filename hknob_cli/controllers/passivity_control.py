"""Passivity observer and controller: what the wall has given out more than it took is taken back by a damper.

Hannaford & Ryu (2001, 2002), for an impedance display. The energy that the wall took is summed from the torque held
and the counts moved; where it is below 0 a damper is added that would bring it to 0 at the speed now seen, up to a
largest one, without which the one count that a slow knob moves would take back all that is owed at once. The damper
acts wherever energy is owed, outside the wall too.
"""

import numpy as np

from hknob_cli.controllers.controller import Action, Differencing, Reading
from hknob_cli.controllers.plant_batch import Array, PlantBatch
from hknob_cli.specs.controller import Controller


class PassivityControl(Differencing):
    """``damping`` (N·m·s/rad): the most that the controller adds; ``reset``: the sum begins anew outside the wall.

    That is at a sample outside at which no count has been moved since the last one.
    """

    rows = 3

    def __init__(self, damping: float, *, reset: bool) -> None:
        self.damping = damping
        self.reset = reset

    @classmethod
    def of(cls, plan: Controller) -> "PassivityControl":
        """With the numbers of a spec."""
        return cls(plan.damping, reset=plan.reset)

    def constants(self, lanes: PlantBatch) -> tuple[Array, ...]:
        """Where counts lie, and the largest damping, in steps of the wall per count a sample."""
        return lanes.offset, self.damping / (lanes.stiffness * lanes.period_s)

    def act(self, reading: Reading, memory: Array, fixed: tuple[Array, ...]) -> Action:
        """The wall's torque, and the damper's while energy is owed."""
        offset, most = fixed
        at = reading.level + offset
        before, torque_held, energy = memory
        travel = at - before
        energy = energy - torque_held * travel
        owed = (energy < 0.0) & (travel != 0.0)
        wanted = -energy / np.where(travel == 0.0, 1.0, travel * travel)
        torque = reading.depth - np.where(owed, np.minimum(wanted, most) * travel, 0.0)
        if self.reset:
            energy = np.where((reading.depth == 0.0) & (travel == 0.0), 0.0, energy)
        guards = (np.where(travel != 0.0, energy, 1.0), wanted - most)
        return Action((torque,), np.stack([at, torque, energy]), guards)
