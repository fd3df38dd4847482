"""Messages to bodies and back: version, type, strict lengths, and floats that are numbers."""

import math
import struct

import numpy as np

from hknob_cli.hardware.port import Block, Control, Converters, Pulse, Settings, Simulated, Squeeze
from hknob_cli.hardware.wire.acts import Piece, Table
from hknob_cli.hardware.wire.answers import Ack, Answer, Event, Samples, pack_answer, unpack_answer
from hknob_cli.hardware.wire.codes import VERSION, Kind
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
