"""Start-up and memory: whole processes against the imports they cannot do without.

Each command is run in turn with its floor, so that a drift of the machine hits both; the ratio is of medians. Cold
means a fresh process and no results; the compiler's cache is warm, and Python's, as a user has them. The number of runs
may be given.
"""

import os
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from record import put

ROOT = Path(__file__).parents[2]
BIN = Path(sys.executable).parent
OUT = Path(tempfile.mkdtemp()) / "out"

CASES = [
    ("hknob --help", ["--help"], "import typer", 3.0),
    (
        "3x3 smoke sweep",
        ["sweep", str(ROOT / "experiments/smoke_grid.yaml"), "-o", str(OUT)],
        "import typer, pydantic, numpy, pyarrow",
        1.5,
    ),
    (
        "7x7 sweep, 64 phases",
        ["sweep", str(ROOT / "experiments/hand_on_knob.yaml"), "-o", str(OUT)],
        "import typer, pydantic, numpy, numba, pyarrow",
        2.0,
    ),
]
KEPT = {"hknob --help": "--help", "3x3 smoke sweep": "small sweep", "7x7 sweep, 64 phases": "grid"}  # of the record


def seconds(command: list[str]) -> float:
    """Wall time of one run in a folder without results."""
    shutil.rmtree(OUT, ignore_errors=True)
    begin = time.perf_counter()
    subprocess.run(command, check=True, capture_output=True)
    return time.perf_counter() - begin


def peak_kib(command: list[str]) -> int:
    """Peak memory of one run, KiB, as the kernel accounts it for a child of its own."""
    code = "import resource, subprocess, sys; subprocess.run(sys.argv[1:], check=True, capture_output=True); "
    code += "print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)"
    shutil.rmtree(OUT, ignore_errors=True)
    return int(
        subprocess.run([BIN / "python", "-c", code, *command], check=True, capture_output=True, text=True).stdout
    )


def rerun(runs: int) -> None:
    """Print how long a pipeline takes that has nothing to do, beside ``hknob --help``."""
    place = tempfile.mkdtemp()
    command = [str(BIN / "hknob"), "run", str(ROOT / "experiments/smoke.yaml"), "-o", place]
    base = [str(BIN / "hknob"), "--help"]
    seconds(command)
    pairs = [(seconds(command), seconds(base)) for _ in range(runs)]
    ours, theirs = (statistics.median(pair[i] for pair in pairs) * 1e3 for i in (0, 1))
    print(f"{'pipeline, nothing to do':24}{ours:8.0f}{theirs:10.0f}{ours / theirs:8.2f}{1.5:9.1f}")
    put("nothing to do", ours / theirs)
    shutil.rmtree(place)


def main() -> None:
    """Print ratios beside their ceilings."""
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # with it, each process parses the program anew
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 15
    print(f"{'command':24}{'ms':>8}{'floor ms':>10}{'ratio':>8}{'ceiling':>9}")
    for name, args, floor, ceiling in CASES:
        command = [str(BIN / "hknob"), *args]
        base = [str(BIN / "python"), "-c", floor]
        seconds(command)
        pairs = [(seconds(command), seconds(base)) for _ in range(runs)]
        ours, theirs = (statistics.median(pair[i] for pair in pairs) * 1e3 for i in (0, 1))
        print(f"{name:24}{ours:8.0f}{theirs:10.0f}{ours / theirs:8.2f}{ceiling:9.1f}")
        put(KEPT[name], ours / theirs)
    rerun(runs)
    sweep = [str(BIN / "hknob"), "sweep", str(ROOT / "experiments/hand_on_knob.yaml"), "-o", str(OUT)]
    few, many = (peak_kib([*sweep, "--set", f"starts.phases={phases}"]) for phases in (64, 65536))
    print(f"peak memory: {few / 1024:.0f} MiB at 64 phases, {many / 1024:.0f} MiB at 65536: ratio {many / few:.3f}")
    print(f"(this process: {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MiB)")


if __name__ == "__main__":
    main()


# Results, 2026-11-21, 2-core AMD EPYC (Zen 4) virtual machine, Python 3.11
#
# command                       ms  floor ms   ratio  ceiling
# hknob --help                 121        58    2.09      3.0
# 3x3 smoke sweep              192       154    1.25      1.5
# 7x7 sweep, 64 phases         473       329    1.44      2.0
# peak memory: 184 MiB at 64 phases, 186 MiB at 65536: ratio 1.006
