"""The fourth-order network of Hasser's section 4.4.1: Equation 1 in state-space form, against Equation 2 as printed.

The state is knob angle and velocity, finger angle and velocity; the input is the torque on the knob.
"""

from typing import Any

import numpy as np

from hknob_cli.page.claims.checks import check
from hknob_cli.page.claims.checks.arithmetic import Names, bound
from hknob_cli.page.claims.expression import evaluate
from hknob_cli.results.result_set import ResultSet

Matrix = np.ndarray[Any, np.dtype[np.float64]]


def network(parameters: dict[str, float]) -> tuple[Matrix, Matrix]:
    """Equation 1 as ``x' = A x + B T``: A [4, 4] and B [4] for J1, B1, K1, J2, B2, K2 in SI units."""
    j1, b1, k1, j2, b2, k2 = (parameters[name] for name in ("J1", "B1", "K1", "J2", "B2", "K2"))
    inertia = np.diag([j2, j1])
    damping = np.array([[b2, -b2], [-b2, b1 + b2]])
    stiffness = np.array([[k2, -k2], [-k2, k1 + k2]])
    rates = np.zeros((4, 4))
    for body, row in enumerate((1, 3)):
        rates[row - 1, row] = 1.0
        rates[row, 0::2] = -np.linalg.solve(inertia, stiffness)[body]
        rates[row, 1::2] = -np.linalg.solve(inertia, damping)[body]
    return rates, np.array([0.0, 1.0 / j2, 0.0, 0.0])


@check
def matrix_difference(_: ResultSet, *, printed: list[list[str]], where: Names) -> float:
    """Largest difference between a printed state matrix and Equation 1's, in % of the larger of the two elements."""
    names = bound(where)
    shown = np.array([[evaluate(element, names) for element in row] for row in printed])
    return _difference(shown, network(names)[0])


@check
def input_difference(_: ResultSet, *, printed: list[str], where: Names) -> float:
    """Largest difference between a printed input vector and Equation 1's, in % of the larger of the two elements."""
    names = bound(where)
    return _difference(np.array([evaluate(element, names) for element in printed]), network(names)[1])


def _difference(shown: Matrix, true: Matrix) -> float:
    scale = np.maximum(np.abs(shown), np.abs(true))
    return float(100.0 * np.max(np.abs(shown - true) / np.where(scale > 0.0, scale, 1.0)))


@check
def static_stiffness(_: ResultSet, *, where: Names) -> float:
    """Torque per angle (N·m/rad) of the knob held still, of the network of Equation 1."""
    rates, enters = network(bound(where))
    return float(-1.0 / np.linalg.solve(rates, enters)[0])


@check
def fitted_inertia(
    _: ResultSet, *, where: Names, pulse_torque: float, pulse_s: float, samples: int, sample_rate_hz: float
) -> float:
    """Inertia (kg·m²) that a second-order least-squares fit finds in the network's answer to a torque pulse.

    The motion is exact at the samples; angle, velocity and acceleration are fitted to the torque, as in section 4.2.3.
    """
    rates, enters = network(bound(where))
    values, vectors = np.linalg.eig(rates)
    step = 1.0 / sample_rate_hz
    hold = np.real(vectors @ np.diag(np.exp(values * step)) @ np.linalg.inv(vectors))
    push = np.linalg.solve(rates, (hold - np.eye(4)) @ enters)
    states, torques = np.zeros((samples, 4)), np.where(np.arange(samples) * step < pulse_s, pulse_torque, 0.0)
    for i in range(1, samples):
        states[i] = hold @ states[i - 1] + push * torques[i - 1]
    acceleration = states @ rates[1] + enters[1] * torques
    regressors = np.column_stack([acceleration, states[:, 1], states[:, 0]])
    return float(np.linalg.lstsq(regressors, torques, rcond=None)[0][0])
