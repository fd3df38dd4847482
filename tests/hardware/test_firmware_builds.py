"""The built targets: the same trials as the virtual device, over a real serial line; ended with whoever runs them."""

import os
import select
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from hknob_cli.errors import DeviceError, UsageError
from hknob_cli.hardware import reference_target
from hknob_cli.hardware.control import control_of, over_angle_of
from hknob_cli.hardware.order import settings_of, trials_of
from hknob_cli.hardware.person import squeezer
from hknob_cli.hardware.port import ROUNDINGS, Block, Converters, Device, Settings, Simulated, Sine
from hknob_cli.hardware.reference_target import QEMU, SOURCES, Target, build_target, compiler, run_target
from hknob_cli.hardware.serial_device import SerialDevice
from hknob_cli.hardware.trial_wall import Conversion
from hknob_cli.hardware.virtual import VirtualDevice
from hknob_cli.hardware.wire.answers import Ack, Event
from hknob_cli.hardware.wire.codes import Kind, Status, Trip
from hknob_cli.hardware.wire.commands import Configure, Plain
from hknob_cli.hardware.wire.messages import Decoder, Message, decode, encode, frame
from hknob_cli.specs.over_angle import Detents, Effects, EndStops
from hknob_cli.specs.parts import Actuator, Encoder
from tests.conftest import ROOT
from tests.hardware.controllers import CONTROLLERS, MODEL, told
from tests.hardware.pulses import HELD, SPEC, planned
from tests.hardware.test_virtual_trials_of_the_engine import SAMPLES, Case, engine_trial
from tests.hardware.trials import HAND

pytestmark = pytest.mark.long  # compilers, an emulator, and programs in real time

SETTINGS = Settings(1_000_000, 1024, 0.27, 1e-5, 0.05, 100.0, 50_000, 5)
PERSON = Simulated(
    *(2.2e-6, 3.45e-4, 0.04, 2e-4, 0.02, 0.0012, 0.71, 0.1, 0.125),
    push_sines=(Sine(3e-4, 1.3, 0.2), Sine(5e-5, 9.0, 1.0)),
    grip_sines=(Sine(0.03, 1.5, -0.5), Sine(0.01, 9.5, 0.0)),
)
TARGETS: list[Target] = ["host", "qemu"]


@pytest.fixture(scope="session")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("targets")


def need(target: Target) -> None:
    """Skip the test where the tools of a target are missing."""
    try:
        compiler(target)
    except DeviceError as error:
        pytest.skip(str(error))
    if target == "qemu" and shutil.which(QEMU) is None:
        pytest.skip(f"needs {QEMU}")


def trial(device: Device, settings: Settings, running: int, person: Simulated = PERSON) -> list[Block]:
    """A trial of at least so many samples with the wall on; all blocks."""
    device.configure(settings, person)
    device.arm()
    blocks = [device.read(60.0)]
    device.start()
    while sum(int(block.running.sum()) for block in blocks if block is not None) < running:
        blocks.append(device.read(60.0))
    device.stop()
    while blocks[-1] is not None:
        blocks.append(device.read(0.2))
    return [block for block in blocks if block is not None]


def undisturbed_trial(
    target: Target, built: Path, settings: Settings, running: int, person: Simulated = PERSON
) -> list[Block]:
    """The same with a target; slower where this computer was too busy to be heard within the watchdog's time."""
    for slower in (1, 4, 16, 64):
        try:
            with run_target(target, built, slower=slower) as path, SerialDevice(path) as device:
                return trial(device, settings, running, person)
        except DeviceError as error:
            if slower == 64 or "did not hear from this computer" not in str(error):
                raise
    raise AssertionError


def column(blocks: list[Block], name: str, *, count: int) -> np.ndarray:
    """Samples with the wall on, the first so many."""
    running = np.concatenate([block.running for block in blocks])
    return np.concatenate([getattr(block, name) for block in blocks])[running][:count]


@pytest.mark.one_in(3)
@pytest.mark.parametrize("rate", [455, 1000, 2000])
@pytest.mark.parametrize("target", TARGETS)
def test_the_same_samples_as_the_virtual_device(target: Target, rate: int, built: Path) -> None:
    """To the last bit of what the wire carries, but where grip's sines, rounded otherwise, round to the next f32."""
    need(target)
    settings = SETTINGS._replace(period_ns=round(1e9 / rate))
    count = rate // 2
    with VirtualDevice() as device:
        expected = trial(device, settings, count)
    found = undisturbed_trial(target, built, settings, count)
    assert [block.first for block in found] == np.cumsum([0, *(block.time_us.size for block in found[:-1])]).tolist()
    for name in ("angle_counts", "torque_nm"):
        assert np.array_equal(column(found, name, count=count), column(expected, name, count=count)), name
    assert np.ptp(column(found, "angle_counts", count=count)) > 1000
    assert (column(found, "torque_nm", count=count) > 0).any()
    grip = np.abs(column(found, "grip_n", count=count) - column(expected, "grip_n", count=count))
    assert grip.max() <= np.spacing(np.float32(1.0))


@pytest.mark.one_in(2)
@pytest.mark.parametrize("name", ["lag", "passivity", "timed through a low-pass", "phase by Kalman"])
def test_under_a_controller_the_same_samples_as_the_virtual_device(name: str, built: Path) -> None:
    need("host")
    settings = told(name, wall_damping=1e-5)
    with VirtualDevice() as device:
        expected = trial(device, settings, 500)
    found = undisturbed_trial("host", built, settings, 500)
    for what in ("angle_counts", "torque_nm"):
        assert np.array_equal(column(found, what, count=500), column(expected, what, count=500)), what
    with VirtualDevice() as device:
        plain = trial(device, settings._replace(control=None), 500)
    assert not np.array_equal(column(plain, "torque_nm", count=500), column(expected, "torque_nm", count=500))


CONVERTED = {
    "all converters": ("", Converters(0.25, 1e-4, 2e-4, 0.04, 1.25, 1)),
    "half a sample late, up": ("", Converters(delay_samples=0.5, rounding=2)),
    "half sample": ("half sample", None),
    "matched wall": ("matched wall", None),
    "impulse": ("impulse", Converters(rounding=3)),
    "hold in steps, delayed": ("hold in steps", Converters(delay_samples=0.5)),
}


@pytest.mark.one_in(4)
@pytest.mark.parametrize(("target", "count"), [("host", 500), ("qemu", 150)])
@pytest.mark.parametrize("name", CONVERTED)
def test_what_the_program_recommends_is_run_as_by_the_virtual_device(
    name: str, target: Target, count: int, built: Path
) -> None:
    """Controllers with a model, torques that change within an interval, delays and converters."""
    need(target)
    law, converters = CONVERTED[name]
    settings = told(law, 455, block_samples=5, torque_limit_nm=0.2) if law else SETTINGS._replace(period_ns=2_000_000)
    settings = settings._replace(converters=converters)
    with VirtualDevice() as device:
        expected = trial(device, settings, count)
    found = undisturbed_trial(target, built, settings, count)
    for what in ("angle_counts", "torque_nm"):
        assert np.array_equal(column(found, what, count=count), column(expected, what, count=count)), what
    assert len(set(column(found, "torque_nm", count=count).tolist())) > 3


READING = {
    "hold that reads, in steps": Converters(delay_samples=0.25, offset_counts=0.25),
    "impulse that reads": Converters(rounding=1),
    "timed within the interval": None,
}


@pytest.mark.one_in(3)
@pytest.mark.parametrize(("target", "count"), [("host", 500), ("qemu", 100)])
@pytest.mark.parametrize("name", READING)
def test_readings_within_an_interval_are_those_of_the_virtual_device(
    name: str, target: Target, count: int, built: Path
) -> None:
    """Their angles, too, which the host checks the torque by."""
    need(target)
    # The emulated machine takes some 250 us from reading to reading, and has to listen to the host, too.
    rate = 1000 if target == "host" else 150 if name == "impulse that reads" else 455
    settings = told(name, rate, torque_limit_nm=0.2)
    settings = settings._replace(converters=READING[name], block_samples=5)
    with VirtualDevice() as device:
        expected = trial(device, settings, count)
    found = undisturbed_trial(target, built, settings, count)
    for what in ("angle_counts", "torque_nm", "looks"):
        assert np.array_equal(column(found, what, count=count), column(expected, what, count=count)), what
    assert len(set(column(found, "torque_nm", count=count).tolist())) > 3
    looks = column(found, "looks", count=count)
    assert not looks[0].any()
    assert (np.diff(looks, axis=1) != 0).any()


@pytest.mark.one_in(2)
@pytest.mark.parametrize("name", [*READING, "long impulse that reads most often"])
def test_a_target_counts_at_every_sample_what_the_engine_does(name: str, built: Path) -> None:
    """The host target against the engine itself, from the first sample on, and its torques to single precision."""
    need("host")
    converters = READING.get(name)
    said = converters or Converters()
    encoder = Encoder(rounding=ROUNDINGS[said.rounding], offset_counts=said.offset_counts)
    case = Case(CONTROLLERS[name], encoder, Actuator(delay_samples=said.delay_samples))
    settings = told(name, 1000, 1000, torque_limit_nm=1.0, block_samples=3)._replace(converters=converters)
    settings = settings._replace(control=control_of(CONTROLLERS[name], settings, MODEL))
    found = undisturbed_trial("host", built, settings, SAMPLES, HAND)
    seen, torques = engine_trial(case, 1000, 1000)  # 640 of the target's counts to one: every edge is on one of them
    angles = column(found, "angle_counts", count=SAMPLES)
    assert Conversion(settings, 640_000).counts(angles).tolist() == seen
    assert min(seen) < 0 < max(seen)
    assert column(found, "torque_nm", count=SAMPLES) == pytest.approx(np.array(torques), rel=3e-7, abs=1e-12)


def test_the_emulated_target_runs_a_controller(built: Path) -> None:
    need("qemu")
    settings = told("lag", 455, block_samples=5)
    with VirtualDevice() as device:
        expected = trial(device, settings, 100)
    found = undisturbed_trial("qemu", built, settings, 100)
    for what in ("angle_counts", "torque_nm"):
        assert np.array_equal(column(found, what, count=100), column(expected, what, count=100)), what


@pytest.mark.parametrize("target", TARGETS)
def test_detents_and_stops_are_those_of_the_virtual_device(target: Target, built: Path) -> None:
    need(target)
    effects = Effects(detents=Detents(torque=0.006, per_revolution=100), end_stops=EndStops(stiffness=0.2, low=0.0))
    settings = SETTINGS._replace(wall_stiffness=0.0, wall_damping=0.0)
    settings = settings._replace(over_angle=over_angle_of(effects, settings))
    with VirtualDevice() as device:
        expected = trial(device, settings, 500)
    found = undisturbed_trial(target, built, settings, 500)
    for what in ("angle_counts", "torque_nm"):
        assert np.array_equal(column(found, what, count=500), column(expected, what, count=500)), what
    torques = column(found, "torque_nm", count=500)
    assert len(set(torques.tolist())) > 5
    assert torques.min() < -0.003
    assert torques.max() > 0.008  # of the stop, which no detent has


@pytest.mark.long
@pytest.mark.parametrize("text", [SPEC, HELD])
def test_the_emulated_target_fires_the_pulse_of_a_grip(text: str, built: Path) -> None:
    """In its own time: the same counts, torques and grips as the virtual device, for a whole trial."""
    need("qemu")
    plan = planned(text.replace("pulses: {", "pulses: {sample_rate: 1 kHz, "))
    first = trials_of(plan)[0]
    settings = settings_of(plan, first)._replace(watchdog_us=50_000)
    with VirtualDevice() as device:
        expected = trial(device, settings, 1000, squeezer(plan, first))
    found = undisturbed_trial("qemu", built, settings, 1000, squeezer(plan, first))
    for what in ("angle_counts", "torque_nm"):
        assert np.array_equal(column(found, what, count=1000), column(expected, what, count=1000)), what
    assert np.count_nonzero(column(found, "torque_nm", count=1000)) == 20
    grip = np.abs(column(found, "grip_n", count=1000) - column(expected, "grip_n", count=1000))
    assert grip.max() <= np.spacing(np.float32(1.0))


@pytest.mark.parametrize("target", TARGETS)
def test_every_start_has_another_boot_number(target: Target, built: Path) -> None:
    need(target)
    boots = set()
    for _ in range(3):
        with run_target(target, built) as path, SerialDevice(path) as device:
            boots.add(device.identity.boot)
            assert device.identity.simulated
            assert device.identity.native_counts == 640_000
    assert len(boots) == 3


def said(line: int, message: Message | None, kind: type, decoder: Decoder) -> Message:
    """Say something, if anything, on an open line; the next answer of a kind."""
    if message is not None:
        os.write(line, frame(encode(message)))
    while select.select([line], [], [], 5.0)[0]:
        for body in decoder.feed(os.read(line, 4096)):
            answer = decode(body)
            if isinstance(answer, kind):
                return answer
    pytest.fail(f"no {kind.__name__}")


@pytest.mark.parametrize("target", TARGETS)
def test_a_silent_host_trips_it(target: Target, built: Path) -> None:
    need(target)
    decoder = Decoder()
    with run_target(target, built) as path:
        line = os.open(path, os.O_RDWR | os.O_NOCTTY)
        try:
            said(line, Configure(1, SETTINGS), Ack, decoder)
            assert said(line, Plain(Kind.ARM, 2), Ack, decoder).status == Status.DONE
            assert said(line, Plain(Kind.START, 3), Ack, decoder).status == Status.DONE
            event = said(line, None, Event, decoder)
        finally:
            os.close(line)
    assert event.fault == Trip.WATCHDOG
    assert event.run == 2
    assert event.time_us >= 50_000


def test_the_emergency_stop_of_the_host_target(built: Path) -> None:
    need("host")
    with run_target("host", built) as path, SerialDevice(path) as device:
        (process,) = children("hknob-target-host")
        device.configure(SETTINGS, PERSON)
        device.arm()
        device.start()
        os.kill(process, signal.SIGUSR1)
        with pytest.raises(DeviceError, match="emergency"):
            read_on(device)


def read_on(device: Device) -> None:
    """Read until the device says that something is wrong."""
    for _ in range(1000):
        device.read(1.0)


def children(name: str) -> list[int]:
    """Processes of this one whose command has a name in it."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                status, command = (entry / "stat").read_text(), (entry / "cmdline").read_bytes()
            except OSError:
                continue
            if name.encode() in command and int(status.rpartition(")")[2].split()[1]) == os.getpid():
                found.append(int(entry.name))
    return found


@pytest.mark.parametrize("target", TARGETS)
def test_it_ends_with_a_killed_parent(target: Target, built: Path) -> None:
    need(target)
    build_target(target, built)
    code = (
        "import sys, time\nfrom pathlib import Path\nfrom hknob_cli.hardware.reference_target import run_target\n"
        f"with run_target({target!r}, Path({os.fspath(built)!r})) as path:\n"
        "    children = Path('/proc/self/task/' + str(__import__('os').getpid()) + '/children').read_text()\n"
        "    print(children, flush=True)\n    time.sleep(60)\n"
    )
    host = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True, cwd=ROOT)
    assert host.stdout is not None
    process = int(host.stdout.readline())
    assert Path(f"/proc/{process}").exists()
    host.kill()
    host.wait()
    host.stdout.close()
    for _ in range(6000):
        if not Path(f"/proc/{process}/cmdline").exists() or not Path(f"/proc/{process}/cmdline").read_bytes():
            return
        time.sleep(0.01)
    pytest.fail(f"the target runs on as process {process}")


@pytest.mark.long
def test_it_is_built_once_and_again_when_the_sources_change(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    need("host")
    first = build_target("host", tmp_path)
    made = first.stat().st_mtime_ns
    assert build_target("host", tmp_path) == first
    assert first.stat().st_mtime_ns == made
    copy = tmp_path / "firmware"
    shutil.copytree(SOURCES, copy)
    (copy / "board_host.c").write_text((copy / "board_host.c").read_text().replace('"hknob host"', '"another"'))
    monkeypatch.setattr(reference_target, "SOURCES", copy)
    other = build_target("host", tmp_path)
    assert other != first
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(["firmware", first.name, other.name])


@pytest.mark.parametrize("target", TARGETS)
def test_no_warnings(target: Target, tmp_path: Path) -> None:
    need(target)
    command = [*compiler(target), "-Werror", *reference_target.options(target), "-o", os.fspath(tmp_path / "target")]
    done = subprocess.run([*command, *reference_target.libraries(target)], cwd=SOURCES, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")


def test_all_targets_are_built_or_what_they_need_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(reference_target, "build_target", lambda target, folder, **_: folder / target)
    with pytest.raises(SystemExit, match="False"):
        reference_target.main(os.fspath(tmp_path))
    assert capsys.readouterr().out == f"host: {tmp_path}/host\nqemu: {tmp_path}/qemu\n"
    monkeypatch.undo()
    monkeypatch.setenv("PATH", os.fspath(tmp_path))
    monkeypatch.delenv("CC", raising=False)
    with pytest.raises(SystemExit, match="True"):
        reference_target.main(os.fspath(tmp_path))
    assert "apt install gcc" in capsys.readouterr().err


def test_what_is_missing_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", os.fspath(tmp_path))
    monkeypatch.delenv("CC", raising=False)
    with pytest.raises(DeviceError, match=r"'host' cannot be built.*apt install gcc"):
        build_target("host", tmp_path)
    with pytest.raises(DeviceError, match=r"'qemu' cannot be built.*gcc-arm-none-eabi libnewlib-arm-none-eabi"):
        build_target("qemu", tmp_path)
    with pytest.raises(DeviceError, match="apt install qemu-system-arm"), run_target("qemu", tmp_path):
        pass
    with pytest.raises(UsageError, match="unknown target 'board'; there are host, qemu"):
        build_target("board", tmp_path)  # type: ignore[arg-type]
    monkeypatch.setenv("CC", "no-such-compiler -O3")
    with pytest.raises(DeviceError, match="tried no-such-compiler -O3"):
        build_target("host", tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_failing_compiler_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    need("host")
    copy = tmp_path / "firmware"
    shutil.copytree(SOURCES, copy)
    (copy / "wall.c").write_text("int wall(void) { return later; }\n")
    monkeypatch.setattr(reference_target, "SOURCES", copy)
    with pytest.raises(DeviceError, match=r"cannot be built by .*: wall.c:1:.*error"):
        build_target("host", tmp_path / "out")
    assert list((tmp_path / "out").iterdir()) == []
    (tmp_path / "file").write_text("")
    with pytest.raises(DeviceError, match=r"cannot be built in .*file"):
        build_target("host", tmp_path / "file")


def test_a_target_that_does_not_start_says_why(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    script = tmp_path / "target"
    monkeypatch.setattr(reference_target, "build_target", lambda target, folder, **_: script)
    for text, message in [("exit 3", "it ended with 3"), ("echo no terminal >&2; exit 1", "no terminal")]:
        script.write_text(f"#!/bin/sh\n{text}\n")
        script.chmod(0o755)
        with pytest.raises(DeviceError, match=f"the target 'host' did not start: {message}"):
            reference_target.run_target("host", tmp_path).__enter__()
    script.chmod(0o644)
    with pytest.raises(DeviceError, match="cannot be run: Permission denied"):
        reference_target.run_target("host", tmp_path).__enter__()


def test_qemu_with_no_firmware_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    need("qemu")
    monkeypatch.setattr(reference_target, "build_target", lambda target, folder, **_: tmp_path / "gone")
    with pytest.raises(DeviceError, match=r"the target 'qemu' did not start: .*gone"):
        reference_target.run_target("qemu", tmp_path).__enter__()
    (tmp_path / "gone").write_bytes(bytes(64))
    monkeypatch.setattr(reference_target, "READY_WITHIN_S", 0.5)
    with pytest.raises(DeviceError, match=r"the target 'qemu' did not start: "):
        reference_target.run_target("qemu", tmp_path).__enter__()


def test_the_wheel_has_the_sources() -> None:
    """They lie in the package's folder, of which the wheel takes all that git does."""
    names = {path.name for path in SOURCES.iterdir()}
    assert {"target.c", "target.h", "board_template.c", "qemu.ld"} <= names
    tracked = subprocess.run(["git", "ls-files", os.fspath(SOURCES)], cwd=ROOT, capture_output=True, text=True)
    if tracked.returncode == 0 and tracked.stdout:
        assert {Path(line).name for line in tracked.stdout.split()} == names
