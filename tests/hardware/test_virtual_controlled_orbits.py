"""Virtual trials under a controller against the sweep: each settles on a proven orbit of its cell, sample by sample."""

from functools import cache
from math import tau

import numpy as np
import pytest

from hknob_cli.controllers.scalar_law import make_law
from hknob_cli.engine.attractors import Attractor
from hknob_cli.engine.outcome import Outcome
from hknob_cli.hardware.control import control_of
from hknob_cli.hardware.wire.codes import ALL_LAWS
from hknob_cli.specs.controller import Controller
from hknob_cli.specs.load import load
from hknob_cli.specs.plan import scene_at
from hknob_cli.stages.sweep.run import SweepStage
from tests.conftest import EXPERIMENTS
from tests.engine.general.law_runs import states_with_law
from tests.hardware.controllers import MODEL
from tests.hardware.trials import ALIGNED, HAND, settings, virtual_trial

KNOWING = ALIGNED._replace(knows_control=True, knows_parts=True, laws=ALL_LAWS)
QUANTUM = tau / ALIGNED.native_counts
CONTROLLERS = {
    "{kind: bounded_lag, keep: 0.15, time_constant: 0.2}": Controller("bounded_lag", keep=0.15, time_constant=0.2),
    "{kind: first_order_hold}": Controller("first_order_hold"),
    "{kind: velocity_damping, damping: 2.0e-5}": Controller("velocity_damping", damping=2.0e-5),
    "{kind: half_sample}": Controller("half_sample"),
    "{kind: matched_wall}": Controller("matched_wall"),
    "{kind: impulse_damping}": Controller("impulse_damping"),
}


@cache
def stage(text: str) -> SweepStage:
    changes = ["scene.bias={torque: 0.001}", f"scene.controller={text}", "starts.phases=64"]
    return SweepStage(load(EXPERIMENTS / "chapter8.yaml", changes), jobs=1)


def samples_of(orbit: Attractor, text: str, rate: int, counts: int) -> np.ndarray:
    """Angles of one period at its samples, in whole native counts."""
    cell = {"sample_rate_hz": float(rate), "counts_per_rev": counts}
    found = make_law(scene_at(stage(text).plan.scene, cell), sample_rate_hz=rate, counts_per_rev=counts)
    states = states_with_law(found.knob, found.law, [orbit.x, orbit.v], list(orbit.line), orbit.period)
    return np.floor([found.knob.angle_rad(x) / QUANTUM for x in states[:-1, 0]])


@pytest.mark.one_in(6)
@pytest.mark.parametrize(("rate", "counts"), [(1000, 256), (2000, 512), (4000, 1024), (1000, 1024)])
@pytest.mark.parametrize("text", CONTROLLERS)
def test_a_trial_settles_on_a_proven_orbit(text: str, rate: int, counts: int) -> None:
    """In native counts, except a few samples so close to one of its edges that rounding puts them on the other side."""
    result = stage(text).run_cell({"sample_rate_hz": float(rate), "counts_per_rev": counts})
    told = settings(rate, counts, torque_limit_nm=1.0)
    told = told._replace(control=control_of(CONTROLLERS[text], told, MODEL))
    got = virtual_trial(told, HAND, duration_s=6.0, identity=KNOWING).angle_counts
    found = []
    for orbit in result.attractors:
        assert orbit.certified
        assert orbit.outcome is Outcome.CYCLE
        exact = samples_of(orbit, text, rate, counts)
        off = [np.abs(np.roll(exact, shift) - got[-orbit.period :]) for shift in range(orbit.period)]
        found.append(any(one.max() <= 1.0 and one.mean() <= 0.02 for one in off))
    assert found.count(True) == 1
