"""Torque over the angle on a target: from a spec's parts to what the wire carries, and what it gives, count by count.

The table and the function that reads it are those of the engine; `firmware/over_angle.c` has the same operations in the
same order. Its torques are in N·m, so that nothing on a target depends on the knob's inertia.
"""

from math import tau

import numpy as np

from hknob_cli.engine.general.torque_table import HEAD, command_at
from hknob_cli.hardware.port import Array, Counts, OverAngle, Settings
from hknob_cli.specs.campaign import Effects


def over_angle_of(effects: Effects, settings: Settings) -> OverAngle:
    """The parts of a spec at the counts and wall of a trial. Raises `ComputationError` where the table is too long."""
    from hknob_cli.scene.torque_over_angle import Clock, table_of

    quantum = tau / settings.counts_per_rev
    clock = Clock(settings.counts_per_rev, quantum, 0.0)
    table = table_of(effects, clock, kappa=settings.wall_stiffness * quantum, unit_nm=1.0)
    first, turn, below, above = table[:HEAD].tolist()
    count = (len(table) - HEAD) // 3
    return OverAngle(int(first), int(turn), below, above, tuple(table[HEAD : HEAD + count].tolist()))


class ShapedWall:
    """Torque over the angle of a trial, and the wall's damping beside it."""

    def __init__(self, settings: Settings, over: OverAngle) -> None:
        self._settings = settings
        unused = [0.0] * (2 * len(over.torques))  # the runs, which only the engine asks for
        self._table = [float(over.first), float(over.turn), over.below, over.above, *over.torques, *unused]

    def torque(self, count: int, before: int) -> float:
        """Torque in N·m, before the limit, at a count of the wall's encoder; ``before``: that of the last sample."""
        spring, brake = self._parts(count, before)
        return spring - brake

    def follow(self, counts: Counts, before: Counts) -> tuple[Array, Array]:
        """Torques at samples (n,), N·m, before the limit; and the sizes of their parts."""
        pairs = zip(counts.tolist(), before.tolist(), strict=True)
        springs, brakes = np.array([self._parts(*one) for one in pairs]).reshape(-1, 2).T
        return springs - brakes, np.abs(springs) + np.abs(brakes)

    def _parts(self, count: int, before: int) -> tuple[float, float]:
        settings = self._settings
        quantum = tau / settings.counts_per_rev
        brake = settings.wall_damping * ((count - before) * quantum) / settings.interval_s if count < 0 else 0.0
        return float(command_at(float(count), self._table)), brake
