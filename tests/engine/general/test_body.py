"""A body's rates, energies and distances, worked out by hand in numbers that a double holds."""

from math import inf, sqrt
from random import Random
from typing import Any

import pytest

from hknob_cli.engine.general.body import (
    CONSTANT,
    CONSTANT_HELD,
    ENTRY,
    HELD,
    RATES,
    Body,
    acceleration,
    coil_at,
    copy_to,
    distance,
    norm,
    norm_at,
    rate_of,
    stiffness,
    turn_finger,
)

from .bodies import knob

PLAIN = knob().body._replace(order=2, friction=0.0, alpha=0.5, beta=0.25, coil=0.0, lag=0.0, reach=2.0)
FINGER = PLAIN._replace(
    order=4, beta=0.0, ratio=4.0, pad_stiffness=2.0, pad_damping=0.25, finger_stiffness=8.0, finger_damping=0.125
)


def numbered(order: int, **more: Any) -> tuple[Body, Random]:
    """A body whose matrices and vectors are whole numbers."""
    chance = Random(order)
    matrices = [float(chance.randrange(-9, 10)) for _ in range(2 * order * order)]
    vectors = [float(chance.randrange(-9, 10)) for _ in range(3 * order)]
    return PLAIN._replace(order=order, matrices=matrices, vectors=vectors, drive=-3.0, friction=2.0, **more), chance


@pytest.mark.parametrize("order", [2, 3, 5])
@pytest.mark.parametrize("lag", [0.0, 0.5, 4.0])
def test_a_rate_is_that_of_its_mode(order: int, lag: float) -> None:
    """A z + c + p u less friction; held, by its own A and c. A lag takes the command, and friction acts at once."""
    body, chance = numbered(order, lag=lag)
    n = order
    for _ in range(5):
        z, u = [float(chance.randrange(-9, 10)) for _ in range(n)], float(chance.randrange(-9, 10))
        for mode, friction in ((1, -2.0), (-1, 2.0), (0, 0.0), (2, 0.0)):
            out = [99.0] * (n + 1)
            rate_of(z, u, mode, body, out)
            pull = (0.0 if lag else u) + friction
            expected = []
            for i in range(n):
                row = (RATES if mode else HELD) * n * n + i * n
                own = sum(a * x for a, x in zip(body.matrices[row : row + n], z, strict=True))
                entry = body.vectors[ENTRY * n + i] * pull if mode else 0.0
                expected.append(own + body.vectors[(CONSTANT if mode else CONSTANT_HELD) * n + i] + entry)
            expected[-1] += lag * u
            assert out == [*expected, 99.0]
        own = sum(a * x for a, x in zip(body.matrices[n : 2 * n], z, strict=True))
        assert acceleration(z, u, body) == own - 3.0 + (0.0 if lag else u)


def test_a_state_is_copied_whole() -> None:
    target = [7.0] * 4
    copy_to(target, [1.0, 2.0, 3.0])
    assert target == [1.0, 2.0, 3.0, 7.0]


def test_a_winding_stands_behind_knob_and_finger() -> None:
    assert coil_at(PLAIN) == 2
    assert coil_at(FINGER) == coil_at(FINGER._replace(ratio=0.5)) == 4


def test_the_energy_of_a_difference_is_that_of_all_springs_and_masses() -> None:
    """v^2 + x^2 / 4. A finger at 2 + 2, off by 3 - 1/2: 4 + 1/2 + (16 + 8 x 6.25) / 4. A lag adds 6 to the root."""
    for dz, one, energy, late in (
        ([3.0, -2.0], PLAIN, 4.0 + 2.25, 0.0),
        ([3.0, -2.0, 9.0], PLAIN._replace(order=3), 4.0 + 2.25, 0.0),
        ([3.0, -2.0, 4.0], PLAIN._replace(order=3, coil=0.5), 4.0 + 2.25 + 8.0, 0.0),
        ([3.0, -2.0, 4.0, -3.0], PLAIN._replace(order=4, coil=0.5, lag=0.5), 4.0 + 2.25 + 8.0, 6.0),
        ([3.0, -2.0, -3.0], PLAIN._replace(order=3, lag=4.0), 4.0 + 2.25, 0.75),
        ([3.0, 2.0, 0.5, -2.0], FINGER, 4.0 + 0.5 + 66.0 / 4.0, 0.0),
        ([3.0, 2.0, 0.5, -2.0], FINGER._replace(ratio=0.5), 4.0 + 0.5 + 132.0, 0.0),
        ([3.0, 2.0, 0.5, -2.0, 3.0], FINGER._replace(order=5, lag=0.5), 4.0 + 0.5 + 66.0 / 4.0, 6.0),
        ([3.0, 2.0, 0.5, -2.0, 4.0, 3.0], FINGER._replace(order=6, coil=2.0, lag=0.5), 21.0 + 32.0, 6.0),
    ):
        for sign in (1.0, -1.0):
            turned = [sign * x for x in dz]
            assert norm(turned, one) == sqrt(energy) + late
            assert norm_at([5.0, 5.0, *turned], 2, one) == sqrt(energy) + late


def test_positions_come_as_far_apart_as_the_energy_allows() -> None:
    """Without spring and friction by the speed over the damping, or for ever."""
    assert distance([3.0, -2.0], PLAIN) == 2.0 * 2.5
    for friction in (0.5, 2.0):
        assert distance([3.0, -2.0], PLAIN._replace(beta=0.0, friction=friction)) == 2.0 * 2.0
    free = PLAIN._replace(beta=0.0)
    for dz in ([3.0, -2.0], [-3.0, 2.0]):
        assert distance(dz, free) == 3.0 + 4.0
        assert distance(dz, free._replace(alpha=4.0)) == 3.0 + 0.5
    assert distance([3.0, -2.0], free._replace(alpha=0.0)) == inf
    assert distance([3.0, -2.0, 3.0], free._replace(order=3, lag=4.0)) == 2.0 * 2.75
    assert distance([3.0, 2.0, 0.5, -2.0], FINGER) == 2.0 * sqrt(21.0)


def test_springs_and_dampers_bound_the_acceleration() -> None:
    """By the root of the energy: 1/2 + 1/2; 1/2 + 1/4 (1 + 2) + sqrt(2) with a finger; and a winding's spring."""
    assert stiffness(PLAIN) == 1.0
    assert stiffness(FINGER) == 0.5 + 0.75 + sqrt(2.0)
    assert stiffness(FINGER._replace(ratio=0.25)) == 0.5 + 0.375 + sqrt(2.0)
    for coil in (4.0, 0.25):
        assert stiffness(PLAIN._replace(coil=coil)) == 1.0 + sqrt(coil)
        assert stiffness(FINGER._replace(coil=coil)) == 0.5 + 0.75 + sqrt(2.0) + sqrt(coil)


def test_a_finger_that_goes_the_other_way_has_most_energy() -> None:
    """Of all differences whose numbers are as large: against all signs."""
    chance = Random(3)
    for _ in range(20):
        sizes = [chance.uniform(0.0, 2.0) for _ in range(4)]
        most = max(
            norm([a * sizes[0], b * sizes[1], c * sizes[2], d * sizes[3]], FINGER)
            for a in (1, -1) for b in (1, -1) for c in (1, -1) for d in (1, -1)
        )  # fmt: skip
        turned = list(sizes)
        turn_finger(turned, FINGER._replace(ratio=0.5) if sizes[0] < 1.0 else FINGER)
        assert turned == [sizes[0], sizes[1], -sizes[2], -sizes[3]]
        assert norm(turned, FINGER) == pytest.approx(most, rel=1e-15)
        turn_finger(turned, FINGER)
        assert turned == sizes
        turn_finger(turned, PLAIN._replace(order=4))
        assert turned == sizes
