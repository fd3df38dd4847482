"""Integrals of forms over a piece, against SciPy's quadrature of the motion by its matrix exponential."""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad_vec
from scipy.linalg import expm

from hknob_cli.measure.forms import generator, integrate, loss_form
from hknob_cli.scene.general_knob import sample_general
from hknob_cli.specs.scene import SceneSpec

FINGER = {
    "finger": {"inertia": 3e-7, "damping": 2.9e-3, "stiffness": 0.4},
    "fingerpad": {"damping": 3.8e-4, "stiffness": 0.05},
}
GRASP = {"inertia": 3.0e-7, "damping": 3.45e-4, "stiffness": 0.04}


@pytest.mark.parametrize("held", [False, True])
@pytest.mark.parametrize("duration", [1e-4, 0.37, 1.0])
@pytest.mark.parametrize(("hand", "lag"), [(GRASP, 1e-3), (FINGER, 0.0), (FINGER, 1e-3)])
def test_integrals(hand: dict[str, Any], lag: float, duration: float, held: bool) -> None:
    """Both to a few roundings of the integrals of absolute values; the quadrature is asked for 1e-13."""
    scene = {"knob": {"inertia": 1.9e-6}, "hand": hand, "wall": {"stiffness": 0.27}, "bias": {"torque": 0.001}}
    scene["actuator"] = {"time_constant": lag}
    plain = SceneSpec.model_validate(scene).plain()
    body = sample_general(plain, sample_rate_hz=1000.0, counts_per_rev=1024).body
    g, n, found = generator(body, held=held), body.order, integrate(body, duration, held=held)
    power = np.zeros_like(g)
    if lag:
        power[n - 1, 1] = 1.0

    def rates(t: float) -> np.ndarray:
        phi = expm(g * t)
        forms = [np.outer(phi[0], phi[0]), phi.T @ loss_form(body) @ phi, phi.T @ power @ phi]
        return np.concatenate([phi[0], *(form.ravel() for form in forms)])

    expected, _ = quad_vec(rates, 0.0, duration, epsabs=1e-15, epsrel=1e-13)
    got = np.concatenate([found.mean, found.square.ravel(), found.loss.ravel(), found.power.ravel()])
    size = max(float(np.abs(expected).max()), duration)
    assert got == pytest.approx(expected, rel=0, abs=1e-12 * size)
