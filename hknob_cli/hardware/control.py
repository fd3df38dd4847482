"""Controllers of the wall on a target: from a spec's to what the wire carries, and what they give, sample by sample.

A target runs the laws of `controllers` that take one reading and give one torque an interval. The functions
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
    from hknob_cli.controllers.controller import Plant, make_control_law

    # Knob and hand are unknown: no law of a target asks for them.
    quantum = tau / settings.counts_per_rev
    plant = Plant(nan, nan, nan, 0.0, settings.interval_s, quantum, settings.wall_stiffness)
    law = make_control_law(plan)
    try:
        code = Law[law.act.__name__.upper()]
    except KeyError:
        raise ValueError(f"no target runs {law.act.__name__}") from None
    # Floats of the wire are finite; a pace that nothing is above is the largest of them.
    numbers = (min(one, sys.float_info.max) for one in law.numbers(plant))
    return Control(int(code), law.places, tuple(numbers), tuple(law.first()))


def _function_of(control: Control) -> Any:
    """The engine's own."""
    from hknob_cli.controllers.controller import act_named

    return act_named(Law(control.law).name.lower())


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
