"""A session against a target that says anything, in made-up time: it never raises, and hands on whole samples."""

import traceback
from collections.abc import Iterator

import numpy as np

from hknob_cli.hardware.port import Block
from hknob_cli.hardware.wire.answers import About, Ack, Event, Samples
from hknob_cli.hardware.wire.codes import Kind, State, Status, Trip
from hknob_cli.hardware.wire.commands import Alive, Command, Configure, Plain, Simulate
from hknob_cli.hardware.wire.messages import Decoder, Message, decode, encode, frame
from hknob_cli.hardware.wire.sending import MOST_AHEAD
from hknob_cli.hardware.wire.session import Session
from tests.fuzz.arena import Arena
from tests.fuzz.attempt import Attempt
from tests.fuzz.frame_case import FrameCase
from tests.hardware.golden import BOOT, GOLDEN, SETTINGS, SIMULATED, block

INTERVAL_US = 250
PLAIN = {"hello": Kind.HELLO, "arm": Kind.ARM, "start": Kind.START, "stop": Kind.STOP, "release": Kind.RELEASE}


def attempts(case: FrameCase, _arena: Arena | None = None) -> list[Attempt]:
    """The session, from its first line to its last."""
    wire = Wire()
    breaches: list[tuple[str, str]] = []
    try:
        for line in case.data.decode("ascii", errors="replace").splitlines():
            wire.do(line.split())
            breaches += wire.wrong()
            if breaches:
                break
    except Exception as error:
        frames = [one for one in traceback.extract_tb(error.__traceback__) if "hknob_cli" in one.filename]
        at = f"{frames[-1].filename.rpartition('hknob_cli')[2]}:{frames[-1].lineno}" if frames else "here"
        breaches.append(("traceback", f"{type(error).__name__} at {at}: {error}"))
    return [Attempt(("decode",), None, "", wire.session.failure or "", 0.0, tuple(breaches))]


class Wire:
    """A session, the time, what it has sent last, and the samples that it has handed on."""

    def __init__(self) -> None:
        self.session = Session(first_nonce=0xFFFFFFF0)
        self.now = 0.0
        self.command: Command = Plain(Kind.HELLO, 0)
        self.run = self.expected = 0
        self.got: list[Block] = []
        self.sent: list[Message | None] = []

    def do(self, words: list[str]) -> None:
        """One line of a case; what is none is left out."""
        match words:
            case ["command", name]:
                self._send(name)
            case ["wait", seconds]:
                self.now += float(seconds)
            case ["take"]:
                while (one := self.session.take()) is not None:
                    self.got.append(one)
            case [*_, change] if (body := self._body(words[:-1])) is not None:
                self.session.feed(frame(_changed(body, change)), now=self.now)
        for body in Decoder().feed(self.session.due(self.now)):
            said = decode(body)
            self.sent.append(said)
            if isinstance(said, Alive):
                self.expected = said.expected

    def wrong(self) -> Iterator[tuple[str, str]]:
        """What must not be."""
        if None in self.sent:
            yield "frame", "what is sent is none of the protocol's"
        failure = self.session.failure
        if failure is not None and not (failure and failure.isprintable()):
            yield "unprintable", repr(failure)[:200]
        following = 0
        for one in self.got:
            if one.first != following or not np.isfinite(one.torque_nm).all():
                yield "samples", f"a block begins at {one.first} where {following} follows"
                return
            following += len(one.time_us)
        if len(self.session.ready) > 10 * MOST_AHEAD:
            yield "memory", f"{len(self.session.ready)} blocks are held"

    def _send(self, name: str) -> None:
        def make(nonce: int) -> Command:
            if name == "configure":
                self.command = Configure(nonce, SETTINGS)
            elif name == "simulate":
                self.command = Simulate(nonce, SIMULATED)
            else:
                self.command = Plain(PLAIN[name], nonce)
            return self.command

        nonce = self.session.command(make)
        if name == "arm":
            self.run, self.expected = nonce, 0
            self.got.clear()

    def _body(self, words: list[str]) -> bytes | None:
        """The body of what a target says."""
        match words:
            case ["answer", *numbers]:
                return self._answer([int(one) for one in numbers])
            case ["block", ahead, count]:
                number = (self.expected + int(ahead)) % 2**32
                first = number * int(count) % 2**32
                samples = block(int(count), first=first, start_us=first * INTERVAL_US % 2**31)
                return encode(Samples(BOOT, self.run, number, samples))
            case ["event", fault, blocks]:
                data = bytearray(encode(Event(BOOT, self.run, Trip.SPEED, 1, 250, int(blocks))))
                data[10] = int(fault)
                return bytes(data)
            case ["golden", name]:
                return encode(GOLDEN[name])
            case ["body", text]:
                return bytes.fromhex(text)
        return None

    def _answer(self, numbers: list[int]) -> bytes:
        status, state, fault, blocks = numbers
        said = None
        match self.command:
            case Plain(kind=Kind.HELLO):
                said = About(10_000, 20_000, simulated=False, name="fuzz")
            case Configure(settings=settings) if status == Status.DONE:
                said = settings
            case Simulate(simulated=simulated) if status == Status.DONE:
                said = simulated
        ack = Ack(self.command.nonce, self.command.kind, Status.DONE, State.IDLE, Trip.NONE, BOOT, blocks, said)
        data = bytearray(encode(ack))
        data[7:10] = bytes((status, state, fault))
        return bytes(data)


def _changed(body: bytes, change: str) -> bytes:
    """A body with a change; one byte at least, and no more than a frame carries."""
    data = bytearray(body)
    match change.split(":"):
        case ["set", at, value]:
            data[int(at) % len(data)] = int(value)
        case ["cut", count]:
            del data[-int(count) :]
        case ["add", text]:
            data += bytes.fromhex(text)
    return bytes(data[:1024]) or b"\1"
