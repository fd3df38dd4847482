"""Torque over the angle on a target: from a spec's parts to what the wire carries, and what it gives, count by count.

The table and the function that reads it are those of the engine; `firmware/over_angle.c` has the same operations in the
same order. Its torques are in N·m, so that nothing on a target depends on the knob's inertia.
"""

from math import tau

from hknob_cli.engine.general.torque_table import HEAD, command_at
from hknob_cli.hardware.port import OverAngle, Settings
from hknob_cli.specs.campaign import Effects


def over_angle_of(effects: Effects, settings: Settings) -> OverAngle:
    """The parts of a spec at the counts and wall of a trial. Raises `ComputationError` where the table is too long."""
    from hknob_cli.scene.torque_over_angle import Clock, table_of

    quantum = tau / settings.counts_per_rev
    offset = settings.converters.offset_counts if settings.converters else 0.0
    clock = Clock(settings.counts_per_rev, quantum, offset)
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
        """Torque in N·m, before converters and limit, at a count; ``before``: that of the last sample."""
        return self.torques(count, before)[0]

    def torques(self, count: int, before: int) -> list[float]:
        """The same, as the only one of the interval."""
        spring, brake = self._parts(count, before)
        return [spring - brake]

    def sized(self, count: int, before: int) -> tuple[list[float], float]:
        """Torque as above, and the size of what it is made of, which roundings are shares of."""
        spring, brake = self._parts(count, before)
        return [spring - brake], abs(spring) + abs(brake)

    def _parts(self, count: int, before: int) -> tuple[float, float]:
        settings = self._settings
        quantum = tau / settings.counts_per_rev
        brake = settings.wall_damping * ((count - before) * quantum) / settings.interval_s if count < 0 else 0.0
        return float(command_at(float(count), self._table)), brake
