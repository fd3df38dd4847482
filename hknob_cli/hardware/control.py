"""Controllers of the wall on a target: from a spec's to what the wire carries, and what they give, sample by sample.

A target runs the laws of `engine.general.laws` that take one reading and give one torque an interval. The functions
here are those of the engine itself; `firmware/law.c` has the same operations in the same order.
"""

import sys
from math import nan, tau
from typing import Any

import numpy as np

from hknob_cli.hardware.port import Array, Control, Counts, Flags, Settings
from hknob_cli.hardware.wire.codes import Law
from hknob_cli.specs.controller import Controller


def control_of(plan: Controller, settings: Settings) -> Control:
    """The controller of a spec at the sample rate, counts and wall of a trial, as the wire carries it.

    Raises `ValueError` for one that is not in `wire.codes.Law`.
    """
    from hknob_cli.controllers.controller import make_control_law
    from hknob_cli.controllers.plant_batch import PlantBatch
    from hknob_cli.controllers.scalar_law import reduce_law

    unknown = dict.fromkeys(PlantBatch._fields, nan)  # knob and hand: no law of a target asks for them
    known = {
        "offset": 0.0,
        "period_s": settings.interval_s,
        "quantum_rad": tau / settings.counts_per_rev,
        "stiffness": settings.wall_stiffness,
    }
    lane = PlantBatch(**{name: np.array([value]) for name, value in (unknown | known).items()})
    law = reduce_law(plan, make_control_law(plan), lane)
    try:
        code = Law[law.act.upper()]
    except KeyError:
        raise ValueError(f"no target runs {law.act}") from None
    # Floats of the wire are finite; a pace that nothing is above is the largest of them.
    numbers = (min(one, sys.float_info.max) for one in law.fixed)
    return Control(int(code), law.places, tuple(numbers), tuple(law.first))


def _function_of(control: Control) -> Any:
    """The engine's own."""
    from hknob_cli.engine.general.laws import kinds, speeds

    name = Law(control.law).name.lower()
    return getattr(kinds, name, None) or getattr(speeds, name)


class ControlledWall:
    """The wall under the controller of a trial, from the first sample with the wall on."""

    def __init__(self, settings: Settings, control: Control) -> None:
        self._settings, self._control = settings, control
        self._act = _function_of(control)
        self._numbers = list(control.numbers)
        self._past: list[float] = []
        self._out = [0.0, 0.0]

    @property
    def memory(self) -> list[float]:
        """What the law remembers, then the last reading; empty before the first sample."""
        return list(self._past)

    def torque(self, count: int, before: int) -> float:
        """Torque in N·m, before the limit, at a count of the wall's encoder; ``before``: that of the last sample."""
        spring, brake = self._parts(count, before)
        return spring - brake

    def follow(self, counts: Counts, before: Counts, running: Flags) -> tuple[Array, Array]:
        """Torques at samples (n,), N·m, before the limit, 0 where the wall is off; and the sizes of their parts."""
        torques, terms = np.zeros(counts.size), np.zeros(counts.size)
        quantum = self._settings.wall_stiffness * tau / self._settings.counts_per_rev
        for i in np.flatnonzero(running).tolist():
            count = int(counts[i])
            spring, brake = self._parts(count, int(before[i]))
            torques[i] = spring - brake
            terms[i] = abs(spring) + abs(brake) + quantum * max(-count, 0)
        return torques, terms

    def _parts(self, count: int, before: int) -> tuple[float, float]:
        settings, control = self._settings, self._control
        if not self._past:
            place = float(before) + self._numbers[0]
            self._past = [*([place] * control.places), *control.rows[control.places :], float(before)]
        self._act(float(count), 0.0, self._past, self._numbers, self._out)
        self._past[len(control.rows)] = float(count)
        quantum = tau / settings.counts_per_rev
        brake = settings.wall_damping * ((count - before) * quantum) / settings.interval_s if count < 0 else 0.0
        return settings.wall_stiffness * (self._out[0] * quantum), brake
