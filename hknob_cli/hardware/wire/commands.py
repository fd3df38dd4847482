"""What the host sends: commands, their fields, and how these lie in a body."""

import struct
from typing import NamedTuple

from hknob_cli.hardware.port import MOST_SINES, Control, Pulse, Settings, Simulated, Sine, Squeeze
from hknob_cli.hardware.wire.acts import (
    SINE,
    Piece,
    Table,
    pack_control,
    pack_piece,
    pack_pulse,
    pack_squeeze,
    pack_table,
    unpack_control,
    unpack_piece,
    unpack_pulse,
    unpack_squeeze,
    unpack_table,
)
from hknob_cli.hardware.wire.codes import Kind

NONCE = struct.Struct("<I")
SETTINGS = struct.Struct("<IIddddIH")
KNOB = struct.Struct("<9dBB")
ALIVE = struct.Struct("<I")
AGAIN = struct.Struct("<IH")
ZERO = struct.Struct("<i")

PLAIN = (Kind.HELLO, Kind.ARM, Kind.START, Kind.STOP, Kind.RELEASE)


class Plain(NamedTuple):
    """HELLO, ARM, START, STOP or RELEASE: nothing but a nonce."""

    kind: Kind
    nonce: int


class Configure(NamedTuple):
    """Settings of a trial."""

    nonce: int
    settings: Settings

    @property
    def kind(self) -> Kind:
        """Its type."""
        return Kind.CONFIGURE


class Simulate(NamedTuple):
    """The simulated knob, and who holds it."""

    nonce: int
    simulated: Simulated

    @property
    def kind(self) -> Kind:
        """Its type."""
        return Kind.SIMULATE


class Alive(NamedTuple):
    """The host is there, and waits for block ``expected``; not answered."""

    nonce: int
    expected: int

    @property
    def kind(self) -> Kind:
        """Its type."""
        return Kind.ALIVE


class Again(NamedTuple):
    """Blocks ``first`` and on, ``count`` of them, are wanted once more; not answered."""

    nonce: int
    first: int
    count: int  # type: ignore[assignment]  # the protocol's name; hides tuple.count, which nothing uses

    @property
    def kind(self) -> Kind:
        """Its type."""
        return Kind.AGAIN


class Zero(NamedTuple):
    """The present angle is ``angle`` from now on, in counts of the target's encoder."""

    nonce: int
    angle: int

    @property
    def kind(self) -> Kind:
        """Its type."""
        return Kind.ZERO


class SetControl(NamedTuple):
    """The controller of the wall of a trial."""

    nonce: int
    control: Control

    @property
    def kind(self) -> Kind:
        """Its type."""
        return Kind.CONTROL


class SetPulse(NamedTuple):
    """The pulse of a trial, in place of its wall."""

    nonce: int
    pulse: Pulse

    @property
    def kind(self) -> Kind:
        """Its type."""
        return Kind.PULSE


class SetSqueeze(NamedTuple):
    """Who squeezes the simulated knob."""

    nonce: int
    squeeze: Squeeze

    @property
    def kind(self) -> Kind:
        """Its type."""
        return Kind.SQUEEZE


class SetTable(NamedTuple):
    """The head of the torque over the angle of a trial."""

    nonce: int
    table: Table

    @property
    def kind(self) -> Kind:
        """Its type."""
        return Kind.OVER_ANGLE


class SetPiece(NamedTuple):
    """The next torques of it."""

    nonce: int
    piece: Piece

    @property
    def kind(self) -> Kind:
        """Its type."""
        return Kind.TORQUES


Acts = SetControl | SetPulse | SetSqueeze | SetTable | SetPiece
Command = Plain | Configure | Simulate | Alive | Again | Zero | Acts


def pack_settings(settings: Settings) -> bytes:
    """Settings as they lie in CONFIGURE, and in its ACK; the controller has a command of its own."""
    return SETTINGS.pack(*settings.numbers)


def unpack_settings(data: bytes) -> Settings:
    """Settings; raises struct.error for another length."""
    return Settings(*SETTINGS.unpack(data))


def pack_simulated(simulated: Simulated) -> bytes:
    """A simulated knob as it lies in SIMULATE, and in its ACK; raises ValueError for more than four sines."""
    sines = (simulated.push_sines, simulated.grip_sines)
    if max(map(len, sines)) > MOST_SINES:
        raise ValueError(f"at most {MOST_SINES} sines of push and of grip")
    head = KNOB.pack(*simulated[:9], *map(len, sines))
    return head + b"".join(SINE.pack(*sine) for group in sines for sine in group)


def unpack_simulated(data: bytes) -> Simulated:
    """A simulated knob; raises struct.error for another length or more than four sines."""
    *knob, push_count, grip_count = KNOB.unpack_from(data)
    if max(push_count, grip_count) > MOST_SINES or len(data) != KNOB.size + (push_count + grip_count) * SINE.size:
        raise struct.error("length")
    sines = tuple(Sine(*each) for each in SINE.iter_unpack(data[KNOB.size :]))
    return Simulated._make((*knob, sines[:push_count], sines[push_count:], ()))


def pack_command(command: Command) -> bytes:
    """What follows version and type."""
    nonce = NONCE.pack(command.nonce)
    match command:
        case Plain():
            return nonce
        case Configure():
            return nonce + pack_settings(command.settings)
        case Simulate():
            return nonce + pack_simulated(command.simulated)
        case Alive():
            return nonce + ALIVE.pack(command.expected)
        case Again():
            return nonce + AGAIN.pack(command.first, command.count)
        case Zero():
            return nonce + ZERO.pack(command.angle)
        case SetControl():
            return nonce + pack_control(command.control)
        case SetPulse():
            return nonce + pack_pulse(command.pulse)
        case SetSqueeze():
            return nonce + pack_squeeze(command.squeeze)
        case SetTable():
            return nonce + pack_table(command.table)
        case SetPiece():
            return nonce + pack_piece(command.piece)


def unpack_command(kind: Kind, data: bytes) -> Command:
    """The command of what follows version and type; raises struct.error for another length."""
    (nonce,) = NONCE.unpack_from(data)
    rest = data[NONCE.size :]
    if kind is Kind.CONFIGURE:
        return Configure(nonce, unpack_settings(rest))
    if kind is Kind.SIMULATE:
        return Simulate(nonce, unpack_simulated(rest))
    if kind is Kind.ALIVE:
        return Alive(nonce, *ALIVE.unpack(rest))
    if kind is Kind.AGAIN:
        return Again(nonce, *AGAIN.unpack(rest))
    if kind is Kind.ZERO:
        return Zero(nonce, *ZERO.unpack(rest))
    if kind is Kind.CONTROL:
        return SetControl(nonce, unpack_control(rest))
    if kind is Kind.PULSE:
        return SetPulse(nonce, unpack_pulse(rest))
    if kind is Kind.SQUEEZE:
        return SetSqueeze(nonce, unpack_squeeze(rest))
    if kind is Kind.OVER_ANGLE:
        return SetTable(nonce, unpack_table(rest))
    if kind is Kind.TORQUES:
        return SetPiece(nonce, unpack_piece(rest))
    if rest:
        raise struct.error("length")
    return Plain(kind, nonce)
