"""A continuous sensor beside cogging, teeth with play, and a sample clock that jitters: what is proven is so.

Cycles on one slope, or one flank, are derived again at 60 digits; and a trial from anywhere that the proof reaches
keeps near and comes to the orbit. Rest beside a clock that jitters is tried by the worst of some intervals.
"""

from collections import Counter
from random import Random

import pytest

from hknob_cli.engine.general.advance import advance_span
from hknob_cli.engine.general.controller import command, edge_gap
from hknob_cli.engine.general.inner_region import spring_of_command
from hknob_cli.engine.general.interval import SHORTEST
from hknob_cli.engine.general.search import as_list
from hknob_cli.engine.general.standstill import comes_to_rest
from hknob_cli.engine.outcome import Outcome, Reason

from .general_scenes import Case, scene
from .test_continuous_over_angle import derive, displaced, interpreted, sampled, settle


def driven(seed: int) -> Case:
    """A scene that buzzes about a jump of its torque, or by its delay: odd ones with cogging, even ones with teeth."""
    chance = Random(f"slopes {seed}")
    actuator = chance.choice(
        [
            {"dead_band": 10 ** chance.uniform(-3, -2.4)},
            {"torque_step": 10 ** chance.uniform(-4.3, -3.0)},
            {"torque_limit": chance.uniform(0.002, 0.006)},
            {"delay_samples": 1.0},
        ]
    )
    parts: dict[str, object] = {"encoder": "none", "actuator": actuator}
    if seed % 2:
        parts["cogging"] = {
            "torque": 10 ** chance.uniform(-4.5, -2.7),
            "per_revolution": chance.choice([12, 24, 42]),
            "centre": chance.uniform(-0.1, 0.1),
        }
    else:
        parts["gear"] = {
            "ratio": 2.5,
            "motor_inertia": 10 ** chance.uniform(-9, -7.5),
            "stiffness": chance.choice([1.0, 5.0]),
            "mesh_damping": chance.choice([2e-3, 1e-2]),
            "backlash": 2e-3,
        }
    rate = chance.choice([200.0, 464.0, 1000.0])
    return Case(f"slopes {seed}", scene(**parts), rate, None, angle=0.02, velocity=-0.2)


def check(seeds: list[int]) -> Counter[str]:
    """Derive proven cycles, and try how far their proofs and those of rests reach."""
    found: Counter[str] = Counter()
    engine = interpreted()
    for seed in seeds:
        case = driven(seed)
        knob, one = settle(case, engine)
        found[one.reason.name] += 1
        if one.outcome is Outcome.CYCLE and one.certified and one.period <= 40:
            derive(case, knob, engine, one)
            found["derived"] += 1
        if one.certified and one.period <= 12:
            found += displaced(case, knob, one)
    return found


@pytest.mark.long
def test_proven_beside_cogging() -> None:
    """And not proven where a corner is passed."""
    found = check([9, 11, 13, 15, 17, 19, 25, 31, 33])
    assert found["derived"] >= 5, found
    assert found["proven"] >= 15, found
    assert found["COGS"] >= 2, found


@pytest.mark.long
def test_proven_beside_teeth_that_press() -> None:
    """And not proven where they part."""
    found = check([16, 24, 34])
    assert found["derived"] >= 2, found
    assert found["PARTS"] >= 1, found


@pytest.mark.long
@pytest.mark.drawn(15)
@pytest.mark.parametrize("seed", [*range(41, 121, 2), 18, 36, 38, 40, 42])
def test_more_proven_beside_cogging_and_teeth(seed: int) -> None:
    assert check([seed])


FIRM = {"inertia": 3e-7, "damping": 1.2e-3, "stiffness": 0.3}
BESIDE = {
    "wall": {},
    "wall, spring detents": {"detents": {"per_revolution": 24, "torque": 2e-3, "shape": "spring"}},
    "triangles": {"wall": {"stiffness": 0.0}, "detents": {"per_revolution": 12, "torque": 4e-3, "shape": "triangle"}},
    "stops": {"wall": {"stiffness": 0.0}, "end_stops": {"low": -0.01, "high": 0.5, "stiffness": 0.2}},
    "profile": {"wall": {"stiffness": 0.0}, "profile": {"points": [[-0.3, 0.012], [0.01, -0.001], [0.3, 0.004]]}},
}


@pytest.mark.one_in(14)
@pytest.mark.parametrize("jitter", [0.05, 0.33, 0.9])
@pytest.mark.parametrize("name", BESIDE)
def test_rest_whatever_the_intervals_are(name: str, jitter: float) -> None:
    """From where rest is proven, under intervals that are long or short as the energy would have it least."""
    case = Case(name, scene(encoder="none", clock={"jitter": jitter}, **BESIDE[name]), 1000.0, None, angle=0.02)
    knob, one = settle(case, interpreted())
    assert (one.outcome, one.certified) == (Outcome.REST, True)
    body, wall, chance = knob.body, as_list(knob.wall), Random(name)
    spring = spring_of_command(one.x, wall)
    assert body.alpha > 0.5 * spring
    stiffness, rest, tried = body.beta + spring, one.x, 0
    for _ in range(60):
        far = 10.0 ** chance.uniform(-3.0, 1.5)
        z = [rest + chance.uniform(-far, far), chance.uniform(-far, far) * stiffness**0.5]
        orbit = [0.0, 0.0]
        rests, gap = comes_to_rest(z, z[0], command(z[0], z[0], wall), body, wall, 0, orbit)
        if not rests:
            continue
        tried += 1
        assert abs(orbit[0] - rest) <= 1e-9 * (1.0 + abs(rest))
        assert gap == pytest.approx(edge_gap(rest, rest, rest, wall))
        first = energy = (z[0] - rest) ** 2 * stiffness + z[1] ** 2
        for _ in range(2000):
            ends = []
            for span in (wall.clock[SHORTEST], 1.0, chance.uniform(wall.clock[SHORTEST], 1.0)):
                end = list(z)
                advance_span(end, command(z[0], z[0], wall), span, body, [0.0] * 4)
                ends.append(((end[0] - rest) ** 2 * stiffness + end[1] ** 2, end))
            after, z = max(ends)
            assert after <= energy * (1.0 + 1e-9) + 1e-18
            assert abs(z[0] - rest) < gap
            energy = after
            if energy <= 1e-5 * first:
                break
        assert energy <= 1e-3 * first + 1e-18
    assert tried >= 15


@pytest.mark.parametrize(
    "parts",
    [
        {"actuator": {"delay_samples": 1.0}, "hand": FIRM},
        {"actuator": {"time_constant": 2e-4}},
        {"wall": {"damping": 1e-5}},
        {"wall": {"stiffness": 0.0}, "detents": {"per_revolution": 12, "torque": 4e-3}},
    ],
)
def test_other_rests_beside_jitter_are_seen(parts: dict[str, object]) -> None:
    """A delay, a lag, virtual damping, a torque that bends: the knob stands still, which is labelled."""
    case = Case("seen", scene(encoder="none", clock={"jitter": 0.2}, **parts), 1000.0, None, angle=0.02)
    _, one = settle(case, interpreted())
    assert (one.outcome, one.reason) == (Outcome.REST, Reason.JITTERS)
    assert not one.certified


def test_a_spring_that_outweighs_the_damping_is_not_proven_to_rest() -> None:
    """Where half of it, held for the longest interval, is more than the damping: whatever the motion does."""
    for jitter, proven in ((0.05, True), (0.9, False)):
        hand = {"inertia": 3e-7, "damping": 1.9e-4, "stiffness": 0.04}
        parts = scene(encoder="none", clock={"jitter": jitter}, hand=hand)
        case = Case("stiff", parts, 1000.0, None, angle=0.02)
        knob = sampled(case)
        passive = knob.body.alpha > 0.5 * knob.wall.kappa
        assert passive == proven
        z = [-3.0, 0.0]
        u = command(z[0], z[0], knob.wall)
        assert comes_to_rest(z, z[0], u, knob.body, knob.wall, 0, [0.0, 0.0])[0] == proven
