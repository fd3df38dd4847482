"""The serial driver: a target at any port or URL that pyserial opens, spoken to as docs/wire.md says."""

import contextlib
import secrets
import threading
import time
from collections.abc import Callable
from types import TracebackType
from typing import Any, Self

from hknob_cli.errors import DeviceError
from hknob_cli.hardware.port import Block, Identity, Settings
from hknob_cli.hardware.simulated import Simulated
from hknob_cli.hardware.wire.answers import About, Ack
from hknob_cli.hardware.wire.codes import STATUS_TEXT, TRIP_TEXT, VERSION, Kind, State, Status
from hknob_cli.hardware.wire.commands import Command, Configure, Plain, Simulate
from hknob_cli.hardware.wire.echo import differences
from hknob_cli.hardware.wire.opening import open_port
from hknob_cli.hardware.wire.pump import Pump
from hknob_cli.hardware.wire.ranges import faults
from hknob_cli.hardware.wire.session import Session

BAUD = 921_600


class SerialDevice:
    """A target behind a serial port; a context manager, whose methods may be called from any thread.

    ``url``: a port's name, or `socket://`, `rfc2217://`, ...; ``patience_s``: how long it may take to answer at first
    (a board may restart when its port is opened). Messages of every `DeviceError` begin with the URL.
    """

    def __init__(self, url: str, *, baud: int = BAUD, patience_s: float = 3.0) -> None:
        self.url = url
        self._baud = baud
        self._patience_s = patience_s
        self._identity: Identity | None = None
        self._agreed = False
        self._port: Any = None
        self._pump: Pump | None = None
        self._session = Session(first_nonce=secrets.randbits(32))
        self._one_command = threading.Lock()

    @property
    def identity(self) -> Identity:
        """Who answered when the port was opened."""
        if self._identity is None:
            raise DeviceError(f"{self.url}: the port is not open")
        return self._identity

    def configure(self, settings: Settings, simulated: Simulated | None = None) -> None:
        """Send settings, and the simulated knob to a target that has one; compare what it took with them."""
        self._agreed = False
        out_of_range = faults(settings, self.identity)
        if out_of_range:
            raise DeviceError(f"{self.url}: {'; '.join(out_of_range)}")
        self._agree(settings, lambda nonce: Configure(nonce, settings))
        if simulated is not None and self.identity.simulated:
            self._agree(simulated, lambda nonce: Simulate(nonce, simulated))
        self._agreed = True

    def arm(self) -> None:
        """Begin to sample, torque off."""
        if not self._agreed:
            raise DeviceError(f"{self.url}: not armed: the target has not taken the settings of a trial")
        self._do(Kind.ARM)

    def start(self) -> None:
        """Switch the wall on."""
        self._do(Kind.START)

    def stop(self) -> None:
        """Torque off, sampling ends; what was sampled can still be read."""
        self._do(Kind.STOP)

    def read(self, timeout_s: float) -> Block | None:
        """The next block; None if none comes within the time. After `stop`, None only when all were read.

        Raises `DeviceError`, when all that came before has been read, if the target tripped or the link is dead.
        """
        pump, until = self._running(), time.monotonic() + timeout_s
        with pump.changed:
            while True:
                block = self._session.take()
                if block is not None:
                    return block
                self._raise_failure(pump)
                left = until - time.monotonic()
                if self._session.is_finished or (left <= 0 and not self._session.is_stopped):
                    return None
                # After a stop the session itself bounds how long the rest may take.
                pump.changed.wait(0.05 if left <= 0 else min(left, 0.05))

    def release(self) -> None:
        """Torque off, whatever state it is in; never raises. Without a link, the target's watchdog does it."""
        pump = self._pump
        if pump is not None and pump.broken is None:
            with contextlib.suppress(DeviceError):
                # In place of any command under way, so not under its lock.
                self._ask(pump, lambda nonce: Plain(Kind.RELEASE, nonce))

    def __enter__(self) -> Self:
        """Open the port and ask who is there. Raises DeviceError; nothing is left open then."""
        self._port = open_port(self.url, baud=self._baud)
        self._session = Session(first_nonce=secrets.randbits(32))
        self._pump = Pump(self._port, self._session)
        try:
            self._pump.start()
            self._identity = self._greet(self._pump)
            self._do(Kind.RELEASE)  # whatever an earlier program left behind
        except BaseException:
            self._close()
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Release, end the thread, close the port."""
        try:
            self.release()
        finally:
            self._close()

    def _close(self) -> None:
        pump, port, self._pump, self._port = self._pump, self._port, None, None
        self._agreed = False
        if pump is not None:
            pump.end()
        if port is not None:
            with contextlib.suppress(OSError):
                port.close()

    def _greet(self, pump: Pump) -> Identity:
        until = time.monotonic() + self._patience_s
        while True:
            ack = self._ask(pump, lambda nonce: Plain(Kind.HELLO, nonce), give_up_at=until)
            if ack is not None and isinstance(ack.said, About):
                return Identity(
                    name=ack.said.name,
                    native_counts=ack.said.native_counts,
                    shortest_period_ns=ack.said.shortest_period_ns,
                    simulated=ack.said.simulated,
                    boot=ack.boot,
                )
            if time.monotonic() >= until:
                raise DeviceError(f"{self.url}: {self._nobody()}")

    def _nobody(self) -> str:
        session = self._session
        if session.versions:
            spoken = ", ".join(map(str, sorted(session.versions)))
            return (
                f"the target speaks version {spoken} of the protocol, this program version {VERSION}: renew one of them"
            )
        if session.echoed:
            return "the port sends back what it is sent: it is a loop or a terminal, not a target"
        if session.damaged:
            return f"what comes from this port is not the protocol (docs/wire.md); is {self._baud} its baud rate?"
        return f"nobody answered within {self._patience_s:g} s: is the target on, and does it run the firmware?"

    def _agree(self, sent: Settings | Simulated, make: Callable[[int], Command]) -> None:
        differing = differences(sent, self._command(make, "take the settings of a trial").said)
        if differing:
            raise DeviceError(f"{self.url}: the target took other values, and was not armed: {'; '.join(differing)}")

    def _do(self, kind: Kind) -> None:
        self._command(lambda nonce: Plain(kind, nonce), kind.name.lower())

    def _command(self, make: Callable[[int], Command], verb: str) -> Ack:
        """Send a command and wait for its answer. Raises DeviceError if there is none, or it is a refusal."""
        pump = self._running()
        with self._one_command:
            ack = self._ask(pump, make)
        if ack is None:
            with pump.changed:
                self._raise_failure(pump)
            raise DeviceError(
                f"{self.url}: the target did not answer when told to {verb}; its watchdog takes torque off"
            )
        if ack.status is Status.DONE:
            return ack
        if ack.state is State.TRIPPED:
            raise DeviceError(f"{self.url}: the target took its torque off: {TRIP_TEXT[ack.fault]}")
        reason = STATUS_TEXT[ack.status]
        raise DeviceError(f"{self.url}: the target refused to {verb}: {reason} ({ack.state.name.lower()})")

    def _ask(self, pump: Pump, make: Callable[[int], Command], *, give_up_at: float = float("inf")) -> Ack | None:
        """The answer to a command, or None if it was given up, replaced by another, or the port broke."""
        with pump.changed:
            nonce = self._session.command(make)
            while self._session.is_waiting(nonce) and pump.broken is None and time.monotonic() < give_up_at:
                pump.changed.wait(0.05)
            answer = self._session.answer
        if pump.broken is not None:
            raise DeviceError(f"{self.url}: the port is gone: {pump.broken}")
        return answer if answer is not None and answer.nonce == nonce else None

    def _running(self) -> Pump:
        if self._pump is None:
            raise DeviceError(f"{self.url}: the port is not open")
        return self._pump

    def _raise_failure(self, pump: Pump) -> None:
        if self._session.failure is not None:
            raise DeviceError(f"{self.url}: {self._session.failure}")
        if pump.broken is not None:
            raise DeviceError(f"{self.url}: the port is gone, is the cable in? {pump.broken}")
