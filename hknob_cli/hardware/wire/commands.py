"""What the host sends: commands, their fields, and how these lie in a body."""

import struct
from typing import NamedTuple

from hknob_cli.hardware.port import MOST_SINES, Settings, Simulated, Sine
from hknob_cli.hardware.wire.codes import KINDS, SINE, UNPACK_ACT, Act, Kind, pack_act

NONCE = struct.Struct("<I")
SETTINGS = struct.Struct("<IIddddIH")
KNOB = struct.Struct("<9dBB")
ALIVE = struct.Struct("<I")
AGAIN = struct.Struct("<IH")
ZERO = struct.Struct("<i")

PLAIN = (Kind.HELLO, Kind.ARM, Kind.START, Kind.STOP, Kind.RELEASE, Kind.ABILITIES)


class Plain(NamedTuple):
    """HELLO, ARM, START, STOP, RELEASE or ABILITIES: nothing but a nonce."""

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


class SetAct(NamedTuple):
    """What acts in a trial beside the plain wall: `codes.KINDS` has its type."""

    nonce: int
    act: Act

    @property
    def kind(self) -> Kind:
        """Its type."""
        return KINDS[type(self.act)]


Command = Plain | Configure | Simulate | Alive | Again | Zero | SetAct


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
        case SetAct():
            return nonce + pack_act(command.act)


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
    if kind in UNPACK_ACT:
        return SetAct(nonce, UNPACK_ACT[kind](rest))
    if rest:
        raise struct.error("length")
    return Plain(kind, nonce)
