"""Bounds for every clock, against clocks that are chosen to break them.

Ranges of motions under adversarial intervals never exceed the bound, and come near it where it is tight; where the
bound is 0, all of them come to rest.
"""

from random import Random
from typing import Any

import numpy as np
import pytest

from hknob_cli.engine.attractors import NeedsCompilerError
from hknob_cli.engine.general.search import as_compiled
from hknob_cli.engine.jit import compiled
from hknob_cli.measure.growth import clock_bound_rad
from hknob_cli.scene.general_knob import GeneralKnob
from hknob_cli.specs.plan import Starts
from tests.engine.general.test_clock_cells import PLAIN, follow_cells, ringed

from .clock_adversary import play
from .general_scenes import GRASP, scene
from .test_jitter import knob_of, with_clock

FIRM = {"inertia": 3.0e-7, "damping": 3.45e-3, "stiffness": 0.3}


def bound_of(knob: GeneralKnob, angle: float = 0.02, velocity: float = 0.0, seconds: float | None = None) -> Any:
    """The bound from one start, counts."""
    starts = Starts(angle=angle, velocity=velocity, phases=1)
    found = clock_bound_rad(knob, starts, compiled("general"), seconds=seconds)
    return None if found is None else found / knob.quantum_rad


@pytest.mark.one_in(4)
@pytest.mark.parametrize(
    ("jitter", "rate", "counts", "tight"),
    [(0.01, 1000.0, 1024, 0.9), (0.05, 1000.0, 1024, 0.8), (0.2, 1000.0, 1024, 0.65), (0.05, 464.0, 1024, 0.6)],
)
def test_no_clock_exceeds_the_bound(jitter: float, rate: float, counts: int, tight: float) -> None:
    """And one comes near it: so near as was found once, less a little."""
    knob = knob_of(with_clock(scene(), jitter), rate, counts)
    start = knob.start(0.02, 0.0)
    bound = bound_of(knob)
    assert bound is not None
    worst = float(play(knob, start, rules=4000, samples=2000).ranges.max())
    assert tight * bound < worst <= bound


@pytest.mark.long
def test_a_wider_range_of_intervals_has_no_smaller_worst_case() -> None:
    found = []
    for jitter in (0.02, 0.2, 0.5):
        knob = knob_of(with_clock(scene(), jitter))
        bound = bound_of(knob)
        assert bound is not None
        found.append(bound * knob.quantum_rad)
    assert found == sorted(found)
    assert found[2] > 1.5 * found[0]


def random_cell(number: int) -> tuple[GeneralKnob, float, float]:
    """A plain linear scene with a clock that jitters, and a start."""
    chance = Random(f"every clock {number}")
    grip = chance.random()
    parts: dict[str, Any] = {
        "hand": chance.choice(
            [GRASP, {"inertia": 3e-7, "damping": 2e-4 + 2e-3 * grip, "stiffness": 0.02 + 0.3 * grip}]
        ),
        "wall": {"stiffness": chance.choice([0.1, 0.27, 0.5])},
        "bias": {"torque": chance.uniform(2e-4, 2e-3)},
    }
    more: list[dict[str, Any]] = [
        {},
        {"encoder": {"rounding": chance.choice(["nearest", "ceil", "truncate"]), "offset_counts": chance.random()}},
        {"actuator": {"torque_limit": chance.uniform(1e-3, 4e-3)}},
        {"actuator": {"torque_step": 3e-4, "dead_band": 5e-4}},
        {"detents": {"per_revolution": 60, "torque": 1e-3}},
    ]
    made = with_clock(scene(**{**parts, **more[number % len(more)]}), chance.choice([0.03, 0.1, 0.3]))
    knob = knob_of(made, chance.choice([464.0, 1000.0, 2154.0]), chance.choice([512, 1024, 2048]))
    return knob, chance.uniform(-0.01, 0.02), chance.uniform(-0.5, 0.5)


def check_random(number: int) -> str:
    """Whether a scene has a bound, rests, or neither; no clock disagrees."""
    knob, angle, velocity = random_cell(number)
    start, bound = knob.start(angle, velocity), bound_of(knob, angle, velocity)
    if bound is None:
        return "none"
    played = play(knob, start, rules=1500, samples=1600, seed=number)
    if bound == 0.0:
        assert np.abs(played.speeds).max() < 1e-6
        return "rests"
    assert float(played.ranges.max()) <= bound
    return "swings"


@pytest.mark.long
def test_random_scenes() -> None:
    found = [check_random(number) for number in range(8)]
    assert found.count("none") <= 2
    assert found.count("rests") >= 1
    assert found.count("swings") >= 4


@pytest.mark.long
@pytest.mark.drawn(3)
@pytest.mark.parametrize("first", range(8, 128, 15))
def test_many_random_scenes(first: int) -> None:
    for number in range(first, first + 15):
        check_random(number)


def test_a_firm_hand_rests_under_every_clock() -> None:
    """The plain trials say so of the intervals that are drawn; the bound of all."""
    knob = knob_of(with_clock(scene(hand=FIRM, bias={"torque": 1.8e-3}), 0.3))
    start = knob.start(0.02, 0.0)
    assert bound_of(knob) == 0.0
    assert np.abs(play(knob, start, rules=1000, samples=1000).speeds).max() < 1e-9


def test_a_range_of_starts_has_the_bound_of_all_of_them() -> None:
    knob = knob_of(with_clock(scene(), 0.05))
    span = (-0.005, 0.01, -0.2, 0.2)
    swing = clock_bound_rad(knob, Starts(0.0, 0.0, 1, span=span), compiled("general"))
    assert swing is not None
    bound = swing / knob.quantum_rad
    for angle in (-0.005, 0.0, 0.01):
        for velocity in (-0.2, 0.2):
            ranges = play(knob, knob.start(angle, velocity), rules=500, samples=1200).ranges
            assert float(ranges.max()) <= bound


@pytest.mark.parametrize(
    "more",
    [
        {"knob": {"coulomb_torque": 1e-5}},
        {"actuator": {"delay_samples": 1.0}},
        {"encoder": {"hysteresis_counts": 0.3}},
        {"wall": {"damping": 1e-6}},
        {"hand": None, "knob": {"damping": 2e-4}},
    ],
)
def test_more_than_this_is_built_for_has_no_bound(more: dict[str, Any]) -> None:
    knob = knob_of(with_clock(scene(**more), 0.05))
    assert bound_of(knob) is None


def test_a_knob_that_leaves_has_no_bound() -> None:
    """A wall far beyond what its damping allows: motions grow."""
    knob = knob_of(with_clock(scene(wall={"stiffness": 20.0}), 0.05))
    assert bound_of(knob) is None


@pytest.mark.parametrize("bias", [1e-3, 1.8e-3])
def test_compiled_cells_are_the_interpreted_ones(bias: float) -> None:
    """To the last bit."""
    knob, cells, begun = ringed(bias)
    plain = follow_cells(PLAIN, knob.body, knob.wall, cells, begun)
    wall = knob.wall._replace(clock=np.array(knob.wall.clock))
    boxes = np.zeros(len(cells.boxes), np.int64)
    grid = cells._replace(parts=np.array(cells.parts), boxes=boxes)
    in_code = follow_cells(compiled("general"), *as_compiled(knob.body, wall), grid, begun)
    for one, other in zip(plain, in_code, strict=True):
        np.testing.assert_array_equal(one, other)


def test_a_limit_of_time_leaves_no_bound() -> None:
    knob = knob_of(with_clock(scene(), 0.05))
    assert bound_of(knob, seconds=0.0) is None
    assert bound_of(knob._replace(wall=knob.wall._replace(clock=None))) is None


def test_the_interpreter_asks_for_the_compiler() -> None:
    knob = knob_of(with_clock(scene(), 0.05))
    with pytest.raises(NeedsCompilerError):
        clock_bound_rad(knob, Starts(0.02, 0.0, 1), None)
