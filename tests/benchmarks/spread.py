"""A large sweep by one process, by several, and by a Dask cluster on this machine: cells per second, and memory.

Every way is the installed command on experiments/million.yaml, smaller by ``--points`` values on each of its six axes,
and is told as a ratio of its rate to that of one process. Memory is the peak of what all its processes hold together
(proportional set size), looked at five times a second. The results of every way are compared byte by byte.

    python tests/benchmarks/spread.py [--points 10] [--jobs 2] [--workers 4] [--repeat 3]

It ends with the results of the day it was last run.
"""

import argparse
import filecmp
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).parents[2]
HKNOB = Path(sys.executable).with_name("hknob")
AXES = ("sample_rate_hz", "counts_per_rev", "wall.stiffness", "hand.damping", "hand.stiffness", "bias.torque")
ENDS = ((200, 10000), (128, 8192), (0.1, 1.0), (1.0e-4, 1.0e-3), (0.02, 0.2), (5.0e-4, 5.0e-3))


def tree(root: int) -> Iterator[int]:
    """A process and all below it."""
    yield root
    try:
        children = Path(f"/proc/{root}/task/{root}/children").read_text().split()
    except OSError:
        return
    for child in children:
        yield from tree(int(child))


def held(root: int) -> int:
    """Bytes that a process and all below it hold."""
    total = 0
    for process in tree(root):
        try:
            lines = Path(f"/proc/{process}/smaps_rollup").read_text().splitlines()
        except OSError:
            continue
        total += sum(1024 * int(line.split()[1]) for line in lines if line.startswith("Pss:"))
    return total


def run(out: Path, points: int, *options: str) -> tuple[float, int]:
    """Seconds and peak bytes of one sweep."""
    smaller = [f"grid.{name}={{log: [{a}, {b}, {points}]}}" for name, (a, b) in zip(AXES, ENDS, strict=True)]
    sets = [part for text in smaller for part in ("--set", text)] if points != 10 else []
    begin = time.perf_counter()
    process = subprocess.Popen(
        [HKNOB, "sweep", ROOT / "experiments" / "million.yaml", "-o", out, "--force", "-q", *sets, *options],
        stdout=subprocess.DEVNULL,
    )
    peak = 0
    while process.poll() is None:
        peak = max(peak, held(process.pid))
        time.sleep(0.2)
    if process.returncode:
        sys.exit(f"hknob ended with {process.returncode}")
    return time.perf_counter() - begin, peak


@contextmanager
def cluster(workers: int, place: Path) -> Iterator[str]:
    """The file of a scheduler with so many workers of one thread."""
    dask, file = Path(sys.executable).with_name("dask"), place / "scheduler.json"
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "cwd": place}
    begun = [
        subprocess.Popen(
            [dask, "scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", file],
            **quiet,
        )
    ]
    while not file.exists():
        time.sleep(0.1)
    options = ["--scheduler-file", file, "--nthreads", "1", "--no-dashboard", "--memory-limit", "0"]
    begun += [subprocess.Popen([dask, "worker", *options], **quiet) for _ in range(workers)]
    time.sleep(5.0)
    try:
        yield str(file)
    finally:
        for process in begun:
            process.terminate()
            process.wait()


def same(one: Path, other: Path) -> bool:
    """Whether two results have the same bytes."""
    names = sorted(path.relative_to(one) for path in one.rglob("*.parquet") if path.is_file())
    return bool(names) and not any(filecmp.cmpfiles(one, other, names, shallow=False)[1:])


def main() -> None:
    """Measure, and print."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--points", type=int, default=10)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--workers", type=int, default=4)
    parser.add_argument("--repeat", type=int, default=3)
    given = parser.parse_args()
    cells = given.points**6
    with tempfile.TemporaryDirectory() as folder, cluster(given.workers, Path(folder)) as file:
        place = Path(folder)
        ways = {
            "1 process": ("--jobs", "1"),
            f"{given.jobs} processes": ("--jobs", str(given.jobs)),
            f"{given.workers} processes": ("--jobs", str(given.workers)),
            f"{given.workers} Dask workers": ("--executor", "dask", "--scheduler", file),
        }
        run(place / "warm", 3)
        best: dict[str, tuple[float, int]] = {}
        for turn in range(given.repeat):
            for way, options in ways.items():
                seconds, peak = run(place / way.replace(" ", "-"), given.points, *options)
                before = best.get(way, (seconds, peak))
                best[way] = min(before[0], seconds), max(before[1], peak)
                print(f"# turn {turn + 1}: {way}: {seconds:.1f} s", file=sys.stderr)
        first = place / "1-process"
        print(f"{cells} cells x 4 phases, best of {given.repeat}")
        print(f"{'':18}  {'seconds':>8}  {'cells/s':>8}  {'ratio':>6}  {'peak MiB':>8}  bytes")
        base = next(iter(best.values()))[0]
        for way, (seconds, peak) in best.items():
            equal = "the same" if same(first, place / way.replace(" ", "-")) else "OTHERS"
            print(
                f"{way:18}  {seconds:8.1f}  {cells / seconds:8.0f}  {base / seconds:6.2f}  {peak / 2**20:8.0f}  {equal}"
            )


if __name__ == "__main__":
    main()


# Results, 2026-11-21, 2-core AMD EPYC virtual machine, quiet, Python 3.11 (numba 0.68, distributed 2026.8)
#
# 1000000 cells x 4 phases, best of 1
#                      seconds   cells/s   ratio  peak MiB  bytes
# 1 process               53.4     18733    1.00       262  the same
# 2 processes             31.1     32112    1.71       315  the same
# 4 processes             32.4     30896    1.65       424  the same
# 4 Dask workers          35.7     27975    1.49       211  the same        (memory of the client alone)
#
# The process that writes takes 3 s of a core for a million cells, a third of it in the kernel (pipes and files); two
# workers on two cores wait for it.
