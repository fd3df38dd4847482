"""Passivity observer and controller: what the wall has given out more than it took is taken back by a damper.

Hannaford & Ryu (2001, 2002), for an impedance display. The energy that the wall took is summed from the torque held
and the counts moved; where it is below 0 a damper is added that would bring it to 0 at the speed now seen, up to a
largest one, without which the one count that a slow knob moves would take back all that is owed at once. The damper
acts wherever energy is owed, outside the wall too.
"""

from math import inf
from typing import Any

from hknob_cli.controllers.controller import ControlLaw, Plant
from hknob_cli.engine.general.laws.step import depth_of
from hknob_cli.specs.controller import Controller


def passivity(shown: float, speed: float, past: Any, fixed: Any, out: Any) -> float:
    """Memory: place, torque, energy, and 1 where the energy begins anew. Fixed: offset, most damping, reset."""
    now, at = depth_of(shown, fixed[0]), shown + fixed[0]
    travel = at - past[0]
    energy = owed = past[2] - past[1] * travel
    torque = now
    if energy < 0.0 and travel != 0.0:
        torque = now - min(-energy / (travel * travel), fixed[1]) * travel
    past[3] = 0.0
    if fixed[2] > 0.0 and now == 0.0 and travel == 0.0:
        energy = 0.0
        past[3] = 1.0
    past[0], past[1], past[2] = at, torque, energy
    out[0] = torque
    return -owed - fixed[1] * travel * travel if travel != 0.0 else inf


class PassivityControl(ControlLaw):
    """``damping`` (N·m·s/rad): the most that the controller adds; ``reset``: the sum begins anew outside the wall.

    That is at a sample outside at which no count has been moved since the last one. It remembers place, torque, the sum
    of energy, which drifts, and whether that has just begun anew.
    """

    act = staticmethod(passivity)
    rows, places = 4, 1
    drifts, anchor = 2, 3
    reads_outside = True

    def __init__(self, damping: float, *, reset: bool) -> None:
        self.damping = damping
        self.reset = reset

    @classmethod
    def of(cls, plan: Controller) -> "PassivityControl":
        """With the numbers of a spec."""
        return cls(plan.damping, reset=plan.reset)

    def numbers(self, plant: Plant) -> list[float]:
        """Where counts lie, the largest damping, in steps of the wall per count a sample, and whether sums end."""
        return [plant.offset, self.damping / (plant.stiffness * plant.period_s), float(self.reset)]
