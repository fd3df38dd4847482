"""Runs of every kind killed at random instants, over and over, until they are through: nothing lost, nothing changed.

`python tests/faults/campaign.py --kills 200 --seed S` kills that many in all: sweeps (in one go, spread over processes,
spread and written in parts), a pipeline, a simulated measuring campaign and one that tries remedies. Each is killed and
begun again, with the same command and no clearing up, until one run comes through; then its folder must hold what an
undisturbed run leaves, byte for byte, and nothing else, and what was finished before a kill must have stayed as it was.
`test_campaign.py` does a share of it.

2026-11-21, --kills 200 --seed 20261121, two busy cores, 334 s: 40 kills of each kind, and 66 runs that came through
(sweep 3, spread 25, parts 19, run 16, hw-run 3), all as undisturbed. At the kills of spread sweeps 0 to 14 pieces or
parts were finished; at those of campaigns, nearly all trials. 2026-11-22, --kills 60 --seed 20261122 and --kills 140
--seed 20261123, and --kills 200 --seed 20261125, quiet, 291 s: 40 kills of each kind, all as undisturbed. 2026-11-27,
--kills 200 --seed 20261127, a pipeline's stages side by side, 279 s: 33 or 34 kills of each kind, all as undisturbed.
"""

import argparse
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

sys.path.insert(0, str(Path(__file__).parents[2]))

from tests.conftest import SPEC
from tests.faults import small_pieces
from tests.faults.spread_runs import SLOW, SMALL_PIECES, SWEEP, left
from tests.hardware.campaigns import REMEDIES
from tests.hardware.campaigns import SPEC as HW_RUN

PIPELINE = """\
kind: pipeline
name: p
stages:
  grid: {spec: pipe-sweep.yaml}
  laws: {spec: predict.yaml, set: {against: {from: grid}}}
  finer: {spec: pipe-sweep.yaml, set: {starts.phases: 9}}
  finer-laws: {spec: predict.yaml, set: {against: {from: finer}}}
"""
PREDICT = re.sub(r"starts: .*\n", "", SPEC.replace("kind: sweep", "kind: predict"))
ONE_FILE = f"{SLOW}; slow_worker.SECONDS = 0.15; {small_pieces.ONE_FILE}"
IN_PARTS = f"{SLOW}; slow_worker.SECONDS = 0.15"
BUSY = SPEC.replace("phases: 8", "phases: 64").replace("[1000]", "{log: [200, 5000, 12]}")
HKNOB = [sys.executable, "-m", "hknob_cli"]


class Case(NamedTuple):
    """A kind of run: the command, the spec, and which files, as long as they are there, must stay as they are."""

    command: list[str]
    spec: str
    kept: tuple[str, ...] = ()


CASES = {
    "sweep": Case([*HKNOB, "sweep"], BUSY),
    "spread": Case([sys.executable, str(SMALL_PIECES), ONE_FILE, "sweep"], SWEEP, ("*.piece",)),
    "parts": Case([sys.executable, str(SMALL_PIECES), IN_PARTS, "sweep"], SWEEP, ("*.piece", "orbits/part-*")),
    "run": Case([*HKNOB, "run"], PIPELINE, ("orbits.parquet",)),
    "hw-run": Case([*HKNOB, "hw-run"], HW_RUN, ("recording/*.parquet",)),
    "tried": Case([*HKNOB, "hw-run"], HW_RUN + REMEDIES, ("recording/*.parquet",)),
}
RECORDS = re.compile(r"\.pytask.*|pytask\.lock|pipeline\.json|.*\.hknob\.lock")  # of a pipeline's runs, not results


class Killed(NamedTuple):
    """What came of it: kills, runs that came through, and by how many files that were there at a kill."""

    kills: int
    through: int
    kept: Counter[int]


def write(folder: Path) -> None:
    """The specs of all cases."""
    for name, case in CASES.items():
        (folder / f"{name}.yaml").write_text(case.spec)
    (folder / "predict.yaml").write_text(PREDICT)
    (folder / "pipe-sweep.yaml").write_text(SPEC)


def start(folder: Path, name: str, out: Path) -> "subprocess.Popen[str]":
    """Begin a run."""
    return subprocess.Popen(
        [*CASES[name].command, str(folder / f"{name}.yaml"), "-o", str(out), "-q"],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])},
    )


def outcome(out: Path) -> dict[str, bytes]:
    """All that a finished run leaves but records of how it went."""
    return {name: content for name, content in left(out).items() if not RECORDS.fullmatch(name)}


def state(out: Path, kept: tuple[str, ...]) -> dict[str, int]:
    """Finished files by their place, and when they were written."""
    found = [path for pattern in kept for path in out.glob(f"**/{pattern}")] if out.exists() else []
    return {path.relative_to(out).as_posix(): path.stat().st_mtime_ns for path in found}


def kill_over_and_over(
    folder: Path, name: str, *, kills: int, seed: int, say: Callable[[str], None] = lambda _: None
) -> Killed:
    """Kill runs of one case. Raises `AssertionError` where anything is lost, changed or left."""
    chance = random.Random(f"{seed} {name}")
    finish(start(folder, name, folder / f"{name}-first"))  # which may have to compile the engine
    undisturbed = folder / f"{name}-undisturbed"
    begin = time.monotonic()
    finish(start(folder, name, undisturbed))
    whole = time.monotonic() - begin
    wanted = outcome(undisturbed)
    killed = through = 0
    kept: Counter[int] = Counter()
    while killed < kills or not through:
        out = folder / f"{name}-{through}"
        done: dict[str, int] = {}
        while True:
            process = start(folder, name, out)
            try:
                _, errors = process.communicate(timeout=chance.uniform(0.2, 1.1) * whole if killed < kills else 120)
            except subprocess.TimeoutExpired:
                if chance.random() < 0.5:
                    process.kill()  # its workers must end themselves
                else:
                    os.killpg(process.pid, signal.SIGKILL)
                process.communicate()
                now = state(out, CASES[name].kept)
                assert all(now.get(file, stamp) == stamp for file, stamp in done.items())
                done |= now
                killed += 1
                kept[len(now)] += 1
                continue
            assert process.returncode == 0, errors
            break
        found = outcome(out)
        assert found.keys() == wanted.keys(), found.keys() ^ wanted.keys()
        assert found == wanted, [file for file in wanted if found[file] != wanted[file]]
        through += 1
        shutil.rmtree(out)
        say(f"{name}: {killed} kills, {through} through")
    return Killed(killed, through, kept)


def finish(process: "subprocess.Popen[str]") -> None:
    """Wait for a run that nobody disturbs."""
    _, errors = process.communicate(timeout=120)
    assert process.returncode == 0, errors


def main() -> None:
    """Run it, and print what came of it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    begin = time.monotonic()
    for i, name in enumerate(CASES):
        share = options.kills // len(CASES) + (i < options.kills % len(CASES))
        with tempfile.TemporaryDirectory() as folder:
            write(Path(folder))
            found = kill_over_and_over(Path(folder), name, kills=share, seed=options.seed)
        print(f"{name}: {found.kills} kills, {found.through} runs came through, all as undisturbed;", end=" ")
        print(f"finished files at the kills: {dict(sorted(found.kept.items()))}", flush=True)
    print(f"seed {options.seed}, {time.monotonic() - begin:.0f} s")


if __name__ == "__main__":
    main()
