"""A simulated knob with a motor by its constants and an eddy brake: its trials are the engine's, count by count."""

from contextlib import ExitStack
from typing import Any

import numpy as np
import pytest

from hknob_cli.controllers.scalar_law import make_law
from hknob_cli.engine.general.controller import read
from hknob_cli.engine.general.laws.law import TORQUE
from hknob_cli.engine.general.laws.step import advance_with_law, begin_past, decide
from hknob_cli.errors import SpecError
from hknob_cli.hardware.campaign import opened, who_of
from hknob_cli.hardware.order import settings_of, trials_of
from hknob_cli.printed import grasps
from hknob_cli.specs.campaign import HwRunPlan
from hknob_cli.specs.controller import Controller
from hknob_cli.specs.drive import reduced
from hknob_cli.specs.load import validate
from hknob_cli.specs.plan import Actuator, Bias, Encoder, Hand, Knob, Scene, Wall
from hknob_cli.specs.source import Source
from tests.hardware.trials import joined, take

SAMPLES = 1200
CONSTANTS = {"torque_constant": 0.0234, "resistance": 12.3}
BRAKE = {"flux_density": 0.3, "conductivity": 5.8e7, "thickness": 1e-3, "area": 5e-5, "radius": 0.01, "share": 0.5}
MOTORS: dict[str, dict[str, Any]] = {
    "shorted winding": {"motor": {**CONSTANTS, "winding": "shorted"}},
    "driven by a voltage": {"motor": {**CONSTANTS, "winding": "voltage"}},
    "eddy brake": {"eddy_brake": BRAKE},
    "both": {"motor": {**CONSTANTS, "winding": "shorted"}, "eddy_brake": BRAKE},
    "supply voltage": {"motor": {**CONSTANTS, "winding": "voltage", "supply_voltage": 1.2}},
    "inductance, shorted": {"motor": {**CONSTANTS, "winding": "shorted", "inductance": 2.4e-3}},
    "inductance, driven": {"motor": {**CONSTANTS, "winding": "voltage", "inductance": 2.4e-3}},
    "current loop": {"motor": {**CONSTANTS, "winding": "current", "bandwidth": 1000.0}},
    "inductance and an eddy brake": {
        "motor": {**CONSTANTS, "winding": "shorted", "inductance": 2.4e-3},
        "eddy_brake": BRAKE,
    },
}
LATE = {"actuator": {"delay_samples": 0.75}}


def planned(**parts: Any) -> HwRunPlan:
    """A campaign of one trial, by somebody who neither wanders nor trembles."""
    source = Source("spec.yaml")
    source.value = {
        "kind": "hw-run",
        "name": "small",
        "controller": {"kind": "bounded_lag", "keep": 1.0},  # a plain wall that the engine follows as a controller
        "knob": {"coulomb_torque": 0.0},
        "person": {"wandering_push": False, "grip_wander": False},
        "limits": {"torque": 1.0},
        **parts,
    }
    plan = validate(source)
    assert isinstance(plan, HwRunPlan)
    return plan


def refused(**parts: Any) -> list[str]:
    with pytest.raises(SpecError) as raised:
        planned(**parts)
    return [f"{fault.key}: {fault.message}" for fault in raised.value.faults]


def engine_trial(plan: HwRunPlan, rate: int, counts: int) -> tuple[list[int], list[float]]:
    """Counts at every sample, and the torque (N·m) from it on, of the scene as a sweep has it."""
    hand = grasps(1)[0]
    tried = plan.first
    actuator = tried.actuator
    if plan.motor and plan.motor.supply_voltage:
        actuator = actuator._replace(torque_limit=None) if actuator else None  # the motor's, which the scene has
    scene = reduced(
        Scene(
            knob=Knob(*plan.knob),
            wall=Wall(*tried.wall),
            hand=Hand(*hand[1:]),
            bias=Bias(torque=plan.person.push),
            encoder=Encoder(),
            actuator=actuator or Actuator(),
            controller=Controller("bounded_lag", keep=1.0),
            motor=plan.motor,
            eddy_brake=plan.eddy_brake,
        )
    )
    knob, law, _ = make_law(scene, sample_rate_hz=float(rate), counts_per_rev=counts)
    z, pad = knob.start(0.02, 0.0), [0.0] * (2 * knob.body.order + 8)
    past, trial = [0.0] * len(law.periodic), [0.0] * len(law.periodic)
    begin_past(past, read(z[0], knob.wall), law)
    seen, torques = [], []
    for _ in range(SAMPLES):
        shown = read(z[0], knob.wall)
        seen.append(int(shown))
        trial[:] = past
        decide(shown, z[1], trial, knob.wall, law)
        torques.append(trial[int(law.sched[TORQUE])] * knob.torque_nm)
        advance_with_law(z, past, knob.body, knob.wall, law, pad)
    return seen, torques


@pytest.mark.one_in(4)
@pytest.mark.parametrize("parts", [{}, LATE, {"knob": {"coulomb_torque": 1e-4}}], ids=["plain", "late", "friction"])
@pytest.mark.parametrize(("rate", "counts"), [(1000, 1024), (4000, 512)])
@pytest.mark.parametrize("name", MOTORS)
def test_a_trial_is_the_engines(name: str, rate: int, counts: int, parts: dict[str, Any]) -> None:
    grid = {"sample_rate_hz": [rate], "counts_per_rev": [counts]}
    plan = planned(grid=grid, **MOTORS[name], **parts)
    (trial,) = trials_of(plan)
    told = settings_of(plan, trial)
    with ExitStack() as stack:
        device = opened(plan, stack)
        blocks = take(device, told, who_of(plan)(trial), blocks=-(-SAMPLES // told.block_samples) + 1)
    block, native = joined(blocks), 640_000 // counts
    on = np.flatnonzero(block.running)[:SAMPLES]
    seen, torques = engine_trial(plan, rate, counts)
    assert np.floor_divide(block.angle_counts[on], native).tolist() == seen
    assert min(seen) < 0 < max(seen)
    assert block.torque_nm[on] == pytest.approx(np.array(torques), rel=3e-7, abs=1e-12)


def test_what_they_come_to() -> None:
    """Kt²/R, L/R, 1/(2πf) and Kt V/R, and the brake's s d A B² r² by its share."""
    brake = 0.5 * 5.8e7 * 1e-3 * 5e-5 * (0.3 * 0.01) ** 2
    shorted = 0.0234**2 / 12.3
    both = planned(**MOTORS["both"], knob={"damping": 1e-5}).driven
    assert both.knob.damping == pytest.approx(1e-5 + brake + shorted, rel=1e-14)
    assert (both.coil, both.lag_s, both.limit_nm) == (None, 0.0, None)
    slow = planned(**MOTORS["inductance, driven"]).driven
    assert slow.coil is not None
    assert (slow.knob.damping, *slow.coil) == pytest.approx((0.0, shorted, 2.4e-3 / 12.3), rel=1e-14)
    assert slow.lag_s == slow.coil.time_constant
    loop = planned(**MOTORS["current loop"]).driven
    assert (loop.knob.damping, loop.lag_s) == pytest.approx((0.0, 1.0 / (2000.0 * np.pi)), rel=1e-14)


def test_a_supply_voltage_limits_every_remedy() -> None:
    """Where a remedy has a limit of its own, the smaller one counts."""
    remedies = {"plain wall": {}, "soft": {"change": {"actuator": {"torque_limit": 1e-3}}}}
    plan = planned(**MOTORS["supply voltage"], remedies=remedies)
    most = 0.0234 * 1.2 / 12.3
    assert [one.actuator.torque_limit for one in plan.tries if one.actuator] == [pytest.approx(most), 1e-3]


def test_a_model_of_the_knob_has_their_damping() -> None:
    """Of half_sample, which believes what the simulated knob is."""
    acts = {"controller": {"kind": "half_sample"}, "grid": {"sample_rate_hz": [1000], "counts_per_rev": [1024]}}
    braked, bare = planned(**MOTORS["eddy brake"], **acts), planned(**acts)
    same = planned(**{**acts, "knob": {"coulomb_torque": 0.0, "damping": braked.driven.knob.damping}})
    told = [settings_of(plan, trials_of(plan)[0]).control for plan in (braked, bare, same)]
    assert told[0] == told[2] != told[1]


@pytest.mark.parametrize("name", ["shorted winding", "eddy brake", "both", "supply voltage"])
def test_a_target_simulates_what_is_damping_and_limit(name: str) -> None:
    """They are in the numbers that it is told anyway: no message of the wire is new."""
    target = {"driver": "serial", "target": "host"}
    parts = MOTORS[name]
    told = planned(**parts, device=target)
    (virtual, there) = (planned(**parts), told)
    for one in trials_of(there)[:2]:
        assert settings_of(there, one) == settings_of(virtual, one)
        assert who_of(there)(one) == who_of(virtual)(one)


@pytest.mark.parametrize(
    ("parts", "said"),
    [
        ({**MOTORS["inductance, shorted"], "device": {"driver": "serial", "target": "host"}},
         "motor.inductance: must be 0 with a target: the knob that its firmware simulates has no winding that"),
        ({**MOTORS["current loop"], "device": {"driver": "serial", "target": "qemu"}},
         "motor.bandwidth: must be absent with a target: the amplifier that its firmware simulates has no lag"),
        ({**MOTORS["both"], "device": {"driver": "serial", "url": "COM3"}},
         "motor: must be absent with url: the knob at a port has a motor of its own"),
        ({**MOTORS["eddy brake"], "device": {"driver": "replay", "recordings": ["a"]}, "knob": None, "person": None},
         "eddy_brake: must be absent: what is replayed was recorded"),
        ({**MOTORS["current loop"], "nuisances": {"amplifier": 1e-4}},
         "nuisances.amplifier: must be absent beside motor.bandwidth, which is the lag"),
        ({**MOTORS["inductance, driven"], "nuisances": {"amplifier": 1e-4}},
         "nuisances.amplifier: must be absent beside motor.inductance, which is the lag"),
        ({**MOTORS["supply voltage"], "actuator": {"torque_limit": 0.01}},
         "actuator.torque_limit: must be absent beside motor.supply_voltage: Kt V/R is the limit"),
        ({"motor": {**CONSTANTS, "winding": "shorted", "supply_voltage": 1.0}},
         "motor: supply_voltage: must be absent"),
        ({"motor": {**CONSTANTS, "winding": "shorted"}, "what": "pulses", "controller": None, "person": None},
         "motor: must be absent with what: pulses: its damping goes into that of the knob"),
    ],
)  # fmt: skip
def test_faults_have_their_place(parts: dict[str, Any], said: str) -> None:
    found = refused(**parts)
    assert any(one.startswith(said) for one in found), found
