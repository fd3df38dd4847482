"""What is said on the wire and of it, case by case: torque that shows, values that differ, frames that are counted."""

import math
from contextlib import suppress
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hknob_cli.errors import ComputationError, DeviceError
from hknob_cli.hardware import order, serial_device
from hknob_cli.hardware.journal import Journal
from hknob_cli.hardware.order import LONGEST_BLOCK_S, faults, faults_of_simulated
from hknob_cli.hardware.person import _sinc
from hknob_cli.hardware.port import Sine, Torque
from hknob_cli.hardware.virtual import IDENTITY
from hknob_cli.hardware.wire.answers import Abilities, About, Ack, Event
from hknob_cli.hardware.wire.codes import Kind, State, Status, Trip
from hknob_cli.hardware.wire.commands import MOST_SINES, Alive, Plain, Simulate, pack_simulated, unpack_simulated
from hknob_cli.hardware.wire.messages import Decoder, decode, encode, frame, is_message, unread_of
from hknob_cli.hardware.wire.pump import Pump
from hknob_cli.hardware.wire.sending import BlockOrder, differences, shows_torque
from hknob_cli.hardware.wire.session import Session
from tests.hardware.fake_target import Manners, made_up
from tests.hardware.golden import SETTINGS, SIMULATED
from tests.hardware.test_session import Wire


def test_a_wall_without_torque_shows_torque_and_so_does_torque_without_a_wall() -> None:
    still = made_up(0, 4, 1000.0, started=None)._replace(torque_nm=np.zeros(4))
    assert not shows_torque(still)
    assert shows_torque(still._replace(running=np.array([False, False, True, False])))
    assert shows_torque(still._replace(torque_nm=np.array([0.0, 0.0, -1e-9, 0.0])))


def test_a_value_that_was_not_taken_differs_from_every_number() -> None:
    """And a number from its neighbour in the last place."""
    sines = SIMULATED._replace(push_sines=(Sine(0.0, 0.0, 0.0),))
    assert len(differences(sines, SIMULATED)) == 3
    assert len(differences(SIMULATED, sines)) == 3
    assert differences(sines, sines) == []
    next_to = SIMULATED._replace(damping=math.nextafter(SIMULATED.damping, 1.0))
    assert len(differences(SIMULATED, next_to)) == 1


def test_what_is_no_message_counts_with_what_is_no_frame() -> None:
    decoder = Decoder()
    decoder.feed(b"\1\2\3\0" + bytes([*frame(b"abc")[:-3], 7, 0]))
    assert decoder.damaged - decoder.bad_crc + 2 == unread_of(decoder, 2).none
    assert "1 frame came" in unread_of(Decoder(), 1).text
    assert "2 frames came" in unread_of(Decoder(), 2).text
    assert unread_of(Decoder(), 0).text == ""


def test_as_many_sines_as_are_allowed_come_back() -> None:
    for push, grip in ((MOST_SINES, 0), (0, MOST_SINES), (MOST_SINES, MOST_SINES)):
        one = SIMULATED._replace(
            push_sines=tuple(Sine(0.5, float(k), 0.25) for k in range(push)),
            grip_sines=tuple(Sine(0.25, float(k), 0.5) for k in range(grip)),
        )
        assert unpack_simulated(pack_simulated(one)) == one
        assert decode(encode(Simulate(7, one))) == Simulate(7, one)


def test_a_fault_of_a_simulated_knob_says_what_is_allowed() -> None:
    for name, value, allowed in (
        ("inertia", 0.0, "> 0"),
        ("damping", -1.0, ">= 0"),
        ("angle_rad", math.inf, "finite"),
        ("push_nm", -math.inf, "finite"),
    ):
        assert faults_of_simulated(SIMULATED._replace(**{name: value})) == [f"{name} must be {allowed}, got {value:g}"]


def test_a_block_may_take_as_long_as_the_longest(monkeypatch: pytest.MonkeyPatch) -> None:
    nobody: Any = None
    monkeypatch.setattr(order, "faults_of_settings", lambda *_: [])
    period = round(LONGEST_BLOCK_S * 1e9 / 20)
    for more, fine in ((0, True), (1, False)):
        told = SETTINGS._replace(block_samples=20, period_ns=period + more)
        assert (faults(told, nobody) == []) is fine


def test_an_error_without_a_text_of_the_systems_is_said_in_its_own(tmp_path: Path) -> None:
    class Broken:
        def write(self, data: bytes) -> int:
            raise OSError("the stick was pulled")

    journal = Journal.__new__(Journal)
    journal.path, journal._file = tmp_path / "journal", Broken()  # type: ignore[assignment]
    with pytest.raises(ComputationError, match="cannot be written: the stick was pulled"):
        journal._append(b"abc")


def test_a_sinc_is_one_at_nothing() -> None:
    assert _sinc(0.0) == 1.0
    assert _sinc(1e-9) == pytest.approx(1.0, abs=1e-15)


# A session.


def sent(data: bytes) -> list[Any]:
    return [decode(body) for body in Decoder().feed(data)]


def test_every_command_has_the_next_nonce() -> None:
    """Also those that nobody answers; they wrap round."""
    wire = Wire()
    wire.arm()
    nonces = []
    for _ in range(60):
        wire.now += 0.0025
        wire.session.feed(wire.target.go_on(wire.now), now=wire.now)
        due = wire.session.due(wire.now)
        nonces += [one.nonce for one in sent(due) if isinstance(one, Alive)]
        for piece in due.split(b"\0")[:-1]:
            wire.session.feed(wire.target.feed(piece + b"\0", now=wire.now), now=wire.now)
    assert len(nonces) > 10
    assert [(b - a) & 0xFFFFFFFF for a, b in pairwise(nonces)] == [1] * (len(nonces) - 1)
    assert wire.session.command(lambda nonce: Plain(Kind.START, nonce)) == (nonces[-1] + 1) & 0xFFFFFFFF


def test_a_stop_without_a_run_is_answered() -> None:
    wire = Wire()
    assert wire.do(Kind.HELLO)
    assert wire.do(Kind.STOP)
    assert (wire.session.state, wire.session.failure) == (State.IDLE, None)


def test_a_session_begins_with_nothing() -> None:
    one = Session(first_nonce=5)
    assert (one.damaged, one.rejected, one.unread.text) == (0, 0, "")
    assert one.command(lambda nonce: Plain(Kind.HELLO, nonce)) == 6
    # Its first command goes at once, and again only after its time.
    assert len(sent(one.due(0.0))) == 1
    assert sent(one.due(0.001)) == []


def test_a_trip_is_told_with_its_time() -> None:
    wire = Wire(Manners(trip=(6, Trip.SPEED)))
    wire.arm()
    assert wire.do(Kind.START)
    wire.go(0.5)
    assert wire.session.failure is not None
    index = int(wire.session.failure.split("at sample ")[1].split(",")[0])
    assert f"{index * SETTINGS.period_ns * 1e-9:.4f} s after arming" in wire.session.failure


def test_a_stop_that_is_carried_out_without_a_run_ends_nothing() -> None:
    """As after a release: there are no blocks to wait for."""
    one = Session(first_nonce=5)
    nonce = one.command(lambda nonce: Plain(Kind.STOP, nonce))
    one.feed(frame(encode(Ack(nonce, Kind.STOP, Status.DONE, State.IDLE, Trip.NONE, 1, 3))), now=1.0)
    assert one.answer is not None
    assert (one.is_finished, one.failure) == (True, None)


def test_a_wall_is_said_to_be_on_from_the_block_after_those_that_were_begun() -> None:
    """By their number, or by a time that is at most what passed; a block of one sample may be that of a trip."""
    one, off = Session(first_nonce=5), made_up(0, 4, 1000.0, started=None)
    assert float(off.time_us[0]) == 0.0
    late = off._replace(time_us=off.time_us + 250_000)
    one._on_after = (3, 0.25)
    for number, block, own_time, fine in (
        (3, late._replace(time_us=late.time_us + 1), False, True),
        (4, late, False, True),
        (4, late._replace(time_us=late.time_us + 1), False, False),
        (4, late, True, False),
        (3, late, True, True),
    ):
        one.own_time = own_time
        assert (one._off_after_start(number, block) == "") is fine
    single = made_up(0, 1, 1000.0, started=None)
    assert one._off_after_start(4, single) == ""
    assert "does not say that the wall is on" in one._off_after_start(4, single)


def test_blocks_are_numbered_as_they_come() -> None:
    """Of a target in its own time the first that must be on is that after the one in which START came."""
    wire = Wire()
    wire.arm()
    session = wire.session
    session.own_time = True
    session._on_after = (4, 0.0)
    while session.failure is None:
        wire.step()
    assert len(wire.got) == 4 + 1  # the first is 0


# A device behind a port.


class Clock:
    """Time that passes while one waits: in the place of the module, of a lock, and of the thread over the port."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now, self.waited = 100.0, [0.0] * 0
        self.broken: str | None = None
        self.changed = self
        monkeypatch.setattr(serial_device, "time", self)

    def monotonic(self) -> float:
        return self.now

    def wait(self, seconds: float) -> None:
        self.waited.append(seconds)
        self.now += seconds
        assert len(self.waited) < 50, "it waits for ever"

    def __enter__(self) -> None:
        pass

    def __exit__(self, *_: object) -> None:
        pass


class Waiting:
    """A session whose command is never answered, and whose blocks never come; ``answer``: of another command."""

    failure = answer = released = None
    is_finished = is_stopped = False

    def command(self, make: Any) -> int:
        return 7

    def is_waiting(self, nonce: int) -> bool:
        return self.answer is None

    def take(self) -> None:
        return None


def device_of(clock: Clock, session: Waiting) -> serial_device.SerialDevice:
    one = serial_device.SerialDevice("somewhere")
    one._pump, one._session = clock, session  # type: ignore[assignment]
    return one


def test_a_block_is_waited_for_as_long_as_was_said(monkeypatch: pytest.MonkeyPatch) -> None:
    """In steps of 50 ms, the last as long as is left; after a stop until the session says that there are no more."""
    clock, session = Clock(monkeypatch), Waiting()
    assert device_of(clock, session).read(0.125) is None
    assert clock.waited == pytest.approx([0.05, 0.05, 0.025])
    clock.waited.clear()
    session.is_stopped = True
    with pytest.raises(AssertionError, match="for ever"):
        device_of(clock, session).read(0.125)
    assert clock.waited[3:] == [0.05] * 47


def test_an_answer_is_waited_for_until_it_is_given_up_or_the_port_is_gone(monkeypatch: pytest.MonkeyPatch) -> None:
    clock, session = Clock(monkeypatch), Waiting()
    one = device_of(clock, session)
    assert one._ask(clock, lambda nonce: Plain(Kind.HELLO, nonce), give_up_at=100.125) is None  # type: ignore[arg-type]
    assert clock.waited == [0.05] * 3
    clock.broken = "pulled"
    with pytest.raises(DeviceError, match="the port is gone: pulled"):
        one._ask(clock, lambda nonce: Plain(Kind.HELLO, nonce))  # type: ignore[arg-type]
    assert clock.waited == [0.05] * 3


def test_the_answer_to_another_command_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    clock, session = Clock(monkeypatch), Waiting()
    one = device_of(clock, session)
    for nonce, answered in ((6, False), (7, True)):
        session.answer = Ack(nonce, Kind.HELLO, Status.DONE, State.IDLE, Trip.NONE, 1, 0)  # type: ignore[assignment]
        found = one._ask(clock, lambda nonce: Plain(Kind.HELLO, nonce))  # type: ignore[arg-type]
        assert (found is not None) is answered


def test_only_what_was_taken_for_this_trial_is_armed() -> None:
    """Not after settings that were refused, nor after the port was closed."""
    one = serial_device.SerialDevice("somewhere")
    for undone in (lambda: one.configure(SETTINGS), one._close):
        one._agreed = True
        with suppress(DeviceError):
            undone()
        with pytest.raises(DeviceError, match="not armed: the target has not taken"):
            one.arm()


def test_nothing_is_sent_any_more_when_the_program_ends() -> None:
    """ALIVE neither: the watchdog then acts."""
    assert Pump(None, Session(first_nonce=5))._thread.daemon is True


def test_the_line_is_listened_to_for_two_of_the_longest_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    """After RELEASE was answered; then its torque counts as off."""
    clock, session = Clock(monkeypatch), Waiting()
    session.answer = Ack(7, Kind.RELEASE, Status.DONE, State.IDLE, Trip.NONE, 1, 0)  # type: ignore[assignment]
    one = device_of(clock, session)
    one.release()
    assert clock.waited == pytest.approx([2.0 * LONGEST_BLOCK_S])
    assert one.torque is Torque.OFF


def test_a_sine_that_differs_is_told_by_its_place_and_name() -> None:
    louder = SIMULATED._replace(push_sines=(Sine(0.5, 1.0, 2.0),))
    other = SIMULATED._replace(push_sines=(Sine(0.25, 1.0, 2.0),))
    assert differences(louder, other) == ["push_sines[0].amplitude sent 0.5, taken 0.25"]


def test_a_frame_that_does_not_decode_is_no_message() -> None:
    whole = frame(encode(Ack(7, Kind.HELLO, Status.DONE, State.IDLE, Trip.NONE, 1, 0)))[:-1]
    assert is_message(whole)
    assert not is_message(b"\xff\x01")
    assert not is_message(frame(encode(Plain(Kind.HELLO, 7)))[:-1])


def test_a_target_that_knows_no_abilities_is_not_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    one, asked = serial_device.SerialDevice("somewhere"), [0] * 0
    answer = Ack(7, Kind.ABILITIES, Status.DONE, State.IDLE, Trip.NONE, 1, 0, Abilities(3, 1))

    def command(_make: Any, _verb: str) -> Ack:
        asked.append(1)
        return answer

    monkeypatch.setattr(one, "_command", command)
    one._identity = IDENTITY._replace(laws=0, knows_converters=False)
    one._ask_abilities()
    assert (asked, one.identity.laws) == ([], 0)
    one._says_abilities = True
    one._ask_abilities()
    assert (asked, one.identity.laws, one.identity.knows_converters) == ([1], 3, True)


def test_who_is_there_is_asked_until_it_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """Not by silence, nor by an answer that does not say it."""
    one = serial_device.SerialDevice("somewhere")
    about = About(1000, 1000, True, "it")
    plain = Ack(7, Kind.HELLO, Status.DONE, State.IDLE, Trip.NONE, 5, 0)
    answers = iter([None, plain, plain._replace(said=about)])
    monkeypatch.setattr(one, "_ask", lambda *_, **__: next(answers))
    assert one._greet(None) == (about, 5)  # type: ignore[arg-type]


def test_what_was_lost_before_a_trip_is_told_with_what_came_in_its_place() -> None:
    one = Session(first_nonce=5)
    order = BlockOrder(boot=1, run=2)
    order.end(3, now=0.0)
    event = Event(1, 2, Trip.SPEED, 40, 10_000, 3)
    said = one._trip_text(event, order)
    assert said.endswith("; its samples from block 0 on were lost")
    one.rejected = 2
    assert one._trip_text(event, order).startswith(f"{said}: ")
    order.expected = 3
    assert "lost" not in one._trip_text(event, order)


def test_a_release_may_be_answered_by_a_target_that_has_restarted() -> None:
    """Its torque is off: nothing has failed. Any other command has."""
    for kind, fails in ((Kind.RELEASE, False), (Kind.START, True)):
        one = Session(first_nonce=5)
        one.boot = 1
        nonce = one.command(lambda nonce, kind=kind: Plain(kind, nonce))
        one.feed(frame(encode(Ack(nonce, kind, Status.DONE, State.IDLE, Trip.NONE, 2, 0))), now=1.0)
        assert (one.failure is not None) is fails


def test_release_is_insisted_on_where_the_torque_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    nobody: Any = object()
    for why, insists in (("", 0), ("it is on", 1)):
        one, insisted = serial_device.SerialDevice("somewhere"), [0] * 0
        one._pump = nobody
        monkeypatch.setattr(one, "_release", lambda _pump, why=why: why)
        monkeypatch.setattr(one, "_insist", insisted.append)
        monkeypatch.setattr(one, "_close", lambda: None)
        one.__exit__(None, None, None)
        assert len(insisted) == insists
