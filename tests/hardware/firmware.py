"""The target's C sources as a library that Python loads, on a board that does what a test says."""

import atexit
import ctypes as c
import functools
import os
import shutil
import subprocess
import tempfile
from pathlib import Path

import pytest

from hknob_cli.errors import DeviceError
from hknob_cli.hardware.port import Control, Converters, Pulse, Settings, Simulated, Squeeze
from hknob_cli.hardware.reference_target import ARITHMETIC, PORTABLE, SOURCES, STRICT, compiler
from hknob_cli.hardware.wire.answers import Ack, Event, Samples
from hknob_cli.hardware.wire.codes import Kind, Piece, State
from hknob_cli.hardware.wire.commands import Plain
from hknob_cli.hardware.wire.messages import Decoder, Message, decode, encode, frame

HERE = Path(__file__).parent
PARTS = [*(str(SOURCES / name) for name in (*PORTABLE, "plant.c", "squeeze.c")), str(HERE / "scripted_board.c")]
MS = 1_000_000  # ns


class CSettings(c.Structure):
    _fields_ = (
        *((name, c.c_uint32) for name in ("period_ns", "counts_per_rev")),
        *((name, c.c_double) for name in Settings._fields[2:6]),
        ("watchdog_us", c.c_uint32),
        ("block_samples", c.c_uint16),
    )


class CSine(c.Structure):
    _fields_ = tuple((name, c.c_double) for name in ("amplitude", "frequency_hz", "phase"))


class CSimulated(c.Structure):
    _fields_ = (
        *((name, c.c_double) for name in Simulated._fields[:9]),
        ("push_count", c.c_uint8),
        ("grip_count", c.c_uint8),
        ("sines", CSine * 8),
    )

    @classmethod
    def of(cls, simulated: Simulated) -> "CSimulated":
        sines = (*simulated.push_sines, *simulated.grip_sines)
        counts = len(simulated.push_sines), len(simulated.grip_sines)
        return cls(*simulated[:9], *counts, (CSine * 8)(*(CSine(*sine) for sine in sines)))


class CControl(c.Structure):
    _fields_ = (
        *((name, c.c_uint8) for name in ("law", "places", "number_count", "row_count")),
        ("numbers", c.c_double * 9),
        ("rows", c.c_double * 65),
    )

    @classmethod
    def of(cls, control: Control) -> "CControl":
        numbers, rows = control.numbers, control.rows
        counts = len(numbers), len(rows)
        return cls(control.law, control.places, *counts, (c.c_double * 9)(*numbers), (c.c_double * 65)(*rows))


class CPulse(c.Structure):
    _fields_ = (
        *((name, c.c_double) for name in Pulse._fields[:4]),
        *((name, c.c_uint32) for name in Pulse._fields[4:]),
    )


class CPulseState(c.Structure):
    _fields_ = (("sum", c.c_double), ("count", c.c_uint32), ("stayed", c.c_uint32), ("phase", c.c_uint8))


class CSqueeze(c.Structure):
    _fields_ = (
        *((name, c.c_double) for name in ("aim_n", "rise_s", "overshoot", "reaction_s", "relax_s", "strength_n")),
        *((name, c.c_uint8) for name in ("climbs", "hand_count", "sine_count")),
        ("hands", c.c_double * 4 * 10),
        ("sines", CSine * 4),
    )

    @classmethod
    def of(cls, one: Squeeze) -> "CSqueeze":
        numbers = (one.aim_n, one.rise_s, one.overshoot, one.reaction_s, one.relax_s, one.strength_n)
        hands = (c.c_double * 4 * 10)(*((c.c_double * 4)(*hand) for hand in one.hands))
        counts = one.climbs, len(one.hands), len(one.sines)
        return cls(*numbers, *counts, hands, (CSine * 4)(*(CSine(*sine) for sine in one.sines)))


class CTable(c.Structure):
    _fields_ = (
        ("first", c.c_int32),
        *((name, c.c_uint32) for name in ("turn", "size")),
        *((name, c.c_double) for name in ("below", "above")),
    )


class CPiece(c.Structure):
    _fields_ = (("at", c.c_uint32), ("count", c.c_uint8), ("values", c.c_double * 32))

    @classmethod
    def of(cls, piece: Piece) -> "CPiece":
        return cls(piece.at, len(piece.torques), (c.c_double * 32)(*piece.torques))


class CConverters(c.Structure):
    _fields_ = (
        *((name, c.c_double) for name in Converters._fields[:-1]),
        ("rounding", c.c_uint8),
    )


class CSlot(c.Structure):
    _fields_ = (("begins", c.c_double), ("age", c.c_uint32), ("part", c.c_uint32))


class CLine(c.Structure):
    _fields_ = (
        *((name, c.c_uint32) for name in ("parts", "rows", "newest", "slot_count")),
        ("slots", CSlot * 65),
        ("torques", c.c_double * 1024),
    )


class COverAngle(c.Structure):
    _fields_ = (("head", CTable), ("filled", c.c_uint32), ("torques", c.c_double * 16_640))


class CCommand(c.Structure):
    _fields_ = (
        ("type", c.c_uint8),
        ("nonce", c.c_uint32),
        ("first", c.c_uint32),
        ("count", c.c_uint16),
        ("angle", c.c_int32),
        ("settings", CSettings),
        ("simulated", CSimulated),
        ("control", CControl),
        ("pulse", CPulse),
        ("squeeze", CSqueeze),
        ("over_angle", CTable),
        ("torques", CPiece),
        ("converters", CConverters),
    )


def need_compiler() -> list[str]:
    """A C compiler; skips the test where there is none."""
    try:
        return compiler("host")
    except DeviceError as error:
        pytest.skip(str(error))


def compiled(output: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Compile strictly; the compiler's result."""
    command = [*need_compiler(), *STRICT, "-Werror", *ARITHMETIC, f"-I{SOURCES}", *arguments, "-o", str(output), "-lm"]
    return subprocess.run(command, capture_output=True, text=True)


@functools.cache
def library() -> c.CDLL:
    """The library, built once in a process."""
    folder = Path(tempfile.mkdtemp(prefix="hknob-firmware-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    done = compiled(folder / "firmware.so", "-shared", "-fPIC", *PARTS)
    assert done.returncode == 0, done.stderr
    built = c.CDLL(os.fspath(folder / "firmware.so"))
    built.frame_crc.restype = c.c_uint32
    for name in ("frame_encode", "frame_decode", "frame_take"):
        getattr(built, name).restype = c.c_size_t
    built.wall_decimate.restype = c.c_int64
    built.wall_decimate.argtypes = (c.c_int32, c.c_uint32, c.c_uint32)
    built.wall_torque.restype = built.wall_limit.restype = c.c_double
    built.wall_torque.argtypes = (c.c_int64, c.c_int64, *5 * (c.c_double,))
    built.wall_limit.argtypes = (c.c_double, c.c_double)
    built.law_act.restype = built.wall_controlled.restype = c.c_double
    built.law_begin.argtypes = (c.POINTER(CControl), c.POINTER(c.c_double), c.c_double)
    built.law_act.argtypes = (*built.law_begin.argtypes, c.POINTER(c.c_double))
    built.law_parts.restype = built.law_looks.restype = built.law_known.restype = c.c_uint32
    built.law_looks.argtypes = (c.POINTER(CControl),)
    built.law_parts.argtypes = (c.POINTER(CControl), c.POINTER(c.c_double))
    built.convert_count.restype, built.convert_send.restype = c.c_int64, c.c_double
    built.convert_count.argtypes = (c.POINTER(CConverters), c.c_int32, c.c_uint32, c.c_uint32)
    built.convert_send.argtypes = (c.POINTER(CConverters), c.c_double)
    built.converters_in_range.restype = built.line_begin.restype = c.c_bool
    built.converters_in_range.argtypes = (c.POINTER(CConverters),)
    built.line_begin.argtypes = (c.POINTER(CLine), c.c_uint32, c.POINTER(c.c_double), c.c_double)
    built.line_put.argtypes = (c.POINTER(CLine), c.POINTER(c.c_double))
    built.line_torque.restype, built.line_torque.argtypes = c.c_double, (c.POINTER(CLine), c.c_uint32)
    built.wall_controlled.argtypes = (c.c_double, c.c_int64, c.c_int64, *4 * (c.c_double,))
    built.control_in_range.restype = c.c_bool
    built.control_in_range.argtypes = (c.POINTER(CControl),)
    built.pulse_step.restype = c.c_double
    built.pulse_step.argtypes = (c.POINTER(CPulse), c.POINTER(CPulseState), c.c_double, c.c_bool)
    built.pulse_in_range.restype = built.squeeze_in_range.restype = c.c_bool
    built.pulse_in_range.argtypes = (c.POINTER(CPulse), c.POINTER(CSettings))
    built.squeeze_in_range.argtypes = (c.POINTER(CSqueeze),)
    built.scripted_squeezed.restype = c.c_int
    built.scripted_squeezed.argtypes = (
        *(c.POINTER(CSimulated), c.POINTER(CSqueeze), c.POINTER(CPulse), c.c_double),
        *(c.c_size_t, c.c_size_t, *3 * (c.c_void_p,)),
    )
    built.over_angle_begin.restype = built.over_angle_take.restype = c.c_bool
    built.over_angle_begin.argtypes = (c.POINTER(COverAngle), c.POINTER(CTable))
    built.over_angle_take.argtypes = (c.POINTER(COverAngle), c.POINTER(CPiece))
    built.over_angle_torque.restype = built.wall_brake.restype = c.c_double
    built.over_angle_torque.argtypes = (c.POINTER(COverAngle), c.c_int64)
    built.wall_brake.argtypes = (c.c_int64, c.c_int64, *3 * (c.c_double,))
    built.command_read.restype = built.target_serve.restype = built.target_busy.restype = c.c_bool
    built.scripted_follow.argtypes = (c.POINTER(CSimulated), c.c_double, c.c_size_t, *3 * (c.c_void_p,))
    built.scripted_person.argtypes = (c.POINTER(CSimulated), c.c_double, c.c_size_t, *2 * (c.c_void_p,))
    return built


class Variable:
    """One of the scripted board's variables, as an attribute."""

    def __init__(self, kind: type) -> None:
        self.kind = kind

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = f"scripted_{name}"

    def __get__(self, instance: object, owner: type) -> int:
        return self.kind.in_dll(library(), self.name).value

    def __set__(self, instance: object, value: float) -> None:
        self.kind.in_dll(library(), self.name).value = value


class ScriptedTarget:
    """The target on the scripted board, just started; time passes only by `run`."""

    now = Variable(c.c_uint64)
    call_at = Variable(c.c_uint64)
    angle = Variable(c.c_int32)
    torque = Variable(c.c_double)
    grip = Variable(c.c_double)
    passed = Variable(c.c_double)
    samples = Variable(c.c_uint32)
    boot = Variable(c.c_uint32)
    trials = Variable(c.c_uint32)
    starts = Variable(c.c_uint32)
    locks = Variable(c.c_uint32)
    emergency = Variable(c.c_uint8)
    unable = Variable(c.c_uint8)
    in_count = Variable(c.c_size_t)
    in_at = Variable(c.c_size_t)
    out_count = Variable(c.c_size_t)
    out_room = Variable(c.c_size_t)

    def __init__(self) -> None:
        self.c = library()
        self.now, self.angle, self.torque, self.grip, self.emergency = 10**12, 0, 0.0, 0.0, 0
        self.passed, self.samples = 0.0, 0
        self.unable = self.trials = self.starts = self.locks = self.in_count = self.in_at = self.out_count = 0
        self.out_room, self.boot, self.call_at = 1 << 18, 7, 2**64 - 1
        self.nonce = 100
        self.decoder = Decoder()
        self.c.target_begin()

    def said(self) -> list[Message | None]:
        """What the target has sent since last asked."""
        out = (c.c_uint8 * (1 << 18)).in_dll(self.c, "scripted_out")
        sent = bytes(out[: self.out_count])
        self.out_count = 0
        return [decode(body) for body in self.decoder.feed(sent)]

    def put(self, message: Message) -> None:
        """Lay a message on the line."""
        data = frame(encode(message))
        c.memmove((c.c_uint8 * 65536).in_dll(self.c, "scripted_in"), data, len(data))
        self.in_at, self.in_count = 0, len(data)

    def tell(self, message: Message) -> list[Message | None]:
        """Send a message, and what the target says at once."""
        self.put(message)
        self.c.target_serve()
        return self.said()

    def command(self, message: Message) -> Ack:
        """The answer to a command, which comes after all else."""
        *_, answer = self.tell(message)
        assert isinstance(answer, Ack)
        return answer

    def plain(self, kind: Kind) -> Ack:
        """The answer to a command of its own nonce."""
        self.nonce += 1
        return self.command(Plain(kind, self.nonce))

    def bring_to(self, state: State) -> None:
        """Take it from idle, with settings, to a state; it trips while it runs, by its emergency stop."""
        if state >= State.ARMED:
            self.plain(Kind.ARM)
        if state >= State.RUNNING:
            self.plain(Kind.START)
        if state == State.TRIPPED:
            self.emergency = 1
            self.sample()
            self.c.target_serve()
        self.said()

    def sample(self, late_ns: int = 0) -> None:
        """Let time pass to the next sample, and take it."""
        assert self.call_at < 2**64 - 1
        self.now = max(self.now, self.call_at) + late_ns
        self.c.target_sample()

    def run(self, duration_ns: int) -> None:
        """Let time pass, the main loop every ms."""
        end = self.now + duration_ns
        while True:
            serve = self.now // MS * MS + MS
            if self.call_at <= min(serve, end):
                self.sample()
            else:
                self.now = min(serve, end)
                self.c.target_serve()
                if self.now == end:
                    return


def samples_of(said: list[Message | None]) -> list[Samples]:
    return [each for each in said if isinstance(each, Samples)]


def events_of(said: list[Message | None]) -> list[Event]:
    return [each for each in said if isinstance(each, Event)]
