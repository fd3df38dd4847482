"""Runs of a small sweep that is spread, in parts, to be disturbed; and what an undisturbed one leaves."""

import atexit
import os
import re
import subprocess
import sys
import time
from collections.abc import Callable
from functools import cache
from pathlib import Path

from tests.forked import Forks

SMALL_PIECES = Path(__file__).with_name("small_pieces.py")

# 24 cells: 6 parts of 4, in pieces of one or two.
SWEEP = """\
kind: sweep
name: small
scene:
  knob: {inertia: 1.9e-6}
  hand: {inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}
  wall: {stiffness: 0.27}
  bias: {torque: 0.001}
grid:
  sample_rate_hz: [1000, 1250, 1500, 1750, 2000, 2500]
  counts_per_rev: [512, 1024, 2048, 4096]
starts: {angle: 0.02, phases: 3}
"""

# Workers on this machine that take their time, so that they can be met at work.
SLOW = "from tests.faults import slow_worker; slow_worker.SECONDS = 0.3"
IMPATIENT = (
    "from hknob_cli.spread.cluster import Cluster; Cluster.__init__.__kwdefaults__['patience'] = 1.0;"
    "from hknob_cli.spread import cluster; cluster.FIRST = 1.0; cluster._ANSWER = 1.0"
)


def start(spec: Path, out: Path, *args: object, fault: str = "", **env: str) -> subprocess.Popen[str]:
    """Begin a run, in a process group of its own; ``fault``: code that is run before it."""
    return subprocess.Popen(
        [sys.executable, str(SMALL_PIECES), fault, "sweep", str(spec), "-o", str(out), *map(str, args)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        env={**os.environ, **env},
    )


# What a slow machine, or one that has not compiled the engine yet, says besides.
PASSING = re.compile(
    r"^(the engine is compiled once .*|compiling( the engine for this machine)?: .*"
    r"|compiled \d+ .*|\d+ of \d+ cells(, .* left)?)\n",
    re.MULTILINE,
)


def finish(process: subprocess.Popen[str], timeout: float = 300) -> tuple[int, str]:
    """Exit code, and what was said on stderr."""
    try:
        _, errors = process.communicate(timeout=timeout)
    finally:
        process.kill()
    return process.returncode, PASSING.sub("", errors)


def run(spec: Path, out: Path, *args: object, fault: str = "", **env: str) -> tuple[int, str]:
    """A whole run: exit code, and what was said on stderr. Without a fault it is a fork (`tests.forked`)."""
    if fault or env:
        return finish(start(spec, out, *args, fault=fault, **env))
    words = ["sweep", str(spec), "-o", str(out), *map(str, args)]
    code, _, errors = loaded().run(words, cwd=Path.cwd(), env=dict(os.environ), timeout=300)
    return code, PASSING.sub("", errors)


@cache
def loaded() -> Forks:
    """The command with small pieces and parts, loaded once for all runs of a process."""
    forks = Forks(SMALL_PIECES.with_name("small_forks.py"))
    atexit.register(forks.end)
    return forks


def left(out: Path) -> dict[str, bytes]:
    """All that is in a folder but the lock: files with their content."""
    paths = {path.relative_to(out).as_posix(): path for path in out.rglob("*") if path.name != ".hknob.lock"}
    return {name: path.read_bytes() if path.is_file() else b"folder" for name, path in paths.items()}


def pieces(out: Path) -> int:
    """Pieces and parts that are finished."""
    return sum(1 for pattern in ("*.piece", "part-*") for _ in out.rglob(pattern))


def wait_until(condition: Callable[[], bool], what: str, seconds: float = 120) -> None:
    """Wait for what must come."""
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, f"waited in vain until {what}"
        time.sleep(0.005)
