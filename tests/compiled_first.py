"""The engine is compiled before the tests, where it is not yet: each worker of a run compiles a share of it.

Without this two workers begin by compiling the same, and commands that find nothing compiled are interpreted. Sets of
starts in the general loop take the compiler longer than all else; so does that loop's variant of cogging, torque over
the angle and jitter. The quick tests of these are interpreted; only the long ones begin with compiling them.
"""

import os
from pathlib import Path

from hknob_cli.engine.jit import is_kept
from hknob_cli.scene.general_knob import simulate
from hknob_cli.specs.load import load
from hknob_cli.specs.plan import SweepPlan
from hknob_cli.stages.sweep.run import SweepStage

CELL = ("grid.sample_rate_hz=1000", "grid.counts_per_rev=512")
TRIALS, PHASES = "starts={angle: 0.02, phases: 8}", "starts={angle: 0.02}"
BOX = "starts={angle: [-50 mrad, 50 mrad], velocity: [-5, 5]}"
FRICTION, LIMIT = "scene.knob.coulomb_torque=0.56 mN*m", "scene.actuator.torque_limit=0.05"
DETENTS = "scene.detents={per_revolution: 24, torque: 2 mN*m}"
CONTROLLER = "scene.controller={kind: bounded_lag, keep: 0.15, time_constant: 0.2}"
# Of two workers: sweeps of one cell, each of which takes other groups of `engine.jit`. They take about as long.
SHARES = (
    ((TRIALS, CONTROLLER), (BOX,)),
    ((TRIALS,), (PHASES,), (TRIALS, FRICTION)),
)
FOLLOWED = (TRIALS, FRICTION)  # whose motion is followed from sample to sample, too: several files of tests do so
# What only long tests take.
MORE = (
    ((TRIALS, DETENTS), (PHASES, CONTROLLER), (PHASES, LIMIT), (BOX, LIMIT)),
    ((PHASES, FRICTION), (BOX, FRICTION), (TRIALS, DETENTS, CONTROLLER)),
)


def compile_share(spec: Path, *, long: bool) -> None:
    """Run what this worker's share has of ``spec``, a sweep, where its groups are not compiled; once on a machine.

    ``long``: whether long tests are to follow.
    """
    number = os.environ.get("PYTEST_XDIST_WORKER", "").removeprefix("gw")
    mine = int(number) if number.isdecimal() and int(number) < len(SHARES) else None
    share = () if mine is None else (*SHARES[mine], *(MORE[mine] if long else ()))
    plans = [(one, load(spec, (*CELL, *one), kind="sweep")) for one in share]
    stages = [(one, SweepStage(plan, jobs=1)) for one, plan in plans if isinstance(plan, SweepPlan)]
    # All are looked at first: a group is kept as soon as one of its functions is, and with it one of its two variants.
    for one, stage in [(one, stage) for one, stage in stages if not all(map(is_kept, stage.expected))]:
        for group in stage.expected:
            stage.engines.compile(group)
        stage.run()
        if stage.plain:  # many cells at once are found by other entries
            stage.find_plain(0, 1)
        if one == FOLLOWED:
            simulate(stage.plan.scene, sample_rate_hz=1e3, counts_per_rev=512, angle_rad=0.02, samples=1, compiled=True)
