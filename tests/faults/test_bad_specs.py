"""Broken specs: exit 2, one line a fault with its place, no traceback, nothing written."""

import os
import re
from pathlib import Path

import pytest

from hknob_cli.errors import UsageError
from hknob_cli.specs.load import load
from tests.conftest import EXPERIMENTS, SPEC

KNOB = "knob: {inertia: 1.9e-6}"

# What is replaced, by what, and the line that must appear: FILE:LINE:COL: key: message.
BROKEN = {
    "negative": ("stiffness: 0.27", "stiffness: -0.27", "6:21: scene.wall.stiffness: must be >= 0, got -0.27"),
    "zero inertia": ("inertia: 1.9e-6", "inertia: 0", "4:19: scene.knob.inertia: must be > 0, got 0"),
    "typo": (
        "stiffness: 0.04", "stifness: 0.04", "5:45: scene.hand.stifness: unknown key; did you mean 'stiffness'?",
    ),
    "typo at the top": ("starts:", "start:", "11:1: start: unknown key; did you mean 'starts'?"),
    "unknown part": (KNOB, f"{KNOB}\n  flywheel: {{}}", "5:3: scene.flywheel: unknown key"),
    "missing part": (f"  {KNOB}\n", "", "3:1: scene.knob: missing, and required"),
    "missing key": ("{stiffness: 0.27}", "{}", "6:3: scene.wall.stiffness: missing, and required"),
    "missing name": ("name: small\n", "", "1:1: name: missing, and required"),
    "missing kind": ("kind: sweep\n", "", "1:1: kind: missing, and required; one of: sysid, sweep"),
    "unknown kind": ("kind: sweep", "kind: sweeep", "1:7: kind: must be sweep, got 'sweeep'"),
    "name is a path": ("name: small", "name: ../../etc", "2:7: name: "),
    "text for a number": ("0.27", "stiff", "6:21: scene.wall.stiffness: 'stiff' is not a number with a unit"),
    "wrong unit": ("0.27", "3 kg", "6:21: scene.wall.stiffness: '3 kg' is in kilogram, which is not a kind of N*m/rad"),
    "unknown unit": ("0.27", "3 blargs", "6:21: scene.wall.stiffness: '3 blargs' has an unknown unit 'blargs'"),
    "quoted number": ("0.27", "'0.27'", "6:21: scene.wall.stiffness: '0.27' is text"),
    "true for a number": ("0.27", "true", "6:21: scene.wall.stiffness: must be a number, got true"),
    "null for a number": ("0.27", "null", "6:21: scene.wall.stiffness: must be a number, got null"),
    "not finite": ("0.27", ".inf", "6:21: scene.wall.stiffness: must be"),
    "not a number": ("0.27", ".nan", "6:21: scene.wall.stiffness: must be"),
    "list for a number": ("0.27", "[1]", "6:21: scene.wall.stiffness: must be a number, got a list of 1"),
    "number for a part": ("{stiffness: 0.27}", "0.27", "6:9: scene.wall: must be a mapping of keys to values"),
    "duplicate key": ("{stiffness: 0.27}", "{stiffness: 1, stiffness: 2}", "6:24: scene.wall.stiffness: duplicate key"),
    "both biases": ("{torque: 0.001}", "{torque: 1, half_quantum: true}", "7:9: scene.bias: must have exactly one of"),
    "neither bias": ("{torque: 0.001}", "{}", "7:9: scene.bias: must have exactly one of"),
    "half a half-quantum": ("{torque: 0.001}", "{half_quantum: false}", "7:24: scene.bias.half_quantum: must be True"),
    "no rates": ("[1000]", "[]", "9:19: grid.sample_rate_hz: must have at least 1 item"),
    "negative rate": ("[1000]", "[1000, -5]", "9:26: grid.sample_rate_hz[1]: must be >= 0.001, got -5"),
    "log from zero": ("[1000]", "{log: [0, 10, 3]}", "9:26: grid.sample_rate_hz.log[0]: must be >= 0.001, got 0"),
    "log of two": ("[1000]", "{log: [1, 10]}", "9:20: grid.sample_rate_hz.log[2]: missing, and required"),
    "log and lin": ("[1000]", "{log: [1, 10, 3], lin: [1, 10, 3]}", "9:37: grid.sample_rate_hz.lin: unknown key"),
    "true for a rate": ("[1000]", "[true, 5]", "9:20: grid.sample_rate_hz[0]"),
    "angular rate": ("[1000]", "[1000 rad/s]", "is in radian / second, which is not a kind of Hz"),
    "turning rate": ("[1000]", "[6000 rpm]", "which is not a kind of Hz"),
    "half a count": ("[1024]", "[1024, 512.5]", "10:26: grid.counts_per_rev[1]: must be a whole number, got 512.5"),
    "no counts": ("  counts_per_rev: [1024]\n", "", "8:1: grid.counts_per_rev: missing, and required"),
    "unknown axis": ("[1024]", "[1024]\n  hand.stifness: [1]", '11:3: grid["hand.stifness"]: unknown key; did you'),
    "axis of nothing": ("[1024]", "[1024]\n  actuator.delay_samples: [1]", "which has no 'actuator'"),
    "no phases": ("phases: 8", "phases: 0", "11:31: starts.phases: must be >= 1, got 0"),
    "part of a phase": ("phases: 8", "phases: 2.5", "11:31: starts.phases: must be a whole number, got 2.5"),
    "unknown rounding": (KNOB, f"{KNOB}\n  encoder: {{rounding: up}}", "5:23: scene.encoder.rounding: must be 'floor'"),
    "offset of a count": (KNOB, f"{KNOB}\n  encoder: {{offset_counts: 1}}", "scene.encoder.offset_counts: must be < 1"),
    "negative friction": (KNOB, "knob: {inertia: 1, coulomb_torque: -1}", "4:38: scene.knob.coulomb_torque: must be"),
    "unknown sampling": (KNOB, f"{KNOB}\n  sampling: often", "5:13: scene.sampling: must be 'zero_order_hold' or"),
    "unknown sensor": (KNOB, f"{KNOB}\n  encoder: gyro", "5:12: scene.encoder: must be 'none'"),
    "null sensor": (KNOB, f"{KNOB}\n  encoder: null", "5:12: scene.encoder: must be a mapping"),
    "lag without clock": (
        KNOB, f"{KNOB}\n  sampling: continuous\n  actuator: {{time_constant: 1 ms}}", "6:29: scene.actuator.time_con",
    ),
    "delay without clock": (
        KNOB, f"{KNOB}\n  sampling: continuous\n  actuator: {{delay_samples: 1}}", "6:29: scene.actuator.delay_samples",
    ),
    "finger alone": ("stiffness: 0.04", "finger: {inertia: 1}", "scene.hand: must have both 'finger' and"),
    "two hands": ("stiffness: 0.04", "finger: {inertia: 1}, fingerpad: {}", "scene.hand: must have 'finger' and"),
    "no weight": ("stiffness: 0.04", "finger: {inertia: 0}, fingerpad: {}", "scene.hand.finger.inertia: must be > 0"),
    "axis of no finger": ("[1024]", "[1024]\n  hand.finger.inertia: [1]", "which has no 'finger'"),
    "damped growth": ("starts:", "growth: {duration: 1}\nstarts:", "5:27: scene.hand.damping: must be absent where"),
    "recording of hardly any time": (
        "starts:", "record: {duration: 5e-324}\nstarts:", "11:20: record.duration: must be >= 1e-09, got 5e-324",
    ),
    "recording of no time": ("starts:", "record: {duration: 0}\nstarts:", "11:20: record.duration: must be > 0, got 0"),
    "no torque without clock": (
        KNOB, f"{KNOB}\n  sampling: continuous\n  actuator: {{torque_limit: 0}}", "6:28: scene.actuator.torque_limit",
    ),
    "half of no count": (
        "{torque: 0.001}", "{half_quantum: true}\n  encoder: none", "7:24: scene.bias.half_quantum: must be absent",
    ),
    "recording of an age": (
        "starts:", "record: {duration: 1e6 s, interval: 1 ms}\nstarts:", "11:10: record.duration: must be shorter",
    ),
    "not YAML": ("[1000]", "[1000", ": not YAML"),
    "a tab": ("  wall", "\twall", ": not YAML"),
}  # fmt: skip


@pytest.mark.parametrize("name", BROKEN)
def test_broken_spec(name: str, spec_file, tmp_path: Path) -> None:
    old, new, message = BROKEN[name]
    assert old in SPEC
    path = spec_file(SPEC.replace(old, new, 1))
    with pytest.raises(UsageError) as caught:
        load(path, kind="sweep")
    said = str(caught.value)
    assert caught.value.exit_code == 2
    lines = said.splitlines()
    assert all(re.match(rf"{re.escape(str(path))}:\d+:\d+: ", line) for line in lines), said
    assert any(message in line for line in lines), said
    assert [entry.name for entry in tmp_path.iterdir()] == ["spec.yaml"]


@pytest.mark.parametrize("name", ["negative", "unknown kind", "wrong unit", "not YAML"])
def test_the_command_says_the_same(name: str, hknob, spec_file, tmp_path: Path) -> None:
    path = spec_file(SPEC.replace(*BROKEN[name][:2], 1))
    with pytest.raises(UsageError) as caught:
        load(path, kind="sweep")
    done = hknob("sweep", path)
    assert (done.returncode, done.stdout, done.stderr) == (2, "", f"{caught.value}\n")
    assert [entry.name for entry in tmp_path.iterdir()] == ["spec.yaml"]


def test_at_least_thirty() -> None:
    assert len(BROKEN) >= 30


def test_all_faults_at_once(hknob, spec_file) -> None:
    text = (
        SPEC.replace("0.27", "-1").replace("[1024]", "[0]").replace("phases: 8", "phases: no").replace("name:", "nam:")
    )
    done = hknob("sweep", spec_file(text))
    assert len(done.stderr.splitlines()) == 5


def test_of_many_faults_two_hundred_are_said(hknob, spec_file) -> None:
    done = hknob("check", spec_file(SPEC + "".join(f"key{i}: 1\n" for i in range(500))))
    lines = done.stderr.splitlines()
    assert (done.returncode, len(lines), lines[-1]) == (2, 201, "... and 300 more faults")
    assert "key42: unknown key; allowed: kind" in lines[42]


def test_nothing_that_a_spec_says_steers_the_terminal(hknob, spec_file) -> None:
    done = hknob("check", spec_file('"a\\e[2J": 1\n"\\u202Eb": [1\n'), "--set", "x\x1b[31m=1\n2")
    assert "\x1b" not in done.stderr
    done = hknob("check", spec_file(SPEC + '"a\\e[2J": 1\n"\\u202Eb": 1\n'))
    assert [line.split(": ")[1] for line in done.stderr.splitlines()] == ["a?[2J", "?b"]
    done = hknob("check", spec_file(), "--set", "scene.wall.stiffness=\x1b[31m\nx")
    assert done.stderr.startswith("--set scene.wall.stiffness=?[31m?x: scene.wall.stiffness: ")
    assert len(done.stderr.splitlines()) == 1


def test_a_path_that_is_no_utf_8_is_said(hknob, spec_file, tmp_path: Path) -> None:
    spec = spec_file().rename(tmp_path / os.fsdecode(b"\xff.yaml"))
    done = hknob("check", spec)
    assert done.returncode == 0, done.stderr
    assert done.stdout.endswith("?.yaml: sweep 'small', 1 cell: good\n")
    assert "must be key.path=value in UTF-8" in hknob("check", spec, "--set", os.fsdecode(b"\xff=1")).stderr


def test_a_terminal_of_few_letters_is_written_to(hknob) -> None:
    done = hknob("sweep", EXPERIMENTS / "smoke_grid.yaml", "-o", "out", PYTHONIOENCODING="ascii", PYTHONUTF8="0")
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("content", [b"", b"\x00\x01\x02", b"\xff\xfe", b"a: 1\n" * 300_000, b"[" * 100_000])
def test_not_a_spec_at_all(content: bytes, hknob, tmp_path: Path) -> None:
    path = tmp_path / "x.yaml"
    path.write_bytes(content)
    done = hknob("sweep", path)
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    assert done.stderr.startswith(str(path))


def test_folders_and_missing_files(hknob, tmp_path: Path) -> None:
    for target in (tmp_path, tmp_path / "none.yaml"):
        done = hknob("sweep", target)
        assert done.returncode == 2
        assert "Traceback" not in done.stderr


@pytest.mark.parametrize("said", ["", "kind: sweep\n"])
def test_the_kind_may_be_set(hknob, spec_file, said: str) -> None:
    """Where a file says none, or another: the check is of the kind that is set."""
    page = spec_file(f"{said}name: page\nresults: [a]\n")
    done = hknob("check", page, "--set", "kind=report")
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == f"{page}: report 'page', 1 result: good\n"


@pytest.mark.parametrize(
    "text", ["", "=1", "scene", "scene.wall=", "scene.wall.stiffness=[1", "kind.x=1", "scene.nothing=1", "..=1"]
)
def test_bad_overrides(text: str, hknob, spec_file) -> None:
    done = hknob("sweep", spec_file(), "--set", text)
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    assert done.stderr.startswith(f"--set {text}: ")
