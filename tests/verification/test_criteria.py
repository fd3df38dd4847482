"""The criteria of section 6.2 against motion: 10 % below a limit that promises it, every motion comes to rest.

Closer to the limit a motion dies too slowly to be seen. The loop without counts is iterated by its state space, that
with counts by the engine's own steps, interpreted.
"""

import numpy as np
import pytest
from scipy.linalg import expm

from hknob_cli.engine.loop import interval, level_of, make_loop, push
from hknob_cli.scene.plain_knob import sample_knob
from hknob_cli.specs.plan import Encoder, Hand, Knob, Scene, Wall
from hknob_cli.theory.criteria import CRITERIA, Case, case_of
from hknob_cli.theory.laws import WorkingEdge, working_edge
from tests.theory.test_laws import edge

LIGHT = edge(damping=1e-4, period_s=1e-3)
SLOW = edge(period_s=1.0 / 215.0)
PLANTS = {"dissertation": edge(), "slow": SLOW, "lightly damped": LIGHT}


def last_swing(plant: WorkingEdge, torque, *, bias: float, seed: int, samples: int) -> float:
    """Peak to peak of the last fifth over that of the first, of the knob on a wall of ``torque(angle)``."""
    random = np.random.default_rng(seed)
    matrix = np.array([[0.0, 1.0, 0.0], [-plant.hand_stiffness, -plant.damping, 1.0], [0.0, 0.0, 0.0]])
    matrix[1] /= plant.inertia
    flow = expm(matrix * plant.period_s)
    x, v = random.uniform(-0.05, 0.05), random.uniform(-1.0, 1.0)
    seen = []
    for _ in range(samples):
        u = torque(x) - bias
        x, v = flow[:2, 0] * x + flow[:2, 1] * v + flow[:2, 2] * u
        seen.append(x)
    fifth = samples // 5
    return float(np.ptp(seen[-fifth:]) / np.ptp(seen[:fifth]))


@pytest.mark.one_in(2)
@pytest.mark.parametrize("bias", [0.0, 1e-3])
@pytest.mark.parametrize("name", ["tsypkin", "tsai_colgate", "miller"])
@pytest.mark.parametrize("plant", PLANTS.values(), ids=PLANTS)
def test_below_a_limit_the_unilateral_wall_brings_the_knob_to_rest(plant: WorkingEdge, name: str, bias: float) -> None:
    stiffness = 0.9 * CRITERIA[name](Case(plant, plant.inertia, 1.0)).stiffness
    for seed in range(4):
        swing = last_swing(plant, lambda x: -stiffness * min(x, 0.0), bias=bias, seed=seed, samples=6000)
        assert swing < 1e-3


@pytest.mark.parametrize("plant", PLANTS.values(), ids=PLANTS)
def test_tsai_and_colgate_s_limit_is_close_to_where_a_pushed_knob_begins_to_swing(plant: WorkingEdge) -> None:
    """A push deep into the wall makes the loop linear there: beyond 1.5 times the limit it grows."""
    stiffness = 1.5 * CRITERIA["tsai_colgate"](Case(plant, plant.inertia, 1.0)).stiffness
    assert last_swing(plant, lambda x: -stiffness * min(x, 0.0), bias=1e-2, seed=1, samples=6000) > 0.1


@pytest.mark.parametrize("seed", range(4))
def test_miller_s_limit_is_about_the_steepest_place_of_a_curved_wall(seed: int) -> None:
    """A wall of random slopes up to 90 % of the limit, in any hand: another spring and more inertia change nothing."""
    random = np.random.default_rng(seed)
    steepest = 0.9 * CRITERIA["miller"](Case(edge(), 1.9e-6, 1.0)).stiffness
    places = np.linspace(0.0, 0.2, 40)
    torques = np.concatenate([[0.0], np.cumsum(random.choice([0.0, steepest], 39) * np.diff(places))])
    hand = edge(inertia=random.uniform(2e-6, 1e-5), hand_stiffness=random.uniform(0.0, 0.5))
    swing = last_swing(hand, lambda x: float(np.interp(-x, places, torques)), bias=2e-3, seed=seed, samples=12000)
    assert swing < 1e-3


@pytest.mark.parametrize(("rounding", "counts"), [("nearest", 512), ("ceil", 512), ("nearest", 4096)])
@pytest.mark.parametrize("seed", range(3))
def test_without_a_push_tsypkin_s_limit_with_counts_brings_the_knob_to_rest(
    rounding: str, counts: int, seed: int
) -> None:
    """And with the counts' first torque at the place of rest, by ``floor``, no stiffness does."""
    cell = {"sample_rate_hz": 1000.0, "counts_per_rev": counts}
    scene = Scene(knob=Knob(1.9e-6), wall=Wall(0.1), hand=Hand(3e-7, 3.45e-4, 0.04), encoder=Encoder(rounding=rounding))
    stiffness = 0.98 * CRITERIA["tsypkin"](case_of(scene, working_edge(scene, cell))).quantised
    scene = scene._replace(wall=Wall(stiffness))
    knob = sample_knob(scene, sample_rate_hz=1000.0, counts_per_rev=counts)
    loop = make_loop(*knob.loop[:7])
    random = np.random.default_rng(seed)
    x, v = random.uniform(-30.0, 30.0), random.uniform(-3.0, 3.0)
    for _ in range(4000):
        older, newer = push(level_of(x, loop.sense), [], 0, loop)
        x, v = interval(x, v, older, newer, loop)
    rest = -knob.shift
    assert abs(x - rest) < 1e-6
    assert abs(v) < 1e-6
