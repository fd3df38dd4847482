"""A target made up for tests: it speaks the protocol with a signal known in advance, and misbehaves as it is told.

`FakeTarget` is logic alone, in a time that the caller gives; `PtyTarget` runs one behind a pseudo-terminal.
"""

import contextlib
import os
import random
import select
import socket
import threading
import time
import tty
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np

from hknob_cli.hardware.port import Block, Settings, Simulated
from hknob_cli.hardware.wire.answers import Abilities, About, Ack, Event, Samples
from hknob_cli.hardware.wire.codes import UNPACK_ACT, Kind, State, Status, Trip
from hknob_cli.hardware.wire.commands import Again, Alive, Configure, Plain, SetAct, Simulate
from hknob_cli.hardware.wire.messages import Decoder, Message, decode, encode, frame

ROOM_S = 0.25


def made_up(first: int, count: int, period_us: float, *, started: int | None, overruns: int = 0) -> Block:
    """Samples of the known signal; ``started``: index from which the wall is on."""
    index = np.arange(first, first + count)
    torque = (index % 97 * 1e-3).astype(np.float32).astype(np.float64)
    grip = (index % 31 * 0.25).astype(np.float64)
    running = index >= started if started is not None else np.zeros(count, bool)
    return Block(first, (index * period_us).astype(np.int64), -7 * index % 1000, torque, grip, running, overruns)


@dataclass
class Manners:
    """How the target misbehaves; without arguments, not at all."""

    alter: Callable[[Any], Any] = lambda values: values  # of what it says it took
    mute: bool = False
    simulated: bool = True
    outside: bool = False  # the wall, where the made-up angles are: it has no torque there, as was agreed
    knows_acts: bool = False  # pulses, torques over the angle, converters
    abilities: int | None = 0b11_1111_1111_1110  # laws that it says it has; None: it does not know the question
    knows: int = 3  # what else it says that it knows
    own_time: bool = False  # it says that its clock is made up, too: nobody holds it against this computer's
    late_s: float = 0.0
    version: int = 1
    trip: tuple[int, Trip] | None = None  # once this block is made
    restart_at: int | None = None  # block at which it starts anew
    cut_at: int | None = None  # block after which the link is cut
    silent_at: int | None = None  # block from which on it sends nothing
    backwards_at: int | None = None  # block whose times run backwards
    shifted_at: int | None = None  # block whose first index is one too high
    hide: set[int] = field(default_factory=set)  # blocks never sent, whatever is asked
    out: Callable[[bytes], bytes] = lambda data: data  # what becomes of frames on their way to the host


class FakeTarget:
    """Commands in, frames out; all times in seconds, given."""

    def __init__(self, manners: Manners | None = None, *, boot: int = 0xB007) -> None:
        self.manners = manners or Manners()
        self.boot = boot
        self.state = State.IDLE
        self.settings: Settings | None = None
        self.simulated: Simulated | None = None
        self.heard: list[Kind] = []
        self.host_has = 0
        self.run = 0
        self.blocks: list[Samples] = []
        self.torque_off_at: float | None = None
        self.slack = 1.0
        self.last_word = 0.0
        self._decoder = Decoder()
        self._armed_at = 0.0
        self._started: int | None = None
        self._done: tuple[int, Ack] | None = None
        self._event: Event | None = None
        self._event_at = 0.0
        self._later: list[tuple[float, bytes]] = []

    def feed(self, data: bytes, *, now: float) -> bytes:
        """Frames that answer what came."""
        out = b""
        for body in self._decoder.feed(data):
            message = decode(body)
            if message is None:
                continue
            self.last_word = now
            self.heard.append(message.kind)
            out += self._answer(message, now)
        if self.manners.late_s:
            self._later.append((now + self.manners.late_s, out))
            return b""
        return out

    def go_on(self, now: float) -> bytes:
        """Samples up to now, and what else is due."""
        out = b"".join(data for at, data in self._later if at <= now)
        self._later = [each for each in self._later if each[0] > now]
        settings = self.settings
        if settings is None or self.state is State.IDLE:
            return out
        if self.state is State.TRIPPED:
            if now - self._event_at >= 0.02 and self._event is not None:
                self._event_at = now
                out += self._send(self._event)
            return out
        made = sum(len(each.samples.time_us) for each in self.blocks)
        taken = int((now - self._armed_at) / settings.interval_s) + 1
        while taken - made >= settings.block_samples and self.state in (State.ARMED, State.RUNNING):
            out += self._make(settings.block_samples)
            made += settings.block_samples
            if self.manners.trip is not None and len(self.blocks) == self.manners.trip[0]:
                out += self._trip(self.manners.trip[1], now)
            elif len(self.blocks) == self.manners.restart_at:
                self.__init__(boot=self.boot + 1)  # type: ignore[misc]
                return out
        if self.state in (State.ARMED, State.RUNNING):
            ahead = (len(self.blocks) - self.host_has) * settings.block_samples * settings.interval_s
            if now - self.last_word > self.slack * settings.watchdog_us * 1e-6:
                out += self._trip(Trip.WATCHDOG, now)
            elif ahead > self.slack * ROOM_S:
                out += self._trip(Trip.NO_ROOM, now)
        return out

    def _answer(self, message: Message, now: float) -> bytes:
        match message:
            case Alive():
                self.host_has = message.expected
            case Again():
                return b"".join(map(self._send, self.blocks[message.first : message.first + message.count]))
            case Plain() | Configure() | SetAct() | Simulate():
                if self._done is not None and self._done[0] == message.nonce:
                    return self._send(self._done[1])
                out, said = self._carry_out(message, now)
                status = said if isinstance(said, Status) else Status.DONE
                told = None if isinstance(said, Status) else said
                fault = self._event.fault if self._event is not None else Trip.NONE
                count = len(self.blocks)
                ack = Ack(message.nonce, message.kind, status, self.state, fault, self.boot, count, told)
                self._done = message.nonce, ack
                return out + self._send(ack)
        return b""

    def _carry_out(self, message: Any, now: float) -> tuple[bytes, Any]:
        out = b""
        match message.kind, self.state:
            case Kind.HELLO, _:
                manners = self.manners
                about = About(10_000, 20_000, simulated=manners.simulated, name="made up", knows_control=True)
                knows = manners.knows_acts
                flags = dict.fromkeys(("knows_pulses", "knows_over_angle", "knows_abilities"), knows)
                return out, about._replace(own_time=manners.own_time, **flags)
            case Kind.ABILITIES, _:
                laws = self.manners.abilities
                return out, Status.NOT_KNOWN if laws is None else Abilities(laws, self.manners.knows)
            case Kind.RELEASE, _:
                self._rest(now)
                self.blocks, self._event = [], None
            case Kind.CONFIGURE, State.IDLE:
                assert isinstance(message, Configure)
                self.settings = message.settings
                return out, self.manners.alter(message.settings)
            case kind, State.IDLE if kind in UNPACK_ACT and self.settings is not None:
                assert isinstance(message, SetAct)
                return out, self.manners.alter(message.act)
            case Kind.SIMULATE, State.IDLE:
                assert isinstance(message, Simulate)
                self.simulated = message.simulated
                return out, self.manners.alter(message.simulated)
            case Kind.ARM, State.IDLE if self.settings is not None:
                self.state, self.run, self.blocks, self.host_has = State.ARMED, message.nonce, [], 0
                self._armed_at, self._started = now, None
            case Kind.START, State.ARMED:
                self.state = State.RUNNING
                self._started = self._taken(now)
            case Kind.STOP, State.ARMED | State.RUNNING:
                made = sum(len(each.samples.time_us) for each in self.blocks)
                short = self._taken(now) - made
                while short > 0:
                    out += self._make(min(short, 48))
                    short -= 48
                self._rest(now)
            case _:
                return out, Status.NOT_NOW
        return out, None

    def _taken(self, now: float) -> int:
        assert self.settings is not None
        return int((now - self._armed_at) / self.settings.interval_s) + 1

    def _rest(self, now: float) -> None:
        self.state = State.IDLE
        self.torque_off_at = now

    def _make(self, count: int) -> bytes:
        assert self.settings is not None
        number, first = len(self.blocks), sum(len(each.samples.time_us) for each in self.blocks)
        samples = made_up(first, count, self.settings.period_ns * 1e-3, started=self._started)
        if self.manners.outside:
            samples = samples._replace(torque_nm=np.zeros(count))
        if number == self.manners.backwards_at:
            samples = samples._replace(time_us=samples.time_us[::-1].copy())
        if number == self.manners.shifted_at:
            samples = samples._replace(first=first + 1)
        self.blocks.append(Samples(self.boot, self.run, number, samples))
        return self._send(self.blocks[-1])

    def _trip(self, fault: Trip, now: float) -> bytes:
        self.state, self.torque_off_at, self._event_at = State.TRIPPED, now, now
        index = sum(len(each.samples.time_us) for each in self.blocks)
        self._event = Event(self.boot, self.run, fault, index, int((now - self._armed_at) * 1e6), len(self.blocks))
        return self._send(self._event)

    def _send(self, message: Message) -> bytes:
        manners = self.manners
        silent = manners.silent_at is not None and len(self.blocks) > manners.silent_at
        hidden = isinstance(message, Samples) and message.block in manners.hide
        if manners.mute or silent or hidden:
            return b""
        body = encode(message)
        return manners.out(frame(bytes((manners.version,)) + body[1:]))


class PtyTarget:
    """A `FakeTarget` behind a pseudo-terminal, in a thread of the test's; ``url`` is what the host opens."""

    def __init__(self, manners: Manners | None = None) -> None:
        self.target = FakeTarget(manners)
        self.target.slack = 10.0  # for computers so busy that a thread waits for more than the watchdog's time
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._fds = self._open()

    def _open(self) -> list[int]:
        master, slave = os.openpty()
        tty.setraw(slave)
        self.url = os.ttyname(slave)
        return [master, slave]

    def _wait_for_host(self) -> None:
        """A pseudo-terminal needs no waiting."""

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ending.set()
        self._thread.join()
        self._close()

    def _close(self) -> None:
        while self._fds:
            os.close(self._fds.pop())

    def _run(self) -> None:
        self._wait_for_host()
        end = self._fds[0]
        os.set_blocking(end, False)
        unsent = b""
        while not self._ending.is_set():
            readable, writable, _ = select.select([end], [end] if unsent else [], [], 0.001)
            if readable:
                with contextlib.suppress(OSError):
                    unsent += self.target.feed(os.read(end, 65536), now=time.monotonic())
            unsent += self.target.go_on(time.monotonic())
            cut_at = self.target.manners.cut_at
            cut = cut_at is not None and len(self.target.blocks) >= cut_at
            if unsent and (writable or cut):
                with contextlib.suppress(BlockingIOError):
                    unsent = unsent[os.write(end, unsent) :]
            if cut:
                self._close()
                return


class SocketTarget(PtyTarget):
    """The same behind a TCP port of this computer."""

    def _open(self) -> list[int]:
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.url = f"socket://127.0.0.1:{self._listener.getsockname()[1]}"
        return []

    def _wait_for_host(self) -> None:
        host, _ = self._listener.accept()
        self._fds = [host.detach()]
        self._listener.close()


def spoiler(seed: int, *, share: float) -> Callable[[bytes], bytes]:
    """Spoils a share of the frames: bits flipped, cut short, sent twice, or lost; the seed says which."""
    dice = random.Random(seed)

    def spoil(data: bytes) -> bytes:
        if dice.random() >= share:
            return data
        match dice.randrange(4):
            case 0:
                return spoilt(data, dice)
            case 1:
                return data[: dice.randrange(len(data))]
            case 2:
                return data + data
        return b""

    return spoil


def spoilt(data: bytes, dice: random.Random) -> bytes:
    """One to four bytes changed."""
    changed = bytearray(data)
    for _ in range(dice.randint(1, 4)):
        changed[dice.randrange(len(changed))] ^= dice.randint(1, 255)
    return bytes(changed)
