"""Campaigns cut short, forbidden or wrongly asked for: nothing lost, nothing done twice, nothing overwritten."""

import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from hknob_cli.errors import SpecError
from hknob_cli.hardware.order import trials_of
from hknob_cli.hardware.trial_file import read_trial
from hknob_cli.results import provenance, store
from tests.conftest import HKNOB
from tests.hardware.campaigns import SPEC, planned

FILES = ("samples.parquet", "trials.parquet", "timing.parquet")
# A trial that is at rest, and would be watched for a quarter of an hour of the device's time.
ENDLESS = SPEC.replace("buzz: [0.1, 0.2], longest: 2", "buzz: [600, 600], longest: 900")


def start(folder: Path, spec: str = SPEC, *args: str) -> subprocess.Popen[str]:
    (folder / "spec.yaml").write_text(spec)
    return subprocess.Popen(
        [HKNOB, "hw-run", folder / "spec.yaml", "-o", folder / "out", *args],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def wait_for_samples(folder: Path) -> Path:
    """The journal of the first trial, when it has some."""
    part = folder / "out" / "recording" / f"{trials_of(planned())[0].label}.part"
    deadline = time.monotonic() + 120
    while not (part.exists() and part.stat().st_size > 50_000) and time.monotonic() < deadline:
        time.sleep(0.01)
    return part


@pytest.mark.parametrize("kind", [signal.SIGINT, signal.SIGTERM])
def test_interrupted(tmp_path: Path, kind: signal.Signals) -> None:
    process = start(tmp_path, ENDLESS)
    wait_for_samples(tmp_path)
    process.send_signal(kind)
    said, errors = process.communicate(timeout=120)
    assert (process.returncode, said) == (130, "")
    first, last = errors.splitlines()
    assert first.startswith("trial 1 of 4 (")
    assert "torque released; what was recorded of it is in " in first
    assert last.startswith("interrupted")
    kept = list((tmp_path / "out" / "recording" / "aborted").iterdir())
    recorded = read_trial(kept[0])
    assert recorded is not None
    assert recorded.table.num_rows > 500
    assert recorded.ended == "aborted"


@pytest.mark.long
def test_killed_at_random_instants(tmp_path: Path) -> None:
    """What a kill leaves is gone on with: finished trials are not touched, and the end is as if nothing had been."""
    (tmp_path / "whole").mkdir()
    process = start(tmp_path / "whole")
    assert process.communicate()[1] == ""
    chance = random.Random(7)
    finished: dict[str, int] = {}
    killed = 0
    for _ in range(14):
        process = start(tmp_path)
        time.sleep(chance.uniform(0.3, 1.1))
        process.kill()
        process.communicate()
        killed += process.returncode == -signal.SIGKILL
        now = {path.name: path.stat().st_mtime_ns for path in (tmp_path / "out" / "recording").glob("*.parquet")}
        if now:
            assert finished.items() <= now.items()
            finished = now
    assert killed > 0
    assert start(tmp_path).communicate()[1] == ""
    for name in FILES:
        assert (tmp_path / "out" / name).read_bytes() == (tmp_path / "whole" / "out" / name).read_bytes()


def test_a_device_that_trips(tmp_path: Path) -> None:
    process = start(tmp_path, SPEC + "limits: {speed: 0.5}\n")
    said, errors = process.communicate(timeout=120)
    assert (process.returncode, said) == (4, "")
    assert errors.startswith("trial 1 of 4 (")
    assert "the knob is faster than the limit of 0.5 rad/s, at sample " in errors
    assert "torque released; what was recorded of it is in " in errors
    assert errors.endswith("change the spec\n")
    assert errors.count("\n") == 1
    kept = list((tmp_path / "out" / "recording" / "aborted").iterdir())
    recorded = read_trial(kept[0])
    assert recorded is not None
    assert any(recorded.table["running"].to_pylist())
    assert not (tmp_path / "out" / "trials.parquet").exists()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_full_disk(tmp_path: Path) -> None:
    """The journal has no room for its tenth block; what it has before that is kept."""
    (tmp_path / "spec.yaml").write_text(SPEC)
    code = (
        "import sys; from hknob_cli.hardware import journal\n"
        "plain, count = journal.Journal.keep, 0\n"
        "def keep(self, block):\n"
        "    global count; count += 1\n"
        "    if count == 10: self._file = open('/dev/full', 'wb', buffering=0)\n"
        "    plain(self, block)\n"
        "journal.Journal.keep = keep\n"
        f"sys.argv = ['hknob', 'hw-run', {str(tmp_path / 'spec.yaml')!r}, '-o', {str(tmp_path / 'out')!r}]\n"
        "from hknob_cli.cli.main import main; main()"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 1, done.stderr
    assert "cannot be written: No space left on device" in done.stderr
    assert "Traceback" not in done.stderr
    kept = list((tmp_path / "out" / "recording" / "aborted").iterdir())
    recorded = read_trial(kept[0])
    assert recorded is not None
    assert recorded.table.num_rows == 9 * (20 if recorded.trial.sample_rate_hz == 2000 else 10)


def test_two_at_once(tmp_path: Path) -> None:
    process = start(tmp_path, ENDLESS)
    wait_for_samples(tmp_path)
    second = subprocess.run(
        [HKNOB, "hw-run", tmp_path / "spec.yaml", "-o", tmp_path / "out"], capture_output=True, text=True, check=False
    )
    process.kill()
    process.communicate()
    assert second.returncode == 3
    assert "another run is writing here" in second.stderr


def recorded_by_a_device(folder: Path, spec: str = SPEC) -> dict[str, bytes]:
    """A folder as a serial device leaves it, with some samples that are not of this program."""
    process = start(folder, spec)
    assert process.communicate()[1] == ""
    values = {**planned(spec).values, "device": {"driver": "serial", "url": "/dev/null"}}
    stamp = provenance.describe(stage="hw-run", values=values, overrides=())
    tables = {folder / "out" / name: pq.read_table(folder / "out" / name) for name in FILES}
    store.write(tables, stamp)
    return {name: (folder / "out" / name).read_bytes() for name in FILES}


def test_recordings_of_a_device_are_not_replaced(tmp_path: Path, hknob) -> None:
    before = recorded_by_a_device(tmp_path)
    for more in ((), ("--dry-run",), ("--set", "seed=3")):
        done = hknob("hw-run", tmp_path / "spec.yaml", "-o", tmp_path / "out", *more)
        assert (done.returncode, done.stdout) == (3, "")
        assert "made with another spec; they are kept" in done.stderr
        assert "--force" in done.stderr
    assert {name: (tmp_path / "out" / name).read_bytes() for name in FILES} == before
    done = hknob("hw-run", tmp_path / "spec.yaml", "-o", tmp_path / "out", "--force")
    assert done.returncode == 0
    earlier = tmp_path / "out" / "earlier" / "1"
    assert {name: (earlier / name).read_bytes() for name in FILES} == before


def test_recordings_without_their_trials_are_not_gone_on_with(tmp_path: Path, hknob) -> None:
    recorded_by_a_device(tmp_path)
    (tmp_path / "spec.yaml").write_text(SPEC + "device: {driver: serial, url: /dev/null}\n")
    done = hknob("hw-run", tmp_path / "spec.yaml", "-o", tmp_path / "out")
    assert done.returncode == 3
    assert "recording: is gone" in done.stderr


# What is replaced, by what, and the line that must appear: FILE:LINE:COL: key: message.
BROKEN = {
    "no driver": ("", "device: {driver: usb}", "6:18: device.driver: must be 'virtual', 'replay' or 'serial'"),
    "serial alone": ("", "device: {driver: serial}", "6:9: device: must have exactly one of url and target"),
    "url and target": (
        "", "device: {driver: serial, url: x, target: host}", "6:9: device: must have exactly one of url and target",
    ),
    "url of nothing": ("", "device: {url: x}", "6:15: device.url: must be absent: it is for the driver serial"),
    "baud of a target": (
        "", "device: {driver: serial, target: host, baud: 9600}", "6:46: device.baud: must be absent with target",
    ),
    "replay of nothing": ("", "device: {driver: replay}", "6:9: device: needs recordings with the driver replay"),
    "knob of a recording": (
        "person: {wandering_push: false, grip_wander: false}",
        "knob: {inertia: 2e-6}\ndevice: {driver: replay, recordings: [x]}",
        "5:7: knob: must be absent: what is replayed was recorded",
    ),
    "noise on a target": (
        "", "device: {driver: serial, target: host}\nnuisances: {jitter: 1 us}",
        "7:12: nuisances: must be absent: they are for the driver virtual",
    ),
    "buzz that falls": ("[0.1, 0.2]", "[0.2, 0.1]", "4:41: trial.buzz: must rise, got 0.2 to 0.1"),
    "too short": ("longest: 2", "longest: 0.1", "4:62: trial.longest: must be >= 0.15, settle and the least buzz"),
    "band": ("", "grip: {target: 0.5 N, band: 500 mN}", "6:29: grip.band: must be < the target of 0.5, got 0.5"),
    "grip of a word": ("", "grip: some", "6:7: grip: must be 'none', or a mapping with target and band"),
    "grip of a typo": ("", "grip: {targte: 1}", "6:8: grip.targte: unknown key; did you mean 'target'?"),
    "grip of nothing": ("", "grip: null", "6:7: grip: must be 'none', or a mapping with target and band"),
    "zero of no knob": ("", "device: {zero_angle: true}", "6:22: device.zero_angle: must be absent without url"),
    "grip in seconds": ("", "grip: {target: 1 s}", "6:16: grip.target: '1 s' is in second, which is not a kind of N"),
    "rate": ("[1000, 2000]", "[1000, 0.5]", "3:31: grid.sample_rate_hz[1]: must be 1 to 1000000 Hz, got 0.5"),
    "rate twice": ("[1000, 2000]", "[1000, 1000]", "3:31: grid.sample_rate_hz[1]: must not repeat a value"),
    "counts": ("[256, 512]", "[256, 0]", "3:60: grid.counts_per_rev[1]: must be >= 1, got 0"),
    "other axis": ("counts_per_rev", "count_per_rev", "3:38: grid.count_per_rev: unknown key; did you mean"),
    "watchdog": ("", "limits: {watchdog: 100 ms}", "6:20: limits.watchdog: must be <= 0.05, got 0.1"),
    "order": ("", "order: alphabetical", "6:8: order: must be 'random' or 'grid', got 'alphabetical'"),
    "repeats": ("", "repeats: 0", "6:10: repeats: must be >= 1, got 0"),
    "many": ("[1000, 2000]", "{lin: [1000, 2000, 600]}", "3:7: grid: must be at most 1000 trials with repeats"),
    "typo": ("person:", "persom:", "5:1: persom: unknown key; did you mean 'person'?"),
}  # fmt: skip


@pytest.mark.parametrize("case", BROKEN)
def test_bad_specs(case: str) -> None:
    old, new, line = BROKEN[case]
    with pytest.raises(SpecError) as error:
        planned(SPEC.replace(old, new) if old else f"{SPEC}{new}\n")
    assert f"spec.yaml:{line}" in str(error.value)


def test_a_bad_spec_writes_nothing(hknob, tmp_path: Path) -> None:
    (tmp_path / "spec.yaml").write_text(SPEC + "order: alphabetical\nrepeats: 0\n")
    for command in (("hw-run",), ("check",), ("run",)):
        done = hknob(*command, "spec.yaml")
        assert (done.returncode, done.stdout) == (2, "")
        assert [line.split(": ")[1] for line in done.stderr.splitlines()] == ["order", "repeats"]
        assert {path.name for path in tmp_path.iterdir()} == {"spec.yaml"}


def test_a_grip_that_nobody_knows(hknob, tmp_path: Path) -> None:
    (tmp_path / "spec.yaml").write_text(SPEC + "grip: {target: 50 N}\n")
    done = hknob("hw-run", "spec.yaml")
    assert done.returncode == 2
    assert "Table 1" in done.stderr
    assert not (tmp_path / "results").exists()


def test_recordings_that_are_not_there(hknob, tmp_path: Path) -> None:
    text = SPEC.replace("person: {wandering_push: false, grip_wander: false}\n", "")
    (tmp_path / "spec.yaml").write_text(text + "device: {driver: replay, recordings: [nothing.parquet]}\n")
    done = hknob("hw-run", "spec.yaml")
    assert done.returncode == 2
    assert "nothing.parquet: No such file or directory" in done.stderr
