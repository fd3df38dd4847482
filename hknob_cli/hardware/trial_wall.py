"""The wall of a trial, from the angle that the device's encoder shows to the torques that go out until the next sample.

Source: docs/reference/wire.md, "What a target does": count, wall or what acts in its place, converters, line, limit.
"""

from math import isfinite, tau
from typing import NamedTuple, Protocol

from hknob_cli.hardware.control import ControlledWall, ShapedWall, begins_of
from hknob_cli.hardware.converters import NONE, Conversion, TorqueLine
from hknob_cli.hardware.port import Settings


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
