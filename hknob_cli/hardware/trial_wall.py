"""The wall of a trial: how it reads the encoder, what it answers, and what is sent of its torque, and when.

Counts are found in whole numbers. The torque goes through the engine's own function, here in N·m; `firmware/convert.c`
has the same operations in the same order, and `firmware/line.c` those of torques that are under way to the motor.

Source: docs/reference/wire.md, "What a target does": count, wall or what acts in its place, converters, line, limit.
"""

from collections import deque
from collections.abc import Sequence
from math import floor, inf, isfinite, tau
from typing import NamedTuple, Protocol

import numpy as np

from hknob_cli.engine.general.controller import Controller, send
from hknob_cli.hardware.control import ControlledWall, ShapedWall, begins_of
from hknob_cli.hardware.port import ROUNDINGS, Converters, Counts, Settings
from hknob_cli.specs.parts import Actuator, Encoder

MOST = 1024  # torques that a target has room for


class Slot(NamedTuple):
    """When in an interval a torque goes out, in parts of it: that of a ``part``, of ``age`` samples ago."""

    begins: float
    age: int
    part: int


def slots_of(begins: Sequence[float], delay_samples: float) -> list[Slot]:
    """The torques of an interval in their order, the first from its begin on; ``begins`` of its parts, from 0."""
    whole = floor(delay_samples)
    split = delay_samples - whole
    found = []
    for late in (1, 0):  # the parts of older torques go on until those of the newer begin
        for i, begin in enumerate(begins):
            at, end = begin + split - late, (begins[i + 1] if i + 1 < len(begins) else 1.0) + split - late
            if at < 1.0 and end > 0.0:
                found.append(Slot(max(at, 0.0), whole + late, i))
    return found


def room_of(parts: int, delay_samples: float) -> int:
    """How many torques a target keeps for such a delay."""
    return (floor(delay_samples) + 2) * parts


class TorqueLine:
    """Torques under way in a trial, none at first."""

    def __init__(self, begins: Sequence[float], delay_samples: float) -> None:
        self._slots = slots_of(begins, delay_samples)
        self.begins = tuple(slot.begins for slot in self._slots)
        rows = floor(delay_samples) + 2
        self._rows: deque[Sequence[float]] = deque([(0.0,) * len(begins)] * rows, maxlen=rows)

    def put(self, torques: Sequence[float]) -> list[float]:
        """Take the torques of a sample, one a part; those that go out until the next, one a slot."""
        self._rows.appendleft(torques)
        return [self._rows[slot.age][slot.part] for slot in self._slots]


NONE = Converters()


def converters_of(encoder: Encoder | None, actuator: Actuator | None) -> Converters | None:
    """Those of a spec; None where they do nothing."""
    encoder, actuator = encoder or Encoder(), actuator or Actuator()
    found = Converters(
        offset_counts=encoder.offset_counts,
        dead_band_nm=actuator.dead_band,
        step_nm=actuator.torque_step,
        limit_nm=actuator.torque_limit or 0.0,
        delay_samples=actuator.delay_samples,
        rounding=ROUNDINGS.index(encoder.rounding),
    )
    return None if found == NONE else found


def words_of(told: Converters) -> str:
    """What they do, in SI units; empty where that is nothing."""
    said = {**told._asdict(), "rounding": ROUNDINGS[told.rounding]}
    usual = {**NONE._asdict(), "rounding": ROUNDINGS[NONE.rounding]}
    shown = {name: value for name, value in said.items() if value != usual[name]}
    shown = {name: f"{value:.6g}" if isinstance(value, float) else value for name, value in shown.items()}
    return ", ".join(f"{name} {value}" for name, value in shown.items())


class Conversion:
    """The converters of a trial, between an encoder of ``native`` counts per revolution and its motor."""

    def __init__(self, settings: Settings, native: int) -> None:
        told = settings.converters or NONE
        self._counts, self._native, self._rounding = settings.counts_per_rev, native, ROUNDINGS[told.rounding]
        self._shift = floor(told.offset_counts * native + 0.5)
        self._half = native // 2 if self._rounding == "nearest" else 0
        self._wall = Controller(
            *(0.0, 0.0, 1.0, 0.0, told.offset_counts, 0.0),
            step=told.step_nm,
            limit=told.limit_nm or inf,
            split=0.0,
            band=told.dead_band_nm,
        )
        self.steps = told.step_nm > 0.0 or told.dead_band_nm > 0.0

    def count(self, angle: int) -> int:
        """The wall's count at an angle in counts of the device's own encoder; exact."""
        count = (angle * self._counts - self._shift + self._half) // self._native
        # The knob is above the edge at which the device's own encoder shows what it does: up means the next count.
        up = self._rounding == "ceil" or (self._rounding == "truncate" and count < 0)
        return count + 1 if up else count

    def counts(self, angles: Counts) -> Counts:
        """The wall's counts at angles (n,)."""
        found = np.floor_divide(angles * self._counts - self._shift + self._half, self._native)
        if self._rounding == "ceil":
            return found + 1
        return np.where(found < 0, found + 1, found) if self._rounding == "truncate" else found

    def send(self, torque_nm: float) -> float:
        """What is sent of a torque; what is not a number stays what it is."""
        return float(send(torque_nm, self._wall)) if isfinite(torque_nm) else torque_nm


class Acting(Protocol):
    """What gives the torque at a count."""

    def torques(self, count: int, before: int) -> list[float]:
        """Torques in N·m, one a part of the interval; ``before``: the count of the last sample."""

    def sized(self, count: int, before: int) -> tuple[list[float], float]:
        """Torques as above, and the size of what they are made of, which roundings are shares of."""


class PlainWall:
    """A spring and a damper inside."""

    def __init__(self, settings: Settings) -> None:
        self._settings = settings
        self._offset = (settings.converters or NONE).offset_counts

    def torques(self, count: int, before: int) -> list[float]:
        """Torque in N·m, before converters and limit, at a count; ``before``: that of the last sample."""
        return self.sized(count, before)[0]

    def sized(self, count: int, before: int) -> tuple[list[float], float]:
        """Torque as above, and the size of its parts."""
        if count >= 0:
            return [0.0], 0.0
        settings = self._settings
        quantum = tau / settings.counts_per_rev
        spring = -settings.wall_stiffness * ((count + self._offset) * quantum)
        brake = settings.wall_damping * ((count - before) * quantum) / settings.interval_s
        return [spring - brake], abs(spring) + abs(brake)


def acting_of(settings: Settings) -> Acting:
    """What acts in a trial."""
    if settings.over_angle is not None:
        return ShapedWall(settings, settings.over_angle)
    return PlainWall(settings) if settings.control is None else ControlledWall(settings, settings.control)


class Sent(NamedTuple):
    """What a sample leads to: ``torque_nm`` from it on, ``later`` those within the interval, one a slot.

    ``size``, and ``slack``: by how much the torque may differ where what it is rounded from differs by ``share`` of its
    size, both of the sample at which it was computed.
    """

    torque_nm: float
    later: tuple[float, ...] = ()
    size: float = 0.0
    slack: float = 0.0


class TrialWall:
    """The wall of a trial on a device whose encoder has ``native`` counts; memory begins with the wall on."""

    def __init__(self, settings: Settings, native: int) -> None:
        self.acting = acting_of(settings)
        self.controlled = self.acting if isinstance(self.acting, ControlledWall) else None
        self._limit = settings.torque_limit_nm
        self._conversion = Conversion(settings, native)
        begins = (0.0,) if settings.over_angle is not None else begins_of(settings.control)
        delay = (settings.converters or NONE).delay_samples
        self._line, self._sizes = TorqueLine(begins, delay), TorqueLine(begins, delay)
        self._slacks = TorqueLine(begins, delay)
        self.begins = self._line.begins
        self._direct = settings.converters is None and len(begins) == 1
        self.count, self.counts = self._conversion.count, self._conversion.counts

    def torques(self, count: int, before: int) -> Sent:
        """At a count with the wall on; ``before``: that of the last sample. Not a number as soon as it is computed."""
        found = self.acting.torques(count, before)
        bad = next((one for one in found if not isfinite(one)), None)
        if bad is not None:
            return Sent(bad)
        if self._direct:
            return Sent(self._cut(found[0]))
        first, *later = (self._cut(one) for one in self._line.put([self._conversion.send(one) for one in found]))
        return Sent(first, tuple(later))

    def follow(self, count: int, before: int, *, share: float) -> Sent:
        """As above, with the size of what the first torque is made of, and its slack at that ``share``."""
        found, size = self.acting.sized(count, before)
        sent = [self._conversion.send(one) for one in found]
        slacks = [0.0] * len(found)
        if self._conversion.steps:
            ways = (-share * size, share * size)
            slacks = [
                max(abs(self._conversion.send(u + way) - out) for way in ways)
                for u, out in zip(found, sent, strict=True)
            ]
        first, *later = (self._cut(one) for one in self._line.put(sent))
        return Sent(first, tuple(later), self._sizes.put([size] * len(found))[0], self._slacks.put(slacks)[0])

    def _cut(self, torque: float) -> float:
        return max(-self._limit, min(self._limit, torque))
