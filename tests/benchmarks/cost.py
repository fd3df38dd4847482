"""How the processor time of a task grows with its size: curves, and the exponent of each.

    python tests/benchmarks/cost.py [CURVE...] [--rounds N]

One process, compiled code warm (each curve runs its smallest size once before it is timed). The time of a size is the
least of the rounds. "exponent" is the slope of log time over log size by least squares; that of the last two sizes
stands beside it, for a fixed cost hides the slope at small sizes. A task that only does more of the same has 1.
"""

import argparse
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hknob_cli.page.claims.ledger import load_ledger
from hknob_cli.page.claims.verdict import judge
from hknob_cli.results.result_set import ResultSet
from hknob_cli.specs.load import load
from hknob_cli.stages.design.work import DesignStage
from hknob_cli.stages.dfa.run import DfaStage
from hknob_cli.stages.remedies.run import RemediesStage
from hknob_cli.stages.sweep.run import SweepStage

EXPERIMENTS = Path(__file__).parents[2] / "experiments"
PLAIN = EXPERIMENTS / "hand_on_knob.yaml"
EVERY = EXPERIMENTS / "every_start.yaml"
FRICTION = "scene.knob.coulomb_torque=0.56 mN*m"
CLAIMS = EXPERIMENTS.parent / "data" / "claims.yaml"
PAPER = EXPERIMENTS.parent / "results" / "dissertation"
FINGER, PAD = "{inertia: 3e-7, damping: 5e-3, stiffness: 0.5}", "{damping: 3e-4, stiffness: 0.1}"
ONE_CELL = ("grid.sample_rate_hz=1000", "grid.counts_per_rev=1024")


class Curve(NamedTuple):
    """A task whose size is varied: ``run(size)`` does it."""

    what: str
    sizes: tuple[int, ...]
    run: Callable[[int], object]


def sweep(*overrides: str, spec: Path = PLAIN) -> object:
    plan = load(spec, overrides, kind="sweep")
    return SweepStage(plan, jobs=1).run()  # type: ignore[arg-type]


def dfa(*overrides: str) -> object:
    return DfaStage(load(EXPERIMENTS / "dfa_hand_on_knob.yaml", overrides, kind="dfa")).run()  # type: ignore[arg-type]


def design(people: int, designs: int) -> object:
    rates = ", ".join(f"{{value: {500 * (i + 1)}, cost: {i}}}" for i in range(designs // 2))
    overrides = (
        f"people.people={people}",
        f"choices={{sample_rate_hz: [{rates}], counts_per_rev: [{{value: 360, cost: 0}}, {{value: 2650, cost: 4}}]}}",
        "remedies={plain wall: {}}",
        "exhaustive=true",
    )
    return DesignStage(load(EXPERIMENTS / "idrive.yaml", overrides, kind="design"), jobs=1).run()  # type: ignore[arg-type]


def remedies(cells: int) -> object:
    overrides = (f"base.grid.sample_rate_hz={{log: [500, 2000, {cells}]}}", "base.grid.counts_per_rev=512")
    return RemediesStage(load(EXPERIMENTS / "remedies.yaml", overrides, kind="remedies"), jobs=1).run()  # type: ignore[arg-type]


def trial(*overrides: str) -> object:
    return sweep(*ONE_CELL, "starts={angle: 0.02, phases: 16}", *overrides)


def ordered(order: int) -> object:
    """16 trials of 100,000 samples beside clock jitter, of a knob with so many numbers as state."""
    lag, finger = "scene.actuator.time_constant=2e-4", f"scene.hand={{finger: {FINGER}, fingerpad: {PAD}}}"
    more = {2: (), 3: (lag,), 4: (finger,), 5: (finger, lag)}[order]
    return trial("scene.clock.jitter=0.2", "limits.max_samples=100000", *more)


def claims(count: int) -> object:
    """What `hknob report` judges, of the results that `make paper` has left."""
    ledger = load_ledger(CLAIMS)
    evidence = ResultSet({folder.name: folder for folder in PAPER.iterdir() if folder.is_dir()})
    return judge(ledger.model_copy(update={"claims": ledger.claims[:: len(ledger.claims) // count]}), evidence)


def rates(count: int) -> str:
    return f"grid.sample_rate_hz={{log: [100, 10000, {count}]}}"


CURVES: dict[str, Curve] = {
    "cells": Curve("cells, 64 phases", (28, 112, 448, 1792), lambda n: sweep(rates(n))),
    "cells with friction": Curve(
        "cells, 64 phases, 0.56 mN m of friction", (14, 28, 56, 112), lambda n: sweep(rates(n), FRICTION)
    ),
    "phases": Curve("phases a cell, 49 cells", (64, 256, 1024, 4096), lambda n: sweep(f"starts.phases={n}")),
    "phases with friction": Curve(
        "phases a cell, 49 cells, 0.56 mN m of friction",
        (64, 256, 1024),
        lambda n: sweep(f"starts.phases={n}", FRICTION),
    ),
    "resolution": Curve(
        "counts a turn, every start in a box, 1 kHz",
        (512, 1024, 2048, 4096, 8192),
        lambda n: sweep("grid.sample_rate_hz=1000", f"grid.counts_per_rev={n}", spec=EVERY),
    ),
    "rate": Curve(
        "samples a second, every start in a box, 1024 counts",
        (500, 1000, 2000, 4000, 8000),
        lambda n: sweep(f"grid.sample_rate_hz={n}", "grid.counts_per_rev=1024", spec=EVERY),
    ),
    "delay": Curve(
        "samples of delay, a cell, every phase of a start",
        (1, 2, 4, 8, 16),
        lambda n: sweep(*ONE_CELL, f"scene.actuator.delay_samples={n}", "starts={angle: 0.02}"),
    ),
    "samples": Curve(
        "samples of each of 16 trials that do not repeat",
        (320_000, 1_280_000, 5_120_000),
        lambda n: trial("scene.clock.jitter=0.2", f"limits.max_samples={n}"),
    ),
    "periods": Curve(
        "samples of a period: 16 trials at 40 to 2560 kHz",
        (400, 1600, 6400, 25_600),
        lambda n: trial(f"grid.sample_rate_hz={100 * n}"),
    ),
    "order": Curve("order of the plant, 16 trials of 100,000 samples", (2, 3, 4, 5), ordered),
    "claims": Curve("claims of the dissertation, judged", (20, 40, 80, 160), claims),
    "people": Curve(
        "people, 2 cells, 64 phases",
        (100, 200, 400, 800),
        lambda n: sweep(f"population.people={n}", spec=EXPERIMENTS / "population_table1.yaml"),
    ),
    "harmonics": Curve(
        "odd harmonics of a describing function, 49 cells", (3, 7, 15, 31), lambda n: dfa(f"methods=[df{n}]")
    ),
    "designs": Curve("designs, exhaustive, 20 people", (8, 16, 32, 64), lambda n: design(20, n)),
    "designs' people": Curve("people of a design, 8 designs", (20, 40, 80, 160), lambda n: design(n, 8)),
    "remedies' cells": Curve("cells of a trial of remedies", (2, 4, 8), remedies),
}


def timed(curve: Curve, rounds: int) -> list[float]:
    """Least processor time of each size in seconds."""
    curve.run(curve.sizes[0])
    best = [float("inf")] * len(curve.sizes)
    for _ in range(rounds):
        for place, size in enumerate(curve.sizes):
            begin = time.process_time()
            curve.run(size)
            best[place] = min(best[place], time.process_time() - begin)
    return best


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("curves", nargs="*", metavar="CURVE", help=f"one of: {', '.join(CURVES)}")
    parser.add_argument("--rounds", type=int, default=3)
    given = parser.parse_args()
    print("| task | sizes | seconds | exponent | of the last two |\n|---|---|---|---|---|")
    for name in given.curves or CURVES:
        curve = CURVES[name]
        seconds = timed(curve, given.rounds)
        sizes = np.log(curve.sizes)
        slope = np.polyfit(sizes, np.log(seconds), 1)[0]
        last = np.diff(np.log(seconds))[-1] / np.diff(sizes)[-1]
        shown = ", ".join(f"{one:.3g}" for one in seconds)
        print(f"| {curve.what} | {', '.join(map(str, curve.sizes))} | {shown} | {slope:.2f} | {last:.2f} |", flush=True)


if __name__ == "__main__":
    main()
