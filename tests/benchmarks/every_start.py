"""How fast sets of starts are followed, beside a plain scalar C loop, and cells by all phases beside cells by 64.

    python tests/benchmarks/every_start.py [--rounds N]

A  The 7 x 7 grid from every state in a box of 50 mrad by 5 rad/s (`SetEngine.search_box`): proofs, merging and the
   sampling of shares included. A sample of a polygon moves its corners or its ball, and tests it against count edges
   and proven ends. scalar_loop.c moves one state, and tests nothing: a floor. The ratio is the time that C takes for as
   many samples of one trial, over that of the search: the share of the search's time that a perfect one would take.
B  Cells of experiments/million.yaml by every clock phase of a start, and by 64 sampled ones: cells a second, from start
   to tables, compiled, one thread.

Processor time, medians over the rounds, every job once per round, in turn.
"""

import argparse
import tempfile
from pathlib import Path

import numpy as np
from hand_on_knob import BIASES, COUNTS, RATES_HZ, knob_at
from record import put
from scalar_loop import ScalarLoop
from throughput import in_turn

from hknob_cli.engine.jit import compiled
from hknob_cli.engine.sets.search import Box, SetEngine
from hknob_cli.specs.load import load
from hknob_cli.specs.plan import SweepPlan
from hknob_cli.stages.sweep.run import SweepStage

MILLION = Path(__file__).parents[2] / "experiments" / "million.yaml"
SOME = (0, 250_000, 500_000, 750_000)  # cells at which a run begins
RUN = 500  # cells
ANGLE, SPEED = 0.05, 5.0  # rad, rad/s


def boxes(rounds: int) -> None:
    """Job A, a row for each sample rate."""
    engine = SetEngine(compiled("sets"))
    print("A  every state in a box; mean over the resolutions of a rate, all under a bias of 1 mN m")
    print("    Hz    pieces  1e6 samples        ms  1e6 pieces/s  1e6 samples/s  C strict/search")
    at_all = np.zeros((rounds, 2))
    with tempfile.TemporaryDirectory() as folder:
        rival = ScalarLoop(Path(folder), "strict")
        for rate in RATES_HZ:
            pieces, samples, spent = 0, 0, np.zeros((rounds, 2))
            for counts in COUNTS:
                knob = knob_at(rate, counts, BIASES[0])
                q, per_sample = knob.quantum_rad, knob.quantum_rad / knob.period_s
                box = Box(-ANGLE / q, ANGLE / q, -SPEED / per_sample, SPEED / per_sample)
                found = engine.search_box(knob.loop, box, max_samples=None)
                one = np.array([knob.position(0.02)]), np.zeros(1)
                jobs = {
                    "C": lambda one=one, n=found.samples, loop=knob.loop: rival.advance(*one, n, loop),
                    "search": lambda box=box, loop=knob.loop: engine.search_box(loop, box, max_samples=None),
                }
                seconds, _ = in_turn(jobs, rounds)
                pieces, samples = pieces + found.pieces, samples + found.samples
                spent += np.transpose([seconds["C"], seconds["search"]])
            at_all += spent
            c, ours = np.median(spent, axis=0)
            rates = f"{pieces / ours / 1e6:13.2f} {samples / ours / 1e6:14.1f} {c / ours:16.2f}"
            print(f"{rate:6.0f} {pieces / 7:9.0f} {samples / 7e6:12.2f} {1e3 * ours / 7:9.1f} {rates}")
    put("C / sets", float(np.median(at_all[:, 0] / at_all[:, 1])))
    print(f"   all {'':31} s {np.median(at_all[:, 1]):6.2f}  {np.median(at_all[:, 0] / at_all[:, 1]):28.2f}\n")


def phases(rounds: int) -> None:
    """Job B."""
    jobs = {}
    for name, starts in (("every phase", "{angle: 0.02}"), ("64 phases", "{angle: 0.02, phases: 64}")):
        plan = load(MILLION, (f"starts={starts}",), kind="sweep")
        assert isinstance(plan, SweepPlan)
        stage = SweepStage(plan, jobs=1)
        jobs[name] = lambda stage=stage: [stage.find_plain(first, first + RUN) for first in SOME]
    seconds, _ = in_turn(jobs, rounds)
    print("B  cells of a million, one thread")
    for name, each in seconds.items():
        print(f"   {name:12} {len(SOME) * RUN / np.median(each):8.0f} cells/s")
    ratio = float(np.median(np.divide(seconds["64 phases"], seconds["every phase"])))
    put("64 / all", ratio)
    print(f"   time of 64 phases over that of all: {ratio:.2f}")


def main() -> None:
    """Run it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    rounds = parser.parse_args().rounds
    boxes(rounds)
    phases(rounds)


if __name__ == "__main__":
    main()
