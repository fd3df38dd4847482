"""The potential of an immediate wall, and the split of the leak, against sums over small steps."""

import numpy as np
import pytest

from hknob_cli.measure.leak import potential, split_leak

KAPPA = 1.7


@pytest.mark.parametrize("offset", [0.0, 0.3])
@pytest.mark.parametrize("analog", [False, True])
def test_potential_is_the_integral_of_the_torque(offset: float, analog: bool) -> None:
    """The torque at depth d is K (floor(d) + 1 - offset), or K d; a midpoint sum over steps within a count is exact."""
    offset = 0.0 if analog else offset
    step = 1.0 / 256.0
    middles = np.arange(step / 2, 5.0, step)
    torque = KAPPA * (middles if analog else np.floor(middles) + 1.0 - offset)
    depths = np.arange(0, 5.0 + step / 2, step)
    expected = np.concatenate([[0.0], np.cumsum(torque) * step])
    found = potential(depths, kappa=KAPPA, offset=offset, analog=analog)
    assert found == pytest.approx(expected, rel=0, abs=1e-12)
    assert (potential(-depths, kappa=KAPPA, offset=offset, analog=analog) == 0.0).all()


@pytest.mark.parametrize("edge", [0.0, -1.0])
@pytest.mark.parametrize("analog", [False, True])
def test_split_of_a_closed_walk(edge: float, analog: bool) -> None:
    """Straight steps cut so finely that none crosses an edge: each is late entry, late exit or staircase as a whole."""
    numbers = np.random.default_rng(3)
    x = np.append(numbers.integers(-4 * 64, 3 * 64, 30), 0) / 64.0
    x[-1] = x[0]
    torque = numbers.choice([0.0, 1.3, 2.9], 30)
    entry = leaving = staircase = 0.0
    for a, b, u in zip(x, x[1:], torque, strict=False):
        pieces = round(abs(b - a) * 64)
        for k in range(pieces):
            low, high = a + (b - a) * k / pieces, a + (b - a) * (k + 1) / pieces
            depth = edge - (low + high) / 2
            ideal = 0.0 if depth < 0.0 else KAPPA * (depth if analog else np.floor(depth) + 1.0)
            work = (u - ideal) * (high - low)
            if depth < 0.0:
                leaving += work
            elif u == 0.0:
                entry += work
            else:
                staircase += work
    found = split_leak(x, torque, edge=edge, kappa=KAPPA, offset=0.0, analog=analog)
    assert found == pytest.approx((entry, leaving, staircase), rel=0, abs=1e-11)
    assert sum(found) == pytest.approx(float((torque * np.diff(x)).sum()), rel=0, abs=1e-11)
