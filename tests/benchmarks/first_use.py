"""What one waits for: a first run with nothing compiled, and the next one, of this state and of others beside it.

    python tests/benchmarks/first_use.py [FOLDER ...]

Each task is run in turn by each checkout, this one and those in the folders, in a cache of its own: wall seconds and
processor seconds of the first run and of the third, whole processes, with Python's own compiled files there.
"""

import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).parents[2]
CELL = ("--set", "grid.sample_rate_hz=1000", "--set", "grid.counts_per_rev=512")
TRIALS = ("--set", "starts={angle: 0.02, phases: 64}")
PHASES = ("--set", "starts={angle: 0.02}")
FRICTION = ("--set", "scene.knob.coulomb_torque=0.56 mN*m")
LAG = ("--set", "scene.controller={kind: bounded_lag, keep: 0.15, time_constant: 0.2}")
GRID = "hand_on_knob.yaml"
TASKS: dict[str, tuple[str, ...]] = {
    "one cell, plain": (GRID, *CELL),
    "one cell with friction": (GRID, *CELL, *FRICTION),
    "one cell, bounded lag": (GRID, *CELL, *LAG),
    "a grid, plain, 64 phases": (GRID, *TRIALS),
    "a grid with friction, 64 phases": (GRID, *TRIALS, *FRICTION),
    "a grid with friction": (GRID, *PHASES, *FRICTION),
    "a grid, bounded lag, 64 phases": (GRID, *TRIALS, *LAG),
    "a grid, bounded lag": (GRID, *PHASES, *LAG),
    "no sample clock": ("analog_wall.yaml",),
}


def run(checkout: Path, task: tuple[str, ...], place: Path) -> str:
    """Wall and processor seconds of a run; why there are none."""
    spec, *options = task
    code = "import sys; sys.argv[0] = 'hknob'; from hknob_cli.cli.main import main; main()"
    command = [sys.executable, "-c", code, "sweep", str(checkout / "experiments" / spec)]
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    env = {**kept, "PYTHONPATH": str(checkout), "HKNOB_CACHE_DIR": str(place / "cache")}
    before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    done = subprocess.run(
        [*command, *options, "-o", str(place / "out"), "--force", "-q"],
        env=env,
        cwd=place,
        capture_output=True,
        text=True,
        check=False,
    )
    seconds, after = time.perf_counter() - begin, resource.getrusage(resource.RUSAGE_CHILDREN)
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return f"{seconds:6.1f} ({used:5.1f})" if done.returncode == 0 else f"fails with {done.returncode}"


def main() -> None:
    """Print a line for each task and checkout."""
    checkouts = [ROOT, *(Path(folder).resolve() for folder in sys.argv[1:])]
    print(f"{'task':34}{'checkout':12}first, next: wall (processor) s")
    for name, task in TASKS.items():
        for checkout in checkouts:
            with tempfile.TemporaryDirectory() as folder:
                first, _, third = (run(checkout, task, Path(folder)) for _ in range(3))
            print(f"{name:34}{checkout.name:12}{first}   {third}", flush=True)


if __name__ == "__main__":
    main()
