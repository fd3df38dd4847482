"""The host's own watch over a trial: what is sent must be within the limits, in order, and as was agreed.

Of a device at a wire, where `LimitMonitor` is told ``wired``, the wall's flag and the torque must also be those that
follow from the commands and from the settings that it took.

The wall that host and target agreed on: the torque of every sample follows from its angle and the one before.

Source: docs/reference/wire.md, "What a target does". Angles are whole counts, so that nothing is open but the rounding
of floats.

Signals that wait until the torque is off.
"""

import contextlib
import math
import signal
import threading
from collections.abc import Iterator
from math import tau
from typing import NamedTuple

import numpy as np

from hknob_cli.errors import DeviceError
from hknob_cli.hardware.control import GripTrigger, looks_of
from hknob_cli.hardware.port import Array, Block, Counts, Flags, Settings
from hknob_cli.hardware.trial_wall import TrialWall
from hknob_cli.hardware.wire.codes import Law

_INTERRUPTING = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
_SLACK = 1.01  # a limit and what is measured by a clock and an encoder are not equal to the last digit
# By how much a reported torque may differ from the wall's: a share of its parts, and of the limit. Single precision on
# the target, and the 24 bits that travel, make some 1e-6.
LAW_SHARE = 1e-4
LAW_LIMIT_SHARE = 1e-6


class WallTorque(NamedTuple):
    """Torque of the wall at samples (n,), N·m; ``terms``: sizes of its parts added, which roundings are shares of.

    ``coarse``: the angle in counts of the encoder that the wall sees; ``slack``: by how much a torque may differ that
    is rounded to steps, where what is rounded differs by `LAW_SHARE`.
    """

    torque_nm: Array
    terms: Array
    coarse: Counts
    slack: Array | float = 0.0


class AgreedWall:
    """The wall that host and device agreed on, followed over the samples of a trial as they come."""

    def __init__(self, settings: Settings, native_counts: int) -> None:
        self._settings, self._native = settings, native_counts
        self._before: int | None = None
        others = (settings.control, settings.over_angle, settings.converters)
        self._followed = None if others == (None, None, None) else TrialWall(settings, native_counts)
        controlled = self._followed.controlled if self._followed else None
        self._reading = controlled if looks_of(settings.control) else None

    def follow(self, angle_counts: Counts, running: Flags, looks: Counts | None = None) -> WallTorque:
        """Torque from the next samples on, at their angles (n,) in counts of the device's own encoder.

        ``looks`` (n, readings): those read within the interval before each. Of more than the plain wall, which may have
        a memory that begins with the wall, the torque is 0 where the wall is off. Raises `DeviceError` where readings
        that the torque follows from are not told.
        """
        read = self._read_of(looks)
        if self._followed is None:
            wall = wall_torque(angle_counts, self._settings, self._native, before=self._before)
            self._before = int(wall.coarse[-1])
            return wall
        coarse = self._followed.counts(angle_counts)
        earlier = np.concatenate([coarse[:1] if self._before is None else [self._before], coarse[:-1]])
        self._before = int(coarse[-1])
        torque, terms, slack = (np.zeros(coarse.size) for _ in range(3))
        for i in np.flatnonzero(running).tolist():
            if self._reading is not None:
                for which, count in enumerate(read[i].tolist()):
                    self._reading.look(which, count)
            sent = self._followed.follow(int(coarse[i]), int(earlier[i]), share=LAW_SHARE)
            torque[i], terms[i], slack[i] = sent.torque_nm, sent.size, sent.slack
        return WallTorque(torque, terms, coarse, slack)

    def _read_of(self, looks: Counts | None) -> Counts:
        """Readings in counts of the wall's encoder."""
        wanted, told = len(looks_of(self._settings.control)), 0 if looks is None else looks.shape[1]
        if told != wanted:
            what = f"the device tells {told} readings within a sample interval, where its wall takes {wanted}"
            raise DeviceError(what)
        if looks is None or self._followed is None:
            return np.zeros((0, 0), dtype=np.int64)
        return self._followed.counts(looks)


def wall_torque(angle_counts: Counts, settings: Settings, native_counts: int, *, before: int | None) -> WallTorque:
    """Torque at these angles (n,), in counts of the device's own encoder.

    ``before``: coarse angle of the sample before the first, None where there was none.
    """
    coarse = np.floor_divide(angle_counts * settings.counts_per_rev, native_counts)
    step = np.diff(coarse, prepend=coarse[:1] if before is None else before)
    quantum = tau / settings.counts_per_rev
    spring = -settings.wall_stiffness * coarse * quantum
    damper = -settings.wall_damping * step * quantum / settings.interval_s
    limit = settings.torque_limit_nm
    inside = coarse < 0
    torque = np.where(inside, np.clip(spring + damper, -limit, limit), 0.0)
    return WallTorque(torque, np.where(inside, np.abs(spring) + np.abs(damper), 0.0), coarse)


@contextlib.contextmanager
def undisturbed() -> Iterator[None]:
    """Put off what interrupts, where this thread would hear it.

    By handlers: a mask is this thread's alone, and another, of a driver or a library, would take the signal for it.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    heard: list[int] = []
    before = {kind: signal.signal(kind, lambda number, _frame: heard.append(number)) for kind in _INTERRUPTING}
    try:
        yield
    finally:
        for kind, handler in before.items():
            signal.signal(kind, signal.SIG_DFL if handler is None else handler)
        for number in dict.fromkeys(heard):
            signal.raise_signal(number)


class LimitMonitor:
    """Checks blocks as they come; ``gaps`` counts samples whose index is missing."""

    def __init__(self, settings: Settings, native_counts: int, *, wired: bool = False) -> None:
        self._settings = settings
        self._native = native_counts
        self._count_rad = 2.0 * math.pi / native_counts
        self._last: tuple[int, int, int] | None = None  # index, time and angle of the last sample
        self._wired = wired
        self._told_to_start = False
        self._on = False
        self._unflagged = False
        self._wall = AgreedWall(settings, native_counts)
        self._pulse = GripTrigger(settings.pulse, settings.interval_s) if settings.pulse else None
        self.gaps = 0

    def start(self) -> None:
        """From now on the wall may be on: the device was told to switch it on."""
        self._told_to_start = True

    def check(self, block: Block) -> None:
        """Look at a block. Raises `DeviceError` naming what is beyond its limit, and at which sample."""
        if not len(block.time_us):
            return
        limit = self._settings.torque_limit_nm
        self._refuse(~np.isfinite(block.torque_nm), block, "the torque is not a number")
        self._refuse(~np.isfinite(block.grip_n), block, "the grip force is not a number")
        what = f"the torque is beyond the limit of {limit:g} N m"
        self._refuse(np.abs(block.torque_nm) > limit * _SLACK, block, what)
        index, time_us, angle = self._last or (block.first - 1, int(block.time_us[0]) - 1, int(block.angle_counts[0]))
        self.gaps += max(0, block.first - index - 1)
        passed = np.diff(block.time_us, prepend=time_us) * 1e-6
        self._refuse(passed < 0.0, block, "the device's clock runs backwards")
        self._refuse(passed == 0.0, block, repeated_time(self._settings))
        moved = np.abs(np.diff(block.angle_counts, prepend=angle)) * self._count_rad
        # A sample that is late is not told from a fast knob by its index: the speed is over the time that passed.
        most = self._settings.speed_limit_rad_s * np.maximum(passed, self._settings.interval_s)
        what = f"the knob is faster than the limit of {self._settings.speed_limit_rad_s:g} rad/s"
        self._refuse(moved > most * _SLACK + self._count_rad, block, what)
        if self._wired:
            self._check_flags(block)
            self._check_law(block)
        last = block.first + len(block.time_us) - 1
        self._last = last, int(block.time_us[-1]), int(block.angle_counts[-1])

    def _check_flags(self, block: Block) -> None:
        """The wall is on from START on, and not before; a sample without the flag after that is the last, of a trip."""
        on = block.running
        if not self._told_to_start:
            self._refuse(on, block, "the device says that the wall is on, and was not told to switch it on")
        before = np.concatenate([[self._on], on[:-1]])
        lost = before & ~on
        lost[-1] = False
        if self._on and self._unflagged:
            raise DeviceError(f"the device said at sample {block.first - 1} that the wall is off, and went on sampling")
        self._refuse(lost, block, "the device says that the wall is off, and goes on sampling")
        self._on = self._on or bool(on.any())
        # A last sample without the flag may be that of a trip: nothing may follow it.
        self._unflagged = self._on and not on[-1]

    def _check_law(self, block: Block) -> None:
        """The torque follows from the angle, the stiffness, the counts and the limit that the device took."""
        settings = self._settings
        if self._pulse is not None:
            self._check_pulse(self._pulse, block)
            return
        wall = self._wall.follow(block.angle_counts, block.running, block.looks)
        expected: Array = np.where(block.running, wall.torque_nm, 0.0)
        allowed = LAW_SHARE * wall.terms + LAW_LIMIT_SHARE * settings.torque_limit_nm + wall.slack
        bad = np.abs(block.torque_nm - expected) > allowed
        if not bad.any():
            return
        i = int(np.argmax(bad))
        angle, torque = int(block.angle_counts[i]), float(block.torque_nm[i])
        at = f"at sample {block.first + i}, {angle} counts of {self._native}"
        if not block.running[i]:
            raise DeviceError(f"the torque is {torque * 1e3:.4g} mN m where the wall is off, {at}")
        times = f", {torque / expected[i]:.3g} times as much" if expected[i] else ""
        under = f" under {Law(settings.control.law).name.lower()}" if settings.control else ""
        under = " and the torque over the angle" if settings.over_angle else under
        under += " behind its converters" if settings.converters else ""
        raise DeviceError(
            f"the torque is not that of the wall{under}: {torque * 1e3:.4g} mN m, where "
            f"{settings.wall_stiffness:g} N m/rad with {settings.wall_damping:g} N m s/rad at "
            f"{settings.counts_per_rev} counts, at most {settings.torque_limit_nm:g} N m, "
            f"give {expected[i] * 1e3:.4g}{times}, {at}"
        )

    def _check_pulse(self, pulse: GripTrigger, block: Block) -> None:
        """The torque is that of the pulse which the grip that the device told fires, to its single precision."""
        expected = np.where(block.running, pulse.follow(block.grip_n, block.running), 0.0)
        bad = np.abs(block.torque_nm - expected) > LAW_LIMIT_SHARE * self._settings.torque_limit_nm
        if bad.any():
            i = int(np.argmax(bad))
            raise DeviceError(
                f"the torque is not that of the pulse: {block.torque_nm[i] * 1e3:.4g} mN m, where the grip that the "
                f"device told calls for {expected[i] * 1e3:.4g}, at sample {block.first + i}"
            )

    def _refuse(self, bad: np.ndarray[tuple[int], np.dtype[np.bool_]], block: Block, what: str) -> None:
        if bad.any():
            raise DeviceError(f"{what}, at sample {block.first + int(np.argmax(bad))}")


def repeated_time(settings: Settings) -> str:
    """What is wrong where two samples have the same time."""
    period = settings.period_ns * 1e-3
    return (
        f"the device's clock gives two samples the same time: it must be told to 1 us, and a period is {period:g} us "
        f"(a clock of 1 ms is too coarse)"
    )
