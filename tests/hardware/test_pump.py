"""The thread between session and port: time in which it was not running is not silence, and RELEASE still goes out."""

import time
from collections.abc import Callable
from typing import Any

import pytest

from hknob_cli.hardware.wire.codes import Kind
from hknob_cli.hardware.wire.commands import Plain
from hknob_cli.hardware.wire.messages import Decoder, decode
from hknob_cli.hardware.wire.pump import LONGEST_STEP_S, Pump
from hknob_cli.hardware.wire.session import Session


class Port:
    """A port that does what it is told at each read and write."""

    def __init__(self, *, on_read: Callable[[int], object], on_write: Callable[[int], object]) -> None:
        self.written = b""
        self.reads = self.writes = 0
        self._on_read, self._on_write = on_read, on_write

    def read(self, most: int) -> bytes:
        self.reads += 1
        time.sleep(0.001)
        self._on_read(self.reads)
        return b""

    def write(self, data: bytes) -> None:
        self.written += data
        self.writes += 1
        self._on_write(self.writes)


class Clock(Session):
    """A session that notes the times it is told."""

    def __init__(self) -> None:
        super().__init__(first_nonce=0)
        self.times: list[float] = []

    def feed(self, data: bytes, *, now: float, arrived_s: float) -> None:
        self.times.append(now)


def nothing(_: int) -> None:
    pass


def until(what: Callable[[], bool]) -> None:
    while not what():
        time.sleep(0.001)


def test_a_computer_that_stood_still_does_not_take_it_for_silence() -> None:
    session = Clock()
    port = Port(on_read=lambda count: time.sleep(4 * LONGEST_STEP_S) if count == 5 else None, on_write=nothing)
    pump = Pump(port, session)
    pump.start()
    until(lambda: len(session.times) > 10)
    pump.end()
    steps = [after - before for before, after in zip(session.times, session.times[1:], strict=False)]
    assert max(steps) == pytest.approx(LONGEST_STEP_S)


def test_a_release_asked_for_at_the_last_moment_still_goes_out() -> None:
    session: Any = Session(first_nonce=0)

    def ask_and_end(count: int) -> None:
        if count == 1:
            session.command(lambda nonce: Plain(Kind.RELEASE, nonce))
            pump._ending.set()

    port = Port(on_read=nothing, on_write=ask_and_end)
    pump = Pump(port, session)
    pump.start()
    pump.end()
    assert [decode(body) for body in Decoder().feed(port.written)] == [Plain(Kind.RELEASE, 1)]


@pytest.mark.parametrize("error", [OSError("gone"), TypeError("closed under its feet")])
def test_a_port_that_breaks_ends_the_thread_and_is_remembered(error: Exception) -> None:
    def fall(_: int) -> None:
        raise error

    pump = Pump(Port(on_read=fall, on_write=nothing), Session(first_nonce=0))
    pump.start()
    until(lambda: pump.broken is not None)
    pump.end()
    assert pump.broken == str(error)
