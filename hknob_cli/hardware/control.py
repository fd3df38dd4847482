"""What acts on a target: what answers the angle, as the wire carries it, and what fires a pulse when a grip is as told.

The table over the angle and the function that reads it are those of the engine; `firmware/over_angle.c` has the same
operations in the same order. Its torques are in N·m, so that nothing on a target depends on the knob's inertia.

A target at a wire runs the laws of `controllers` without a sensor of the speed; the virtual device has that, too. The
functions here are those of the engine itself; `firmware/law.c` has the same operations in the same order.

RELAX until the grip is below the release level; SQUEEZE until it reaches the target, or is in its band, where it has
to stay (HOLD); PULSE; RELEASE until the grip is below the release level again; DONE. Times are whole samples. The force
is that of the cell less its mean before the start, as the device told it, so that host and device go by one number.
"""

import sys
from enum import Enum
from math import nan, tau
from typing import Any

import numpy as np

from hknob_cli.engine.general.torque_table import HEAD, command_at
from hknob_cli.hardware.port import Array, Control, Flags, OverAngle, Pulse, PulseOrder, Settings
from hknob_cli.hardware.wire.codes import Law
from hknob_cli.specs.campaign import Model
from hknob_cli.specs.controller import Controller
from hknob_cli.specs.over_angle import Effects


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


UNKNOWN = Model(nan, nan, nan)


def control_of(plan: Controller, settings: Settings, model: Model = UNKNOWN) -> Control:
    """The controller of a spec at the sample rate, counts and wall of a trial, as the wire carries it.

    ``model``: of knob and hand, for the kinds that have one. Raises `ValueError` for what no target runs.
    """
    from hknob_cli.controllers.controller import Plant, make_control_law

    quantum, period = tau / settings.counts_per_rev, settings.interval_s
    square = period * period / model.inertia
    plant = Plant(
        alpha=model.damping * period / model.inertia,
        beta=model.stiffness * square,
        kappa=settings.wall_stiffness * square,
        offset=settings.converters.offset_counts if settings.converters else 0.0,
        period_s=period,
        quantum_rad=quantum,
        stiffness=settings.wall_stiffness,
    )
    law = make_control_law(plan)
    try:
        code = Law[law.act.__name__.upper()]
    except KeyError:
        raise ValueError(f"no target runs {law.act.__name__}") from None
    # Floats of the wire are finite; a pace that nothing is above is the largest of them.
    numbers = (min(one, sys.float_info.max) for one in law.numbers(plant))
    return Control(int(code), law.places, tuple(numbers), tuple(law.first()))


def begins_of(control: Control | None) -> tuple[float, ...]:
    """Where in a sample interval its torque changes, in parts of it; of the plain wall at its begin alone."""
    if control is not None and control.law == Law.FIRST_ORDER_HOLD:
        steps = int(control.numbers[3])
        return tuple(k / steps for k in range(steps))
    if control is not None and control.law == Law.IMPULSE_DAMPING and control.numbers[1] < 1.0:
        return 0.0, control.numbers[1]
    return (0.0,)


_SENSOR = {Law.VELOCITY_DAMPING: 2, Law.HALF_SAMPLE: 4, Law.MATCHED_WALL: 3}  # the number that says so
_LOOKS = {Law.FIRST_ORDER_HOLD: 2, Law.IMPULSE_DAMPING: 3}  # the number that counts them
_READINGS = {Law.TIMED_VELOCITY: 7}  # the number that counts them with the sample's own


def senses_speed(control: Control | None) -> bool:
    """Whether a controller reads a sensor of the speed."""
    if control is None or control.law not in _SENSOR:
        return False
    return control.numbers[_SENSOR[Law(control.law)]] > 0.0


def looks_of(control: Control | None) -> tuple[float, ...]:
    """Where in a sample interval a controller reads the encoder beside the sample, in parts of it."""
    if control is None:
        return ()
    readings = 1
    if control.law in _LOOKS:
        readings += int(control.numbers[_LOOKS[Law(control.law)]])
    elif control.law in _READINGS:
        readings = int(control.numbers[_READINGS[Law(control.law)]])
    return tuple(k / readings for k in range(1, readings))


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
        self._parts = len(begins_of(control))
        self._out = [0.0] * (2 * self._parts)
        self._speed = 0.0

    def sense(self, speed: float) -> None:
        """Take the speed of the next sample, in counts of the wall's encoder and sample intervals."""
        self._speed = speed

    def look(self, which: int, count: int) -> None:
        """Take a count that is read within the interval, the ``which`` of `looks_of`."""
        if self._past:
            self._past[len(self._control.rows) + 1 + which] = float(count)

    @property
    def memory(self) -> list[float]:
        """What the law remembers, then the last reading and those since; empty before the first sample."""
        return list(self._past)

    def torque(self, count: int, before: int) -> float:
        """Torque in N·m from a sample on, at a count of the wall's encoder; ``before``: that of the last sample."""
        return self.torques(count, before)[0]

    def torques(self, count: int, before: int) -> list[float]:
        """Torques in N·m, one a part of the interval, before converters and limit."""
        springs, brake = self._act_at(count, before)
        return [spring - brake for spring in springs]

    def sized(self, count: int, before: int) -> tuple[list[float], float]:
        """Torques as above, and the size of what they are made of, which roundings are shares of."""
        springs, brake = self._act_at(count, before)
        quantum = self._settings.wall_stiffness * tau / self._settings.counts_per_rev
        size = max(map(abs, springs)) + abs(brake) + quantum * max(-count, 0)
        return [spring - brake for spring in springs], size

    def _act_at(self, count: int, before: int) -> tuple[list[float], float]:
        settings, control = self._settings, self._control
        if not self._past:
            place = float(before) + self._numbers[0]
            shown = [float(before)] * (1 + len(looks_of(control)))
            self._past = [*([place] * control.places), *control.rows[control.places :], *shown]
        self._act(float(count), self._speed, self._past, self._numbers, self._out)
        self._past[len(control.rows)] = float(count)
        quantum = tau / settings.counts_per_rev
        brake = settings.wall_damping * ((count - before) * quantum) / settings.interval_s if count < 0 else 0.0
        return [settings.wall_stiffness * (part * quantum) for part in self._out[: self._parts]], brake


class Phase(str, Enum):
    """What a trial is at; ``ZERO``: before the start."""

    ZERO = "zero"
    RELAX = "relax"
    SQUEEZE = "squeeze"
    HOLD = "hold"
    PULSE = "pulse"
    RELEASE = "release"
    DONE = "done"


def pulse_of(order: PulseOrder, interval_s: float) -> Pulse:
    """A pulse in samples, as devices count them; ``interval_s`` from sample to sample."""
    return Pulse(
        grip_n=order.grip_n,
        band_n=order.band_n,
        release_n=order.release_n,
        torque_nm=order.torque_nm,
        width=max(1, round(order.width_s / interval_s)),
        dwell=round(order.dwell_s / interval_s),
    )


class GripTrigger:
    """Follows the grip of one trial; ``phase`` is that of the last sample."""

    def __init__(self, order: PulseOrder, interval_s: float) -> None:
        """``interval_s`` from sample to sample."""
        self._pulse = pulse_of(order, interval_s)
        self._stayed = 0
        self._sum, self._count = 0.0, 0
        self.phase = Phase.ZERO

    @property
    def zero_n(self) -> float:
        """Mean of the cell before the start."""
        return self._sum / self._count if self._count else 0.0

    def step(self, cell_n: float, *, running: bool) -> float:
        """Torque (N·m) from this sample to the next, at which the grip cell shows ``cell_n``."""
        if not running:
            self._sum, self._count = self._sum + cell_n, self._count + 1
            return 0.0
        grip = cell_n - self.zero_n
        if self.phase in (Phase.ZERO, Phase.RELAX):
            self.phase = Phase.SQUEEZE if grip < self._pulse.release_n else Phase.RELAX
        if self.phase in (Phase.SQUEEZE, Phase.HOLD):
            self._wait(grip)
        elif self.phase is Phase.PULSE:
            self._stayed += 1
            self.phase = Phase.PULSE if self._stayed < self._pulse.width else Phase.RELEASE
        if self.phase is Phase.RELEASE and grip < self._pulse.release_n:
            self.phase = Phase.DONE
        return self._pulse.torque_nm if self.phase is Phase.PULSE else 0.0

    def _wait(self, grip: float) -> None:
        """Fire, or go on waiting."""
        pulse = self._pulse
        if not pulse.dwell:
            fires = grip >= pulse.grip_n
        else:
            held = abs(grip - pulse.grip_n) <= pulse.band_n
            self._stayed = self._stayed + 1 if held else 0
            self.phase = Phase.HOLD if held else Phase.SQUEEZE
            fires = self._stayed > pulse.dwell
        if fires:
            self.phase, self._stayed = Phase.PULSE, 0

    def follow(self, cell_n: Array, running: Flags) -> Array:
        """Torques (n,) at samples."""
        return np.array([self.step(one, running=on) for one, on in zip(cell_n.tolist(), running.tolist(), strict=True)])
