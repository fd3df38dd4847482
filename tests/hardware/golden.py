"""Golden frames: for every message type what is said, and how it is written in data/wire/golden_frames.txt.

``python -m tests.hardware.golden`` prints that file; it changes only with the protocol's version.
"""

from typing import Any

import numpy as np

from hknob_cli.hardware.port import Block, Control, Converters, Pulse, Settings, Simulated, Sine, Squeeze
from hknob_cli.hardware.wire.answers import Abilities, About, Ack, Event, Samples
from hknob_cli.hardware.wire.codes import Kind, Law, Piece, State, Status, Table, Trip
from hknob_cli.hardware.wire.commands import Again, Alive, Configure, Plain, SetAct, Simulate, Zero
from hknob_cli.hardware.wire.messages import Message, encode, frame

HEAD = """\
# Golden frames of the wire's version 1 (docs/reference/wire.md), a line each: name | fields | its frame in hex.
# An encoder given the fields makes these bytes; a decoder given these bytes finds the fields. Both sides test them.
# sampleN=(time_us,angle,torque_nm,grip_n,flags); in block_of_48, torque of sample i is the f32 nearest to i times the
# f32 nearest to 0.001.
"""
BOOT = 0x1A2B3C4D
SETTINGS = Settings(
    period_ns=250_000,
    counts_per_rev=1024,
    wall_stiffness=0.27,
    wall_damping=1.5e-5,
    torque_limit_nm=0.05,
    speed_limit_rad_s=100.0,
    watchdog_us=20_000,
    block_samples=40,
)
SIMULATED = Simulated(
    inertia=2.2e-6,
    damping=3.45e-4,
    stiffness=0.04,
    coulomb_nm=5.6e-4,
    angle_rad=0.02,
    push_nm=1e-3,
    grip_n=0.71,
    grip_rise_s=0.2,
    grip_offset_n=0.125,
)
WITH_SINES = SIMULATED._replace(
    push_sines=(Sine(1e-4, 0.5, 0.25), Sine(5e-5, 9.0, 1.0)), grip_sines=(Sine(0.03, 1.5, -0.5),)
)

# Bounded lag and passivity control at the settings above: numbers that a double holds only nearly, memory, places.
LAG = Control(Law.BOUNDED_LAG, 0, (0.0, 0.0012492190758457357, 0.2), (0.0,))
# A pulse of 5 mN·m for 20 ms after a grip of 0.71 N that was held for 0.1 s, and two hands of Table 1.
PULSE = Pulse(grip_n=0.71, band_n=0.071, release_n=0.213, torque_nm=0.005, width=80, dwell=400)
SQUEEZE = Squeeze(
    aim_n=0.71,
    rise_s=0.2,
    overshoot=0.1,
    climbs=True,
    reaction_s=0.2,
    relax_s=0.05,
    strength_n=30.0,
    hands=((0.71, 2.2e-6, 3.45e-4, 0.04), (1.3, 2.3e-6, 4.5e-4, 0.0625)),
    sines=(Sine(0.02, 0.5, 0.25),),
)
# A spring of 0.25 N·m a count below 0 and none above, two counts a turn, and its six torques.
TABLE = Table(first=-4, turn=2, size=6, below=-0.5, above=0.0)
PIECE = Piece(0, (1.0, 0.75, 0.5, 0.25, 0.0, 0.0))
# An encoder that rounds to the nearest count, a dead band, steps, a limit, and a delay of a sample and a half.
CONVERTERS = Converters(0.25, 0.0001, 0.0005, 0.04, 1.5, 1)
ABILITIES = Abilities(laws=0x3FFE, knows=3)
READING = Abilities(laws=0x3FFE, knows=7)
PASSIVITY = Control(Law.PASSIVITY, 1, (0.0, 0.4444444444444444, 1.0), (0.0, 0.0, 0.0, 0.0))


def block(count: int, *, first: int = 0, overruns: int = 0, start_us: int = 0) -> Block:
    """A block of a made-up signal that the wire's floats hold exactly."""
    index = np.arange(count)
    torque = (float(np.float32(0.001)) * index).astype(np.float32).astype(np.float64)
    return Block(first, start_us + index * 250, -3 * index - 1, torque, 0.5 + index * 0.25, index > 0, overruns)


def ack(nonce: int, of: Kind, **differing: Any) -> Ack:
    """An answer: done, idle, no fault, no blocks, unless told otherwise."""
    return Ack(nonce, of, Status.DONE, State.IDLE, Trip.NONE, BOOT, 0)._replace(**differing)


def without_zeros(count: int) -> Block:
    """Samples all of whose bytes differ from zero, but the lowest of the first angle."""
    index = np.arange(count)
    value = float(np.float32(1.1))
    angle = np.where(index == 0, -256, -1 - index)
    return Block(
        0x01010101, 0x11111111 + index, angle, np.full(count, value), np.full(count, value), index >= 0, 0x01010101
    )


# From the second byte of the first angle to the last of the CRC 254 bytes that are not zero: the frame ends in a full
# run, which no further byte of stuffing follows.
ENDING_IN_254 = Samples(BOOT, 5, 0x01010101, without_zeros(15))

GOLDEN: dict[str, Message] = {
    "hello": Plain(Kind.HELLO, 1),
    "configure": Configure(2, SETTINGS),
    "simulate": Simulate(3, SIMULATED),
    "simulate_with_sines": Simulate(4, WITH_SINES),
    "arm": Plain(Kind.ARM, 5),
    "start": Plain(Kind.START, 6),
    "stop": Plain(Kind.STOP, 7),
    "release": Plain(Kind.RELEASE, 0xFFFFFFFF),
    "alive": Alive(9, 256),
    "again": Again(10, 3, 2),
    "zero": Zero(11, -1024),
    "control": SetAct(12, LAG),
    "control_with_a_place": SetAct(13, PASSIVITY),
    "pulse": SetAct(14, PULSE),
    "squeeze": SetAct(15, SQUEEZE),
    "over_angle": SetAct(16, TABLE),
    "torques": SetAct(17, PIECE),
    "abilities": Plain(Kind.ABILITIES, 18),
    "converters": SetAct(19, CONVERTERS),
    "ack_of_hello": ack(1, Kind.HELLO, said=About(10000, 20000, simulated=True, name="reference")),
    "ack_of_hello_of_a_knob": ack(
        1, Kind.HELLO, said=About(16384, 250000, simulated=False, name="knob", no_grip_cell=True, knows_zero=True)
    ),
    "ack_of_hello_of_a_target_with_controllers": ack(
        1, Kind.HELLO, said=About(10000, 20000, simulated=True, name="reference", knows_zero=True, knows_control=True)
    ),
    "ack_of_hello_of_a_target_with_pulses": ack(
        1,
        Kind.HELLO,
        said=About(10000, 20000, simulated=True, name="reference", knows_control=True, knows_pulses=True),
    ),
    "ack_of_hello_of_a_target_with_torque_over_the_angle": ack(
        1,
        Kind.HELLO,
        said=About(10000, 20000, simulated=True, name="reference", knows_control=True, knows_over_angle=True),
    ),
    "ack_of_hello_of_a_target_with_abilities": ack(
        1,
        Kind.HELLO,
        said=About(10000, 20000, simulated=True, name="reference", knows_control=True, knows_abilities=True),
    ),
    "ack_of_zero": ack(11, Kind.ZERO, said=-1024),
    "ack_of_configure": ack(2, Kind.CONFIGURE, said=SETTINGS),
    "ack_of_configure_refused": ack(2, Kind.CONFIGURE, status=Status.OUT_OF_RANGE),
    "ack_of_simulate": ack(4, Kind.SIMULATE, said=WITH_SINES),
    "ack_of_simulate_not_known": ack(4, Kind.SIMULATE, status=Status.NOT_KNOWN),
    "ack_of_control": ack(13, Kind.CONTROL, said=PASSIVITY),
    "ack_of_control_not_known": ack(12, Kind.CONTROL, status=Status.NOT_KNOWN),
    "ack_of_pulse": ack(14, Kind.PULSE, said=PULSE),
    "ack_of_pulse_not_known": ack(14, Kind.PULSE, status=Status.NOT_KNOWN),
    "ack_of_squeeze": ack(15, Kind.SQUEEZE, said=SQUEEZE),
    "ack_of_over_angle": ack(16, Kind.OVER_ANGLE, said=TABLE),
    "ack_of_over_angle_not_known": ack(16, Kind.OVER_ANGLE, status=Status.NOT_KNOWN),
    "ack_of_torques": ack(17, Kind.TORQUES, said=PIECE),
    "ack_of_abilities": ack(18, Kind.ABILITIES, said=ABILITIES),
    "ack_of_abilities_of_a_target_that_reads_within_an_interval": ack(18, Kind.ABILITIES, said=READING),
    "ack_of_converters": ack(19, Kind.CONVERTERS, said=CONVERTERS),
    "ack_of_converters_not_known": ack(19, Kind.CONVERTERS, status=Status.NOT_KNOWN),
    "ack_of_arm": ack(5, Kind.ARM, state=State.ARMED),
    "ack_of_start": ack(6, Kind.START, state=State.RUNNING, blocks=12),
    "ack_of_stop": ack(7, Kind.STOP, blocks=301),
    "ack_of_stop_tripped": ack(7, Kind.STOP, status=Status.NOT_NOW, state=State.TRIPPED, fault=Trip.SPEED, blocks=17),
    "ack_of_release": ack(0xFFFFFFFF, Kind.RELEASE),
    "block_of_2": Samples(BOOT, 5, 0, block(2)),
    "block_of_48": Samples(BOOT, 5, 7, block(48, first=336, overruns=1, start_us=84_000)),
    "block_ending_in_254": ENDING_IN_254,
    "readings_of_2": Samples(BOOT, 5, 0, block(2)._replace(looks=np.array([[0, 0, 0], [-2, -3, -2147483648]]))),
    "event": Event(BOOT, 5, Trip.WATCHDOG, 673, 168_250, 17),
}


RULES = {
    48: "(84000+250i,-1-3i,i*f32(0.001),0.5+0.25i,i>0)",
    15: "(286331153+i,-256 if i=0 else -1-i,f32(1.1),f32(1.1),1)",
}


def fields(message: Any) -> list[str]:
    """A message's fields as the file writes them."""
    found = []
    for name, value in message._asdict().items():
        if (name, value) == ("squeeze", ()) or name == "sensors":  # SQUEEZE has a person who squeezes; no target has
            continue  # these sensors
        if isinstance(
            value, Converters | Abilities | Settings | Simulated | About | Control | Pulse | Squeeze | Table | Piece
        ):
            found += fields(value)
        elif isinstance(value, Block):
            found += [f"first={value.first}", f"overruns={value.overruns}", *samples(value)]
        elif isinstance(value, tuple):
            texts = (repr(one) if isinstance(one, float) else str(tuple(one)).replace(" ", "") for one in value)
            found.append(f"{name}=[{';'.join(texts)}]")
        elif isinstance(value, int):
            found += [f"{name}={int(value)}"] if name != "kind" else []
        elif value is not None:
            found.append(f"{name}={value}")
    return found


def samples(of: Block) -> list[str]:
    """Samples one by one, or by their rule where they are many."""
    count = len(of.time_us)
    if count > 2:
        return [f"count={count}", f"sample_i={RULES[count]}"]
    rows = zip(of.time_us, of.angle_counts, of.torque_nm, of.grip_n, of.running, strict=True)
    texts = (f"({time},{angle},{torque:.9g},{float(grip)!r},{int(on)})" for time, angle, torque, grip, on in rows)
    looks = [] if of.looks is None else [f"looks{i}=[{';'.join(map(str, row))}]" for i, row in enumerate(of.looks)]
    return [f"count={count}", *(f"sample{index}={text}" for index, text in enumerate(texts)), *looks]


def text() -> str:
    """The whole file."""
    rows = (f"{name} | {' '.join(fields(each))} | {frame(encode(each)).hex()}\n" for name, each in GOLDEN.items())
    return HEAD + "".join(rows)


if __name__ == "__main__":
    print(text(), end="")
