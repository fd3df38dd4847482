"""Virtual trials against the engine's own, from the first sample on: the same counts at every sample, and the torques.

The engine moves the knob in other units, so that its angles differ from the virtual device's by roundings. Counts and
what follows from them are the same to the last bit, unless a sample lies within such a rounding of a count's edge.
"""

from typing import NamedTuple

import numpy as np
import pytest

from hknob_cli.controllers.scalar_law import make_law
from hknob_cli.engine.general.controller import read
from hknob_cli.engine.general.laws.law import PIECE, TORQUE
from hknob_cli.engine.general.laws.step import advance_with_law, begin_past, decide
from hknob_cli.hardware.control import control_of
from hknob_cli.hardware.knob_motion import Nuisances
from hknob_cli.hardware.trial_wall import Conversion, converters_of
from hknob_cli.hardware.virtual import IDENTITY
from hknob_cli.specs.controller import Controller
from hknob_cli.specs.plan import Actuator, Bias, Encoder, Hand, Knob, Scene, Wall
from tests.hardware.controllers import CONTROLLERS, MODEL
from tests.hardware.trials import ALIGNED, HAND, settings, virtual_trial

SAMPLES = 1200
KNOWING = IDENTITY._replace(native_counts=ALIGNED.native_counts)
PLAIN = Controller("bounded_lag", keep=1.0)  # a wall that the engine follows as it does a controller's


class Case(NamedTuple):
    """A trial's controller, encoder and actuator, and friction."""

    controller: Controller = PLAIN
    encoder: Encoder = Encoder()
    actuator: Actuator = Actuator()
    friction_nm: float = 0.0
    damping: float = 0.0


CASES = {
    "plain": Case(),
    "half a sample of delay": Case(actuator=Actuator(delay_samples=0.5)),
    "a sample of delay": Case(actuator=Actuator(delay_samples=1.0)),
    "a sample and a quarter": Case(actuator=Actuator(delay_samples=1.25)),
    "steps": Case(actuator=Actuator(torque_step=3e-4)),
    "a dead band": Case(actuator=Actuator(dead_band=1.5e-3)),
    "a limit": Case(actuator=Actuator(torque_limit=2e-3)),
    "nearest": Case(encoder=Encoder(rounding="nearest")),
    "up": Case(encoder=Encoder(rounding="ceil")),
    "toward zero": Case(encoder=Encoder(rounding="truncate")),
    "offset": Case(encoder=Encoder(offset_counts=0.25)),
    "all of them": Case(
        encoder=Encoder(rounding="nearest", offset_counts=0.25),
        actuator=Actuator(delay_samples=0.75, torque_step=2e-4, dead_band=5e-4, torque_limit=3e-3),
        damping=1e-5,
    ),
    "friction beside all of them": Case(
        CONTROLLERS["impulse"],
        Encoder(rounding="ceil", offset_counts=0.25),
        Actuator(delay_samples=1.5, torque_step=2e-4, dead_band=3e-4, torque_limit=4e-3),
        friction_nm=2e-4,
    ),
    "half sample, delayed": Case(CONTROLLERS["half sample"], actuator=Actuator(delay_samples=0.5)),
    "matched wall beside friction": Case(CONTROLLERS["matched wall"], friction_nm=2e-4),
    "hold in steps, delayed": Case(CONTROLLERS["hold in steps"], actuator=Actuator(delay_samples=0.5)),
    "half sample that senses": Case(Controller("half_sample", velocity="sensor")),
    "matched wall that senses": Case(Controller("matched_wall", velocity="sensor")),
    "sensed damping": Case(Controller("velocity_damping", damping=1e-4, velocity="sensor")),
    "sensed damping everywhere": Case(
        Controller("velocity_damping", damping=5e-5, velocity="sensor", everywhere=True, cut_off=3.0)
    ),
    "sensed, delayed, in steps": Case(
        Controller("velocity_damping", damping=1e-4, velocity="sensor"),
        actuator=Actuator(delay_samples=0.5, torque_step=1e-4),
        friction_nm=1e-4,
    ),
    "hold that reads four times": Case(Controller("first_order_hold", detections=4)),
    "hold that reads, in steps": Case(
        Controller("first_order_hold", detections=3, steps=4), actuator=Actuator(delay_samples=0.25)
    ),
    "impulse that reads": Case(Controller("impulse_damping", detections=40)),
    "long impulse that reads": Case(Controller("impulse_damping", pulse=0.5, detections=4), friction_nm=1e-4),
    "timed within the interval": Case(
        Controller("velocity_damping", damping=5e-5, velocity="timed", detections=16),
        Encoder(rounding="nearest", offset_counts=0.25),
    ),
    "half sample, offset": Case(CONTROLLERS["half sample"], Encoder(rounding="nearest", offset_counts=0.25)),
    **{name: Case(CONTROLLERS[name]) for name in CONTROLLERS},
}


def engine_trial(case: Case, rate: int, counts: int) -> tuple[list[int], list[float]]:
    """Counts at every sample, and the torque (N·m) from it on."""
    scene = Scene(
        knob=Knob(HAND.inertia, HAND.damping, case.friction_nm),
        wall=Wall(0.27, case.damping),
        hand=Hand(stiffness=HAND.stiffness),
        bias=Bias(torque=HAND.push_nm),
        encoder=case.encoder,
        actuator=case.actuator,
        controller=case.controller,
    )
    knob, law, _ = make_law(scene, sample_rate_hz=float(rate), counts_per_rev=counts)
    z, pad = knob.start(HAND.angle_rad, 0.0), [0.0] * 8
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
    assert law.sched[PIECE - 1] >= 0.0
    return seen, torques


@pytest.mark.one_in(5)
@pytest.mark.parametrize(("rate", "counts"), [(1000, 1024), (4000, 512)])
@pytest.mark.parametrize("name", CASES)
def test_a_trial_is_the_engines(name: str, rate: int, counts: int) -> None:
    case = CASES[name]
    told = settings(rate, counts, wall_damping=case.damping, torque_limit_nm=1.0)
    told = told._replace(converters=converters_of(case.encoder, case.actuator))
    told = told._replace(control=control_of(case.controller, told, MODEL))
    person = HAND._replace(coulomb_nm=case.friction_nm)
    block = virtual_trial(told, person, duration_s=SAMPLES / rate + 0.1, identity=KNOWING, nuisances=Nuisances())
    on = np.flatnonzero(block.running)[:SAMPLES]
    counted = Conversion(told, KNOWING.native_counts).counts(block.angle_counts[on])
    seen, torques = engine_trial(case, rate, counts)
    assert counted.tolist() == seen
    assert min(seen) < 0 < max(seen)
    assert block.torque_nm[on] == pytest.approx(np.array(torques), rel=3e-7, abs=1e-12)


@pytest.mark.parametrize("name", ["impulse that reads", "timed within the interval", "sensed damping"])
def test_a_late_clock_leaves_out_no_reading(name: str) -> None:
    """A reading that the next sample comes before is made then: the trial goes on, and is the same again."""
    case = CASES[name]
    told = settings(1000, 1024, torque_limit_nm=1.0)
    told = told._replace(converters=converters_of(case.encoder, case.actuator))
    told = told._replace(control=control_of(case.controller, told, MODEL))
    late = Nuisances(jitter_s=3e-4, late_share=0.1, angle_noise_rad=1e-3)
    one, again = (virtual_trial(told, HAND, duration_s=0.5, identity=KNOWING, nuisances=late) for _ in range(2))
    assert np.array_equal(one.angle_counts, again.angle_counts)
    assert np.isfinite(one.torque_nm).all()
    assert one.overruns > 0
