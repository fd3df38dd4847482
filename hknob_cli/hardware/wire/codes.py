"""Numbers of the protocol (docs/reference/wire.md), and what acts beside the plain wall as it lies in bodies.

A controller; a pulse; who squeezes a simulated knob that pulses; a torque over the angle, in pieces; and converters.
"""

import struct
from collections.abc import Callable
from enum import IntEnum
from typing import NamedTuple

from hknob_cli.hardware.port import MOST_HANDS, MOST_SINES, Control, Converters, OverAngle, Pulse, Sine, Squeeze

VERSION = 1


class Kind(IntEnum):
    """Types of messages; the target's have their top bit set."""

    HELLO = 0x01
    CONFIGURE = 0x02
    ARM = 0x03
    START = 0x04
    STOP = 0x05
    RELEASE = 0x06
    ALIVE = 0x07
    AGAIN = 0x08
    ZERO = 0x09
    SIMULATE = 0x10
    CONTROL = 0x11
    PULSE = 0x12
    SQUEEZE = 0x13
    OVER_ANGLE = 0x14
    TORQUES = 0x15
    ABILITIES = 0x16
    CONVERTERS = 0x17
    ACK = 0x81
    BLOCK = 0x82
    EVENT = 0x83
    READINGS = 0x84


class Law(IntEnum):
    """Controllers that a target can run; the names are those of their functions in `controllers`."""

    BOUNDED_LAG = 1
    FIRST_ORDER_HOLD = 2
    PASSIVITY = 3
    PHASE_DAMPING = 4
    STIFFENING = 5
    VELOCITY_DAMPING = 6
    DIFFERENCED_VELOCITY = 7
    TIMED_VELOCITY = 8
    ADAPTIVE_VELOCITY = 9
    TRACKED_VELOCITY = 10
    IMPULSE_DAMPING = 11
    HALF_SAMPLE = 12
    MATCHED_WALL = 13

    @property
    def bit(self) -> int:
        """Its place among the laws that a target has."""
        return 1 << self


ALL_LAWS = sum(law.bit for law in Law)


class Status(IntEnum):
    """What became of a command."""

    DONE = 0
    NOT_NOW = 1
    OUT_OF_RANGE = 2
    NOT_KNOWN = 3


class State(IntEnum):
    """What a target is doing."""

    IDLE = 0
    ARMED = 1
    RUNNING = 2
    TRIPPED = 3


class Trip(IntEnum):
    """Why a target took its torque off by itself."""

    NONE = 0
    WATCHDOG = 1
    SPEED = 2
    NOT_A_NUMBER = 3
    EMERGENCY_STOP = 4
    NO_ROOM = 5


STATUS_TEXT = {
    Status.DONE: "done",
    Status.NOT_NOW: "not in this state",
    Status.OUT_OF_RANGE: "a value is out of its range",
    Status.NOT_KNOWN: "it does not know this command",
}
TRIP_TEXT = {
    Trip.NONE: "it did not say why",
    Trip.WATCHDOG: "it did not hear from this computer for the watchdog's time (program stopped, or cable out?)",
    Trip.SPEED: "the knob turned faster than the speed limit",
    Trip.NOT_A_NUMBER: "a torque was not a number",
    Trip.EMERGENCY_STOP: "the emergency stop was pressed",
    Trip.NO_ROOM: "this computer took no samples for so long that the target has no room for more",
}


LAW = struct.Struct("<4B")
PULSE = struct.Struct("<4dII")
SQUEEZE = struct.Struct("<6d3B")
HAND = struct.Struct("<4d")
SINE = struct.Struct("<3d")
OVER_ANGLE = struct.Struct("<iIIdd")
TORQUES = struct.Struct("<IB")
CONVERTERS = struct.Struct("<5dB")
MOST_TORQUES = 32


class Table(NamedTuple):
    """The head of an `OverAngle`: all but its torques, and how many there are."""

    first: int
    turn: int
    size: int
    below: float
    above: float


class Piece(NamedTuple):
    """Torques (N·m) of an `OverAngle`, from the place ``at`` on."""

    at: int
    torques: tuple[float, ...]


Act = Control | Pulse | Squeeze | Table | Piece | Converters
KINDS: dict[type[Act], Kind] = {
    Control: Kind.CONTROL,
    Pulse: Kind.PULSE,
    Squeeze: Kind.SQUEEZE,
    Table: Kind.OVER_ANGLE,
    Piece: Kind.TORQUES,
    Converters: Kind.CONVERTERS,
}


def pieces_of(over: OverAngle) -> tuple[Table, list[Piece]]:
    """The head, and the pieces in their order."""
    places = range(0, len(over.torques), MOST_TORQUES)
    head = Table(over.first, over.turn, len(over.torques), over.below, over.above)
    return head, [Piece(at, over.torques[at : at + MOST_TORQUES]) for at in places]


def pack_control(control: Control) -> bytes:
    """A controller as it lies in CONTROL, and in its ACK."""
    numbers = (*control.numbers, *control.rows)
    head = LAW.pack(control.law, control.places, len(control.numbers), len(control.rows))
    return head + struct.pack(f"<{len(numbers)}d", *numbers)


def unpack_control(data: bytes) -> Control:
    """A controller; raises struct.error for another length."""
    law, places, count, rows = LAW.unpack_from(data)
    numbers = struct.unpack(f"<{count + rows}d", data[LAW.size :])
    return Control(law, places, numbers[:count], numbers[count:])


def pack_pulse(pulse: Pulse) -> bytes:
    """A pulse as it lies in PULSE, and in its ACK."""
    return PULSE.pack(*pulse)


def unpack_pulse(data: bytes) -> Pulse:
    """A pulse; raises struct.error for another length."""
    return Pulse(*PULSE.unpack(data))


def pack_squeeze(squeeze: Squeeze) -> bytes:
    """Who squeezes, as it lies in SQUEEZE, and in its ACK; raises ValueError for too many hands or sines."""
    one = squeeze
    if len(one.hands) > MOST_HANDS or len(one.sines) > MOST_SINES:
        raise ValueError(f"at most {MOST_HANDS} hands and {MOST_SINES} sines")
    numbers = (one.aim_n, one.rise_s, one.overshoot, one.reaction_s, one.relax_s, one.strength_n)
    head = SQUEEZE.pack(*numbers, one.climbs, len(one.hands), len(one.sines))
    return head + b"".join((*(HAND.pack(*hand) for hand in one.hands), *(SINE.pack(*sine) for sine in one.sines)))


def unpack_squeeze(data: bytes) -> Squeeze:
    """Who squeezes; raises struct.error for another length, or for more hands or sines than there may be."""
    *numbers, climbs, hand_count, sine_count = SQUEEZE.unpack_from(data)
    split = SQUEEZE.size + hand_count * HAND.size
    if max(hand_count - MOST_HANDS, sine_count - MOST_SINES) > 0 or len(data) != split + sine_count * SINE.size:
        raise struct.error("length")
    if climbs > 1:
        raise struct.error("a flag")
    hands = tuple(HAND.iter_unpack(data[SQUEEZE.size : split]))
    sines = tuple(Sine(*each) for each in SINE.iter_unpack(data[split:]))
    aim_n, rise_s, overshoot, reaction_s, relax_s, strength_n = numbers
    return Squeeze(aim_n, rise_s, overshoot, bool(climbs), reaction_s, relax_s, strength_n, hands, sines)


def pack_table(table: Table) -> bytes:
    """The head of a table as it lies in OVER_ANGLE, and in its ACK."""
    return OVER_ANGLE.pack(*table)


def unpack_table(data: bytes) -> Table:
    """The head of a table; raises struct.error for another length."""
    return Table(*OVER_ANGLE.unpack(data))


def pack_piece(piece: Piece) -> bytes:
    """Torques as they lie in TORQUES, and in its ACK; raises ValueError for too many."""
    count = len(piece.torques)
    if count > MOST_TORQUES:
        raise ValueError(f"at most {MOST_TORQUES} torques")
    return TORQUES.pack(piece.at, count) + struct.pack(f"<{count}d", *piece.torques)


def unpack_piece(data: bytes) -> Piece:
    """Torques; raises struct.error for another length, or for more than there may be."""
    at, count = TORQUES.unpack_from(data)
    if count > MOST_TORQUES:
        raise struct.error("length")
    return Piece(at, struct.unpack(f"<{count}d", data[TORQUES.size :]))


def pack_converters(converters: Converters) -> bytes:
    """Converters as they lie in CONVERTERS, and in its ACK."""
    return CONVERTERS.pack(*converters)


def unpack_converters(data: bytes) -> Converters:
    """Converters; raises struct.error for another length."""
    return Converters(*CONVERTERS.unpack(data))


def pack_act(act: Act) -> bytes:
    """Any of these, by its type; raises ValueError for too much."""
    match act:
        case Control():
            return pack_control(act)
        case Pulse():
            return pack_pulse(act)
        case Squeeze():
            return pack_squeeze(act)
        case Table():
            return pack_table(act)
        case Piece():
            return pack_piece(act)
        case Converters():
            return pack_converters(act)


UNPACK_ACT: dict[int, Callable[[bytes], Act]] = {
    Kind.CONTROL: unpack_control,
    Kind.PULSE: unpack_pulse,
    Kind.SQUEEZE: unpack_squeeze,
    Kind.OVER_ANGLE: unpack_table,
    Kind.TORQUES: unpack_piece,
    Kind.CONVERTERS: unpack_converters,
}
