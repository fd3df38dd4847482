"""Torque over the angle of a continuous sensor against the 60-digit model: samples, proven orbits, and their proof.

Two motions with the same counts get the same torques; here every rounding is followed by the torque, and may grow. So
the bounds of `test_general_trajectory` are widened by as much as a small change of the model's own states grows. A
proof says that all motions from so near stay so near: they are followed.
"""

from collections import Counter
from random import Random
from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.attractors import Attractor, Patience
from hknob_cli.engine.certificate import DIFFERENT, PROVEN
from hknob_cli.engine.general.controller import bends, read
from hknob_cli.engine.general.interval import advance
from hknob_cli.engine.general.orbit_proof import certify
from hknob_cli.engine.general.search import GeneralEngine, as_list, make_space
from hknob_cli.engine.general.torque_curve import curve_at, rounded_size
from hknob_cli.engine.jit import compiled
from hknob_cli.engine.outcome import Outcome
from hknob_cli.measure.general_orbit import GeneralMeasurer
from hknob_cli.scene.general_knob import GeneralKnob, sample_general, simulate
from hknob_cli.specs.drive import reduced
from hknob_cli.specs.scene import SceneSpec
from tests import digits as mp

from . import general_reference as reference
from .general_orbits import measure, solve
from .general_scenes import Case, scene
from .random_scenes import LEFT, bared
from .random_scenes import compare as composed
from .test_general_trajectory import AWAY, bounds
from .test_over_angle import random_case, random_part

NUDGE = mp.mpf(10) ** -25
RELATIVE = 1e-9
LONG = 1200  # periods in which the slowest motion that a sum of powers bounds comes nearer by 7 in 8


def bare(seed: int) -> Case:
    """A scene of `test_over_angle` with a continuous sensor."""
    case = random_case(seed)
    return case._replace(scene={**case.scene, "encoder": "none"}, counts=None, samples=80)


def sampled(case: Case) -> GeneralKnob:
    plain = reduced(SceneSpec.model_validate(case.scene).plain())
    return sample_general(plain, sample_rate_hz=case.rate_hz, counts_per_rev=None)


def holds_to_the_bounds(case: Case) -> bool:
    """Run both and compare; False where a jump, a step or a standstill is too near to go one way for certain."""
    expected = reference.simulate(case.scene, **case.arguments)
    other = reference.simulate(case.scene, **case.arguments, nudge=NUDGE)
    apart = max(abs(a.angle - b.angle) for a, b in zip(expected.samples, other.samples, strict=True))
    grown = max(1.0, float(apart) / (float(NUDGE) * expected.largest_angle * (case.samples + 1)))
    if grown > 1e4:
        return False  # neighbours part: nothing is left to compare
    knob = sampled(case)
    places = [float(sample.angle) / knob.quantum_rad for sample in expected.samples]
    size = max(rounded_size(x, knob.wall.curve) for x in places) * knob.torque_nm
    steepest = max(curve_at(x, knob.wall.curve)[3] for x in places) * knob.torque_nm / knob.quantum_rad
    load = expected.largest_command + float(expected.friction.bodies.bias)
    within = bounds(expected, case)
    angle, velocity, torque, command = (grown * (1.0 + size / load) * bound for bound in within)
    torque, command = torque + steepest * angle, command + steepest * angle
    closest = expected.friction.closest if expected.friction.bodies.friction else 1.0
    if not (expected.edge > AWAY * angle and expected.step > AWAY * command and closest > 1e-9):
        return False
    got = simulate(SceneSpec.model_validate(case.scene).plain(), **case.arguments)
    for name, bound in (("angle_rad", angle), ("velocity_rad_s", velocity), ("torque_nm", torque)):
        exact = [getattr(sample, name.split("_")[0]) for sample in expected.samples]
        errors = [float(abs(mp.mpf(x) - y)) for x, y in zip(getattr(got, name), exact, strict=True)]
        assert max(errors) <= bound, f"{name} off by {max(errors):.3g}, bound {bound:.3g}: {case}"
    return True


def test_every_sample_of_random_scenes() -> None:
    compared = sum(holds_to_the_bounds(bare(seed)) for seed in range(30))
    assert compared >= 20


@pytest.mark.long
@pytest.mark.drawn(9)
@pytest.mark.parametrize("first", range(30, 300, 30))
def test_every_sample_of_many_random_scenes(first: int) -> None:
    compared = sum(holds_to_the_bounds(bare(seed)) for seed in range(first, first + 30))
    assert compared >= 12


def buzzing(seed: int) -> Case:
    """A scene whose torque is stiff and its clock slow, so that it often buzzes; some have a limit or a lag."""
    chance = Random(f"buzzing {seed}")
    hand = {"inertia": 3e-7, "damping": 10.0 ** chance.uniform(-3.5, -2.5), "stiffness": chance.choice([0.04, 0.3])}
    if chance.random() < 0.6:
        parts: dict[str, Any] = {
            "detents": {
                "torque": 10.0 ** chance.uniform(-2.5, -1.0),
                "per_revolution": chance.choice([6, 12, 24]),
                "shape": chance.choice(["sine", "sine", "triangle", "spring"]),
                "centre": chance.uniform(-0.1, 0.1),
            }
        }
    else:
        parts = random_part(chance)
    actuator = chance.choice([None, None, {"torque_limit": 0.02}, {"time_constant": 3e-4}, {"delay_samples": 1.0}])
    parts |= {"actuator": actuator} if actuator else {}
    whole = scene(wall={"stiffness": chance.choice([0.0, 0.27])}, encoder="none", hand=hand, **parts)
    return Case(f"buzzing {seed}", whole, chance.choice([50.0, 100.0, 200.0, 464.0]), None, angle=0.05, velocity=-0.5)


def settle(case: Case, engine: GeneralEngine) -> tuple[GeneralKnob, Attractor]:
    knob = sampled(case)
    start = knob.start(case.angle, case.velocity)
    found = engine.search(
        knob.body, knob.wall, start, rate=knob.rate, phases=1, delay_line=knob.delay_line, max_samples=8000
    )
    return knob, found.attractors[0]


def interpreted() -> GeneralEngine:
    return GeneralEngine(patience=Patience(samples=10**9, seconds=60.0))


def derive(case: Case, knob: GeneralKnob, engine: GeneralEngine, one: Attractor) -> None:
    """Solve a proven cycle again: its error, margin, measures and energy."""
    solved = solve(case.scene, case.rate_hz, None, knob, one)
    assert solved.closes, f"does not close: {case}"
    off = float(abs(solved.run.states[0][0] / mp.mpf(knob.quantum_rad) - mp.mpf(one.x)))
    assert off <= one.bound, f"{off:.3g} off, bound {one.bound:.3g}: {case}"
    jump = min(solved.control.edge_distance(z[0]) for z in solved.run.states) / knob.quantum_rad
    assert one.margin <= jump + one.bound, case
    found, expected = GeneralMeasurer(knob, engine).measure(one), measure(solved)
    for name in ("p2p_rad", "min_rad", "max_rad", "rms_rad", "frequency_hz", "wall_work_j", "damping_loss_j"):
        size = float(expected["wall_work_j"] if name.endswith("_j") else abs(expected[name]))
        assert float(abs(getattr(found, name) - expected[name])) <= RELATIVE * size, (name, case)
    assert abs(found.wall_work_j - found.damping_loss_j) <= RELATIVE * found.damping_loss_j, case


def stays(case: Case, knob: GeneralKnob, one: Attractor) -> None:
    """A rest that is proven: the model stays there when put there, without a torque under way."""
    angle = float(knob.angle_rad(one.x))
    held = case._replace(angle=angle, velocity=0.0, samples=40)
    trial = reference.simulate(held.scene, **{**held.arguments, "phase": 1e-12})
    far = max(abs(float(sample.angle) - angle) for sample in trial.samples)
    assert far <= 1e-9 + 1e-9 * abs(angle), (far, case)


def check(seeds: range) -> Counter[str]:
    found: Counter[str] = Counter()
    engine = interpreted()
    for seed in seeds:
        case = buzzing(seed)
        knob, one = settle(case, engine)
        found[f"{one.outcome.name}{'' if one.certified else ', not proven'}"] += 1
        if one.outcome is Outcome.CYCLE and one.certified and one.period <= 40:
            derive(case, knob, engine, one)
            found["bent" if bends(knob.wall) > 0.0 else "straight"] += 1
        if one.outcome is Outcome.REST and one.certified and knob.body.order == 2 and not knob.delay_line:
            stays(case, knob, one)
            found["stays"] += 1
    return found


@pytest.mark.long
def test_proven_orbits_and_rests_are_those_of_the_model() -> None:
    found = check(range(60))
    assert found["bent"] >= 3, found
    assert found["straight"] >= 2, found
    assert found["stays"] >= 15, found


@pytest.mark.long
@pytest.mark.drawn(9)
@pytest.mark.parametrize("first", range(60, 600, 30))
def test_many_proven_orbits_and_rests(first: int) -> None:
    found = check(range(first, first + 30))
    assert found["stays"] >= 2, found


def test_friction_beside_it_brings_the_knob_to_rest() -> None:
    """Held, or creeping up to where it can be held, on a slope or beside: where the model's knob comes to rest, too."""
    engine, found = interpreted(), Counter[str]()
    for seed in range(40):
        chance, case = Random(f"rubbing {seed}"), bare(seed + 1000)
        hand = {"inertia": 3e-7, "damping": 10.0 ** chance.uniform(-3.5, -2.3), "stiffness": chance.choice([0.04, 0.3])}
        knob = {"inertia": 1.98e-6, "coulomb_torque": 10.0 ** chance.uniform(-4.5, -3.0)}
        plain = {name: part for name, part in case.scene.items() if name != "actuator"}
        case = case._replace(scene={**plain, "hand": hand, "knob": knob}, rate_hz=1000.0, samples=400, phase=0.5)
        made, one = settle(case, engine)
        found[f"{one.outcome.name}, {one.reason.name}"] += 1
        if one.outcome is not Outcome.REST or not one.certified:
            continue
        trial = reference.simulate(case.scene, **case.arguments)
        last = [float(sample.angle) / made.quantum_rad for sample in trial.samples[-40:]]
        moves = max(last) - min(last)
        if trial.friction.closest < 1e-9 or moves > 1e-3 or trial.edge < 1e-9:
            found["not told"] += 1
            continue
        assert abs(last[-1] - one.x) <= LEFT * moves + 1e-6 * (1.0 + abs(one.x)), (seed, last[-1], one.x)
        found["rests"] += 1
    assert found["rests"] >= 15, found


def follow(knob: GeneralKnob, z: list[float], before: float, ring: list[float], samples: int) -> list[list[float]]:
    """States at the samples of a motion, and one more."""
    wall, head, pad = as_list(knob.wall), 0, [0.0] * (2 * knob.body.order)
    z, ring, seen = list(z), list(ring), []
    for _ in range(samples):
        seen.append(list(z))
        before, head = advance(z, before, ring, head, knob.body, wall, pad)
    return [*seen, list(z)]


def displaced(case: Case, knob: GeneralKnob, one: Attractor) -> Counter[str]:
    """Try to prove the orbit from ever farther trials. Where it is proven, the trial keeps near, and comes to it."""
    found: Counter[str] = Counter()
    chance, n, period = Random(case.name), knob.body.order, one.period
    wall, start = as_list(knob.wall), [one.x, one.v, *one.state]
    orbit = follow(knob, start, one.before, list(one.line), period)
    for power in np.arange(-9.0 + chance.choice([0.0, 0.5]), 3.0):
        z = [value + 10.0**power * chance.uniform(-1.0, 1.0) for value in start]
        space = make_space(n, knob.delay_line, lambda count: [0.0] * count)
        before = one.before if one.line else z[0]
        status, _, _, _, _ = certify(z, before, list(one.line), 0, period, knob.body, wall, space)
        away = abs(space.orbit[0] - one.x)
        if status != PROVEN or away > 1e-6 * (1.0 + abs(one.x)):
            found["other" if status == PROVEN else "far"] += 1
            continue
        turns = follow(knob, z, before, list(one.line), LONG * period)
        far = np.array([abs(turns[i][0] - orbit[i % period][0]) for i in range(LONG * period)])
        reach = np.array(space.trail[:period])
        allowed = 2.0 * reach[np.arange(LONG * period) % period] + 1e-12 * (1.0 + abs(one.x))
        assert (far <= allowed).all(), (case, power)
        assert far[-period:].max() <= 0.3 * max(far[:period].max(), 1e-9) + 1e-11 * (1.0 + abs(one.x)), (case, power)
        for x, place in zip(turns[: 2 * period], np.tile(orbit[:period], (2, 1)), strict=True):
            assert read(x[0], wall) == x[0]
            assert abs(x[0] - place[0]) <= 1e3
        found["proven"] += 1
    return found


@pytest.mark.long
def test_what_is_proven_to_come_to_an_orbit_comes_to_it() -> None:
    """From as far as the proof reaches, which is nowhere so far that it goes elsewhere."""
    engine, found, bent = interpreted(), Counter[str](), 0
    for seed in range(40):
        case = buzzing(seed)
        knob, one = settle(case, engine)
        if one.certified and one.period <= 12 and not (one.outcome is Outcome.REST and knob.body.friction > 0.0):
            seen = displaced(case, knob, one)
            bent += seen["proven"] if bends(knob.wall) > 0.0 else 0
            found += seen
    assert bent >= 30, (bent, found)
    assert found["proven"] >= 100, found
    assert found["far"] >= 50, found


def test_a_motion_at_rest_is_no_cycle() -> None:
    """However many samples are said to be its period."""
    case = Case("rest", scene(wall={"stiffness": 0.0}, encoder="none", detents={"torque": 5e-3, "per_revolution": 24}))
    knob, one = settle(case._replace(counts=None, angle=0.05), interpreted())
    assert (one.outcome, one.period) == (Outcome.REST, 1)
    for period, expected in ((1, PROVEN), (2, DIFFERENT), (7, DIFFERENT)):
        space = make_space(2, 0, lambda count: [0.0] * count)
        status, *_ = certify([one.x, 0.0], one.x, [], 0, period, knob.body, as_list(knob.wall), space)
        assert status == expected


def test_a_continuous_sensor_beside_what_needs_no_counts() -> None:
    """Scenes with three parts or more, as `random_scenes` compares them; interpreted, as so few are."""
    found = [composed(bared(number), in_code=False) for number in (2, 10, 17, 24, 30)]
    assert sum(one.settled for one in found) >= 4


@pytest.mark.long
@pytest.mark.drawn(3)
@pytest.mark.parametrize("first", range(100, 180, 10))
def test_many_scenes_with_a_continuous_sensor(first: int) -> None:
    found = [composed(bared(number)) for number in range(first, first + 10)]
    assert found


@pytest.mark.long
def test_compiled_to_the_last_bit() -> None:
    """Compiled and interpreted, a curve is the same arithmetic, its sines included."""
    engines = GeneralEngine(compiled("general")), interpreted()
    for seed in range(40):
        case = buzzing(seed)
        ours, theirs = (settle(case, engine) for engine in engines)
        assert ours[1] == theirs[1], case
