"""The target's frames and messages: the golden ones, lengths at the edges, and 100,000 that are none."""

import ctypes as c
import random
import subprocess
import zlib
from pathlib import Path

import pytest

from hknob_cli.hardware.port import Control, Converters, Pulse, Squeeze
from hknob_cli.hardware.wire.codes import Kind, Piece, Table
from hknob_cli.hardware.wire.commands import Again, Alive, Configure, Plain, SetAct, Simulate
from hknob_cli.hardware.wire.messages import body_of, encode, frame
from tests.conftest import ROOT
from tests.hardware.firmware import (
    HERE,
    PARTS,
    SOURCES,
    CCommand,
    CControl,
    CConverters,
    CLine,
    COverAngle,
    CPiece,
    CPulse,
    CSettings,
    CSimulated,
    CSqueeze,
    CTable,
    compiled,
    library,
)
from tests.hardware.golden import GOLDEN

LINES = [row.split(" | ") for row in (ROOT / "data/wire/golden_frames.txt").read_text().splitlines() if row[0] != "#"]
FRAMES = {name: bytes.fromhex(text) for name, _, text in LINES}
COMMANDS = [name for name in FRAMES if not name.startswith(("ack", "block", "event", "readings"))]


def unstuffed(data: bytes) -> bytes:
    """The body that the target finds between two zeros."""
    buffer = (c.c_uint8 * 1100)(*data)
    return bytes(buffer[: library().frame_decode(buffer, c.c_size_t(len(data)))])


def stuffed(body: bytes) -> bytes:
    """The frame that the target makes."""
    buffer = (c.c_uint8 * 1100)()
    return bytes(buffer[: library().frame_encode(buffer, body, c.c_size_t(len(body)))])


def read(body: bytes) -> CCommand | None:
    command = CCommand()
    return command if library().command_read(c.byref(command), body, c.c_size_t(len(body))) else None


def values(structure: c.Structure) -> tuple:
    return tuple(getattr(structure, name) for name, _ in structure._fields_)


@pytest.mark.parametrize("name", FRAMES)
def test_the_target_frames_bodies_as_the_golden_frames_are(name: str) -> None:
    body = unstuffed(FRAMES[name][:-1])
    assert body == encode(GOLDEN[name])
    assert stuffed(body) == FRAMES[name]


@pytest.mark.parametrize("name", COMMANDS)
def test_the_target_reads_the_fields_of_golden_commands(name: str) -> None:
    said, command = GOLDEN[name], read(unstuffed(FRAMES[name][:-1]))
    assert command is not None
    assert command.type == int(said.kind)
    assert command.nonce == said.nonce
    match said:
        case Configure():
            assert values(command.settings) == said.settings.numbers
        case Simulate():
            expected = CSimulated.of(said.simulated)
            assert bytes(command.simulated) == bytes(expected)
        case SetAct(act=Control()):
            assert bytes(command.control) == bytes(CControl.of(said.act))
        case SetAct(act=Pulse()):
            assert values(command.pulse) == tuple(said.act)
        case SetAct(act=Table()):
            assert bytes(command.over_angle) == bytes(CTable(*said.act))
        case SetAct(act=Piece()):
            assert bytes(command.torques) == bytes(CPiece.of(said.act))
        case SetAct(act=Converters()):
            assert values(command.converters) == tuple(said.act)
        case SetAct(act=Squeeze()):
            assert bytes(command.squeeze) == bytes(CSqueeze.of(said.act))
        case Alive():
            assert command.first == said.expected
        case Again():
            assert (command.first, command.count) == (said.first, said.count)


@pytest.mark.parametrize("name", [name for name in FRAMES if name not in COMMANDS])
def test_the_target_takes_no_answer_for_a_command(name: str) -> None:
    assert read(unstuffed(FRAMES[name][:-1])) is None


@pytest.mark.parametrize("name", COMMANDS)
def test_every_other_length_is_refused(name: str) -> None:
    body = encode(GOLDEN[name])
    for length in range(len(body)):
        assert read(body[:length]) is None
    assert read(body + b"\0") is None
    assert read(bytes([2]) + body[1:]) is None


def test_five_sines_are_refused() -> None:
    body = bytearray(encode(GOLDEN["simulate"]))
    body[-2] = 5
    assert read(bytes(body) + bytes(5 * 24)) is None


@pytest.mark.parametrize(("place", "count"), [(8, 10), (8, 255), (9, 66), (9, 255)])
def test_more_numbers_or_rows_than_there_is_room_for_are_no_message(place: int, count: int) -> None:
    body = bytearray(encode(GOLDEN["control"]))
    body[place] = count
    there = body[8] + body[9]
    assert read(bytes(body[:10]) + bytes(8 * there)) is None


@pytest.mark.parametrize(("place", "count"), [(55, 11), (55, 255), (56, 5), (56, 255)])
def test_more_hands_or_sines_than_there_is_room_for_are_no_message(place: int, count: int) -> None:
    body = bytearray(encode(GOLDEN["squeeze"]))
    assert (body[55], body[56]) == (2, 1)
    body[place] = count
    assert read(bytes(body[:57]) + bytes(32 * body[55] + 24 * body[56])) is None


@pytest.mark.parametrize("count", [7, 33, 255])
def test_more_torques_than_there_are_or_room_for_are_no_message(count: int) -> None:
    body = bytearray(encode(GOLDEN["torques"]))
    body[10] = count
    assert read(bytes(body[:11]) + bytes(8 * (6 if count == 7 else count))) is None


def test_frames_of_every_length_come_back() -> None:
    """Runs without a zero of 253 to 255 bytes, and their CRC, are where stuffing goes wrong if it does."""
    rng = random.Random(7)
    for length in [*range(1, 20), *range(240, 270), *range(495, 520), 839, 1023, 1024]:
        for zeros in (0.0, 0.005, 0.5, 1.0):
            body = bytes(0 if rng.random() < zeros else rng.randint(1, 255) for _ in range(length))
            assert stuffed(body) == frame(body)
            assert unstuffed(stuffed(body)[:-1]) == body == body_of(stuffed(body)[:-1])


def test_a_body_too_long_is_dropped() -> None:
    from cobs import cobs

    body = bytes(1025)
    assert unstuffed(cobs.encode(body + zlib.crc32(body).to_bytes(4, "little"))) == b""


def test_a_line_that_never_ends_is_dropped_up_to_its_zero() -> None:
    class Receiver(c.Structure):
        _fields_ = (("bytes", c.c_uint8 * 1033), ("count", c.c_size_t), ("too_long", c.c_bool))

    receiver, good = Receiver(), frame(encode(Plain(Kind.START, 77)))
    line = good[:-1] + bytes([5]) * 5000 + b"\0" + good
    lengths = [library().frame_take(c.byref(receiver), byte) for byte in line]
    assert lengths == [0] * (len(line) - 1) + [6]
    assert bytes(receiver.bytes[:6]) == encode(Plain(Kind.START, 77))


def test_one_turned_bit_is_noticed() -> None:
    whole = frame(encode(Plain(Kind.START, 77)))[:-1]
    for place in range(len(whole) * 8):
        turned = bytearray(whole)
        turned[place // 8] ^= 1 << place % 8
        if 0 not in turned:
            assert unstuffed(bytes(turned)) == b""


@pytest.mark.long
def test_100000_frames_that_are_none_and_50000_that_are(tmp_path: Path) -> None:
    """With address and undefined-behaviour sanitizers, where the compiler has them."""
    program = tmp_path / "stormy_line"
    sources = [*PARTS, str(HERE / "stormy_line.c")]
    guarded = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-g"]
    done = compiled(program, *guarded, *sources)
    if done.returncode != 0:
        done = compiled(program, *sources)
    assert done.returncode == 0, done.stderr
    done = subprocess.run([program], capture_output=True, text=True)
    assert done.stderr == ""
    assert done.returncode == 0
    # An answer to HELLO is a body of 43 bytes, 4 of CRC, one of stuffing and the zero.
    storm, wander, controllers = done.stdout.splitlines()
    assert storm == "taken 0, trials 0, bytes answered 0, to a good frame then 49"
    assert wander == "torque without a clock 0, locks in order, torque seen often"
    assert controllers == "controllers many, pulses many, tables many, converters many"


def test_the_template_compiles(tmp_path: Path) -> None:
    portable = [part for part in PARTS if not part.endswith(("plant.c", "squeeze.c")) and "scripted" not in part]
    done = compiled(tmp_path / "template", *portable, str(SOURCES / "board_template.c"))
    assert done.returncode == 0, done.stderr


def test_structures_are_laid_out_as_in_c() -> None:
    """Else the other tests would compare garbage with garbage."""
    assert c.sizeof(CSettings) == 48
    assert c.sizeof(CSimulated) == 9 * 8 + 8 + 8 * 24
    assert c.sizeof(CControl) == 8 + 9 * 8 + 65 * 8
    assert c.sizeof(CPulse) == 4 * 8 + 8
    assert c.sizeof(CTable) == 32
    assert c.sizeof(CPiece) == 8 + 32 * 8
    assert c.sizeof(COverAngle) == 32 + 8 + 16_640 * 8
    assert c.sizeof(CConverters) == 6 * 8
    assert c.sizeof(CLine) == 16 + 65 * 16 + 1024 * 8
    assert c.sizeof(CSqueeze) == 6 * 8 + 8 + 40 * 8 + 4 * 24
