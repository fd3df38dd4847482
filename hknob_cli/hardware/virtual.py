"""The virtual device: a simulated knob behind the device port, in its own time, as fast as it can.

Samples come into being when they are read: `start` and `stop` take effect between blocks. There is no watchdog: nothing
happens here while the host is silent.
"""

from enum import IntEnum
from types import TracebackType
from typing import NoReturn, Self

from hknob_cli.errors import DeviceError
from hknob_cli.hardware.nuisances import Nuisances
from hknob_cli.hardware.port import Block, Drift, Identity, Settings, Torque
from hknob_cli.hardware.ranges import faults_of_settings, faults_of_simulated
from hknob_cli.hardware.simulated import Simulated
from hknob_cli.hardware.virtual_loop import VirtualLoop

NATIVE_COUNTS = 640_000  # of the encoder on the dissertation's apparatus (Hasser, ch. 3)
SHORTEST_PERIOD_NS = 1000
IDENTITY = Identity("virtual", NATIVE_COUNTS, SHORTEST_PERIOD_NS, True, 1)


class State(IntEnum):
    """As the wire numbers them."""

    IDLE = 0
    ARMED = 1
    RUNNING = 2
    TRIPPED = 3


class VirtualDevice:
    """A knob that is computed; ``nuisances`` of its sensors, amplifier and clock, none if not given."""

    def __init__(self, nuisances: Nuisances | None = None, *, identity: Identity = IDENTITY) -> None:
        """Make ready. Raises `UsageError` for nuisances out of range."""
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

    @property
    def torque(self) -> Torque:
        """Off: there is no motor."""
        return Torque.OFF

    @property
    def drift(self) -> Drift | None:
        """None: it has no clock."""
        return None

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
        self._trial = VirtualLoop(self._settings, self._simulated, self.nuisances, self._identity.native_counts)
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

    def __enter__(self) -> Self:
        """Open the device."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Release it."""
        self.release()

    def _must_be(self, *states: State) -> None:
        if self._state is State.TRIPPED:
            self._refuse_tripped()
        if self._state not in states:
            allowed = " or ".join(state.name.lower() for state in states)
            raise DeviceError(f"the virtual device is {self._state.name.lower()}; it must be {allowed} for that")

    def _refuse_tripped(self) -> NoReturn:
        fault = self._trial.fault if self._trial else ""
        raise DeviceError(f"the virtual device has tripped, its torque is off: {fault}")
