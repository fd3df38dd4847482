"""The sampled plant, against the matrix exponential; ranges of stable gains, against Jury's table."""

from math import pi

import numpy as np
import pytest
from scipy.linalg import expm

from hknob_cli.theory.sampled_plant import is_stable, sampled_plant, stable_gains
from tests.theory.jury import stable_by_jury

BODIES = {
    "dissertation": {"inertia": 2.2e-6, "damping": 3.45e-4, "stiffness": 0.04},
    "wheel": {"inertia": 0.05, "damping": 0.8, "stiffness": 6.0},
    "free": {"inertia": 2.2e-6, "damping": 3.45e-4, "stiffness": 0.0},
    "bare": {"inertia": 2.2e-6, "damping": 0.0, "stiffness": 0.0},
    "overdamped": {"inertia": 2.2e-6, "damping": 3e-3, "stiffness": 0.04},
}


def response(body: dict[str, float], period: float, delay: float, omega: np.ndarray) -> np.ndarray:
    """From held torque to sampled angle, with a delay in samples: state space, with old torques as further states."""
    plant = np.array([[0.0, 1.0, 0.0], [-body["stiffness"], -body["damping"], 1.0], [0.0, 0.0, 0.0]])
    plant[1] /= body["inertia"]
    whole, part = int(delay), delay - int(delay)
    first, rest = expm(plant * part * period), expm(plant * (1.0 - part) * period)
    phi = rest[:2, :2] @ first[:2, :2]
    older, newer = rest[:2, :2] @ first[:2, 2], rest[:2, 2]
    z = np.exp(1j * np.asarray(omega))[:, None]
    state = np.linalg.solve(z[:, :, None] * np.eye(2) - phi, (newer + older / z)[:, :, None])
    return state[:, 0, 0] / z[:, 0] ** whole


@pytest.mark.parametrize("body", BODIES.values(), ids=BODIES)
@pytest.mark.parametrize("delay", [0.0, 0.3, 1.0, 2.75, 300.5])
@pytest.mark.parametrize("period", [1e-2, 1e-3, 1e-4])
def test_the_fraction_is_the_response_of_the_state_space(body: dict[str, float], delay: float, period: float) -> None:
    """The state space loses up to 1/(w^2) roundings at a low frequency: tolerance 1e-6 at w = 1e-3."""
    plant = sampled_plant(**body, period_s=period, transport_s=delay * period)
    for omega in (1e-3, 0.1, 1.0, 3.0, pi):
        at = np.array([omega])
        expected = complex(response(body, period, delay, at)[0])
        assert complex(plant.at(at)[0]) == pytest.approx(expected, rel=1e-6 if omega < 0.1 else 1e-9)


def test_at_standstill_the_hand_s_spring_holds() -> None:
    """H(1) = 1/k, however fast the clock."""
    for period in (1e-2, 1e-4, 1e-6):
        plant = sampled_plant(**BODIES["dissertation"], period_s=period, transport_s=0.4 * period)
        assert complex(plant.at(np.array([0.0]))[0]) == pytest.approx(1.0 / 0.04, rel=1e-12)


def in_z(polynomial: np.ndarray) -> np.ndarray:
    """A polynomial in w = z - 1 as one in z."""
    found = np.zeros(1)
    for coefficient in polynomial:
        found = np.polyadd(np.polymul(found, [1.0, -1.0]), [coefficient])
    return found


@pytest.mark.parametrize("seed", range(40))
def test_a_range_of_gains_ends_where_jury_s_table_says_unstable(seed: int) -> None:
    """Polynomials of degree 2 to 5 with stable roots, and a random direction: inside stable, beyond the ends not."""
    random = np.random.default_rng(seed)
    degree = int(random.integers(2, 6))
    fixed = np.poly(random.uniform(-0.95, 0.95, degree) - 1.0)
    added = random.normal(size=degree)
    grid = np.unique(np.concatenate([np.geomspace(1e-7, pi, 2000), np.linspace(1e-7, pi, 4000)]))
    found = stable_gains(fixed, added, grid, around=0.0)
    assert found is not None
    assert found[0] == 0.0
    top = min(found[1], 1e3)
    for share in (0.01, 0.3, 0.7, 0.999):
        assert stable_by_jury(in_z(np.polyadd(fixed, share * top * added)))
    if found[1] < 1e3:
        assert not stable_by_jury(in_z(np.polyadd(fixed, 1.001 * top * added)))


def test_no_gain_makes_a_double_integrator_stable() -> None:
    plant = sampled_plant(**BODIES["bare"], period_s=1e-3, transport_s=0.0)
    grid = np.linspace(1e-6, pi, 4000)
    assert stable_gains(plant.under, plant.over, grid, around=0.27) is None
    assert not is_stable(plant.under)
