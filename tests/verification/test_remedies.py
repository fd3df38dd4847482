"""Controllers of the wall: what must hold of their orbits, and whether what is called proven is."""

from itertools import islice
from typing import Any

import numpy as np
import pytest

from hknob_cli.controllers.scalar_law import LawKnob, make_law
from hknob_cli.engine.attractors import Attractor
from hknob_cli.engine.general.laws.search import LawEngine
from hknob_cli.engine.jit import compiled
from hknob_cli.engine.outcome import Outcome
from hknob_cli.specs.scene import SceneSpec
from hknob_cli.stages.sweep.run import SweepStage
from tests.conftest import loaded
from tests.controllers.laws import CONTROLLERS
from tests.controllers.reference import Rig, law_of

from .test_laws_in_the_general_loop import run

GRID = """\
kind: sweep
name: grid
scene:
  knob: {{inertia: 1.9e-6}}
  hand: {{inertia: 3.0e-7, damping: {damping}, stiffness: 0.04}}
  wall: {{stiffness: 0.27}}
  bias: {bias}
  encoder: {encoder}
{controller}grid:
  sample_rate_hz: [464, 1000, 2154]
  counts_per_rev: [256, 2650]
starts: {{angle: 0.02, phases: 6}}
"""
# Controllers that, with these numbers, are the plain wall.
NOTHING = {
    "stiffening": "{kind: stiffening, surface: 1}",
    "bounded lag": "{kind: bounded_lag, keep: 1, time_constant: 0.01}",
    "damping, sensor": "{kind: velocity_damping, damping: 0, velocity: sensor}",
    "damping": "{kind: velocity_damping, damping: 0, everywhere: true}",
}
EXACT = ("period_samples", "cycles_per_period", "outcome", "certified", "basin_fraction")
CLOSE = ("p2p_rad", "min_rad", "max_rad", "rms_rad", "frequency_hz", "wall_work_j", "damping_loss_j")


def orbits(
    controller: str = "", *, bias: str = "{torque: 0.001}", encoder: str = "{}", damping: float = 3.45e-4
) -> Any:
    line = f"  controller: {controller}\n" if controller else ""
    text = GRID.format(controller=line, bias=bias, encoder=encoder, damping=damping)
    return SweepStage(loaded(text), jobs=1).run().orbits.to_pylist()


@pytest.mark.one_in(5)
@pytest.mark.parametrize("encoder", ["{}", "{rounding: nearest, offset_counts: 0.2}", "{rounding: truncate}"])
@pytest.mark.parametrize("name", NOTHING)
def test_a_controller_that_changes_nothing_gives_the_plain_walls_orbits(name: str, encoder: str) -> None:
    def key(row: dict[str, Any]) -> Any:
        return row["sample_rate_hz"], row["counts_per_rev"], row["period_samples"], round(row["p2p_rad"] * 1e9)

    ours = sorted(orbits(NOTHING[name], encoder=encoder), key=key)
    plain = sorted(orbits(encoder=encoder), key=key)
    assert len(plain) > 6
    assert len(ours) == len(plain)
    for one, other in zip(ours, plain, strict=True):
        assert {k: one[k] for k in EXACT} == {k: other[k] for k in EXACT}
        for column in CLOSE:
            # Both are exact except for rounding, of 1e-16 of the position per sample and some thousand samples.
            scale = abs(other["min_rad"]) if column.endswith("_rad") else 0.0
            assert one[column] == pytest.approx(other[column], rel=1e-9, abs=1e-12 * scale)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", CONTROLLERS)
def test_work_of_the_wall_is_the_loss_in_damping(name: str) -> None:
    """On a periodic motion; a push that is constant does no work, and neither does the hand's spring."""
    settings = ", ".join(f"{key}: {str(value).lower()}" for key, value in CONTROLLERS[name].items())
    cycles = [row for row in orbits(f"{{{settings}}}") if row["outcome"] == "cycle" and row["certified"]]
    if not name.startswith("passivity"):  # its sum of energy drifts: it seldom repeats
        assert cycles
    for row in cycles:
        assert row["wall_work_j"] > 0.0
        assert row["wall_work_j"] == pytest.approx(row["damping_loss_j"], rel=1e-9)


def draw(rng: np.random.Generator) -> tuple[dict[str, Any], float, int, str]:
    """A scene, a rate and an encoder at random, from light to heavy, slow to fast; and the name of a controller."""
    name = str(rng.choice(list(CONTROLLERS)))
    scene: dict[str, Any] = {
        "knob": {"inertia": 10 ** rng.uniform(-6.3, -5.0)},
        "hand": {"damping": 10 ** rng.uniform(-4.0, -2.5), "stiffness": 10 ** rng.uniform(-2.0, 0.0)},
        "wall": {"stiffness": 10 ** rng.uniform(-1.5, 0.3)},
        "bias": {"half_quantum": True} if rng.random() < 0.3 else {"torque": 10 ** rng.uniform(-4.0, -2.0)},
        "encoder": {
            "rounding": str(rng.choice(["floor", "nearest", "ceil", "truncate"])),
            "offset_counts": 0.0 if rng.random() < 0.5 else rng.uniform(0.0, 0.99),
        },
        "controller": CONTROLLERS[name],
    }
    if rng.random() < 0.25:
        scene["actuator"] = {"torque_limit": 10 ** rng.uniform(-3.0, -1.0)}
    return scene, 10 ** rng.uniform(2.0, 3.7), int(10 ** rng.uniform(2.0, 3.7)), name


def trial_ends(
    made: LawKnob, engine: LawEngine, velocity: float, *, angle: float = 0.02, max_samples: int | None = None
) -> tuple[Attractor, ...]:
    """The end of one trial, whose first sample comes in the middle of an interval."""
    return engine.search(
        made.knob.body,
        made.knob.wall,
        made.knob.start(angle, velocity),
        rate=made.rate,
        phases=1,
        delay_line=engine.past_length,
        max_samples=max_samples,
    ).attractors


@pytest.mark.one_in(3)
@pytest.mark.parametrize("seed", range(12))
def test_what_is_proven_is_what_the_reference_does_for_ever_after(seed: int) -> None:
    """The trial of a proven end, from its own start by the reference, comes to the orbit and stays there."""
    rng = np.random.default_rng(seed)
    compared = 0
    for _ in range(8):
        scene, rate, counts, name = draw(rng)
        plan = SceneSpec.model_validate(scene).plain()
        assert plan.controller
        made = make_law(plan, sample_rate_hz=rate, counts_per_rev=counts)
        velocity = rng.uniform(-1.0, 1.0)
        knob, engine = made.knob, LawEngine(made.law, compiled("laws"))
        for end in trial_ends(made, engine, velocity):
            if not end.certified or end.outcome not in (Outcome.CYCLE, Outcome.REST) or end.period > 400:
                continue
            compared += 1
            rig = Rig(scene, rate, counts)
            trial = rig.trial(law_of(rig, CONTROLLERS[name]), 0.02, velocity, 0.5)
            settling = float(np.max(1.0 / -np.log(np.abs(eigenvalues(scene, rate, counts)))))
            transient = int(40.0 * max(settling, 1.0 / made.rate)) + 2000  # until it is captured, and from then on
            late = np.array([state[0] for state in islice(trial, transient, transient + 2 * end.period)])
            states, _ = run(made, [end.x, end.v, *end.state], end.line, end.period)
            orbit = np.array([knob.angle_rad(x) for x in states[:-1, 0]])
            size = np.abs(orbit).max() + knob.quantum_rad
            off = min(np.abs(np.roll(np.tile(orbit, 2), shift) - late).max() for shift in range(end.period))
            # 40 time constants leave 1e-17 of the start; rounding of both sides is 1e-12, the matrices' included.
            assert off <= 1e-9 * size, (name, scene, rate, counts, end.period)
    assert compared > 0


def eigenvalues(scene: dict[str, Any], rate: float, counts: int) -> Any:
    """Those of the plant over a sample, with the damping that a negative virtual one leaves."""
    less = min(0.0, scene["controller"].get("damping", 0.0))
    rig = Rig({**scene, "knob": {**scene["knob"], "damping": less}}, rate, counts)
    return np.linalg.eigvals(np.array(rig.hold(rig.period))[:2, :2])


@pytest.mark.parametrize("name", ["stiffening", "half sample"])
def test_nothing_is_proven_without_damping(name: str) -> None:
    """An undamped knob keeps the energy of its start: no nearby motion approaches, whatever rounding says."""
    scene = {
        "knob": {"inertia": 2.2e-6},
        "hand": {"damping": 0.0, "stiffness": 0.04},
        "wall": {"stiffness": 0.27},
        "controller": CONTROLLERS[name],
    }
    made = make_law(SceneSpec.model_validate(scene).plain(), sample_rate_hz=1000.0, counts_per_rev=64)
    found = trial_ends(made, LawEngine(made.law, compiled("laws")), 0.0, angle=0.5, max_samples=4096)
    assert not any(end.certified for end in found)
