"""A large sweep by one process, by several, and by a Dask cluster on this machine: cells per second, and memory.

Every way is the installed command on experiments/million.yaml, smaller by ``--points`` values on each of its six axes,
and is told as a ratio of its rate to that of one process, and as a share of the kernel's: of `ensemble` back to back on
prepared cells (`cells.py`), drawn from the same grid, in as many processes at once as work at cells in this way, on as
many cores as there are. The kernel is timed just before and just after, for the speed of a machine comes and goes; all
numbers are medians over turns, ratios and shares of those of each turn. Memory is the peak of what all its processes
hold together (proportional set size), of a cluster, which is there for its own runs alone, and has loaded the engine
before, the client's; it is looked at in a turn before the others, for a look takes time. The results of every way are
compared byte by byte.

    python tests/benchmarks/spread.py [--points 10] [--jobs 2] [--workers 4] [--repeat 3]
    python tests/benchmarks/spread.py --phases [--points 10] [--jobs 2] [--repeat 3]
    python tests/benchmarks/spread.py --phases --drawn 2000 [--repeat 3]

With ``--phases`` instead: every clock phase beside 64 sampled ones, in turns, and the ratio of the rates of each turn.
With ``--drawn``: so many random cells of the grid, from axis values to tables in this process, by processor time, which
a busy machine disturbs less; by sample rate, too.

It ends with the results of the day it was last run.
"""

import argparse
import filecmp
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext, suppress
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from cells import PHASES, kernel, prepared

from hknob_cli.engine.jit import compiled
from hknob_cli.specs.cells import cells_of
from hknob_cli.specs.load import load
from hknob_cli.spread.forks import usable_cores
from hknob_cli.stages.sweep.plain_chunk import chunk_group, plain_chunk

ROOT = Path(__file__).parents[2]
HKNOB = Path(sys.executable).with_name("hknob")
AXES = ("sample_rate_hz", "counts_per_rev", "wall.stiffness", "hand.damping", "hand.stiffness", "bias.torque")
SETTINGS = {  # of docs/howto/large_sweeps.md: without them a worker that waits takes a twentieth of a core
    "DASK_DISTRIBUTED__ADMIN__TICK__INTERVAL": "1s",
    "DASK_DISTRIBUTED__ADMIN__SYSTEM_MONITOR__INTERVAL": "5s",
    "DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED": "false",
}
LOOK = 2.0  # s between two looks at the memory
DRAWN = 100_000  # cells that the kernel is timed on, before and after: some seconds
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


def run(out: Path, points: int, *options: str, looked_at: bool = False) -> tuple[float, int]:
    """Seconds and, if it is ``looked_at``, peak bytes of one sweep."""
    sets = [part for text in smaller(points) for part in ("--set", text)] if points != 10 else []
    begin = time.perf_counter()
    process = subprocess.Popen(
        [HKNOB, "sweep", ROOT / "experiments" / "million.yaml", "-o", out, "--force", "-q", *sets, *options],
        stdout=subprocess.DEVNULL,
    )
    peak = 0
    while looked_at and process.poll() is None:
        peak = max(peak, held(process.pid))
        with suppress(subprocess.TimeoutExpired):
            process.wait(LOOK)
    if process.wait():
        sys.exit(f"hknob ended with {process.returncode}")
    return time.perf_counter() - begin, peak


@contextmanager
def cluster(workers: int, place: Path) -> Iterator[str]:
    """The file of a scheduler with so many workers of one thread."""
    dask, file = Path(sys.executable).with_name("dask"), place / "scheduler.json"
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "cwd": place, "env": os.environ | SETTINGS}
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
        file.unlink(missing_ok=True)


def kernel_seconds(points: int, processes: int) -> float:
    """Seconds that the kernel takes for the cells in so many processes at once."""
    ready, room = prepared_kernel(points)
    begin = time.perf_counter()
    children = []
    for i in range(processes):
        child = os.fork()
        if not child:
            kernel(np.ascontiguousarray(ready[i::processes]), room, PHASES)
            os._exit(0)
        children.append(child)
    for child in children:
        os.waitpid(child, 0)
    return (time.perf_counter() - begin) * points**6 / len(ready)


@cache
def prepared_kernel(points: int) -> tuple[Any, Any]:
    """What the kernel takes for cells drawn from the grid, and its work space; it is compiled."""
    plan = load(ROOT / "experiments" / "million.yaml", [text for text in smaller(points) if points != 10])
    drawn = np.random.default_rng(0).integers(0, points**6, DRAWN)
    ready = np.concatenate([prepared(plan, int(number), int(number) + 1) for number in drawn])
    room = tuple(np.zeros(n) for n in (PHASES, PHASES, 0, 0, 10 * PHASES, 1))
    kernel(ready[:1], room, PHASES)
    return ready, room


def smaller(points: int) -> list[str]:
    """Overrides that leave so many values on each axis."""
    return [f"grid.{name}={{log: [{a}, {b}, {points}]}}" for name, (a, b) in zip(AXES, ENDS, strict=True)]


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
    parser.add_argument("--phases", action="store_true", help="every clock phase beside 64 of them")
    parser.add_argument("--drawn", type=int, help="random cells, in this process, with --phases")
    given = parser.parse_args()
    if given.phases and given.drawn:
        compare_drawn(given.drawn, given.repeat)
        return
    if given.phases:
        compare_phases(given.points, given.jobs, given.repeat)
        return
    cells = given.points**6
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        ways = {
            "1 process": (1, ["--jobs", "1"]),
            f"{given.jobs} processes": (given.jobs, ["--jobs", str(given.jobs)]),
            f"{given.workers} processes": (given.workers, ["--jobs", str(given.workers)]),
            f"{given.workers} Dask workers": (given.workers, ["--executor", "dask", "--scheduler"]),
        }
        peaks = {way: turn(place, given.points, *ways[way], way=way, looked_at=True)[2] for way in ways}
        turns: dict[str, list[tuple[float, float]]] = {way: [] for way in ways}
        for number in range(given.repeat):
            for way, (count, options) in ways.items():
                seconds, fastest, _ = turn(place, given.points, count, options, way=way)
                print(f"# turn {number + 1}: {way}: {seconds:.1f} s, kernel {fastest:.1f} s", file=sys.stderr)
                turns[way].append((seconds, fastest))
        first, *_ = ways
        print(f"{cells} cells x 4 phases, medians of {given.repeat} turns")
        head = ("seconds", "cells/s", "ratio", "kernel", "share", "peak MiB")
        print(f"{'':18}" + "".join(f"  {name:>8}" for name in head) + "  bytes")
        for way, timed in turns.items():
            seconds, fastest = np.median(timed, axis=0)
            ratio = np.median([one / its for (one, _), (its, _) in zip(turns[first], timed, strict=True)])
            share = np.median([its_kernel / its for its, its_kernel in timed])
            equal = "the same" if same(place / folder_of(first), place / folder_of(way)) else "OTHERS"
            print(
                f"{way:18}  {seconds:8.1f}  {cells / seconds:8.0f}  {ratio:8.2f}  {fastest:8.1f}  "
                f"{share:8.3f}  {peaks[way] / 2**20:8.0f}  {equal}"
            )


def compare_phases(points: int, jobs: int, repeat: int) -> None:
    """Rates of sweeps with every clock phase, and with 64 of them."""
    ways = {name: ["--jobs", str(jobs), "--set", f"starts.phases={name}"] for name in ("64", "null")}
    with tempfile.TemporaryDirectory() as folder:
        for options in ways.values():
            run(Path(folder) / "warm", 4, *options)
        timed = np.array(
            [[run(Path(folder) / name, points, *options)[0] for name, options in ways.items()] for _ in range(repeat)]
        )
    rates = points**6 / timed
    print(f"{points**6} cells, {jobs} processes, {repeat} turns; cells/s of 64 phases, of every phase, ratio")
    for sampled, every in rates:
        print(f"{sampled:8.0f}  {every:8.0f}  {every / sampled:8.2f}")
    print(f"{np.median(rates[:, 0]):8.0f}  {np.median(rates[:, 1]):8.0f}  {np.median(rates[:, 1] / rates[:, 0]):8.2f}")


def compare_drawn(count: int, repeat: int) -> None:
    """Processor time of random cells with every clock phase, and with 64 of them."""
    plans = [load(ROOT / "experiments" / "million.yaml", [f"starts.phases={phases}"]) for phases in ("64", "null")]
    functions = [compiled(chunk_group(plan)) for plan in plans]
    cells = cells_of(plans[0])
    drawn = [
        cells.columns(int(k), int(k) + 1) for k in np.sort(np.random.default_rng(0).integers(0, len(cells), count))
    ]
    columns = {name: np.concatenate([one[name] for one in drawn]) for name in drawn[0]}
    rates, at, sizes = np.unique(columns[AXES[0]], return_inverse=True, return_counts=True)
    groups = [{name: values[at == k] for name, values in columns.items()} for k in range(len(rates))]
    timed = np.zeros((repeat + 1, 2, len(rates)))  # the first turn loads what is compiled, and is left out
    for turn_number in range(repeat + 1):
        for k, group in enumerate(groups):
            for way in range(2):
                begin = time.process_time()
                plain_chunk(plans[way], group, functions[way])
                timed[turn_number, way, k] = time.process_time() - begin
    microseconds = np.median(timed[1:], axis=0) / sizes * 1e6
    print(f"{count} random cells, one process, {repeat} turns; Hz, us a cell of 64 phases, of every phase, ratio")
    for rate, (sampled, every) in zip(rates, microseconds.T, strict=True):
        print(f"{rate:8.0f}  {sampled:8.1f}  {every:8.1f}  {sampled / every:8.2f}")
    whole = timed[1:].sum(axis=2)
    (sampled, every), ratios = np.median(whole, axis=0) / count * 1e6, whole[:, 0] / whole[:, 1]
    least, middle, most = ratios.min(), np.median(ratios), ratios.max()
    print(f"{'all':>8}  {sampled:8.1f}  {every:8.1f}  {middle:8.2f}, from {least:.3f} to {most:.3f}")


def folder_of(way: str) -> str:
    """Where the results of a way are."""
    return way.replace(" ", "-")


def turn(
    place: Path, points: int, count: int, options: list[str], *, way: str, looked_at: bool = False
) -> tuple[float, float, int]:
    """Seconds of one sweep in one way, of the kernel for its cells, and peak bytes if it is ``looked_at``."""
    processes = min(count, usable_cores())
    with cluster(count, place) if "Dask" in way else nullcontext("") as file:
        more = [file] if file else []
        run(place / "warm", 4, *options, *more)
        before = 0.0 if looked_at else kernel_seconds(points, processes)
        seconds, peak = run(place / folder_of(way), points, *options, *more, looked_at=looked_at)
        after = 0.0 if looked_at else kernel_seconds(points, processes)
    return seconds, 0.5 * (before + after), peak


if __name__ == "__main__":
    main()


# Results, 2026-11-22, 2-core AMD EPYC virtual machine, quiet, Python 3.11 (numba 0.68, distributed 2026.8)
#
# 1000000 cells x 4 phases, medians of 3 turns
#                      seconds   cells/s     ratio    kernel     share  peak MiB  bytes
# 1 process               48.8     20507      1.00      44.6     0.919       377  the same
# 2 processes             25.9     38567      1.88      23.0     0.899       515  the same
# 4 processes             26.1     38270      1.87      22.2     0.844       760  the same
# 4 Dask workers          27.9     35800      1.76      21.6     0.792       215  the same
#
# Each turn, the sweep and then its kernel in as many processes, at most two (seconds):
# 1 process: 48.8 and 42.8, 48.6 and 44.6, 49.2 and 46.5
# 2 processes: 25.9 and 21.8, 25.6 and 23.0, 26.2 and 23.6: shares 0.84, 0.90, 0.90
# 4 processes: 26.1 and 22.1, 26.0 and 22.2, 29.4 and 22.3
# 4 Dask workers: 27.2 and 21.6, 27.9 and 21.6, 28.0 and 22.6
# All nine times of the kernel on both cores have the median 22.2, the sweeps by two processes 25.9: 0.86.
# A cluster without `SETTINGS`, an earlier version: 34.0, 34.6 s; --jobs 4 next to it 28.9, 29.0.
#
# Results of --phases --drawn 2000 --repeat 5, 2026-11-22, the same machine, busy with other work (load 10 to 14)
#
# 2000 random cells, one process, 5 turns; Hz, us a cell of 64 phases, of every phase, ratio
#      200     117.6     107.5      1.09
#      309     212.1     244.6      0.87
#      477     341.9     246.4      1.39
#      737     185.2     323.0      0.57
#     1138     313.4     544.3      0.58
#     1758     318.5     341.3      0.93
#     2714     335.1     381.8      0.88
#     4192     645.9     663.5      0.97
#     6475    1095.7     679.8      1.61
#    10000    2216.0    1507.0      1.47
#      all     597.2     527.0      1.13, from 1.118 to 1.179
# Of 2000 others: 1.19, from 1.179 to 1.194 in three turns; before edges were solved once, 0.97.
