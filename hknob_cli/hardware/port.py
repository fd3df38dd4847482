"""The device port: what every driver does for a trial, and what it hands back.

A driver runs the control loop somewhere else (on a target, or in a simulation) and hands back samples in blocks. Times
are the device's. The order of calls is: `configure`, `arm`, `read` while nobody holds the knob, `start`, `read` until
enough, `stop`, `read` until None; `release` ends anything, at any time, and is called whatever is raised.
"""

from enum import Enum
from types import TracebackType
from typing import Any, NamedTuple, Protocol, Self

import numpy as np

from hknob_cli.hardware.simulated import MOST_HANDS as MOST_HANDS
from hknob_cli.hardware.simulated import MOST_SINES as MOST_SINES
from hknob_cli.hardware.simulated import Simulated as Simulated
from hknob_cli.hardware.simulated import Sine as Sine
from hknob_cli.hardware.simulated import Squeeze as Squeeze

ROUNDINGS = ("floor", "nearest", "ceil", "truncate")  # by their numbers on the wire
FIRST_LAWS = 0b1111_1111_1110  # what a target with controllers has that does not say which: the first eleven

Array = np.ndarray[Any, np.dtype[np.float64]]
Counts = np.ndarray[Any, np.dtype[np.int64]]
Flags = np.ndarray[Any, np.dtype[np.bool_]]


class Control(NamedTuple):
    """A controller of the wall as a target computes it.

    ``law``: its number (`wire.codes.Law`); ``numbers`` that its function takes; ``rows``: its memory before the first
    sample, of which the first ``places`` begin with the place at which the knob is.
    """

    law: int
    places: int
    numbers: tuple[float, ...]
    rows: tuple[float, ...]


class Converters(NamedTuple):
    """What lies between the knob's angle and the wall, and between the wall's torque and the motor.

    ``offset_counts``: an edge of the encoder lies so much above its count's angle; ``dead_band_nm``: a smaller torque
    is not sent; ``step_nm`` to whole multiples of which it is rounded, ``limit_nm`` at which it is cut off; of each
    0: none. ``delay_samples``: how long a torque takes; ``rounding``: a place of `ROUNDINGS`.
    """

    offset_counts: float = 0.0
    dead_band_nm: float = 0.0
    step_nm: float = 0.0
    limit_nm: float = 0.0
    delay_samples: float = 0.0
    rounding: int = 0


class PulseOrder(NamedTuple):
    """A pulse that a grip fires, as a device is told (`control`): forces in N, times in s, torque in N·m.

    ``dwell_s``: how long the grip has to stay within ``band_n`` of ``grip_n``; 0: it fires as it reaches ``grip_n``.
    ``release_n``: below which the hand counts as relaxed.
    """

    grip_n: float
    band_n: float
    dwell_s: float
    release_n: float
    torque_nm: float
    width_s: float


class Pulse(NamedTuple):
    """A `PulseOrder` as a target has it: forces in N, torque in N·m, ``width`` and ``dwell`` in samples.

    ``dwell`` 0: it fires as the grip reaches ``grip_n``.
    """

    grip_n: float
    band_n: float
    release_n: float
    torque_nm: float
    width: int
    dwell: int


class OverAngle(NamedTuple):
    """Torque over the measured angle as a target has it: N·m for every count of the wall's encoder from ``first`` on.

    Beyond its ends the table repeats itself every ``turn`` counts, each time with a constant added: ``below`` it, or
    ``above`` it, for each turn up (`engine.general.torque_table`).
    """

    first: int
    turn: int
    below: float
    above: float
    torques: tuple[float, ...]


class Identity(NamedTuple):
    """What a device says it is; ``native_counts`` per revolution of its own encoder; ``boot`` differs after a restart.

    ``simulated``: it has no knob but the simulated one of `Simulated`. ``shortest_period_ns`` of its sample clock.
    ``no_grip_cell``: its grip force is 0 and means nothing. ``own_time``: its clock is simulated too, and may run
    faster or slower than any other. ``knows_zero``: it can make the present angle zero.
    ``knows_control``: it can run controllers; ``knows_pulses``: it can fire a pulse at a grip; ``knows_over_angle``: it
    can run a torque over the angle; ``knows_converters``: it can round, delay and cut off as the spec says;
    ``knows_parts``: its torque can change within a sample interval; ``knows_looks``: it can read its encoder within
    one; ``knows_speed``: it has a sensor of the speed. ``laws``: controllers that it has, a bit each.
    """

    name: str
    native_counts: int
    shortest_period_ns: int
    simulated: bool
    boot: int
    no_grip_cell: bool = False
    own_time: bool = False
    knows_zero: bool = False
    knows_control: bool = False
    knows_pulses: bool = False
    knows_over_angle: bool = False
    knows_converters: bool = False
    knows_parts: bool = False
    knows_looks: bool = False
    knows_speed: bool = False
    laws: int = FIRST_LAWS


class Torque(str, Enum):
    """What is known of the torque after a release: off, not seen, or said by the device to be on."""

    OFF = "off"
    UNSEEN = "unseen"
    ON = "on"


class Drift(NamedTuple):
    """By which share a device's clock is fast, by this computer's clock, and how far that may be wrong."""

    share: float
    uncertainty: float

    @property
    def at_least(self) -> float:
        """The share that the clocks differ by, even if all of the uncertainty were on their side."""
        return max(0.0, abs(self.share) - self.uncertainty)


class Settings(NamedTuple):
    """A trial as the target is told: sample clock, decimated encoder, virtual wall, limits.

    ``period_ns`` of the sample clock; ``counts_per_rev`` of the encoder that the wall sees; ``wall_stiffness`` in
    N·m/rad, ``wall_damping`` in N·m·s/rad, on the differenced coarse angle; torque is cut off at ±``torque_limit_nm``;
    a speed above ``speed_limit_rad_s``, or ``watchdog_us`` without a word from the host, ends the trial at the target.
    ``control``: what acts in place of the wall's spring, or beside it; None: the plain wall. ``pulse``: a pulse that a
    grip fires, in place of a wall. ``over_angle``: in place of the wall's spring, which is in it. ``converters``: None
    where there are none but the target's own.
    """

    period_ns: int
    counts_per_rev: int
    wall_stiffness: float
    wall_damping: float
    torque_limit_nm: float
    speed_limit_rad_s: float
    watchdog_us: int
    block_samples: int
    control: Control | None = None
    pulse: PulseOrder | None = None
    over_angle: OverAngle | None = None
    converters: Converters | None = None

    @property
    def interval_s(self) -> float:
        """Time from sample to sample."""
        return self.period_ns * 1e-9

    @property
    def numbers(self) -> tuple[float, ...]:
        """All but what acts beside the plain wall, in the order of CONFIGURE."""
        numbers: tuple[float, ...] = self.plain[:-4]
        return numbers

    @property
    def plain(self) -> "Settings":
        """These with the plain wall, which is all that CONFIGURE carries."""
        return self._replace(control=None, pulse=None, over_angle=None, converters=None)


class Block(NamedTuple):
    """Consecutive samples, arrays (n,): the first has index ``first``, counted from arming.

    ``time_us`` since arming, by the device's clock; ``angle_counts`` of the device's own encoder; ``torque_nm``
    commanded from this sample to the next; ``grip_n`` as the cell gives it, its zero not subtracted; ``running`` where
    the wall was on. ``overruns``: samples so far for which the loop was late. ``measured_torque_nm`` and
    ``acceleration_rad_s2`` where the device has such a sensor. ``looks`` (n, readings): angles that a controller read
    within the interval before each sample, in counts of the device's own encoder; 0 before it has read any.
    """

    first: int
    time_us: Counts
    angle_counts: Counts
    torque_nm: Array
    grip_n: Array
    running: Flags
    overruns: int
    measured_torque_nm: Array | None = None
    acceleration_rad_s2: Array | None = None
    looks: Counts | None = None


class Device(Protocol):
    """A driver. Every method raises `DeviceError` if the device does not answer, refuses, or has tripped."""

    @property
    def identity(self) -> Identity:
        """Who answers."""

    @property
    def torque(self) -> Torque:
        """What is known of the torque since the last `release`."""

    @property
    def drift(self) -> Drift | None:
        """The device's clock against this computer's in the last trial; None for a device in its own time."""

    def configure(self, settings: Settings, simulated: Simulated | None = None) -> None:
        """Send a trial's settings, and compare what the target says it took with them, value by value.

        ``simulated``: knob, hand and person, for a device that simulates them; ignored by others.
        """

    def arm(self) -> None:
        """Begin to sample, torque off."""

    def start(self) -> None:
        """Switch the wall on; a simulated person takes hold of the knob."""

    def read(self, timeout_s: float) -> Block | None:
        """The next samples, in order, none lost or twice; None if there are none within the time, or no more."""

    def stop(self) -> None:
        """Torque off, sampling ends; what was sampled can still be read."""

    def release(self) -> None:
        """Torque off, whatever state it is in; never raises."""

    def __enter__(self) -> Self:
        """Open the device."""

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Release and close it."""


class ComputedDevice:
    """What devices without a motor and a clock of their own share."""

    @property
    def torque(self) -> Torque:
        """Off: there is no motor."""
        return Torque.OFF

    @property
    def drift(self) -> Drift | None:
        """None: it has no clock."""
        return None

    def release(self) -> None:
        """End it, whatever state it is in."""
        raise NotImplementedError

    def __enter__(self) -> Self:
        """Open the device."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Release it."""
        self.release()
