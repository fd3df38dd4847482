"""Torque over the measured angle against the 60-digit model: random scenes sample by sample, and proven orbits.

The bounds are those of `test_general_trajectory`; the commands of a table add some roundings of the largest torque,
which the load of a step there counts in. Random scenes have friction, delay, lag, limits and steps of their own.
"""

from random import Random
from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.attractors import Patience
from hknob_cli.engine.general.controller import read
from hknob_cli.engine.general.search import GeneralEngine, as_list
from hknob_cli.engine.general.torque_table import run_at
from hknob_cli.engine.general.trace import Rows, run
from hknob_cli.engine.jit import compiled
from hknob_cli.engine.outcome import Outcome
from hknob_cli.measure.general_orbit import GeneralMeasurer
from hknob_cli.scene.general_knob import sample_general, simulate
from hknob_cli.specs.scene import SceneSpec
from tests import digits as mp

from . import general_reference as reference
from .general_orbits import measure, solve
from .general_scenes import Case, scene
from .test_general_trajectory import AWAY, bounds

SHAPES = ("sine", "triangle", "spring")


def random_part(chance: Random) -> dict[str, Any]:
    """One or two parts with a torque over the angle."""

    def profile() -> dict[str, Any]:
        number, kind = chance.randint(2, 6), chance.choice(["linear", "stepped"])
        angles = sorted(chance.uniform(-0.3, 0.3) for _ in range(number))
        torques = [chance.uniform(0.006, -0.006) for _ in range(number)]
        if chance.random() < 0.5:
            return {"points": [list(one) for one in zip(angles, torques, strict=True)], "interpolation": kind}
        times = chance.choice([1, 3, 24])
        span, first = 2.0 * np.pi / times, chance.uniform(-0.1, 0.1)
        shares = [0.0, *sorted(chance.random() for _ in range(number - 1)), 1.0]
        torques.append(torques[0])
        points = [[first + share * span, u] for share, u in zip(shares, torques, strict=True)]
        return {"points": points, "interpolation": kind, "periodic": True}

    def detents() -> dict[str, Any]:
        made: dict[str, Any] = {"torque": chance.uniform(0.001, 0.01), "shape": chance.choice(SHAPES)}
        if chance.random() < 0.7:
            made["per_revolution"] = chance.choice([6, 12, 24, 29])
        else:
            made |= {"spacing": chance.uniform(0.1, 0.3), "range": [-0.4, chance.uniform(0.0, 0.4)]}
        if made["shape"] == "spring":
            made["dead_zone"] = chance.choice([0.0, 0.03])
        if chance.random() < 0.5:
            made["centre"] = chance.uniform(-0.1, 0.1)
        return made

    def end_stops() -> dict[str, Any]:
        return {
            "low": -chance.uniform(0.0, 0.05),
            "high": chance.uniform(0.01, 0.05),
            "stiffness": chance.uniform(0.1, 0.5),
        }

    def dead_zone() -> dict[str, Any]:
        made = {"width": chance.uniform(0.0, 0.05), "stiffness": chance.uniform(0.1, 0.5)}
        return made | ({"torque": 0.004} if chance.random() < 0.5 else {})

    makers = {"profile": profile, "detents": detents, "end_stops": end_stops, "dead_zone": dead_zone}
    return {name: makers[name]() for name in chance.sample(list(makers), chance.choice([1, 1, 2]))}


def random_case(seed: int) -> Case:
    """A scene with a torque over the angle, and two or so of all that goes with it."""
    chance = Random(seed)
    actuator: dict[str, float] = {}
    parts: dict[str, Any] = {"wall": {"stiffness": chance.choice([0.0, 0.0, 0.27])}}
    if chance.random() < 0.5:
        parts["knob"] = {"coulomb_torque": chance.choice([5e-5, 5.6e-4])}
    if chance.random() < 0.5:
        actuator["delay_samples"] = chance.choice([1.0, 0.4, 2.3])
    if chance.random() < 0.3:
        actuator["time_constant"] = 3e-4
    if chance.random() < 0.2:
        actuator["torque_limit"] = 0.0041
    if chance.random() < 0.2:
        actuator["torque_step"] = 2.3e-4
    if chance.random() < 0.4:
        parts["encoder"] = {
            "rounding": chance.choice(["floor", "nearest", "ceil", "truncate"]),
            "offset_counts": chance.choice([0.0, 0.3]),
        }
    if actuator:
        parts["actuator"] = actuator
    return Case(
        f"seed {seed}",
        scene(**parts, **random_part(chance)),
        rate_hz=chance.choice([500.0, 1000.0, 2154.0]),
        counts=chance.choice([100, 256, 1024]),
        angle=chance.uniform(-0.2, 0.2),
        velocity=chance.uniform(-3.0, 3.0),
        phase=chance.uniform(0.1, 0.9),
        samples=120,
    )


def holds_to_the_bounds(case: Case) -> bool:
    """Run both and compare; False where a sample, a step or a standstill is too near to go one way for certain."""
    expected = reference.simulate(case.scene, **case.arguments)
    within = bounds(expected, case)
    closest = expected.friction.closest if expected.friction.bodies.friction else 1.0
    if not (expected.edge > AWAY * within.angle and expected.step > AWAY * within.command and closest > 1e-9):
        return False
    got = simulate(SceneSpec.model_validate(case.scene).plain(), **case.arguments)
    for name, bound in zip(("angle_rad", "velocity_rad_s", "torque_nm"), within, strict=False):
        exact = [getattr(sample, name.split("_")[0]) for sample in expected.samples]
        errors = [float(abs(mp.mpf(x) - y)) for x, y in zip(getattr(got, name), exact, strict=True)]
        assert max(errors) <= bound, f"{name} off by {max(errors):.3g}, bound {bound:.3g}: {case}"
    return True


def test_every_sample_of_random_scenes() -> None:
    compared = sum(holds_to_the_bounds(random_case(seed)) for seed in range(30))
    assert compared >= 24


@pytest.mark.long
def test_every_sample_of_many_random_scenes() -> None:
    compared = sum(holds_to_the_bounds(random_case(seed)) for seed in range(30, 400))
    assert compared >= 300


def check_orbits(case: Case) -> tuple[int, int]:
    """Solve again each proven cycle of a scene, and search for the runs of its samples: cycles, and rests checked."""
    made = SceneSpec.model_validate(case.scene).plain()
    knob = sample_general(made, sample_rate_hz=case.rate_hz, counts_per_rev=case.counts)
    engine = GeneralEngine(patience=Patience(samples=10**9, seconds=60.0))
    search = engine.search(
        knob.body,
        knob.wall,
        knob.start(case.angle, case.velocity),
        rate=knob.rate,
        phases=3,
        delay_line=knob.delay_line,
        max_samples=20_000,
    )
    cycles = rests = 0
    for one in search.attractors:
        if one.outcome is Outcome.REST and one.certified:
            rests += stays(case, knob, one)
        if one.outcome is not Outcome.CYCLE or not one.certified or one.period > 60:
            continue
        solved = solve(case.scene, case.rate_hz, case.counts, knob, one)
        assert solved.closes, f"does not close: {case}"
        unit = solved.control.quantum
        exact = [z[0] / unit - mp.mpf(knob.shift) for z in solved.run.states]
        n = knob.body.order
        states, torques = [0.0] * ((one.period + 1) * n), [0.0] * (one.period + 1)
        wall, state, line = as_list(knob.wall), [one.x, one.v, *one.state], list(one.line)
        run(state, one.before, line, 0, knob.body, wall, [0.0] * (2 * n), Rows(states, torques))
        gaps = []
        for x, y in zip(states[::n], exact, strict=True):
            size = float(np.ptp(states[::n]) + np.abs(states[::n]).max()) + max(map(abs, torques))
            assert abs(mp.mpf(x) - y) <= one.bound + 16.0 * 2.0**-53 * one.period * size, case
            shown = read(x, wall)
            low, high = run_at(shown, wall.table) if wall.damping == 0.0 else (shown, shown)
            over = solved.control.over_angle
            for end, beyond in ((low, -1), (high, 1)):
                if abs(end) < 1e9:  # the command changes there in the model, too, and nowhere between
                    assert torque(solved.control, over, int(end)) != torque(solved.control, over, int(end) + beyond)
            ends = [int(end) for end in (low, shown, high) if abs(end) < 1e9]
            assert len({torque(solved.control, over, end) for end in ends}) == 1
            gaps.append(min(abs(y - mp.nint(y)), mp.mpf(1)))
        assert one.margin >= float(min(gaps[:-1])) - 1e-9, case  # to a change of the command, which is never nearer
        found, expected = GeneralMeasurer(knob, engine).measure(one), measure(solved)
        for name in ("p2p_rad", "min_rad", "max_rad", "rms_rad", "frequency_hz", "wall_work_j", "damping_loss_j"):
            size = float(expected["wall_work_j"] if name.endswith("_j") else abs(expected[name]))
            assert float(abs(getattr(found, name) - expected[name])) <= 1e-9 * size, (name, case)
        cycles += 1
    return cycles, rests


def torque(control: Any, over: Any, count: int) -> float:
    """The model's torque at a count, of doubles: equal ones are equal to the last bit or differ by what is felt."""
    measured = (count + control.offset) * control.quantum
    return round(float(over(count) + (-control.stiffness * measured if measured < 0 else 0)) * 1e13)


def stays(case: Case, knob: Any, one: Any) -> int:
    """A rest that is proven: the model stays there for a while when put there, with what is under way."""
    angle = float(knob.angle_rad(one.x))
    held = case._replace(angle=angle, velocity=0.0, samples=40)
    if knob.body.order > 2 or knob.delay_line:
        return 0  # no command is under way where the model begins
    trial = reference.simulate(held.scene, **{**held.arguments, "phase": 1e-12})
    far = max(abs(float(sample.angle) - angle) for sample in trial.samples)
    assert far <= 1e-9 + 1e-9 * abs(angle), (far, case)
    return 1


@pytest.mark.long
def test_proven_orbits_of_random_scenes() -> None:
    seeds = range(1000, 1060)
    found = np.array([check_orbits(random_case(seed)) for seed in seeds]).sum(axis=0)
    assert found[0] >= 8, found
    assert found[1] >= 8, found


@pytest.mark.long
def test_proven_orbits_of_many_random_scenes() -> None:
    found = np.array([check_orbits(random_case(seed)) for seed in range(2000, 2400)]).sum(axis=0)
    assert found[0] >= 150, found
    assert found[1] >= 40, found


@pytest.mark.long
def test_compiled_to_the_last_bit() -> None:
    """Compiled and interpreted, a table is the same arithmetic; the code without tables is another."""
    engines = GeneralEngine(compiled("general")), GeneralEngine(patience=Patience(samples=10**9, seconds=60.0))
    for seed in range(1000, 1030):
        case = random_case(seed)
        made = SceneSpec.model_validate(case.scene).plain()
        knob = sample_general(made, sample_rate_hz=case.rate_hz, counts_per_rev=case.counts)
        ours, theirs = (
            engine.search(
                knob.body,
                knob.wall,
                knob.start(case.angle, case.velocity),
                rate=knob.rate,
                phases=3,
                delay_line=knob.delay_line,
                max_samples=20_000,
            )
            for engine in engines
        )
        assert ours == theirs, case
        for one in ours.attractors:
            if one.outcome is Outcome.CYCLE and one.period < 1000:
                measured = [repr(GeneralMeasurer(knob, engine).measure(one)) for engine in engines]
                assert measured[0] == measured[1], case
