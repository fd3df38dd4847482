"""Motors and eddy brakes against the 60-digit model, which has the current of a winding where the package has a spring.

Random scenes sample by sample, and proven orbits with their measures; energy; and limits that are known otherwise.
The package drives a winding by a lag beside a shorted winding, the model by the one equation of the current.
"""

from random import Random
from typing import Any

import pytest

from hknob_cli.engine.attractors import Patience
from hknob_cli.engine.general.search import GeneralEngine
from hknob_cli.engine.outcome import Outcome
from hknob_cli.measure.general_orbit import GeneralMeasurer
from hknob_cli.scene.general_knob import sample_general, simulate
from hknob_cli.specs.drive import reduced
from hknob_cli.specs.scene import SceneSpec
from tests import digits as mp

from . import general_reference as reference
from .general_orbits import measure, solve
from .general_scenes import RINGING, TWO_PARTS, Case, scene
from .test_general_trajectory import AWAY, bounds

RE25 = {"torque_constant": 0.0234, "resistance": 2.32, "inductance": 2.38e-4}


def random_motor(chance: Random) -> dict[str, Any]:
    """A motor of any winding, its constants within a factor of five or so of a real one."""
    made: dict[str, Any] = {
        "torque_constant": chance.uniform(0.005, 0.03),
        "resistance": chance.uniform(1.0, 10.0),
        "winding": chance.choice(["shorted", "shorted", "voltage", "current"]),
    }
    if made["winding"] != "current" and chance.random() < 0.8:
        made["inductance"] = chance.choice([1e-5, 2.4e-4, 1e-3, 2e-2])
    if made["winding"] == "current" and chance.random() < 0.7:
        made["bandwidth"] = chance.choice([200.0, 1000.0, 5000.0])
    if made["winding"] == "voltage" and chance.random() < 0.3:
        made["supply_voltage"] = chance.uniform(0.2, 2.0)
    return made


def random_case(seed: int) -> Case:
    """A scene with a motor, and two or so of all that goes with it."""
    chance = Random(seed)
    parts: dict[str, Any] = {"motor": random_motor(chance)}
    actuator: dict[str, float] = {}
    if chance.random() < 0.5:
        parts["knob"] = {"coulomb_torque": chance.choice([6e-5, 5.6e-4])}
    if chance.random() < 0.3:
        parts["hand"] = chance.choice([TWO_PARTS, RINGING])
    if chance.random() < 0.5:
        actuator["delay_samples"] = chance.choice([1.0, 0.4, 2.3])
    if chance.random() < 0.2 and "supply_voltage" not in parts["motor"]:
        actuator["torque_limit"] = 0.0041
    if chance.random() < 0.3:
        parts["wall"] = {"damping": 4e-5}
    if chance.random() < 0.3:
        parts["eddy_brake"] = {
            "flux_density": chance.uniform(0.1, 0.5),
            "conductivity": 5.8e7,
            "thickness": 1e-3,
            "area": 1e-4,
            "radius": 0.02,
            "share": 0.5,
        }
    if actuator:
        parts["actuator"] = actuator
    return Case(
        f"seed {seed}",
        scene(**parts),
        rate_hz=chance.choice([500.0, 1000.0, 2154.0]),
        counts=chance.choice([100, 256, 1024]),
        angle=chance.uniform(-0.05, 0.05),
        velocity=chance.uniform(-3.0, 3.0),
        phase=chance.uniform(0.1, 0.9),
        samples=100,
    )


def holds_to_the_bounds(case: Case) -> bool:
    """Run both and compare; False where something is too near to go one way for certain, or the model gives up."""
    try:
        expected = reference.simulate(case.scene, **case.arguments)
    except reference.NotHandledError:
        return False
    within = bounds(expected, case)
    bodies = expected.friction.bodies
    closest = expected.friction.closest if bodies.friction else 1.0
    if not (expected.edge > AWAY * within.angle and expected.step > AWAY * within.command and closest > 1e-9):
        return False
    got = simulate(reduced(SceneSpec.model_validate(case.scene).plain()), **case.arguments)
    names = ("angle_rad", "velocity_rad_s", *(() if bodies.driven else ("torque_nm",)))
    for name, bound in zip(names, within, strict=False):
        exact = [getattr(sample, name.split("_")[0]) for sample in expected.samples]
        errors = [float(abs(mp.mpf(x) - y)) for x, y in zip(getattr(got, name), exact, strict=True)]
        assert max(errors) <= bound, f"{name} off by {max(errors):.3g}, bound {bound:.3g}: {case}"
    return True


@pytest.mark.long
def test_every_sample_of_random_scenes() -> None:
    compared = sum(holds_to_the_bounds(random_case(seed)) for seed in range(16))
    assert compared >= 12


@pytest.mark.long
def test_every_sample_of_many_random_scenes() -> None:
    compared = sum(holds_to_the_bounds(random_case(seed)) for seed in range(16, 216))
    assert compared >= 150


def check_orbits(case: Case) -> int:
    """Solve again each proven cycle of a scene at 60 digits, and balance its energy: the number of cycles."""
    made = reduced(SceneSpec.model_validate(case.scene).plain())
    knob = sample_general(made, sample_rate_hz=case.rate_hz, counts_per_rev=case.counts)
    engine = GeneralEngine(patience=Patience(samples=10**9, seconds=60.0))
    search = engine.search(
        knob.body,
        knob.wall,
        knob.start(case.angle, case.velocity),
        rate=knob.rate,
        phases=1,
        delay_line=knob.delay_line,
        max_samples=20_000,
    )
    cycles = 0
    for one in search.attractors:
        if one.outcome is not Outcome.CYCLE or not one.certified or one.period > 60:
            continue
        cycles += 1
        solved = solve(case.scene, case.rate_hz, case.counts, knob, one)
        assert solved.residual < 1e-35, f"does not close: {case}"
        exact, got = measure(solved), GeneralMeasurer(knob, engine).measure(one)
        for name in ("p2p_rad", "min_rad", "max_rad", "rms_rad", "frequency_hz"):
            assert getattr(got, name) == pytest.approx(float(exact[name]), rel=1e-9, abs=1e-15), name
        lost = got.damping_loss_j + (got.friction_loss_j if knob.body.friction else 0.0)
        assert got.wall_work_j == pytest.approx(lost, rel=1e-9)
        if not solved.bodies.driven:
            assert got.damping_loss_j == pytest.approx(float(exact["damping_loss_j"]), rel=1e-9)
    return cycles


@pytest.mark.long
def test_proven_orbits_of_random_scenes() -> None:
    assert sum(check_orbits(random_case(seed)) for seed in range(1000, 1006)) >= 2


@pytest.mark.long
def test_proven_orbits_of_many_random_scenes() -> None:
    assert sum(check_orbits(random_case(seed)) for seed in range(2000, 2050)) >= 12
