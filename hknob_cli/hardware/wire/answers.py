"""What a target sends: answers, blocks of samples, events, and how these lie in a body."""

import struct
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from hknob_cli.hardware.port import Block, Settings, Simulated
from hknob_cli.hardware.wire.codes import UNPACK_ACT, Act, Kind, State, Status, Trip, pack_act
from hknob_cli.hardware.wire.commands import ZERO, pack_settings, pack_simulated, unpack_settings, unpack_simulated

ACK = struct.Struct("<IBBBBII")
HELLO = struct.Struct("<IIB16s")
ABILITIES = struct.Struct("<II")
BLOCK = struct.Struct("<IIIIIB")
SAMPLE = np.dtype([("time_us", "<u4"), ("angle", "<i4"), ("torque_nm", "<f4"), ("grip_n", "<f4"), ("flags", "u1")])
EVENT = struct.Struct("<IIBIII")

LOOKS = struct.Struct("<B")  # of READINGS, behind the head of a block
MOST_SAMPLES = 48
MOST_SAMPLE_BYTES = 1000  # of a block, with what was read within the intervals
SIMULATED_FLAG = RUNNING_FLAG = 1
NO_GRIP_CELL_FLAG, OWN_TIME_FLAG, KNOWS_ZERO_FLAG, KNOWS_CONTROL_FLAG, KNOWS_PULSES_FLAG = 2, 4, 8, 16, 32
KNOWS_OVER_ANGLE_FLAG, KNOWS_ABILITIES_FLAG = 64, 128


class About(NamedTuple):
    """What the answer to HELLO says of the target."""

    native_counts: int
    shortest_period_ns: int
    simulated: bool
    name: str
    no_grip_cell: bool = False
    own_time: bool = False
    knows_zero: bool = False
    knows_control: bool = False
    knows_pulses: bool = False
    knows_over_angle: bool = False
    knows_abilities: bool = False


class Abilities(NamedTuple):
    """What the answer to ABILITIES says: ``laws``, and what it ``knows`` beside, a bit each."""

    laws: int
    knows: int


Said = About | Abilities | Settings | Simulated | Act | int


class Ack(NamedTuple):
    """The answer to the command ``nonce`` of type ``of``; ``said``: what commands with values are told."""

    nonce: int
    of: int
    status: Status
    state: State
    fault: Trip
    boot: int
    blocks: int
    said: Said | None = None

    @property
    def kind(self) -> Kind:
        """Its type."""
        return Kind.ACK


class Samples(NamedTuple):
    """Block number ``block`` of a run; READINGS where it has what was read within the intervals."""

    boot: int
    run: int
    block: int
    samples: Block

    @property
    def kind(self) -> Kind:
        """Its type."""
        return Kind.BLOCK if self.samples.looks is None else Kind.READINGS


class Event(NamedTuple):
    """The target has tripped, at sample ``index``; ``blocks`` were made, the last one included."""

    boot: int
    run: int
    fault: Trip
    index: int  # type: ignore[assignment]  # the protocol's name; hides tuple.index, which nothing uses
    time_us: int
    blocks: int

    @property
    def kind(self) -> Kind:
        """Its type."""
        return Kind.EVENT


Answer = Ack | Samples | Event


def pack_answer(answer: Answer) -> bytes:
    """What follows version and type; raises struct.error or ValueError for what has no place in it."""
    match answer:
        case Ack():
            return ACK.pack(*answer[:-1]) + _pack_said(answer.said)
        case Samples():
            block = answer.samples
            looks = 0 if block.looks is None else block.looks.shape[1]
            rows = np.zeros(len(block.time_us), _samples_with(looks))
            rows["time_us"], rows["angle"], rows["flags"] = block.time_us, block.angle_counts, block.running
            rows["torque_nm"], rows["grip_n"] = block.torque_nm, block.grip_n
            head = BLOCK.pack(answer.boot, answer.run, answer.block, block.first, block.overruns, len(rows))
            if block.looks is None:
                return head + rows.tobytes()
            rows["looks"] = block.looks
            return head + LOOKS.pack(looks) + rows.tobytes()
        case Event():
            return EVENT.pack(*answer)


def unpack_answer(kind: Kind, data: bytes) -> Answer:
    """The answer of what follows version and type; raises struct.error or ValueError for what cannot be one."""
    if kind is Kind.ACK:
        nonce, of, status, state, fault, boot, blocks = ACK.unpack_from(data)
        said = _unpack_said(of, Status(status), data[ACK.size :])
        return Ack(nonce, of, Status(status), State(state), Trip(fault), boot, blocks, said)
    if kind is Kind.EVENT:
        boot, run, fault, index, time_us, blocks = EVENT.unpack(data)
        return Event(boot, run, Trip(fault), index, time_us, blocks)
    return _unpack_block(data, looks=kind is Kind.READINGS)


def _pack_said(said: Said | None) -> bytes:
    match said:
        case About():
            flags = said.simulated * SIMULATED_FLAG + said.no_grip_cell * NO_GRIP_CELL_FLAG
            flags += said.own_time * OWN_TIME_FLAG + said.knows_zero * KNOWS_ZERO_FLAG
            flags += said.knows_control * KNOWS_CONTROL_FLAG + said.knows_pulses * KNOWS_PULSES_FLAG
            flags += said.knows_over_angle * KNOWS_OVER_ANGLE_FLAG + said.knows_abilities * KNOWS_ABILITIES_FLAG
            return HELLO.pack(said.native_counts, said.shortest_period_ns, flags, said.name.encode("ascii"))
        case Abilities():
            return ABILITIES.pack(*said)
        case int():
            return ZERO.pack(said)
        case Settings():
            return pack_settings(said)
        case Simulated():
            return pack_simulated(said)
        case None:
            return b""
        case _:
            return pack_act(said)


def _unpack_said(of: int, status: Status, data: bytes) -> Said | None:
    if of == Kind.HELLO:
        native_counts, shortest_period_ns, flags, name = HELLO.unpack(data)
        text = name.rstrip(b"\0").decode("ascii")
        if not text.isprintable():
            raise ValueError("name")
        return About(
            native_counts,
            shortest_period_ns,
            simulated=bool(flags & SIMULATED_FLAG),
            name=text,
            no_grip_cell=bool(flags & NO_GRIP_CELL_FLAG),
            own_time=bool(flags & OWN_TIME_FLAG),
            knows_zero=bool(flags & KNOWS_ZERO_FLAG),
            knows_control=bool(flags & KNOWS_CONTROL_FLAG),
            knows_pulses=bool(flags & KNOWS_PULSES_FLAG),
            knows_over_angle=bool(flags & KNOWS_OVER_ANGLE_FLAG),
            knows_abilities=bool(flags & KNOWS_ABILITIES_FLAG),
        )
    if status is Status.DONE and of in _UNPACK:
        return _UNPACK[of](data)
    if data:
        raise ValueError("length")
    return None


def _unpack_abilities(data: bytes) -> Abilities:
    return Abilities(*ABILITIES.unpack(data))


def _unpack_zero(data: bytes) -> int:
    (angle,) = ZERO.unpack(data)
    return int(angle)


_UNPACK: dict[int, Callable[[bytes], Said]] = {
    Kind.CONFIGURE: unpack_settings,
    Kind.SIMULATE: unpack_simulated,
    Kind.ZERO: _unpack_zero,
    Kind.ABILITIES: _unpack_abilities,
    **UNPACK_ACT,
}


def _samples_with(looks: int) -> np.dtype[Any]:
    """A sample with so many readings behind it."""
    return np.dtype([*SAMPLE.descr, ("looks", "<i4", (looks,))]) if looks else SAMPLE


def most_samples(looks: int) -> int:
    """How many samples a block has at most where so many readings are with each; 0: not even one."""
    return min(MOST_SAMPLES, MOST_SAMPLE_BYTES // _samples_with(looks).itemsize)


def _unpack_block(data: bytes, *, looks: bool) -> Samples:
    boot, run, block, first, overruns, count = BLOCK.unpack_from(data)
    begin, each = BLOCK.size, 0
    if looks:
        (each,) = LOOKS.unpack_from(data, begin)
        begin += LOOKS.size
        if each == 0:
            raise ValueError("readings")
    kind = _samples_with(each)
    if not 1 <= count <= MOST_SAMPLES or len(data) != begin + count * kind.itemsize:
        raise ValueError("length")
    rows = np.frombuffer(data, kind, offset=begin)
    with np.errstate(invalid="ignore"):  # a NaN that signals; what is no number ends the trial, by its name
        torque_nm, grip_n = rows["torque_nm"].astype(np.float64), rows["grip_n"].astype(np.float64)
    samples = Block(
        first,
        rows["time_us"].astype(np.int64),
        rows["angle"].astype(np.int64),
        torque_nm,
        grip_n,
        (rows["flags"] & RUNNING_FLAG).astype(np.bool_),
        overruns,
        looks=rows["looks"].astype(np.int64) if looks else None,
    )
    return Samples(boot, run, block, samples)
