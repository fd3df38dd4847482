"""The serial driver: a target at any port or URL that pyserial opens, spoken to as docs/reference/wire.md says.

So a host tells a target the numbers of each trial over a network, and gets its samples (Hasser, section 3.2).
"""

import contextlib
import secrets
import threading
import time
from collections.abc import Callable
from types import TracebackType
from typing import Any, Self

from hknob_cli.errors import DeviceError
from hknob_cli.hardware.order import faults
from hknob_cli.hardware.port import Block, Drift, Identity, Settings, Simulated, Torque
from hknob_cli.hardware.safety import undisturbed
from hknob_cli.hardware.wire.answers import Abilities, About, Ack
from hknob_cli.hardware.wire.codes import STATUS_TEXT, TRIP_TEXT, Kind, State, Status
from hknob_cli.hardware.wire.commands import Command, Plain, Zero
from hknob_cli.hardware.wire.messages import nobody_text
from hknob_cli.hardware.wire.pump import Pump, open_port
from hknob_cli.hardware.wire.sending import Sent, differences, told_of
from hknob_cli.hardware.wire.session import Session

BAUD = 921_600
KNOWS_CONVERTERS, KNOWS_PARTS, KNOWS_LOOKS = 1, 2, 4  # of `Abilities`
# After RELEASE was answered the line is listened to for two of the longest blocks: what goes on sampling shows itself.
LISTEN_S = 0.1
# Where the torque stays RELEASE is sent again, and said again, until the port closes.
INSIST_S, INSIST_EVERY_S, SAY_EVERY_S = 3.0, 0.1, 1.0
TORQUE_ON = "THE TORQUE IS STILL ON: switch the amplifier off by hand"


class SerialDevice:
    """A target behind a serial port; a context manager, whose methods may be called from any thread.

    ``url``: a port's name, or `socket://`, `rfc2217://`, ...; ``patience_s``: how long it may take to answer at first
    (a board may restart when its port is opened); ``zero_angle``: the angle of the knob when the port is opened becomes
    0; ``alarm`` is told, at once and again, of torque that stays. Messages of every `DeviceError` begin with the URL.
    """

    def __init__(
        self,
        url: str,
        *,
        baud: int = BAUD,
        patience_s: float = 3.0,
        zero_angle: bool = False,
        alarm: Callable[[str], None] = lambda _text: None,
    ) -> None:
        self.url = url
        self._zero_angle = zero_angle
        self._alarm = alarm
        self._torque = Torque.UNSEEN
        self._baud = baud
        self._patience_s = patience_s
        self._identity: Identity | None = None
        self._agreed = self._says_abilities = False
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

    @property
    def torque(self) -> Torque:
        """What is known of the torque since the last `release`."""
        return self._torque

    @property
    def drift(self) -> Drift | None:
        """The target's clock against this computer's in the last trial; None for a target in its own time."""
        return None if self.identity.own_time else self._session.clock.drift()

    def configure(self, settings: Settings, simulated: Simulated | None = None) -> None:
        """Send settings, and the simulated knob to a target that has one; compare what it took with them."""
        self._agreed = False
        if seen := self._seen():  # after the release of the trial before, and only now
            raise DeviceError(f"{self.url}: {seen}")
        out_of_range = faults(settings, self.identity)
        if out_of_range:
            raise DeviceError(f"{self.url}: {'; '.join(out_of_range)}")
        for sent, make in told_of(settings, simulated if self.identity.simulated else None):
            self._agree(sent, make)
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
        """Torque off, whatever state it is in; never raises. Without a link, the target's watchdog does it.

        `torque` then says what the target answered, and what its samples show.
        """
        pump = self._pump
        if pump is None:
            return
        why = self._release(pump)
        if why:
            self._alarm(f"{self.url}: {TORQUE_ON}. {why}")

    def _release(self, pump: Pump) -> str:
        """Send RELEASE and look what becomes of it; why the torque is on, empty where it is not or cannot be seen."""
        answer, seen = None, ""
        if pump.broken is None:
            with contextlib.suppress(DeviceError):
                # In place of any command under way, so not under its lock.
                answer = self._ask(pump, lambda nonce: Plain(Kind.RELEASE, nonce))
        if answer is not None:
            until = time.monotonic() + LISTEN_S
            with pump.changed:
                while not (seen := self._seen()) and pump.broken is None and (left := until - time.monotonic()) > 0:
                    pump.changed.wait(left)
        self._torque = Torque.ON if seen else Torque.OFF if answer is not None else Torque.UNSEEN
        return seen

    def _seen(self) -> str:
        released = self._session.released
        return released.seen if released is not None else ""

    def __enter__(self) -> Self:
        """Open the port and ask who is there. Raises DeviceError; nothing is left open then."""
        self._port = open_port(self.url, baud=self._baud)
        self._session = Session(first_nonce=secrets.randbits(32))
        self._pump = Pump(self._port, self._session)
        try:
            self._pump.start()
            about, boot = self._greet(self._pump)
            self._identity = _identity_of(about, boot)
            self._says_abilities = about.knows_abilities
            self.release()  # whatever an earlier program left behind
            if self._torque is Torque.UNSEEN:
                raise DeviceError(f"{self.url}: the target did not answer when told to release")
            if self._torque is Torque.ON:
                self._insist(self._pump)
                raise DeviceError(f"{self.url}: {TORQUE_ON}. {self._seen()}")
            self._ask_abilities()
            if self._zero_angle:
                self._make_zero()
        except BaseException:
            self._close()
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Release, end the thread, close the port. Raises `DeviceError` where the torque stays on."""
        pump = self._pump
        try:
            with undisturbed():
                why = self._release(pump) if pump is not None else ""
                if why and pump is not None:
                    self._insist(pump)
        finally:
            self._close()
            if self._torque is Torque.ON:
                raise error if isinstance(error, DeviceError) else DeviceError(f"{self.url}: {TORQUE_ON}")

    def _insist(self, pump: Pump) -> None:
        """RELEASE again and again for `INSIST_S`, said again every second, unless the torque goes off at last."""
        begin = said = time.monotonic()
        while self._torque is Torque.ON and pump.broken is None and (now := time.monotonic()) < begin + INSIST_S:
            why = self._release(pump)
            if why and now - said >= SAY_EVERY_S:
                said = now
                self._alarm(f"{self.url}: {TORQUE_ON}. {why}; RELEASE is sent again")
            time.sleep(INSIST_EVERY_S)

    def _ask_abilities(self) -> None:
        """What a target knows that has no flag in its answer to HELLO; one of before has none of it."""
        if not self._says_abilities:
            return
        said = self._command(lambda nonce: Plain(Kind.ABILITIES, nonce), "say what it knows").said
        if not isinstance(said, Abilities):
            raise DeviceError(f"{self.url}: the target did not say what it knows (docs/reference/wire.md, ABILITIES)")
        self._identity = self.identity._replace(
            laws=said.laws,
            knows_converters=bool(said.knows & KNOWS_CONVERTERS),
            knows_parts=bool(said.knows & KNOWS_PARTS),
            knows_looks=bool(said.knows & KNOWS_LOOKS),
        )

    def _make_zero(self) -> None:
        if not self.identity.knows_zero:
            raise DeviceError(
                f"{self.url}: zero_angle: the target '{self.identity.name}' does not know ZERO (docs/reference/wire.md)"
            )
        said = self._command(lambda nonce: Zero(nonce, 0), "make the present angle zero").said
        if said != 0:
            raise DeviceError(f"{self.url}: zero_angle: the target was told angle 0, and took {said}")

    def _close(self) -> None:
        pump, port, self._pump, self._port = self._pump, self._port, None, None
        self._agreed = False
        if pump is not None:
            pump.end()
        if port is not None:
            with contextlib.suppress(OSError):
                port.close()

    def _greet(self, pump: Pump) -> tuple[About, int]:
        until = time.monotonic() + self._patience_s
        while True:
            ack = self._ask(pump, lambda nonce: Plain(Kind.HELLO, nonce), give_up_at=until)
            if ack is not None and isinstance(ack.said, About):
                return ack.said, ack.boot
            if time.monotonic() >= until:
                raise DeviceError(f"{self.url}: {self._nobody()}")

    def _nobody(self) -> str:
        session = self._session
        return nobody_text(
            session.unread,
            versions=session.versions,
            echoed=session.echoed,
            amid=session.is_amid,
            baud=self._baud,
            patience_s=self._patience_s,
        )

    def _agree(self, sent: Sent, make: Callable[[int], Command]) -> None:
        differing = differences(sent, self._command(make, "take the settings of a trial").said)
        if differing:
            raise DeviceError(f"{self.url}: the target took other values, and was not armed: {'; '.join(differing)}")

    def _do(self, kind: Kind) -> None:
        if kind in (Kind.START, Kind.STOP):  # of a trial that has failed, its reason: the target has been released
            self._raise_failure(self._running())
        self._command(lambda nonce: Plain(kind, nonce), kind.name.lower())

    def _command(self, make: Callable[[int], Command], verb: str) -> Ack:
        """Send a command and wait for its answer. Raises DeviceError if there is none, or it is a refusal."""
        pump = self._running()
        with self._one_command:
            before = self._session.failure
            ack = self._ask(pump, make)
        if self._session.failure != before:
            with pump.changed:
                self._raise_failure(pump)
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


def _identity_of(about: About, boot: int) -> Identity:
    """Who a target says it is."""
    said = about._asdict()
    return Identity(boot=boot, **{name: said[name] for name in Identity._fields if name in said})
