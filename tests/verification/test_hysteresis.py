"""An encoder with hysteresis, or slack before it, against the 60-digit model, where each edge is a relay of its own.

The model finds all turning points by exclusion and shows them to its relays; the package keeps one number, the count.
Bounds of the samples are those of `test_general_trajectory`: the count is the same, so that the errors are, too. A run
is comparable where no sample and no turning point is near a relay's threshold: asserted.
"""

from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.general.search import GeneralEngine
from hknob_cli.engine.outcome import Outcome, Reason
from hknob_cli.measure.general_orbit import GeneralMeasurer
from hknob_cli.scene.general_knob import sample_general, simulate
from hknob_cli.specs.scene import SceneSpec

from . import general_reference as reference
from .general_scenes import TWO_PARTS, Case, scene
from .law_reference import simulate_law
from .law_scenes import Drawn, reduce, search
from .test_general_trajectory import AWAY, bounds
from .test_laws_in_the_general_loop import LONGEST, ORDER, balance, check_orbit, check_trial, scenes

HALF = {"torque": None, "half_quantum": True}


def case(name: str, *, rate_hz: float = 1000.0, counts: int = 512, **parts: Any) -> Case:
    """A short trial of a scene with ``parts``."""
    return Case(name, scene(**parts), rate_hz=rate_hz, counts=counts, samples=max(150, int(0.15 * rate_hz)))


CASES = [
    case("half a count", encoder={"hysteresis_counts": 0.5}),
    case("a little", encoder={"hysteresis_counts": 0.01}, rate_hz=4000.0),
    case("wider than a count", encoder={"hysteresis_counts": 2.3}),
    case("slack", encoder={"backlash": 0.004}),
    case("both", encoder={"backlash": 0.004, "hysteresis_counts": 0.2, "offset_counts": 0.3}),
    case("nearest", encoder={"hysteresis_counts": 0.4, "rounding": "nearest"}),
    case("ceil", encoder={"hysteresis_counts": 0.4, "rounding": "ceil"}),
    case("slow clock", encoder={"hysteresis_counts": 0.5}, rate_hz=200.0),
    case("friction", encoder={"hysteresis_counts": 0.5}, knob={"coulomb_torque": 2e-4}),
    case("heavy", encoder={"hysteresis_counts": 0.5}, knob={"inertia": 5e-5}),
    case("delay", encoder={"hysteresis_counts": 0.5}, actuator={"delay_samples": 1.4}),
    case("whole delay", encoder={"hysteresis_counts": 0.5}, actuator={"delay_samples": 1.0}),
    case("lag", encoder={"hysteresis_counts": 0.5}, actuator={"time_constant": 3e-4}),
    case("finger", encoder={"hysteresis_counts": 0.5}, hand=TWO_PARTS),
    case("dead band", encoder={"hysteresis_counts": 0.5}, actuator={"dead_band": 2e-3}),
    case("detents", encoder={"hysteresis_counts": 0.5}, detents={"torque": 0.006, "per_revolution": 16}),
]  # fmt: skip


def of_package(one: Case, *, samples: int) -> Any:
    """The package's trial of a case."""
    plain = SceneSpec.model_validate(one.scene).plain()
    arguments = {**one.arguments, "samples": samples}
    return simulate(plain, **arguments)


@pytest.mark.one_in(5)
@pytest.mark.parametrize("one", CASES, ids=lambda one: one.name)
def test_every_sample_is_the_models(one: Case) -> None:
    expected = reference.simulate(one.scene, **one.arguments)
    within = bounds(expected, one)
    assert expected.edge > AWAY * within.angle
    found = of_package(one, samples=one.samples)
    angles = np.array([float(sample.angle) for sample in expected.samples])
    torques = np.array([float(sample.torque) for sample in expected.samples])
    assert np.abs(found.angle_rad - angles).max() <= within.angle
    assert np.abs(found.torque_nm - torques).max() <= within.torque
    plain = {name: part for name, part in one.scene.items() if name != "encoder"}
    kept = {name: value for name, value in one.scene["encoder"].items() if name in ("rounding", "offset_counts")}
    other = of_package(one._replace(scene={**plain, "encoder": kept}), samples=one.samples)
    assert np.abs(other.torque_nm - found.torque_nm).max() > 1e-6, "the hysteresis does nothing here"


def test_a_turning_point_between_samples_counts() -> None:
    """A count that changed at samples alone would differ: the model without turning points does."""

    class Blind(reference.Friction):
        def hold(self, command: Any, duration: Any) -> None:
            super().hold(command, duration)
            self.turns.clear()

    one = case("slow clock", encoder={"hysteresis_counts": 0.5}, rate_hz=200.0)
    seeing = reference.simulate(one.scene, **one.arguments)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(reference, "Friction", Blind)
        blind = reference.simulate(one.scene, **one.arguments)
    assert any(a.torque != b.torque for a, b in zip(seeing.samples, blind.samples, strict=True))


ORBITS = [
    (case("half a count", encoder={"hysteresis_counts": 0.5}, bias=HALF), 600),
    (case("two counts", encoder={"hysteresis_counts": 2.0}, bias=HALF, rate_hz=2000.0), 1200),
    (case("off the middle", encoder={"hysteresis_counts": 0.3}), 600),
    # A turning point between two samples is nearer to a change of the count than any sample.
    (case("at a turning point", encoder={"hysteresis_counts": 0.05}, rate_hz=150.0), 300),
    (case("slow", encoder={"hysteresis_counts": 0.5}, rate_hz=200.0), 300),
    (case("friction", encoder={"hysteresis_counts": 0.5}, bias=HALF, knob={"coulomb_torque": 2e-4}), 600),
    (case("heavy", encoder={"hysteresis_counts": 0.5}, bias=HALF, knob={"inertia": 1e-5}), 3000),
    (case("lag", encoder={"hysteresis_counts": 0.5}, bias=HALF, actuator={"time_constant": 3e-4}), 600),
    (case("delay", encoder={"hysteresis_counts": 0.5}, bias=HALF, actuator={"delay_samples": 1.4}), 600),
]  # fmt: skip


@pytest.mark.one_in(12)
@pytest.mark.parametrize(("one", "samples"), ORBITS, ids=lambda one: one.name if isinstance(one, Case) else "")
def test_a_proven_cycle_is_what_the_model_settles_to(one: Case, samples: int) -> None:
    plain = SceneSpec.model_validate(one.scene).plain()
    knob = sample_general(plain, sample_rate_hz=one.rate_hz, counts_per_rev=one.counts)
    engine = GeneralEngine()
    start = knob.start(one.angle, one.velocity)
    search = engine.search(
        knob.body, knob.wall, start, rate=knob.rate, phases=1, delay_line=knob.delay_line, max_samples=None
    )
    (orbit,) = search.attractors
    assert (orbit.outcome, orbit.reason) == (Outcome.CYCLE, Reason.NONE)
    measured = GeneralMeasurer(knob, engine).measure(orbit)
    length = orbit.period * max(1, 40 // orbit.period)
    trial = reference.simulate(one.scene, **{**one.arguments, "samples": samples})
    assert trial.relays is not None
    last, before = (float(trial.samples[samples - back].angle) for back in (0, length))
    assert abs(last - before) < 1e-11, "the model has not settled"
    log = [row for row in trial.relays.log if row[0] > samples - length]
    turns = [float(angle) for _, turn, angle, _ in log if turn]
    middle = 0.5 * (min(turns) + max(turns))
    highs, lows = [x for x in turns if x > middle], [x for x in turns if x < middle]
    assert measured.p2p_rad == pytest.approx(np.mean(highs) - np.mean(lows), rel=1e-8)
    assert measured.min_rad == pytest.approx(min(turns), abs=1e-8 * measured.p2p_rad)
    assert measured.frequency_hz == pytest.approx(len(highs) * one.rate_hz / length, rel=1e-12)
    assert orbit.margin == pytest.approx(min(gap for _, _, _, gap in log), abs=1e-8)
    rubbed = measured.friction_loss_j if knob.body.friction else 0.0
    assert measured.wall_work_j == pytest.approx(measured.damping_loss_j + rubbed, rel=1e-9)


def with_hysteresis(controller: str, count: int, seed: int) -> list[Drawn]:
    """Random scenes under a controller, whose count stays behind by a part of a count or by more than one."""
    found = []
    for k, one in enumerate(scenes(controller, count, seed)):
        key, value = ("backlash", 0.002) if k % 3 == 1 else ("hysteresis_counts", (0.3, 0.0, 1.2)[k % 3])
        encoder = {**one.scene.get("encoder", {}), key: value}
        found.append(one._replace(scene={**one.scene, "encoder": encoder}))
    return found


def check_controlled(drawn: list[Drawn]) -> tuple[int, int]:
    """Trials that could be compared, and proven cycles derived again, turning points and all."""
    trials = cycles = 0
    for one in drawn:
        trials += bool(np.isfinite(check_trial(one)))
        made = reduce(one)
        engine, attractors = search(one, made)
        for orbit in attractors:
            assert made.law.provable or not orbit.certified
            if orbit.outcome is Outcome.CYCLE and orbit.certified and orbit.period <= LONGEST:
                check_orbit(one, made, orbit)
                balance(made, engine, orbit, one)
                cycles += 1
    return trials, cycles


@pytest.mark.one_in(36)
@pytest.mark.parametrize("controller", ORDER)
def test_beside_a_controller(controller: str) -> None:
    trials, _ = check_controlled(with_hysteresis(controller, 3, seed=31))
    assert trials, "rounding could decide in all scenes: nothing was tested"


@pytest.mark.long
def test_beside_virtual_damping_without_a_controller() -> None:
    """The wall's own torque is the law; the model that knows no controllers has the same samples."""
    drawn = []
    for one in with_hysteresis("bounded lag", 12, seed=33):
        plain = {name: part for name, part in one.scene.items() if name != "controller"}
        plain["wall"] = {"stiffness": 0.27, "damping": plain["wall"].get("damping") or 5e-6}
        drawn.append(one._replace(controller="", scene=plain))
    trials, cycles = check_controlled(drawn)
    assert (trials >= 8, cycles >= 2) == (True, True)
    for one in drawn[:4]:
        arguments = {"sample_rate_hz": one.rate_hz, "counts_per_rev": one.counts, "phase": 0.37}
        expected = reference.simulate(one.scene, **arguments, angle_rad=0.02, velocity_rad_s=-0.5, samples=40)
        by_law = simulate_law(one.scene, one.rate_hz, one.counts, angle=0.02, velocity=-0.5, phase=0.37)
        for sample, (angle, _, _) in zip(expected.samples, by_law, strict=False):
            assert abs(sample.angle - angle) < 1e-40


@pytest.mark.long
def test_proven_cycles_beside_a_controller() -> None:
    _, cycles = check_controlled(with_hysteresis("bounded lag", 12, seed=32))
    assert cycles >= 2
