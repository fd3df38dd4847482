"""A sweep of very many cheap cells beside the kernel that does its work, on one core.

    python tests/benchmarks/cells.py [--cells N] [--rounds N]

The grid: a hand on a knob at ten sample rates, ten resolutions, ten dampings, ten stiffnesses, and as many bias torques
as make up the cells; four phases a cell. Three jobs take turns on the cells of each sample rate, so that a drift of the
machine meets all of them. "kernel": `ensemble` back to back from one compiled loop, with everything that it is given
made ready before: nothing is reduced, measured, ranked or kept. "chunk": `stages.sweep.plain_chunk` from axis values to
the two tables, all but the writing of Parquet. "one by one": `stages.sweep.cell` and `stages.sweep.tables`, on a
twentieth of the cells. Compiling and loading are left out. Times are processor time, us a cell; the share is the
kernel's time over the
chunk's, as median and, in brackets, range over the rounds: 1 were a sweep at the speed of its kernel.
"""

import argparse
import time
from collections.abc import Callable
from typing import Any

import numba
import numpy as np
from hand_on_knob import Array
from record import put

from hknob_cli.engine import attractors
from hknob_cli.engine.budget import TrialBudget, prospect
from hknob_cli.engine.ensemble import ROW, TrialRoom, first_sample
from hknob_cli.engine.jit import compiled
from hknob_cli.engine.loop import Loop
from hknob_cli.scene.plain_knob import sample_knob
from hknob_cli.specs.cells import Cells, cells_of
from hknob_cli.specs.load import validate
from hknob_cli.specs.plan import COUNTS, RATE, SweepPlan, scene_at
from hknob_cli.specs.source import parse
from hknob_cli.stages.sweep.cell import CellFinder
from hknob_cli.stages.sweep.plain_chunk import GROUP, plain_chunk, takes_plain
from hknob_cli.stages.sweep.tables import cells_table, orbits_table

SPEC = """\
kind: sweep
name: many-cells
scene:
  knob: {{inertia: 1.9e-6}}
  hand: {{inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}}
  wall: {{stiffness: 0.27}}
  bias: {{torque: 0.001}}
grid:
  sample_rate_hz: {{log: [200, 10000, 10]}}
  counts_per_rev: {{log: [128, 8192, 10]}}
  hand.stiffness: {{log: [0.02, 0.2, 10]}}
  hand.damping: {{log: [1.0e-4, 1.0e-3, 10]}}
  bias.torque: {{lin: [0.0005, 0.005, {torques}]}}
starts: {{angle: 0.02, phases: 4}}
"""
PHASES = 4
CHUNK = 10_000  # cells
ONE_IN = 20  # cells that are also run one by one

functions = compiled(GROUP)
ensemble = functions["ensemble"]


@numba.njit(nogil=True)
def kernel(cells: Array, room: Any) -> int:
    """Run the kernel on prepared cells: a loop, the state at the first sample, and what bounds the search, in a row."""
    samples = 0
    for i in range(len(cells)):
        c = cells[i]
        loop = Loop(c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7], c[8], c[9], c[10], c[11], c[12])
        budget = TrialBudget(int(c[15]), int(c[16]), True, c[17])
        found = ensemble((c[13], c[14]), PHASES, 0, PHASES, budget, 0, room, loop)
        samples += found[2]
    return samples


def prepared(plan: SweepPlan, start: int, stop: int) -> Array:
    """Rows that `kernel` takes."""
    rows = []
    for cell in cells_of(plan).run(start, stop):
        knob = sample_knob(scene_at(plan.scene, cell), sample_rate_hz=cell[RATE], counts_per_rev=int(cell[COUNTS]))
        x, v = knob.position(plan.starts.angle), knob.speed(plan.starts.velocity)
        _, budget, skip, limit = prospect(x, v, 0, knob.loop)
        rows.append([*knob.loop, *first_sample(x, v, PHASES, knob.loop), skip, budget, limit])
    return np.array(rows)


def seconds(job: Callable[[], Any]) -> tuple[float, Any]:
    """Processor time of a job, and its result."""
    begin = time.process_time()
    result = job()
    return time.process_time() - begin, result


def run_rate(plan: SweepPlan, cells: Cells, start: int, stop: int) -> Array:
    """Seconds a cell of the three jobs over the cells of one rate, and trial-samples a cell."""
    room = TrialRoom(*(np.zeros(n) for n in (PHASES, PHASES, 0, 0, ROW * PHASES, 1)))
    finder = CellFinder({"plain": functions})
    total = np.zeros(4)
    for first in range(start, stop, CHUNK):
        last = min(first + CHUNK, stop)
        ready, some = prepared(plan, first, last), list(cells.run(first, last))[::ONE_IN]

        def one_by_one(some: Any = some) -> None:
            results = [finder.find(plan, cell) for cell in some]
            cells_table(plan, results)
            orbits_table(plan, results)

        kernel_s, samples = seconds(lambda ready=ready: kernel(ready, room))
        chunk_s, chunk = seconds(
            lambda first=first, last=last: plain_chunk(plan, cells.columns(first, last), functions)
        )
        assert chunk.samples == samples, "the kernel and the chunk ran different trials"
        total += kernel_s, chunk_s, seconds(one_by_one)[0] * (last - first) / len(some), samples
    return total / (stop - start)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description="A sweep of many cheap cells beside its kernel.")
    parser.add_argument("--cells", type=int, default=20_000, help="cells, in ten thousands, at least two")
    parser.add_argument("--rounds", type=int, default=5, help="rounds")
    args = parser.parse_args()
    plan = validate(parse(SPEC.format(torques=max(2, args.cells // 10_000)), "cells.yaml"))
    assert takes_plain(plan)
    assert plan.starts.phases <= attractors.CAPACITY
    cells = cells_of(plan)
    each = len(cells) // len(plan.axes[RATE])
    run_rate(plan, cells, 0, 500)
    print(f"{len(cells)} cells of {PHASES} phases, {args.rounds} rounds; us a cell")
    print(f"{'Hz':>6} {'samples':>8} {'kernel':>8} {'chunk':>8} {'beside':>8} {'one by one':>11}  {'share':18}")
    rounds = np.array(
        [
            [run_rate(plan, cells, i * each, (i + 1) * each) for i in range(len(plan.axes[RATE]))]
            for _ in range(args.rounds)
        ]
    )
    for label, of in [
        *((f"{rate:.0f}", rounds[:, i]) for i, rate in enumerate(plan.axes[RATE])),
        ("all", rounds.mean(1)),
    ]:
        ours, chunk, single, samples = np.median(of, axis=0) * [1e6, 1e6, 1e6, 1.0]
        share = of[:, 0] / of[:, 1]
        beside = np.median(of[:, 1] - of[:, 0]) * 1e6
        print(f"{label:>6} {samples:8.0f} {ours:8.2f} {chunk:8.2f} {beside:8.2f} {single:11.1f}", end="")
        print(f"  {np.median(share):.3f} [{share.min():.3f}-{share.max():.3f}]")
    whole = rounds.mean(1)
    put("kernel / sweep", float(np.median(whole[:, 0] / whole[:, 1])))
    rates = whole[:, 3] / whole[:, 0] / 1e6, whole[:, 3] / whole[:, 1] / 1e6
    print(f"1e6 trial-samples/s: kernel {np.median(rates[0]):.1f}, chunk {np.median(rates[1]):.1f}")


if __name__ == "__main__":
    main()


# Results, 2026-11-21, 2-core AMD EPYC (Zen 4) virtual machine, busy with other work, Python 3.11 (numba 0.68)
#
# 1000000 cells of 4 phases, 3 rounds; us a cell
#     Hz  samples   kernel    chunk   beside  one by one  share
#    200     2046    28.18    33.31     5.13        96.2  0.846 [0.839-0.850]
#    309     2279    28.90    32.47     3.76       102.8  0.884 [0.872-0.896]
#    477     1576    20.83    24.13     3.51        91.2  0.854 [0.847-0.863]
#    737     1110    15.23    18.98     3.66        83.2  0.806 [0.798-0.807]
#   1138     1514    18.43    22.02     3.64        89.3  0.835 [0.828-0.840]
#   1758     1921    19.58    23.14     3.54        93.2  0.846 [0.842-0.867]
#   2714     2902    29.54    34.07     4.45        99.8  0.868 [0.867-0.873]
#   4192     4701    51.80    58.64     6.93       131.0  0.882 [0.878-0.886]
#   6475     7744    93.78   104.68    10.90       180.9  0.896 [0.877-0.897]
#  10000    12923   170.17   188.09    17.26       272.0  0.907 [0.900-0.917]
#    all     3872    47.84    54.21     6.31       125.0  0.884 [0.879-0.884]
# 1e6 trial-samples/s: kernel 80.9, chunk 71.4
#
# What is beside the kernel, us a cell. Measures: at 737 Hz 1.2 for the integrals over a hold (once for cells in a row
# that have one plant, as nearly all have here: so little of it is above), 1.3 for 9 turning points, 0.3 to trace, 0.5
# for moments, work and leak; at 10 kHz, where the orbits of a cell have 670 samples, 4.9 to trace, 3.8 for 26 turning
# points, 4.7 for the others. Tables 0.5 and the reduction 0.04 in chunks of 10,000 cells; 1.0 and 0.1 in those of 2000.
