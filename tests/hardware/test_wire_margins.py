"""What is said on the wire and of it, case by case: torque that shows, values that differ, frames that are counted."""

import math
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hknob_cli.errors import ComputationError
from hknob_cli.hardware import ranges
from hknob_cli.hardware.journal import Journal
from hknob_cli.hardware.person import _sinc
from hknob_cli.hardware.port import Sine
from hknob_cli.hardware.ranges import LONGEST_BLOCK_S, faults, faults_of_simulated
from hknob_cli.hardware.wire.codes import Kind, State, Trip
from hknob_cli.hardware.wire.commands import MOST_SINES, Alive, Plain, Simulate, pack_simulated, unpack_simulated
from hknob_cli.hardware.wire.frame import Decoder, frame, unread_of
from hknob_cli.hardware.wire.messages import decode, encode
from hknob_cli.hardware.wire.sending import differences, shows_torque
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
    monkeypatch.setattr(ranges, "faults_of_settings", lambda *_: [])
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
