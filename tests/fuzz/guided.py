"""Fuzzing led by coverage: inputs that reach new code are changed further. Needs atheris (`pip install atheris`).

    python tests/fuzz/guided.py --seconds 150

Each target of `guided_targets.py` begins with the kept inputs of ``corpus/guided/``, a line in base64 each, which
`test_guided.py` tries without atheris. ``--keep`` puts back as few as reach all that was reached. What breaks a rule
is saved under ``--save``, once a place in the program, and the exit code is 1.
"""

import argparse
import base64
import contextlib
import importlib
import os
import shlex
import subprocess
import sys
import tempfile
import traceback
from pathlib import Path
from typing import Any

sys.path[0] = str(Path(__file__).parents[2])  # the folder of this file has modules with names of others

from tests.fuzz.guided_targets import GUIDED, MOST_BYTES, MOST_KEPT, TARGETS, kept  # noqa: E402

LIMIT_S = 20  # of one input
INSIDE = "--inside"  # the process that feeds one target


def main() -> int:
    """Try all targets, one after the other; 1 if any rule was broken."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=int, default=150, help="for each target")
    parser.add_argument("--targets", default=",".join(TARGETS), help="default: %(default)s")
    parser.add_argument("--save", default="results/fuzz", help="folder for inputs that break a rule")
    parser.add_argument("--keep", action="store_true", help="keep inputs that reach new code")
    options = parser.parse_args()
    saved = Path(options.save).resolve() / "guided"
    before = _found(saved)
    for name in options.targets.split(","):
        with tempfile.TemporaryDirectory() as folder:
            inputs = Path(folder) / "inputs"
            inputs.mkdir()
            for i, data in enumerate(kept(name)):
                (inputs / f"{i:04}").write_bytes(data)
            _run(name, saved, folder, f"-max_total_time={options.seconds}", str(inputs))
            if options.keep:
                least = Path(folder) / "least"
                least.mkdir()
                _run(name, saved, folder, "-merge=1", str(least), str(inputs))
                _keep(name, least)
    new = _found(saved) - before
    print(f"rules broken: {sorted(map(str, new)) or 'none'}")
    return int(bool(new))


def _found(saved: Path) -> set[Path]:
    return set(saved.rglob("*.txt"))


def _run(name: str, saved: Path, folder: str, *options: str) -> None:
    most = f"-max_len={MOST_BYTES[name]}"
    done = subprocess.run(
        [sys.executable, __file__, INSIDE, name, str(saved), folder, most, f"-timeout={LIMIT_S}", *options],
        env={**os.environ, "PYTHONPATH": sys.path[0]},
        cwd=folder,
        stderr=subprocess.PIPE,
        text=True,
        check=False,
    )
    lines = done.stderr.splitlines()
    told = [line for line in lines if line.startswith(("Done ", "DONE", "#")) or "ERROR" in line or "broken" in line]
    print(f"{name}: exit {done.returncode}; {'; '.join(told[-2:]) or lines[-3:]}", flush=True)
    if done.returncode not in (0, 1):
        saved.mkdir(parents=True, exist_ok=True)
        (saved / f"{name}-ended-{done.returncode}.txt").write_text(done.stderr[-5000:])


def _keep(name: str, folder: Path) -> None:
    """The smallest inputs first."""
    found = sorted((path.read_bytes() for path in folder.iterdir()), key=lambda data: (len(data), data))[:MOST_KEPT]
    GUIDED.mkdir(exist_ok=True)
    (GUIDED / f"{name}.txt").write_text("".join(f"{base64.b64encode(data).decode()}\n" for data in found if data))


def _feed(name: str, saved: str, folder: str, *options: str) -> None:
    """In a process of its own: load the program with what counts its branches, and begin."""
    atheris: Any = importlib.import_module("atheris")
    with atheris.instrument_imports(include=["hknob_cli"]):
        from tests.fuzz import guided_targets

        guided_targets.FOLDER = Path(folder)
        for data in (b"", b"\0", *kept(name)):  # so that what is loaded on the way is looked at, too
            with contextlib.suppress(Exception):
                TARGETS[name](data)
    seen: set[str] = set()

    def try_one(data: bytes) -> None:
        error = guided_targets.quietly(TARGETS[name], data)
        if error is None:
            return
        frames = [one for one in traceback.extract_tb(error.__traceback__) if "hknob_cli" in one.filename]
        place = f"{Path(frames[-1].filename).stem}-{frames[-1].lineno}" if frames else "here"
        signature = f"{name}-{type(error).__name__}-{place}"
        if signature in seen:
            return
        seen.add(signature)
        Path(saved).mkdir(parents=True, exist_ok=True)
        text = "".join(traceback.format_exception(error))
        (Path(saved) / f"{signature}.txt").write_text(f"{base64.b64encode(data).decode()}\n{data!r}\n{text}")

    again = Path(folder) / "again"  # what libFuzzer calls to look at a corpus in processes of its own
    again.write_text(f'#!/bin/sh\nexec {shlex.join([sys.executable, __file__, INSIDE, name, saved, folder])} "$@"\n')
    again.chmod(0o700)
    atheris.Setup([str(again), *options], try_one)
    atheris.Fuzz()


if __name__ == "__main__":
    if sys.argv[1:2] == [INSIDE]:
        _feed(*sys.argv[2:])
    sys.exit(main())
