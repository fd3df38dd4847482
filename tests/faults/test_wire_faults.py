"""Faults of the wire, its target and its host: nothing wrong is taken, nothing taken is lost, the torque goes off."""

import errno
import os
import random
import re
import signal
import subprocess
import sys
import threading
import time
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hknob_cli.errors import DeviceError
from hknob_cli.hardware.port import Block, Control, Converters, OverAngle, Pulse, PulseOrder, Settings, Sine
from hknob_cli.hardware.serial_device import SerialDevice
from hknob_cli.hardware.wire import pump
from hknob_cli.hardware.wire.codes import ALL_LAWS, Kind, Law, Piece, State, Table, Trip
from hknob_cli.hardware.wire.commands import Plain
from hknob_cli.hardware.wire.messages import MOST_STUFFED_BYTES, Decoder, body_of, encode, frame
from hknob_cli.hardware.wire.session import Session
from tests.conftest import ROOT
from tests.hardware.controllers import READING, told
from tests.hardware.fake_target import Manners, PtyTarget, spoiler, spoilt
from tests.hardware.golden import BOOT, CONVERTERS, GOLDEN, SETTINGS, WITH_SINES
from tests.hardware.test_serial_device import assert_whole, trial

pytestmark = pytest.mark.long  # programs that talk in real time

# A host in a process of its own: it says what it does, line by line, and what ended it.
HOST = """
import sys
from hknob_cli.errors import DeviceError
from hknob_cli.hardware.serial_device import SerialDevice
from tests.hardware.golden import SETTINGS
try:
    with SerialDevice(sys.argv[1]) as device:
        device.configure(SETTINGS)
        device.arm()
        device.start()
        count = 0
        while True:
            block = device.read(2.0)
            count += len(block.time_us)
            print(count, flush=True)
except DeviceError as error:
    print(error, flush=True)
    sys.exit(error.exit_code)
"""


def host(url: str) -> subprocess.Popen[str]:
    """Starts a host that reads until something ends it."""
    return subprocess.Popen(
        [sys.executable, "-c", HOST, url], cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


def wait_for(what: Callable[[], bool]) -> None:
    """Waits until something is so; a test that would wait for ever fails."""
    end = time.monotonic() + 120
    while not what():
        assert time.monotonic() < end
        time.sleep(0.002)


def read_to_the_fault(device: SerialDevice, *, within_s: float = 60.0) -> tuple[list[Block], str]:
    """Blocks up to a fault, and the fault; a read that waits so long in vain is a failure."""
    got: list[Block] = []
    try:
        while (block := device.read(within_s)) is not None:
            got.append(block)
    except DeviceError as error:
        return got, str(error)
    raise AssertionError("no fault was told")


def assert_nothing_left() -> None:
    assert not [thread for thread in threading.enumerate() if thread.name == "hknob wire"]


def damage(sent: bytes, dice: random.Random) -> bytes:
    """A frame changed, cut, stretched, mixed, or run into another."""
    match dice.randrange(6):
        case 0:
            return spoilt(sent, dice)
        case 1:
            return sent[: dice.randrange(len(sent))] + b"\0"
        case 2:
            return sent[dice.randrange(1, len(sent)) :]
        case 3:
            at = dice.randrange(len(sent))
            return sent[:at] + dice.randbytes(dice.randint(1, 40)) + sent[at:]
        case 4:
            at = dice.randrange(len(sent) - 1)
            return sent[:at] + sent[at + 1 :]
    return sent[:-1] + sent


def test_a_hundred_thousand_spoilt_frames_none_taken_none_fatal() -> None:
    """A frame left whole among rubbish decodes to what was sent. CRC-32 misses one in 4e9: none of these, seeded."""
    dice, decoder, wrong = random.Random(20261121), Decoder(), 0
    frames = [frame(encode(message)) for message in GOLDEN.values()]
    bodies = {body_of(each[:-1]) for each in frames}
    session = Session(first_nonce=4)
    session.boot = BOOT
    session.command(lambda nonce: Plain(Kind.ARM, nonce))  # run 5, that of the golden blocks
    event = frame(encode(GOLDEN["event"]))
    for count in range(100_000):
        data = damage(dice.choice(frames), dice)
        for found in decoder.feed(data):
            wrong += found not in bodies
        decoder.feed(b"\0")
        assert decoder.held <= MOST_STUFFED_BYTES
        if count == 95_000:
            tracemalloc.start()
            before, _ = tracemalloc.get_traced_memory()
        if event[:-1] not in data:
            session.feed(data + b"\0", now=count * 1e-6)
    after, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert wrong == 0
    assert decoder.damaged > 90_000
    assert after - before < 10 * MOST_STUFFED_BYTES
    assert [block.first for block in session.ready] == [0]  # one that rubbish left whole
    assert session.failure is None


@pytest.mark.parametrize("seed", range(3))
def test_spoilt_doubled_and_lost_blocks_cost_no_sample(seed: int) -> None:
    manners = Manners()
    with PtyTarget(manners) as served, SerialDevice(served.url) as device:
        manners.out = spoiler(seed, share=0.1)
        blocks = trial(device, blocks=60)
        assert assert_whole(blocks) == sum(len(each.samples.time_us) for each in served.target.blocks)


def test_garbage_between_the_frames_costs_no_sample() -> None:
    dice = random.Random(7)
    manners = Manners(out=lambda data: dice.randbytes(dice.randrange(3000)) + b"\0" + data)
    with PtyTarget(manners) as served, SerialDevice(served.url) as device:
        blocks = trial(device, blocks=40)
        assert assert_whole(blocks) == sum(len(each.samples.time_us) for each in served.target.blocks)


def test_a_link_cut_in_a_trial_is_told_and_what_came_is_kept() -> None:
    with PtyTarget(Manners(cut_at=12)) as served:
        with SerialDevice(served.url) as device:
            device.configure(SETTINGS)
            device.arm()
            blocks, said = read_to_the_fault(device)
            device.release()
        assert_whole(blocks)
        assert served.target.host_has <= len(blocks) <= 12
        assert said.startswith(f"{served.url}: the port is gone, is the cable in?")
    assert_nothing_left()


def test_a_link_gone_silent_in_a_trial_is_told() -> None:
    with PtyTarget(Manners(silent_at=12, simulated=False)) as served, SerialDevice(served.url) as device:
        device.configure(SETTINGS)
        device.arm()
        blocks, said = read_to_the_fault(device)
        assert_whole(blocks)
        assert len(blocks) <= 12
        silent = re.search(r"no samples came for (\d+) ms", said)
        assert silent
        assert int(silent[1]) >= 100  # more where the machine is busy
        wait_for(lambda: served.target.state is State.IDLE)
        assert served.target.heard[-1] is Kind.RELEASE


def test_a_target_that_restarts_in_a_trial_is_told() -> None:
    with PtyTarget(Manners(restart_at=12)) as served, SerialDevice(served.url) as device:
        device.configure(SETTINGS)
        device.arm()
        blocks, said = read_to_the_fault(device)
        assert_whole(blocks)
        assert len(blocks) == 12
        assert "the target has restarted" in said
        with pytest.raises(DeviceError, match="restarted"):
            device.configure(SETTINGS)


@pytest.mark.parametrize("fault", [trip for trip in Trip if trip is not Trip.NONE])
def test_a_trip_is_told_after_its_last_sample_and_released(fault: Trip) -> None:
    with PtyTarget(Manners(trip=(12, fault))) as served, SerialDevice(served.url) as device:
        device.configure(SETTINGS)
        device.arm()
        device.start()
        blocks, said = read_to_the_fault(device)
        assert assert_whole(blocks) == 12 * SETTINGS.block_samples
        assert "took its torque off at sample 480" in said
        device.release()
        assert served.target.state is State.IDLE
        served.target.manners.trip = None
        assert_whole(trial(device))


def test_to_stop_what_has_tripped_says_so_and_its_samples_can_be_read() -> None:
    with PtyTarget(Manners(trip=(12, Trip.SPEED))) as served, SerialDevice(served.url) as device:
        device.configure(SETTINGS)
        device.arm()
        wait_for(lambda: served.target.state is State.TRIPPED)
        with pytest.raises(DeviceError, match="the knob turned faster"):
            device.stop()
        blocks, said = read_to_the_fault(device)
        assert assert_whole(blocks) == 12 * SETTINGS.block_samples
        assert "the knob turned faster than the speed limit" in said


def another(name: str) -> Callable[[Any], Any]:
    """Alters one value by the least amount there is."""

    def alter(values: Any) -> Any:
        if name not in values._fields:
            return values
        value = getattr(values, name)
        return values._replace(**{name: (least(value[0]), *value[1:]) if isinstance(value, tuple) else least(value)})

    def least(value: Any) -> Any:
        if isinstance(value, Sine):
            return value._replace(phase=0.125)
        return value + 1 if isinstance(value, int) else float(np.nextafter(value, 9))

    return alter


UNSENT = ("control", "converters", "over_angle", "pulse", "squeeze")  # sent by themselves, or not sent
SENT = [name for name in (*Settings._fields, *Control._fields, *type(WITH_SINES)._fields) if name not in UNSENT]


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", SENT)
def test_a_target_that_took_another_value_is_not_armed(name: str) -> None:
    with PtyTarget(Manners(alter=another(name))) as served, SerialDevice(served.url) as device:
        with pytest.raises(DeviceError, match=f"took other values, and was not armed: {name}.* sent .*, taken "):
            device.configure(SETTINGS._replace(control=told("lag").control), WITH_SINES)
        with pytest.raises(DeviceError, match="not armed"):
            device.arm()
        assert Kind.ARM not in served.target.heard


TABLE = OverAngle(-20, 7, 0.5, -0.25, tuple(float(k) / 64.0 for k in range(40)))  # in two pieces
PULSE = PulseOrder(2.0, 0.1, 0.01, 0.5, 1e-3, 0.02)


@pytest.mark.one_in(4)
@pytest.mark.parametrize(
    ("acts", "name"),
    [
        *(({"over_angle": TABLE}, name) for name in (*Table._fields, *Piece._fields)),
        *(({"pulse": PULSE}, name) for name in Pulse._fields),
        *(({"converters": CONVERTERS}, name) for name in Converters._fields),
    ],
)
def test_a_target_that_took_another_act_is_not_armed(acts: dict[str, Any], name: str) -> None:
    settings = SETTINGS._replace(wall_damping=0.0, **acts)
    with PtyTarget(Manners(knows_acts=True)) as served, SerialDevice(served.url) as device:
        device.configure(settings, WITH_SINES)
    with (
        PtyTarget(Manners(knows_acts=True, alter=another(name))) as served,
        SerialDevice(served.url) as device,
    ):
        with pytest.raises(DeviceError, match=f"took other values, and was not armed: {name}.* sent .*, taken "):
            device.configure(settings, WITH_SINES)
        with pytest.raises(DeviceError, match="not armed"):
            device.arm()
        assert Kind.ARM not in served.target.heard


NEWER = [
    ("converters", CONVERTERS, "does not know CONVERTERS"),
    ("control", told("half sample").control, "controller half_sample"),
    ("control", told("impulse").control, "does not change within a sample interval"),
]


@pytest.mark.parametrize(("key", "value", "said"), NEWER)
def test_older_firmware_is_asked_for_nothing_that_it_does_not_know(key: str, value: Any, said: str) -> None:
    with PtyTarget() as served, SerialDevice(served.url) as device:
        with pytest.raises(DeviceError, match=said):
            device.configure(SETTINGS._replace(**{key: value}))
        assert {Kind.ABILITIES, Kind.CONVERTERS, Kind.CONFIGURE} & set(served.target.heard) == set()


def test_a_target_without_a_law_is_told_from_one_that_has_it() -> None:
    laws = ALL_LAWS - Law.HALF_SAMPLE.bit
    with PtyTarget(Manners(knows_acts=True, abilities=laws)) as served, SerialDevice(served.url) as device:
        device.configure(SETTINGS._replace(control=told("matched wall").control))
        with pytest.raises(DeviceError, match="it does not have the controller half_sample: its firmware is older"):
            device.configure(SETTINGS._replace(control=told("half sample").control))


@pytest.mark.parametrize("name", READING)
def test_a_target_that_reads_once_a_sample_is_not_asked_for_more(name: str) -> None:
    said = "it reads its encoder once a sample: its firmware is older"
    with PtyTarget(Manners(knows_acts=True)) as served, SerialDevice(served.url) as device:
        device.configure(SETTINGS._replace(control=told("hold").control))
        served.target.heard.clear()
        with pytest.raises(DeviceError, match=said):
            device.configure(SETTINGS._replace(control=told(name).control))
        assert not {Kind.CONTROL, Kind.CONFIGURE} & set(served.target.heard)


def test_a_target_that_reads_within_an_interval_is_told_to() -> None:
    """And is refused what no block has room for, before it is asked."""
    control, most = told("hold that reads").control, told("long impulse that reads most often").control
    with PtyTarget(Manners(knows_acts=True, knows=7)) as served, SerialDevice(served.url) as device:
        device.configure(SETTINGS._replace(control=control, block_samples=34))
        for one, samples, said in (
            (control, 35, "block_samples: a block with 3 readings beside each sample has at most 34 samples"),
            (most, 4, "block_samples: a block with 63 readings beside each sample has at most 3 samples"),
            (most._replace(numbers=(*most.numbers[:3], 64.0)), 3, "at most 64 times a sample, not 65 times"),
        ):
            with pytest.raises(DeviceError, match=said):
                device.configure(SETTINGS._replace(control=one, block_samples=samples))


def test_a_target_that_promises_abilities_must_tell_them() -> None:
    with PtyTarget(Manners(knows_acts=True, abilities=None)) as served:
        with pytest.raises(DeviceError, match="the target refused to say what it knows: it does not know this command"):
            SerialDevice(served.url).__enter__()
        assert served.target.state is State.IDLE


def test_negative_zero_is_another_value_than_zero() -> None:
    """Bits are compared, not values."""
    manners = Manners(alter=lambda values: values._replace(wall_damping=-0.0))
    told = pytest.raises(DeviceError, match=r"wall_damping sent 0\.0, taken -0\.0")
    with PtyTarget(manners) as served, SerialDevice(served.url) as device, told:
        device.configure(SETTINGS._replace(wall_damping=0.0))


def test_a_reader_that_stalls_for_200_ms_loses_nothing() -> None:
    with PtyTarget() as served, SerialDevice(served.url) as device:
        device.configure(SETTINGS)
        device.arm()
        device.start()
        time.sleep(0.2)
        assert served.target.state is State.RUNNING
        device.stop()
        blocks = []
        while (block := device.read(60.0)) is not None:
            blocks.append(block)
        assert assert_whole(blocks) == sum(len(each.samples.time_us) for each in served.target.blocks)


def test_a_host_stopped_by_the_system_finds_the_torque_off_and_says_why() -> None:
    with PtyTarget() as served:
        process = host(served.url)
        wait_for(lambda: served.target.state is State.RUNNING and len(served.target.blocks) > 20)
        process.send_signal(signal.SIGSTOP)
        wait_for(lambda: served.target.state is State.TRIPPED)
        made = len(served.target.blocks)
        process.send_signal(signal.SIGCONT)
        out, errors = process.communicate(timeout=120)
        assert process.returncode == 4
        *counts, said = out.splitlines()
        assert "it did not hear from this computer for the watchdog's time" in said
        assert int(counts[-1]) == made * SETTINGS.block_samples  # what was sampled meanwhile was asked for again
        assert errors == ""
        assert served.target.state is State.IDLE


@pytest.mark.parametrize(("kind", "trips"), [(signal.SIGINT, False), (signal.SIGKILL, True), (signal.SIGTERM, True)])
def test_a_host_that_is_ended_takes_the_torque_off(kind: signal.Signals, trips: bool) -> None:
    """By RELEASE on Ctrl-C; by the target's watchdog where the process has no say."""
    with PtyTarget() as served:
        process = host(served.url)
        wait_for(lambda: served.target.state is State.RUNNING and len(served.target.blocks) > 20)
        process.send_signal(kind)
        process.communicate(timeout=120)
        wait_for(lambda: served.target.torque_off_at is not None and served.target.state is not State.RUNNING)
        assert (served.target.state is State.TRIPPED) == trips
        assert (served.target.heard[-1] is Kind.RELEASE) == (not trips)


def begin_and_break(device: SerialDevice) -> None:
    device.configure(SETTINGS)
    device.arm()
    device.start()
    _ = 1 // 0


def test_any_exception_releases_and_is_not_replaced() -> None:
    with PtyTarget() as served:
        with pytest.raises(ZeroDivisionError), SerialDevice(served.url) as device:
            begin_and_break(device)
        assert served.target.state is State.IDLE
        assert served.target.heard[-1] is Kind.RELEASE
    assert_nothing_left()


def test_a_session_left_behind_by_another_host_is_ended_when_opening() -> None:
    with PtyTarget(Manners(trip=(3, Trip.EMERGENCY_STOP))) as served:
        process = host(served.url)
        wait_for(lambda: served.target.state is State.RUNNING)
        process.kill()
        process.communicate()
        wait_for(lambda: served.target.state is State.TRIPPED)
        served.target.manners.trip = None
        with SerialDevice(served.url) as device:
            assert served.target.state is State.IDLE
            assert_whole(trial(device))


@pytest.mark.parametrize(
    ("manners", "said"),
    [
        (Manners(mute=True), "nobody answered within 0.3 s"),
        (Manners(version=2), "the target speaks version 2 of the protocol, this program version 1"),
        (Manners(out=lambda data: data[1:] or b""), "what comes from this port is not the protocol"),
        (Manners(out=lambda _data: b"ready\r\n"), "what comes from this port is not the protocol"),
        (Manners(out=lambda _data: b"ready\r\n" * 1000), "what comes from this port is not the protocol"),
    ],
)
def test_a_target_that_cannot_be_spoken_to_is_told_in_one_line(manners: Manners, said: str) -> None:
    with PtyTarget(manners) as served:
        with pytest.raises(DeviceError) as caught, SerialDevice(served.url, patience_s=0.3):
            pass
        assert str(caught.value).startswith(f"{served.url}: {said}")
        assert "\n" not in str(caught.value)
    assert_nothing_left()


def test_a_loop_is_told_from_a_target() -> None:
    with pytest.raises(DeviceError, match="sends back what it is sent"), SerialDevice("loop://", patience_s=0.3):
        pass


def test_a_port_in_use_is_told() -> None:
    told = pytest.raises(DeviceError, match="this port is in use by another program")
    with PtyTarget() as served, SerialDevice(served.url), told, SerialDevice(served.url):
        pass
    assert_nothing_left()


def test_ports_that_are_none_are_told(tmp_path: Path) -> None:
    import socket

    with socket.create_server(("127.0.0.1", 0)) as listener:
        closed = f"socket://127.0.0.1:{listener.getsockname()[1]}"
    plain = tmp_path / "file"
    plain.touch()
    for url, said in [
        (str(tmp_path / "none"), "there is no such port; this computer has "),
        (str(plain), "this is not a serial port"),
        (closed, "this port cannot be opened"),
        ("telepathy://knob", "must be a port's name, or begin with socket://"),
    ]:
        with pytest.raises(DeviceError) as caught, SerialDevice(url):
            pass
        assert str(caught.value).startswith(f"{url}: {said}")
        assert "\n" not in str(caught.value)


def test_a_port_without_permission_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whoever runs tests may be allowed everything: the system's refusal is made up."""
    import serial

    def refuse(*_: object, **__: object) -> None:
        raise serial.SerialException(errno.EACCES, os.strerror(errno.EACCES))

    monkeypatch.setattr(serial, "serial_for_url", refuse)
    with pytest.raises(DeviceError, match=r"no permission to open this port .* dialout"):
        pump.open_port("/dev/ttyACM0", baud=9600)


def test_opening_again_after_a_fault_works() -> None:
    manners = Manners(mute=True)
    with PtyTarget(manners) as served:
        with pytest.raises(DeviceError), SerialDevice(served.url, patience_s=0.2):
            pass
        manners.mute = False
        with SerialDevice(served.url) as device:
            assert_whole(trial(device))
