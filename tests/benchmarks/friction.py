"""Throughput with Coulomb friction beside that without, in one run.

    python tests/benchmarks/friction.py [--quick]

The 7 x 7 grid of experiments/hand_on_knob.yaml by `CellFinder`: starts to measures, proofs included, compiled, one
thread, processor time. Rounds are interleaved and the least time of a configuration counts. "samples" are the intervals
that trials took until their end was proven; with friction trials end sooner or later than without, so both the time per
trial-sample and the time of the whole grid are shown.

A level of 1e-5 N m is small beside the torque of one count (2.1e-4 to 1.3e-2 N m), 5.6e-4 N m is Hasser's hardware.
"""

import argparse
import time
from pathlib import Path

from record import put

from hknob_cli.engine.jit import compiled
from hknob_cli.specs.cells import cells_of
from hknob_cli.specs.load import load
from hknob_cli.specs.plan import SweepPlan
from hknob_cli.stages.sweep.cell import CellFinder

SPEC = Path(__file__).parents[2] / "experiments" / "hand_on_knob.yaml"
LEVELS = (0.0, 1e-5, 1e-4, 5.6e-4)


def plan(level: float, phases: int) -> SweepPlan:
    overrides = (f"scene.knob.coulomb_torque={level}", f"starts.phases={phases}")
    found = load(SPEC, overrides, kind="sweep")
    assert isinstance(found, SweepPlan)
    return found


def run(finder: CellFinder, what: SweepPlan) -> tuple[float, int]:
    begin = time.process_time()
    samples = sum(finder.find(what, cell).samples for cell in cells_of(what))
    return time.process_time() - begin, samples


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="one round, 64 phases")
    quick = parser.parse_args().quick
    finder = CellFinder({"plain": compiled("plain"), "general": compiled("general")})
    for level in LEVELS:
        run(finder, plan(level, 1))
    for phases in (64,) if quick else (64, 1024):
        plans = {level: plan(level, phases) for level in LEVELS}
        best: dict[float, tuple[float, int]] = {}
        for _ in range(1 if quick else 5):
            for level, what in plans.items():
                found = run(finder, what)
                best[level] = min(best.get(level, found), found)
        print(f"{phases} phases")
        free = best[0.0]
        if phases == 64:
            put("friction", best[LEVELS[-1]][0] / free[0])
        for level, (seconds, samples) in best.items():
            rate = samples / seconds
            print(
                f"  {level:8.1e} N m  {1e3 * seconds:8.1f} ms  {samples:10d} samples  {rate / 1e6:6.1f} M/s"
                f"   throughput 1/{free[1] / free[0] / rate:.1f}, time x {seconds / free[0]:.1f}"
            )


if __name__ == "__main__":
    main()


# 2026-11-23, two shared cores, busy (load 2 to 3; x86-64, AVX-512), Python 3.11, numba 0.68.1, one thread. Least and
# most of four runs at 64 phases, and of three at 1024; throughput without over with:
#
#   phases    1e-5 N m     1e-4 N m   5.6e-4 N m
#       64   4.0 to 5.3   2.8 to 4.5   3.1 to 4.1
#     1024   2.1 to 2.7   1.9 to 2.3   2.7 to 3.1
#
# In time for the whole grid: x 3.0 to 4.0, 2.1 to 3.3, 2.6 to 3.4 at 64 phases, and x 1.6 to 2.0, 1.4 to 1.7, 2.2 to
# 2.6 at 1024, because trials with friction take fewer samples. Without friction 29 to 37 and 34 to 39 million
# trial-samples a second.
