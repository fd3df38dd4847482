"""``hknob run`` killed, interrupted, run twice at once, with a damaged record, on a full disk."""

import json
import random
import signal
import subprocess
import time
import tomllib
from pathlib import Path

import pytest

from tests.conftest import HKNOB, SPEC
from tests.faults import campaign

KILLS = 25  # `campaign.py` does more
BUSY = SPEC.replace("phases: 8", "phases: 100000").replace("[1000]", "{lin: [1000, 2000, 30]}")


def start(spec: Path, out: Path, *options: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [HKNOB, "run", spec, "-o", out, "--json", *options], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


def results(out: Path) -> dict[str, bytes]:
    """Every result file: what a reader may rely on. Records of the runs are hidden, or name themselves."""
    files = (path for path in out.rglob("*") if path.suffix in {".parquet", ".html", ".svg"})
    return {path.relative_to(out).as_posix(): path.read_bytes() for path in files}


def recorded(out: Path) -> set[str]:
    """Stages that the record says are finished."""
    names: set[str] = set()
    if (out / "pytask.lock").exists():
        names |= {task["id"] for task in tomllib.loads((out / "pytask.lock").read_text())["task"]}
    journal = out / "pytask.lock.journal"
    for line in journal.read_text().splitlines() if journal.exists() else ():
        try:
            names.add(json.loads(line)["id"])
        except ValueError:
            break  # torn by the kill
    return names


@pytest.mark.long
def test_kill_at_random_instants(tmp_path: Path) -> None:
    """Of four stages that wait for each other by twos, small ones: what they compute is nothing to a kill."""
    campaign.write(tmp_path)
    pipeline = tmp_path / "run.yaml"
    start(pipeline, tmp_path / "first").communicate(timeout=300)  # which may have to compile the engine
    undisturbed = tmp_path / "undisturbed"
    begin = time.monotonic()
    process = start(pipeline, undisturbed)
    process.communicate(timeout=120)
    assert process.returncode == 0
    whole = time.monotonic() - begin
    wanted = results(undisturbed)
    chance = random.Random(5)
    killed = rounds = 0
    finished_before_a_kill: set[int] = set()
    while killed < KILLS or (
        len(finished_before_a_kill) < 3 and killed < 4 * KILLS
    ):  # on a busy machine few fall between
        out = tmp_path / f"round-{rounds}"
        rounds += 1
        done: set[str] = set()
        while True:
            process = start(pipeline, out)
            try:
                said, errors = process.communicate(timeout=chance.uniform(0.1, 1.1) * whole)
            except subprocess.TimeoutExpired:
                process.kill()
                process.communicate()
                killed += 1
                assert done <= recorded(out)
                done = recorded(out)
                finished_before_a_kill.add(len(done))
                continue
            assert process.returncode == 0, errors
            status = {stage["name"]: stage["status"] for stage in json.loads(said)["stages"]}
            assert {status[name] for name in done} <= {"up to date"}
            break
        assert results(out) == wanted
        assert not list(out.rglob(".*.partial"))
    assert len(finished_before_a_kill) >= 3, "kills hit between stages, not all in one place"


@pytest.mark.long
@pytest.mark.parametrize("kind", [signal.SIGINT, signal.SIGTERM])
def test_interruption_exits_130_and_keeps_what_is_finished(kind: signal.Signals, tmp_path: Path) -> None:
    (tmp_path / "busy.yaml").write_text(BUSY)
    (tmp_path / "quick.yaml").write_text(SPEC)
    pipeline = tmp_path / "p.yaml"
    pipeline.write_text("kind: pipeline\nname: p\nstages:\n  quick: {spec: quick.yaml}\n  slow: {spec: busy.yaml}\n")
    out = tmp_path / "out"
    process = start(pipeline, out)
    deadline = time.monotonic() + 120
    while not (out / "slow" / ".hknob.lock").exists() and time.monotonic() < deadline:
        time.sleep(0.01)
    time.sleep(0.2)
    process.send_signal(kind)
    _, errors = process.communicate(timeout=120)
    assert process.returncode == 130, errors
    assert errors.splitlines()[-1].startswith("interrupted")
    assert not (out / "slow" / "cells.parquet").exists()
    finished = {path.parent.name for path in out.glob("*/cells.parquet")}
    assert recorded(out) <= finished <= {"quick"}  # a stage beside others may have ended before its turn to be recorded
    if finished:
        said, errors = start(pipeline, out, "--until", "quick").communicate(timeout=120)
        assert [stage["status"] for stage in json.loads(said)["stages"]] == ["up to date"], errors


def test_a_second_run_on_one_folder_is_refused(hknob, tmp_path: Path) -> None:
    (tmp_path / "busy.yaml").write_text(BUSY)
    out = tmp_path / "out"
    process = start(tmp_path / "busy.yaml", out)
    deadline = time.monotonic() + 120
    while not (out / "sweep" / ".hknob.lock").exists() and time.monotonic() < deadline:
        time.sleep(0.01)
    time.sleep(0.2)  # the file is there a moment before it is locked
    process.send_signal(signal.SIGSTOP)  # or it could be done before the second begins
    second = hknob("run", tmp_path / "busy.yaml", "-o", out)
    process.kill()
    process.communicate()
    assert second.returncode == 3
    assert "another run is writing here" in second.stderr


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    "damage",
    ["", "lock-version = 1\n[[", "\x00\x00", 'lock-version = "99"\ntask = []\n', 'lock-version = "1"\ntask = 3\n'],
)
def test_a_damaged_record_costs_no_result(hknob, spec_file, tmp_path: Path, damage: str) -> None:
    spec = spec_file()
    hknob("run", spec, "-o", "out")
    before = results(tmp_path / "out")
    stamp = (tmp_path / "out" / "sweep" / "cells.parquet").stat().st_mtime_ns
    (tmp_path / "out" / "pytask.lock").write_text(damage)
    done = hknob("run", spec, "-o", "out")
    assert done.returncode == 0, done.stderr
    assert results(tmp_path / "out") == before
    assert (tmp_path / "out" / "sweep" / "cells.parquet").stat().st_mtime_ns == stamp
    assert "1 up to date" in done.stdout
    assert "up to date" in hknob("run", spec, "-o", "out").stdout


@pytest.mark.one_in(2)
@pytest.mark.parametrize("damage", ["", "{}", "[]", '{"name": 3}', "\x00"])
def test_a_damaged_note_of_the_last_run_costs_nothing(hknob, spec_file, tmp_path: Path, damage: str) -> None:
    spec = spec_file()
    hknob("run", spec, "-o", "out")
    (tmp_path / "out" / "pipeline.json").write_text(damage)
    (tmp_path / "out" / "pytask.lock.journal").write_text("junk")
    assert "1 up to date" in hknob("run", spec, "-o", "out").stdout
    assert not (tmp_path / "out" / "pytask.lock.journal").exists()


def test_a_folder_that_cannot_be_written(hknob, spec_file, tmp_path: Path) -> None:
    (tmp_path / "out").write_text("a file")
    done = hknob("run", spec_file(), "-o", "out/deeper")
    assert done.returncode == 1
    assert "out/deeper: cannot be written" in done.stderr
    assert "Traceback" not in done.stderr


BAD = {
    "no stages": ("stages: {}\n", "stages: must have at least 1 item"),
    "unknown key": (
        "stages: {a: {spec: s.yaml, needs: b}}\n",
        "stages.a.needs: unknown key; allowed: spec, folder, set",
    ),
    "no file": ("stages: {a: {spec: nowhere.yaml}}\n", "stages.a.spec: "),
    "folder with a name too long": (f"stages: {{a: {{folder: {'x' * 300}}}}}\n", "xxx: File name too long"),
    "unknown stage": (
        "stages: {a: {spec: s.yaml, set: {against: {from: grud}}}, grid: {spec: s.yaml}}\n",
        "stages.a.set.against: unknown stage 'grud'; did you mean 'grid'? allowed: grid",
    ),
    "itself": ("stages: {a: {spec: s.yaml, set: {against: {from: a}}}}\n", "must be another stage, got 'a'"),
    "circle": (
        "stages: {a: {spec: s.yaml, set: {against: {from: b}}}, b: {spec: s.yaml, set: {against: {from: a}}}}\n",
        "must not wait for itself: ",
    ),
    "both": ("stages: {a: {spec: s.yaml, folder: here}}\n", "stages.a: must have either spec (and set), or folder"),
    "more beside from": (
        "stages: {a: {spec: s.yaml, set: {against: {from: b, x: 1}}}, b: {spec: s.yaml}}\n",
        "set against={",
    ),
    "a fault that the pipeline sets": (
        "stages: {a: {spec: s.yaml, set: {scene.wall.stiffness: -1}}}\n",
        "set scene.wall.stiffness=-1: scene.wall.stiffness: must be >= 0, got -1",
    ),
    "reserved name": ("stages: {pytask.lock: {spec: s.yaml}}\n", 'stages["pytask.lock"]: must be another name'),
    "bad name": ("stages: {'../a': {spec: s.yaml}}\n", "must match pattern"),
    "empty from": ("stages: {a: {spec: s.yaml, set: {against: {from: []}}}}\n", "must be {from: STAGE}, a list"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_pipelines(hknob, tmp_path: Path, name: str) -> None:
    (tmp_path / "s.yaml").write_text(SPEC)
    text, wanted = BAD[name]
    (tmp_path / "p.yaml").write_text(f"kind: pipeline\nname: p\n{text}")
    for command in (("run",), ("check",), ("run", "--dry-run")):
        done = hknob(*command, "p.yaml")
        assert done.returncode == 2, done.stderr
        assert wanted in done.stderr
        assert done.stderr.startswith(("p.yaml:", "s.yaml:"))
        assert "Traceback" not in done.stderr
    assert not (tmp_path / "results").exists()
