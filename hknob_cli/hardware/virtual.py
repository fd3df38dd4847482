"""The control loop of a virtual trial: what `docs/reference/wire.md` asks of a target, at a simulated knob.

Times are whole microseconds, rounded down; the device's own encoder rounds down. The torque is computed, and acts, in
double precision. Torque and grip are handed on rounded to single precision, as the wire does, so that a trial here and
the same trial over the wire give the same samples.

The virtual device: a simulated knob behind the device port, in its own time, as fast as it can.

Samples come into being when they are read: `start` and `stop` take effect between blocks. There is no watchdog: nothing
happens here while the host is silent.
"""

from enum import IntEnum
from math import floor, isfinite, tau
from typing import NoReturn, Protocol

import numpy as np

from hknob_cli.errors import DeviceError
from hknob_cli.hardware.control import looks_of, senses_speed
from hknob_cli.hardware.knob_motion import Disturbances, KnobMotion, Nuisances
from hknob_cli.hardware.order import faults_of_settings, faults_of_simulated
from hknob_cli.hardware.port import Array, Block, ComputedDevice, Counts, Identity, Settings, Simulated, Sine
from hknob_cli.hardware.trial_wall import Sent, TrialWall
from hknob_cli.hardware.wire.codes import ALL_LAWS
from hknob_cli.specs.motor import Coil

_MOST_COUNTS = 2**31
NOTHING = Sent(0.0)

NATIVE_COUNTS = 640_000  # of the encoder on the dissertation's apparatus (Hasser, ch. 3)
SHORTEST_PERIOD_NS = 1000
_KNOWN = ("control", "pulses", "over_angle", "converters", "parts", "looks", "speed")
_KNOWS = {f"knows_{what}": True for what in _KNOWN}
IDENTITY = Identity("virtual", NATIVE_COUNTS, SHORTEST_PERIOD_NS, True, 1, **_KNOWS, laws=ALL_LAWS)


class MovingKnob(Protocol):
    """What moves between samples."""

    @property
    def angle_counts(self) -> float:
        """Angle in counts, whole and broken."""

    @property
    def speed_counts(self) -> float:
        """Speed in counts of a sample period."""

    def move(self, torque_nm: float, push_nm: float, periods: float = 1.0) -> None:
        """Move for some sample periods under a commanded torque, and a push into the wall, both constant."""


class VirtualLoop:
    """The control loop of one trial, from arming on; ``fault`` says why it tripped."""

    def __init__(
        self,
        settings: Settings,
        simulated: Simulated,
        nuisances: Nuisances,
        native_counts: int,
        coil: Coil | None = None,
    ) -> None:
        self.fault = ""
        self._settings, self._simulated, self._native = settings, simulated, native_counts
        self._motion: MovingKnob = KnobMotion(
            simulated,
            interval_s=settings.interval_s,
            counts_per_rev=native_counts,
            amplifier_s=nuisances.amplifier_s,
            coil=coil,
        )
        self._disturbances = Disturbances(nuisances, settings, simulated)
        self._index, self._overruns = 0, 0
        self._counts: int | None = None  # at the sample before, and of the wall's encoder
        self._coarse: int | None = None
        self._began: float | None = None  # when the wall was switched on, in periods
        self._held: tuple[Sent, float] | None = None  # torques and push since the sample before, which began at
        self._last = 0.0
        self._wall = TrialWall(settings, native_counts)
        self._looks = looks_of(settings.control)
        self._looked = [0] * len(self._looks)  # angles that were last read within an interval
        later = [(begins, i, -1) for i, begins in enumerate(self._wall.begins[1:])]
        self._within = sorted(later + [(at, -1, i) for i, at in enumerate(self._looks)])
        self._senses = senses_speed(settings.control)
        self._noise = 0.0  # of the encoder at the last sample, in counts
        self._told_us = -1

    def block(self, *, running: bool) -> Block:
        """The next samples: as many as a block has, or fewer if it trips."""
        count = self._settings.block_samples
        begins, late = self._disturbances.begins(count)
        noise = self._disturbances.angle_rad(count) * (self._native / tau)
        pushes, grips = self._person(begins, running)
        grips = grips + self._disturbances.grip_n(count)
        self._shown(grips)
        angles, torques = np.zeros(count, dtype=np.int64), np.zeros(count)
        on = np.full(count, running)
        looks = np.zeros((count, len(self._looks)), dtype=np.int64)
        taken = count
        for i, (begin, push, extra) in enumerate(zip(begins.tolist(), pushes.tolist(), noise.tolist(), strict=True)):
            if self._held is not None:
                self._move(*self._held, begin - self._last)
                looks[i] = self._looked
            # A speed is over the time that passed, which is longer than a period after a late sample.
            passed_s = max(1.0, begin - self._last) * self._settings.interval_s
            self._noise = extra
            angles[i], sent = self._sample(self._index + i, self._motion.angle_counts + extra, passed_s, running)
            if self.fault:
                on[i], taken = False, i + 1
                break
            torques[i] = sent.torque_nm
            self._held, self._last = ((sent, push) if running else None), begin
        first, self._index = self._index, self._index + taken
        self._overruns += int((late[:taken] > 0.5).sum())
        return Block(
            first=first,
            time_us=self._microseconds(begins[:taken]),
            angle_counts=angles[:taken],
            torque_nm=as_single(torques[:taken]),
            grip_n=as_single(grips[:taken]),
            running=on[:taken],
            overruns=self._overruns,
            looks=looks[:taken] if self._looks else None,
        )

    def _move(self, sent: Sent, push: float, periods: float) -> None:
        """From sample to sample, or as far as the next is away, under the torques of the interval.

        A reading within the interval has the noise of the sample before. One that the next sample comes before is that
        of this sample's instant.
        """
        torque, passed, looked = sent.torque_nm, 0.0, 0
        for at, later, look in self._within:
            if at >= periods:
                break
            self._motion.move(torque, push, at - passed)
            passed = at
            if look < 0:
                torque = sent.later[later]
            else:
                self._look(look)
                looked = look + 1
        self._motion.move(torque, push, periods - passed)
        for look in range(looked, len(self._looks)):
            self._look(look)

    def _look(self, look: int) -> None:
        """Read the encoder within the interval."""
        assert self._wall.controlled is not None
        position = self._motion.angle_counts + self._noise
        if -_MOST_COUNTS <= position < _MOST_COUNTS:
            self._looked[look] = floor(position)
            self._wall.controlled.look(look, self._wall.count(self._looked[look]))

    def _sample(self, index: int, position: float, passed_s: float, running: bool) -> tuple[int, Sent]:
        """Angle in counts and torques from a sample on, in the order of the wire; a fault means none, and is noted."""
        settings = self._settings
        if not -_MOST_COUNTS <= position < _MOST_COUNTS:  # nor is it where it is not a number
            self.fault = f"the angle is no number that it can tell, at sample {index}"
            return self._counts or 0, NOTHING
        counts = floor(position)
        before, self._counts = self._counts, counts
        coarse = self._wall.count(counts)
        coarse_before, self._coarse = self._coarse, coarse
        if before is not None:
            speed = abs(counts - before) * (tau / self._native) / passed_s
            if speed > settings.speed_limit_rad_s:
                limit = f"limit {settings.speed_limit_rad_s:g} rad/s"
                self.fault = f"the knob moved at {speed:.4g} rad/s, {limit}, at sample {index}"
                return counts, NOTHING
        sent = self._commanded(index, coarse, coarse if coarse_before is None else coarse_before, running)
        if not isfinite(sent.torque_nm):
            self.fault = f"the torque is not a number, at sample {index}"
            return counts, NOTHING
        return counts, sent

    def _commanded(self, _index: int, coarse: int, before: int, running: bool) -> Sent:
        """Torques of the wall, limited."""
        if self._senses and self._wall.controlled is not None:
            self._wall.controlled.sense(self._motion.speed_counts * (self._settings.counts_per_rev / self._native))
        return self._wall.torques(coarse, before) if running else NOTHING

    def _person(self, begins: Array, running: bool) -> tuple[Array, Array]:
        """Push (N·m) and what the grip cell shows (N) at the samples of a block."""
        person = self._simulated
        if not running:
            return np.zeros(begins.size), np.full(begins.size, person.grip_offset_n)
        if self._began is None:
            self._began = float(begins[0])
        t = (begins - self._began) * self._settings.interval_s
        risen = -np.expm1(-t / person.grip_rise_s) if person.grip_rise_s > 0.0 else np.ones(t.size)
        push = np.maximum(0.0, person.push_nm + _sum(person.push_sines, t))
        return push, person.grip_n * risen + _sum(person.grip_sines, t) + person.grip_offset_n

    def _shown(self, grips: Array) -> None:
        """What the grip cell shows at the samples of a block, before any of them: nothing depends on it here."""

    def _microseconds(self, begins: Array) -> Counts:
        # Whole periods and the rest apart: a product of floats would round some exact times down by one.
        whole = np.floor(begins).astype(np.int64)
        rest = ((begins - whole) * self._settings.period_ns).astype(np.int64)
        found = (whole * self._settings.period_ns + rest) // 1000
        # A sample that follows at once on a late one may be in the same microsecond: times rise all the same.
        rank = np.arange(found.size)
        found = np.maximum.accumulate(np.maximum(found, self._told_us + 1) - rank) + rank
        self._told_us = int(found[-1])
        return np.asarray(found, dtype=np.int64)


def _sum(sines: tuple[Sine, ...], t: Array) -> Array:
    total = np.zeros(t.size)
    for sine in sines:
        total += sine.amplitude * np.sin(tau * sine.frequency_hz * t + sine.phase)
    return total


def as_single(values: Array) -> Array:
    """Values to single precision, as they travel."""
    return values.astype(np.float32).astype(np.float64)


class State(IntEnum):
    """As the wire numbers them."""

    IDLE = 0
    ARMED = 1
    RUNNING = 2
    TRIPPED = 3


class VirtualDevice(ComputedDevice):
    """A knob that is computed; ``nuisances`` of its sensors, amplifier and clock, none if not given.

    ``coil``: a winding on the knob that remembers, in trials of a wall.
    """

    def __init__(
        self, nuisances: Nuisances | None = None, *, identity: Identity = IDENTITY, coil: Coil | None = None
    ) -> None:
        """Make ready. Raises `UsageError` for nuisances out of range."""
        self._coil = coil
        self.nuisances = (nuisances or Nuisances()).checked()
        self._identity = identity
        self._settings: Settings | None = None
        self._simulated: Simulated | None = None
        self._trial: VirtualLoop | None = None
        self._state = State.IDLE

    @property
    def identity(self) -> Identity:
        """Who answers."""
        return self._identity

    @property
    def state(self) -> State:
        """Idle, armed, running or tripped."""
        return self._state

    def configure(self, settings: Settings, simulated: Simulated | None = None) -> None:
        """Take a trial's settings, and who holds the knob. Raises `DeviceError` if a value is out of range."""
        self._must_be(State.IDLE)
        faults = faults_of_settings(settings, self._identity) + (faults_of_simulated(simulated) if simulated else [])
        if faults:
            raise DeviceError(f"the device refuses the settings: {'; '.join(faults)}")
        self._settings = settings
        self._simulated = simulated or self._simulated

    def arm(self) -> None:
        """Begin to sample, torque off. Raises `DeviceError` if the device is not idle, or not configured."""
        self._must_be(State.IDLE)
        if self._settings is None or self._simulated is None:
            missing = "settings" if self._settings is None else "a simulated knob and person"
            raise DeviceError(f"the virtual device cannot be armed: it was given no {missing}")
        native, coil = self._identity.native_counts, self._coil
        if self._settings.pulse is not None:
            if not self._simulated.squeeze:
                raise DeviceError("the virtual device cannot be armed: nobody squeezes its knob")
            from hknob_cli.hardware.pulse_loop import PulseLoop

            self._trial = PulseLoop(self._settings, self._simulated, self.nuisances, native)
        else:
            self._trial = VirtualLoop(self._settings, self._simulated, self.nuisances, native, coil)
        self._state = State.ARMED

    def start(self) -> None:
        """Switch the wall on from the next sample on. Raises `DeviceError` if the device is not armed."""
        self._must_be(State.ARMED)
        self._state = State.RUNNING

    def read(self, timeout_s: float) -> Block | None:  # noqa: ARG002 - nothing takes time here
        """The next block, at once; None after `stop`.

        Raises `DeviceError` if the device has tripped and all samples are read, or has not been armed.
        """
        if self._trial is None:
            raise DeviceError("the virtual device was not armed: there is nothing to read")
        if self._state is State.TRIPPED:
            self._refuse_tripped()
        if self._state is State.IDLE:
            return None
        block = self._trial.block(running=self._state is State.RUNNING)
        if self._trial.fault:
            self._state = State.TRIPPED
        return block

    def stop(self) -> None:
        """Torque off, sampling ends. Raises `DeviceError` if the device is neither armed nor running."""
        self._must_be(State.ARMED, State.RUNNING)
        self._state = State.IDLE

    def release(self) -> None:
        """Torque off, whatever state the device is in."""
        self._state, self._trial = State.IDLE, None

    def _must_be(self, *states: State) -> None:
        if self._state is State.TRIPPED:
            self._refuse_tripped()
        if self._state not in states:
            allowed = " or ".join(state.name.lower() for state in states)
            raise DeviceError(f"the virtual device is {self._state.name.lower()}; it must be {allowed} for that")

    def _refuse_tripped(self) -> NoReturn:
        assert self._trial is not None
        raise DeviceError(f"the virtual device has tripped, its torque is off: {self._trial.fault}")
