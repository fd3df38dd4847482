"""The wall's describing function by quadrature, its limits, and its balance."""

from math import pi

import numpy as np
import pytest

from hknob_cli.engine.loop import Loop, drive_of, level_of
from hknob_cli.theory.relay import Relay, describing_function
from hknob_cli.theory.staircase import balanced, mean_and_gain, swings


def loop(*, kappa: float = 0.12, gamma: float = 0.06, sense: float = 1.0, offset: float = 0.0) -> Loop:
    return Loop(0.16, 0.018, kappa, gamma, sense, offset, 0.0, *[0.0] * 6)


@pytest.mark.parametrize(("sense", "offset"), [(1.0, 0.0), (-1.0, 0.0), (1.0, 0.3)])
@pytest.mark.parametrize(("amplitude", "mean"), [(0.4, -0.1), (3.7, -1.2), (25.0, 8.0), (2.0, 5.0), (0.3, -4.5)])
def test_mean_and_gain_by_quadrature(sense: float, offset: float, amplitude: float, mean: float) -> None:
    """The engine's own wall over 2^17 phases; steps in its torque leave an error of a phase each."""
    wall = loop(sense=sense, offset=offset)
    phase = (np.arange(1 << 17) + 0.5) * 2.0 * pi / (1 << 17)
    places = mean + amplitude * np.sin(phase)
    torques = np.array([drive_of(level_of(float(x), sense), wall) + wall.gamma for x in places])
    whole, gain = mean_and_gain(wall, amplitude, mean)
    error = 2.0 * wall.kappa * (2.0 * amplitude + 2.0) / (1 << 17) + 1e-12
    assert whole == pytest.approx(float(torques.mean()), abs=error)
    fundamental = -2.0 * float((torques * np.sin(phase)).mean())
    assert gain * amplitude == pytest.approx(fundamental, abs=4.0 * error)
    assert 2.0 * float((torques * np.cos(phase)).mean()) == pytest.approx(0.0, abs=4.0 * error)  # no memory


def test_beside_one_edge_with_half_a_step_s_push_it_is_the_relay() -> None:
    """A swing of less than a count, about the edge where push and spring balance: 4 M / pi |W|, M = kappa/2."""
    wall = loop()._replace(beta=0.018)
    (cycle,) = describing_function(Relay(wall.alpha, wall.beta, 1.0, 0.5), 1)
    (swing,) = swings(wall, 0.25 * pi * cycle.amplitude)
    assert swing.amplitude < 1.0
    assert swing.mean == pytest.approx(0.0, abs=1e-9)
    assert swing.amplitude == pytest.approx(0.5 * wall.kappa * cycle.amplitude, rel=1e-9)


def test_a_swing_over_many_counts_is_that_of_the_wall_without_counts() -> None:
    """A large motion in and out of the wall: half a rectified sine, whatever the counts."""
    wall = loop(gamma=3.0)
    for amplitude in (50.0, 400.0):
        mean = balanced(wall, amplitude)
        phase = (np.arange(1 << 14) + 0.5) * 2.0 * pi / (1 << 14)
        smooth = wall.kappa * np.maximum(0.5 - (mean + amplitude * np.sin(phase)), 0.0)  # a count on average
        whole, gain = mean_and_gain(wall, amplitude, mean)
        assert whole == pytest.approx(wall.gamma + wall.beta * mean, rel=1e-9)
        assert whole == pytest.approx(float(smooth.mean()), rel=0.02)
        assert gain == pytest.approx(-2.0 * float((smooth * np.sin(phase)).mean()) / amplitude, rel=0.02)


@pytest.mark.parametrize("response", [5.0, 12.0, 20.0])
def test_what_is_found_balances_and_falls(response: float) -> None:
    wall = loop(gamma=1.3)
    for swing in swings(wall, response):
        at = [
            mean_and_gain(wall, f * swing.amplitude, balanced(wall, f * swing.amplitude)) for f in (0.999, 1.0, 1.001)
        ]
        assert response * at[1][1] == pytest.approx(1.0, rel=1e-6)
        assert at[0][1] > at[1][1] > at[2][1]
        assert at[1][0] == pytest.approx(wall.gamma + wall.beta * swing.mean, rel=1e-6)
