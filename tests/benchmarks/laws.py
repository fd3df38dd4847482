"""Trials under a controller: the compiled general loop against the arrays of the sets of starts, in the same run.

    python tests/benchmarks/laws.py [PHASES]

Both find what trials of the hand on the knob settle to, from 20 mrad at equally spaced phases of the sample clock, at
4 cells. Shares are those of trials whose end is proven. Neither compiling nor loading counts.
"""

import sys
from time import perf_counter
from typing import Any

from hknob_cli.controllers.controller import make_control_law
from hknob_cli.controllers.scalar_law import make_law
from hknob_cli.engine.general.laws.search import LawEngine
from hknob_cli.engine.jit import compiled
from hknob_cli.engine.outcome import Reason
from hknob_cli.specs.plan import Starts
from hknob_cli.specs.scene import SceneSpec
from tests.controllers.batches import make_batch, search
from tests.controllers.laws import CONTROLLERS

SCENE: dict[str, Any] = {
    "knob": {"inertia": 1.9e-6},
    "hand": {"inertia": 3.0e-7, "damping": 3.45e-4, "stiffness": 0.04},
    "wall": {"stiffness": 0.27},
    "bias": {"torque": 0.001},
}
CELLS = [{"sample_rate_hz": rate, "counts_per_rev": counts} for rate in (464.0, 1000.0) for counts in (512, 1024)]


def by_arrays(scene: Any, phases: int) -> tuple[float, float]:
    """Seconds, and the share of trials whose end is proven."""
    begin = perf_counter()
    proven = 0.0
    for cell in CELLS:  # of one rate at a time; a sweep puts cells of one rate side by side
        batch = make_batch(scene, [cell], Starts(angle=0.02, velocity=0.0, phases=phases))
        ends = search(make_control_law(scene.controller), batch)
        proven += sum(one.trials for one in ends if one.reason in (Reason.NONE, Reason.GREW))
    return perf_counter() - begin, proven / (phases * len(CELLS))


def by_loop(scene: Any, phases: int, functions: Any) -> tuple[float, float]:
    """Seconds, and the share of trials whose end is proven."""
    begin = perf_counter()
    proven = 0.0
    for cell in CELLS:
        made = make_law(scene, sample_rate_hz=cell["sample_rate_hz"], counts_per_rev=int(cell["counts_per_rev"]))
        engine = LawEngine(made.law, functions)
        found = engine.search(
            made.knob.body,
            made.knob.wall,
            made.knob.start(0.02, 0.0),
            rate=made.rate,
            phases=phases,
            delay_line=engine.past_length,
            max_samples=None,
        )
        proven += sum(one.trials for one in found.attractors if one.reason in (Reason.NONE, Reason.GREW))
    return perf_counter() - begin, proven / (phases * len(CELLS))


def main(phases: int) -> None:
    """Print a table."""
    functions = compiled("laws")
    print(f"{'controller':28}{'arrays, trials/s':>18}{'loop, trials/s':>16}{'ratio':>8}{'proven':>16}")
    for name, controller in CONTROLLERS.items():
        scene = SceneSpec.model_validate({**SCENE, "controller": controller}).plain()
        by_loop(scene, 1, functions)
        slow, old = by_arrays(scene, phases)
        quick, new = by_loop(scene, phases, functions)
        trials = phases * len(CELLS)
        print(
            f"{name:28}{trials / slow:18.0f}{trials / quick:16.0f}{slow / quick:8.1f}{100 * old:8.0f}%{100 * new:6.0f}%"
        )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 64)
