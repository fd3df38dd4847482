"""Bits flipped at random in results of every kind and in compiled code: not one such file is taken as it is.

`python tests/faults/flips.py --flips 10000 --seed S` makes results once (a pipeline with tables, a page and its
drawings, pictures, pieces of an unfinished sweep, trials of a device, compiled
code), then flips one bit of one file at a time. Whatever would read the file must refuse it, and so must
`hknob verify`. Every so often the command that made the results is run, which must put back what was there, byte for
byte. `test_flips.py` does a share of it.

2026-11-23, --flips 10000 --seed 20261123 --rerun-every 1000, two busy cores, 133 s: none believed (4748 in tables, 432
in pages, 463 in drawings, 464 in pictures, 911 in records, 1317 in pieces, 1665 in compiled code), ten made again.
2026-11-25, --flips 10000 --seed 20261125 --rerun-every 1000, beside other work, 147 s: none believed (5223 in tables,
496 in pages, 506 in drawings, 467 in pictures, 922 in records, 1434 in pieces, 952 in compiled code), ten made again.
2026-11-27, --flips 10000 --seed 20261127: none believed (5233, 463, 477, 499, 979, 1419, 930), ten made again.
"""

import argparse
import json
import os
import random
import re
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

sys.path.insert(0, str(Path(__file__).parents[2]))

from hknob_cli.engine.kept_code import _file_class
from hknob_cli.hardware.journal import read_about
from hknob_cli.hardware.trial_file import read_trial
from hknob_cli.pipeline.fresh import RECORD
from hknob_cli.pipeline.verify import Verdict, _file
from hknob_cli.results.files import Staging
from hknob_cli.results.store import are_current, read_current
from hknob_cli.specs.seal import State, state_of
from tests.conftest import SPEC
from tests.hardware.campaigns import Faulty, campaign

HKNOB = [sys.executable, "-m", "hknob_cli"]
PIPELINE = """\
kind: pipeline
name: all
stages:
  grid: {spec: grid.yaml}
  laws: {spec: laws.yaml, set: {against: {from: grid}}}
  page: {spec: page.yaml, set: {results: {from: [grid]}}}
"""
SPECS = {
    "all.yaml": PIPELINE,
    "grid.yaml": SPEC.replace("[1000]", "[1000, 2000]").replace("phases: 8", "phases: 2"),
    "laws.yaml": SPEC.replace("kind: sweep", "kind: predict").partition("starts:")[0],
    "page.yaml": "kind: report\nname: page\nresults: {grid: grid}\n",
}
CODE = 'from hknob_cli.engine.jit import compiled; compiled("bounces")["make_loop"](0.1, 0.2, 0.5, 0.1, 1.0, 0.0, 0.0)'


class Target(NamedTuple):
    """A file; ``believed`` says whether it is taken as it is; ``verified``: whether `hknob verify` looks at it."""

    path: Path
    believed: Callable[[Path], bool]
    verified: bool


def build(folder: Path) -> list[Target]:
    """Results of every kind, and what they are read by."""
    for name, text in SPECS.items():
        (folder / name).write_text(text)
    env = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])}
    kept = {**env, "HKNOB_CACHE_DIR": str(folder / "cache")}
    subprocess.run(
        [*HKNOB, "run", folder / "all.yaml", "-o", folder / "all", "-q"], check=True, env=env, stdout=subprocess.DEVNULL
    )
    subprocess.run([*HKNOB, "sweep", folder / "grid.yaml", "-o", folder / "drawn", "--plot", "-q"],
                   check=True, env=env, stdout=subprocess.DEVNULL)  # fmt: skip
    subprocess.run([sys.executable, "-c", CODE], check=True, env=kept)
    (folder / "device").mkdir()
    campaign(folder / "device", Faulty(), is_source=True).run()
    staging = Staging(folder / "drawn", b"of another run")
    staging.begin()
    for start in range(3):
        staging.put(start, start + 1, random.Random(start).randbytes(900))
    return [target for path in sorted(folder.rglob("*")) if path.is_file() for target in _targets(path)]


def _targets(path: Path) -> list[Target]:
    readers: dict[str, Callable[[Path], bool]] = {
        ".parquet": _is_table_believed,
        ".html": _is_text_believed,
        ".svg": _is_text_believed,
        ".png": lambda _path: False,  # drawn again whenever it is asked for
        ".piece": _is_piece_believed,
        ".nbi": _is_code_believed,
        ".nbc": _is_code_believed,
    }
    if path.name == RECORD:
        return [Target(path, lambda file: state_of(file) is State.WHOLE, verified=True)]
    if path.name == "campaign.json":
        return [Target(path, lambda file: read_about(file.parent) is not None, verified=True)]
    reader = readers.get(path.suffix)
    return [Target(path, reader, verified=not path.suffix.startswith(".nb"))] if reader else []


def _is_table_believed(path: Path) -> bool:
    if path.parent.name == "recording":
        return read_trial(path) is not None
    if path not in _STAMPS:
        _STAMPS[path] = _provenance(path)
    return read_current([path], _STAMPS[path]) is not None


def _provenance(path: Path) -> bytes:
    import pyarrow.parquet as pq

    return (pq.read_metadata(path).metadata or {})[b"hknob.provenance"]


def _is_text_believed(path: Path) -> bool:
    if path not in _MARKS:
        _MARKS[path] = _mark(path)
    return are_current([path], _MARKS[path])


def _mark(path: Path) -> str:
    found = re.search("<!-- hknob .*? -->", path.read_text())
    assert found
    return re.sub("sha256:[0-9a-f]{64}", f"sha256:{'0' * 64}", found[0]) + "\n"


def _is_piece_believed(path: Path) -> bool:
    staging = Staging(path.parents[1], b"of another run")
    start, stop = map(int, path.stem.split("-"))
    return staging._read(start, stop) is not None


def _is_code_believed(path: Path) -> bool:
    content = path.read_bytes()
    found = _file_class()(str(path.parent), path.name, None)._content(str(path)) is not None
    path.write_bytes(content)  # it is removed
    return found


_STAMPS: dict[Path, bytes] = {}
_MARKS: dict[Path, str] = {}


def flip(path: Path, chance: random.Random) -> bytes:
    """Flip a bit; the content before."""
    before = path.read_bytes()
    place, bit = chance.randrange(len(before)), chance.randrange(8)
    path.write_bytes(before[:place] + bytes([before[place] ^ 1 << bit]) + before[place + 1 :])
    return before


def flip_over_and_over(folder: Path, *, flips: int, seed: int, rerun_every: int) -> Counter[str]:
    """Flip so many bits. Raises `AssertionError` where a file is believed; how many there were by kind of file."""
    chance = random.Random(seed)
    targets = build(folder)
    for one in targets:  # all are good before
        assert one.believed(one.path) or one.path.suffix == ".png", one.path
    found: Counter[str] = Counter()
    for i in range(flips):
        again = bool(rerun_every) and i % rerun_every == 0
        one = chance.choice([each for each in targets if folder / "all" in each.path.parents] if again else targets)
        before = flip(one.path, chance)
        what = f"flip {i} of seed {seed}: {one.path}"
        assert not one.believed(one.path), what
        if one.verified:
            assert _file(one.path).verdict is Verdict.CHANGED, what
        if again:
            _run_again(folder)
            found["made again by the command"] += 1
            assert one.path.read_bytes() == before or one.path.name == RECORD, what
        one.path.write_bytes(before)
        found[one.path.suffix] += 1
    return found


def _run_again(folder: Path) -> None:
    env = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])}
    command = [*HKNOB, "run", folder / "all.yaml", "-o", folder / "all", "--json"]
    done = subprocess.run(command, check=True, env=env, capture_output=True, text=True)
    assert json.loads(done.stdout)["stages"]


def main() -> None:
    """Run it, and print what came of it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--flips", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--rerun-every", type=int, default=100)
    options = parser.parse_args()
    begin = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        found = flip_over_and_over(
            Path(folder), flips=options.flips, seed=options.seed, rerun_every=options.rerun_every
        )
    print(f"seed {options.seed}: {options.flips} flips, none believed; {dict(found)}; {time.monotonic() - begin:.0f} s")


if __name__ == "__main__":
    main()
