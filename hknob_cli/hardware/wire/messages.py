"""Messages to bodies and back, and bodies in frames: lengths, checksums, and the zero bytes between them.

A frame is COBS of a body and its CRC-32, ended by a zero byte; frames are found in any bytes. What came from a port and
could not be read is told, with what that says of who sent it.
"""

import math
import struct
import zlib
from typing import NamedTuple

import numpy as np
from cobs import cobs

from hknob_cli.hardware.port import Block, Control, Converters, Pulse, Settings, Simulated, Squeeze
from hknob_cli.hardware.wire.answers import Ack, Answer, Event, Samples, pack_answer, unpack_answer
from hknob_cli.hardware.wire.codes import VERSION, Kind, Piece, Table
from hknob_cli.hardware.wire.commands import Command, Configure, SetAct, Simulate, pack_command, unpack_command

Message = Command | Answer


def encode(message: Message) -> bytes:
    """The body of a message. Raises ValueError for a value that has no place in it."""
    if not is_finite(message):
        raise ValueError("a value is not a finite number")
    try:
        rest = pack_answer(message) if isinstance(message, Ack | Samples | Event) else pack_command(message)
    except (struct.error, OverflowError) as error:
        raise ValueError(f"a value does not fit its field: {error}") from error
    return bytes((VERSION, message.kind)) + rest


def decode(body: bytes) -> Message | None:
    """The message in a body; None if version, type, length or a value is none of the protocol's."""
    if len(body) < 2 or body[0] != VERSION:
        return None
    try:
        kind = Kind(body[1])
        message = unpack_answer(kind, body[2:]) if kind & 0x80 else unpack_command(kind, body[2:])
    except (struct.error, ValueError):
        return None
    # A command with what is no number is none; of an answer whose checksum is right, what is no number can be said.
    return message if kind & 0x80 or is_finite(message) else None


def is_finite(message: Message) -> bool:
    """Whether every float of a message is a finite number."""
    match message:
        case Configure(settings=Settings() as values) | Ack(said=Settings() as values):
            return all(map(math.isfinite, values.numbers))
        case SetAct(act=Control() as control) | Ack(said=Control() as control):
            return all(map(math.isfinite, (*control.numbers, *control.rows)))
        case SetAct(act=Pulse() as pulse) | Ack(said=Pulse() as pulse):
            return all(map(math.isfinite, pulse))
        case SetAct(act=Converters() as converters) | Ack(said=Converters() as converters):
            return all(map(math.isfinite, converters))
        case SetAct(act=Table() as table) | Ack(said=Table() as table):
            return all(map(math.isfinite, table))
        case SetAct(act=Piece() as piece) | Ack(said=Piece() as piece):
            return all(map(math.isfinite, piece.torques))
        case SetAct(act=Squeeze() as one) | Ack(said=Squeeze() as one):
            lone = (one.aim_n, one.rise_s, one.overshoot, one.reaction_s, one.relax_s, one.strength_n)
            return all(map(math.isfinite, (*lone, *(number for row in (*one.hands, *one.sines) for number in row))))
        case Simulate(simulated=Simulated() as knob) | Ack(said=Simulated() as knob):
            sines = (number for sine in (*knob.push_sines, *knob.grip_sines) for number in sine)
            return all(map(math.isfinite, (*knob[:9], *sines)))
        case Samples():
            block = message.samples
            return bool(np.isfinite(block.torque_nm).all() and np.isfinite(block.grip_n).all())
    return True


def not_a_number(block: Block) -> str:
    """What is no number in a block whose checksum is right: the target's own doing; empty if nothing is."""
    for what, values in (("torque", block.torque_nm), ("grip force", block.grip_n)):
        bad = ~np.isfinite(values)
        if bad.any():
            return f"the target sent a {what} that is not a number, at sample {block.first + int(bad.argmax())}"
    return ""


MOST_BODY_BYTES = 1024
CRC_BYTES = 4
# COBS adds at most one byte in 254, rounded up.
MOST_STUFFED_BYTES = MOST_BODY_BYTES + CRC_BYTES + -(-(MOST_BODY_BYTES + CRC_BYTES) // 254)


def frame(body: bytes) -> bytes:
    """The frame that carries a body of 1 to 1024 bytes. Raises ValueError for another length."""
    if not 1 <= len(body) <= MOST_BODY_BYTES:
        raise ValueError(f"a body has 1 to {MOST_BODY_BYTES} bytes, this one has {len(body)}")
    return bytes(cobs.encode(body + zlib.crc32(body).to_bytes(CRC_BYTES, "little"))) + b"\0"


def body_of(stuffed: bytes) -> bytes | None:
    """The body in a frame without its zero byte; None if it does not decode, or its CRC is wrong."""
    try:
        checked = cobs.decode(stuffed)
    except cobs.DecodeError:
        return None
    body, crc = checked[:-CRC_BYTES], checked[-CRC_BYTES:]
    if not body or len(body) > MOST_BODY_BYTES or zlib.crc32(body) != int.from_bytes(crc, "little"):
        return None
    return bytes(body)


def is_message(stuffed: bytes) -> bool:
    """Whether a frame would be an answer, whatever its CRC is: it decodes, to the version and the type of one."""
    try:
        checked = cobs.decode(stuffed)
    except cobs.DecodeError:
        return False
    return len(checked) > 2 + CRC_BYTES and checked[0] == VERSION and Kind.ACK <= checked[1] <= Kind.EVENT


class Decoder:
    """Finds the frames in bytes as they come, in pieces of any size.

    Holds no more than one frame's bytes: what is longer cannot be a frame, and is skipped up to the next zero byte.
    ``damaged`` counts what was dropped; ``bad_crc`` those of them that would be an answer except for their checksum.
    """

    def __init__(self) -> None:
        self.damaged = 0
        self.bad_crc = 0
        self._begun = bytearray()
        self._skipping = False

    @property
    def held(self) -> int:
        """Bytes of a frame that has not ended yet."""
        return len(self._begun)

    @property
    def is_amid(self) -> bool:
        """Whether bytes came since the last zero byte."""
        return bool(self._begun) or self._skipping

    def feed(self, data: bytes) -> list[bytes]:
        """Bodies of the good frames that end in this piece, in order; never raises."""
        bodies = []
        *ended, begun = data.split(b"\0")
        for piece in ended:
            self._add(piece)
            if self._begun or self._skipping:
                body = None if self._skipping else body_of(bytes(self._begun))
                if body is None:
                    self.damaged += 1
                    self.bad_crc += not self._skipping and is_message(bytes(self._begun))
                else:
                    bodies.append(body)
            self._begun.clear()
            self._skipping = False
        self._add(begun)
        return bodies

    def _add(self, piece: bytes) -> None:
        if self._skipping or len(self._begun) + len(piece) > MOST_STUFFED_BYTES:
            self._skipping = True
            self._begun.clear()
        else:
            self._begun += piece


class Unread(NamedTuple):
    """Frames so far: ``bad_crc`` would be answers except for their checksum; ``none`` are nothing of the protocol."""

    bad_crc: int
    none: int

    def since(self, before: "Unread") -> "Unread":
        """What came after."""
        return Unread(self.bad_crc - before.bad_crc, self.none - before.none)

    @property
    def text(self) -> str:
        """In words; empty where there was nothing."""
        if self.bad_crc >= max(1, self.none):
            return (
                f"{_frames(self.bad_crc)} came with a wrong checksum: does the target make its CRC-32 as "
                "docs/reference/wire.md says, of the whole body, least significant byte first?"
            )
        return f"{_frames(self.none)} came that cannot be read: is the line disturbed?" if self.none else ""


def unread_of(decoder: Decoder, rejected: int) -> Unread:
    """What a decoder dropped, and what was none of the protocol's messages."""
    return Unread(decoder.bad_crc, decoder.damaged - decoder.bad_crc + rejected)


def nobody_text(unread: Unread, *, versions: set[int], echoed: bool, amid: bool, baud: int, patience_s: float) -> str:
    """Why nobody could be spoken to when a port was opened."""
    if versions:
        spoken = ", ".join(map(str, sorted(versions)))
        return f"the target speaks version {spoken} of the protocol, this program version {VERSION}: renew one of them"
    if echoed:
        return "the port sends back what it is sent: it is a loop or a terminal, not a target"
    if unread.bad_crc:
        return f"a target answers, but {unread.text}"
    if unread.none or amid:
        return f"what comes from this port is not the protocol (docs/reference/wire.md); is {baud} its baud rate?"
    return f"nobody answered within {patience_s:g} s: is the target on, and does it run the firmware?"


def _frames(count: int) -> str:
    return f"{count} frame{'s' if count != 1 else ''}"
