"""The target's wall: against whole numbers of any size, and the formula of docs/reference/wire.md."""

import math
import random

import pytest

from tests.hardware.firmware import library

EDGES = [-(2**31), -(2**31) + 1, -(2**30), -640_001, -640_000, -1025, -2, -1, 0, 1, 639_999, 640_000, 2**30, 2**31 - 1]


def angles(rng: random.Random, native: int, counts: int) -> list[int]:
    """Random ones, extreme ones, and those around edges of the decimated encoder."""
    edge = -(-rng.randrange(-4 * counts, 4 * counts) * native // counts)
    near = [edge + step for step in (-1, 0, 1)]
    return [
        *EDGES,
        *near,
        *(rng.randrange(-(2**31), 2**31) for _ in range(4)),
        *(rng.randrange(-9999, 9999) for _ in range(4)),
    ]


def test_decimation_is_the_floor_of_whole_numbers() -> None:
    rng = random.Random(3)
    for _ in range(3000):
        native = rng.choice([1, 2, 3, 360, 1000, 640_000, 2**31, 2**32 - 1, rng.randrange(1, 2**32)])
        counts = rng.choice([1, native, rng.randrange(1, native + 1), min(native, 1024)])
        for angle in angles(rng, native, counts):
            if -(2**31) <= angle < 2**31:
                assert library().wall_decimate(angle, counts, native) == angle * counts // native


def test_torque_is_the_formula_to_the_last_bit() -> None:
    rng = random.Random(4)
    for _ in range(5000):
        count, before = rng.randrange(-5000, 50), rng.randrange(-5000, 50)
        quantum, interval = math.tau / rng.randrange(1, 100_000), rng.choice([1e-3, 2.5e-4, 1 / 455])
        stiffness, damping = rng.uniform(0, 10), rng.choice([0.0, rng.uniform(0, 1e-3)])
        torque = library().wall_torque(count, before, 0.0, quantum, interval, stiffness, damping)
        expected = -stiffness * (count * quantum) - damping * ((count - before) * quantum) / interval
        assert torque == (expected if count < 0 else 0.0)


def test_outside_the_wall_there_is_no_torque_however_fast() -> None:
    assert library().wall_torque(0, -1000, 0.0, 0.01, 1e-3, 1.0, 1.0) == 0.0
    assert library().wall_torque(-1, 0, 0.0, 0.01, 1e-3, 1.0, 0.0) == 0.01


@pytest.mark.parametrize(
    ("torque", "cut"), [(2.0, 0.5), (-2.0, -0.5), (0.25, 0.25), (math.inf, 0.5), (-math.inf, -0.5)]
)
def test_the_limit_cuts_off_on_both_sides(torque: float, cut: float) -> None:
    assert library().wall_limit(torque, 0.5) == cut


def test_the_limit_does_not_hide_what_is_not_a_number() -> None:
    assert math.isnan(library().wall_limit(math.nan, 0.5))
