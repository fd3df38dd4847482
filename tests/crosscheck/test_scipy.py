"""Orbits against SciPy: the sampled loop, integrated interval by interval, stays on them and finds the same peaks."""

from math import floor, pi

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from hknob_cli.stages.sweep.run import SweepStage
from tests.conftest import SPEC, loaded

J, B, K_HAND, K_WALL, BIAS = 2.2e-6, 3.45e-4, 0.04, 0.27, 0.001


def integrate(theta: float, omega: float, rate: float, quantum: float, samples: int) -> tuple[np.ndarray, list[float]]:
    """States at samples and the angles where the velocity vanishes, by DOP853 with events."""
    states, turns = [(theta, omega)], []
    for _ in range(samples):
        measured = quantum * floor(theta / quantum)
        torque = -K_WALL * measured if measured < 0 else 0.0

        def motion(_: float, s: np.ndarray, torque: float = torque) -> list[float]:
            return [s[1], (torque - BIAS - B * s[1] - K_HAND * s[0]) / J]

        def turn(_: float, s: np.ndarray) -> float:
            return s[1]

        done = solve_ivp(motion, (0, 1 / rate), [theta, omega], method="DOP853", rtol=1e-12, atol=1e-15, events=turn)
        turns += [float(state[0]) for state in done.y_events[0]]
        theta, omega = done.y[:, -1]
        states.append((theta, omega))
    return np.array(states), turns


@pytest.mark.parametrize(("rate", "counts"), [(215.0, 512), (1000.0, 1024), (1000.0, 8192), (4641.6, 2048)])
def test_orbits_are_orbits_of_the_integrated_loop(rate: float, counts: int) -> None:
    stage = SweepStage(loaded(SPEC.replace("[1000]", f"[{rate}]").replace("[1024]", f"[{counts}]")))
    result = stage.run_cell({"sample_rate_hz": rate, "counts_per_rev": counts})
    quantum = 2 * pi / counts
    for orbit, measures in zip(result.attractors, result.measures, strict=True):
        states, turns = integrate(orbit.x * quantum, orbit.v * quantum * rate, rate, quantum, orbit.period)
        # The integrator's own tolerance, per step, over the period.
        tolerance = 1e-10 * measures.p2p_rad + 1e-13 * orbit.period
        assert abs(states[-1] - states[0])[0] < tolerance
        assert len(turns) == 2 * measures.cycles
        assert max(turns) == pytest.approx(measures.max_rad, abs=tolerance)
        assert min(turns) == pytest.approx(measures.min_rad, abs=tolerance)
