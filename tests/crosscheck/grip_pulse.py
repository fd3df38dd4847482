"""Hasser's Figs. 15 and 16: a 20 ms torque pulse on a hand of second and of fourth order, by SciPy's DOP853.

Section 4.4.1: a second-order fit (J, B_T, K_T) of the highest grip against the model of finger and fingerpad with
K1 = 10 K2, B1 = 10 B2 in series, K_T = K1 K2/(K1 + K2), B_T = B1 B2/(B1 + B2). His trial's own fit is not printed; the
means of Table 1 at 14.2 N stand in for it. Their J is of hand and apparatus together.
"""

from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import least_squares

INERTIA, DAMPING, STIFFNESS = 1.67e-6, 1.15e-3, 0.23  # Table 1, 14.2 N
FINGER_INERTIA, MOTOR_INERTIA = 3.0e-7, 1.98e-6
PULSE_S, PEAK_RAD = 0.02, 0.08
RATIO = 10.0


class Grip(NamedTuple):
    """Parts of the fourth-order model: finger to ground (1), fingerpad (2)."""

    finger_damping: float
    finger_stiffness: float
    pad_damping: float
    pad_stiffness: float


class Response(NamedTuple):
    """Responses to the same pulse of ``torque_nm``: angle [rad] and acceleration [rad/s^2] of the knob, and the finger.

    ``two``: second order with Table 1's inertia; ``bare``: with the motor's; ``four``: the knob of fourth order.
    """

    time_s: np.ndarray
    torque_nm: float
    two_rad: np.ndarray
    two_rad_s2: np.ndarray
    bare_rad: np.ndarray
    bare_rad_s2: np.ndarray
    four_rad: np.ndarray
    four_rad_s2: np.ndarray
    finger_rad: np.ndarray
    finger_rad_s2: np.ndarray


def grip() -> Grip:
    """Series springs and dampers that have the fit's own between knob and ground."""
    share = (1.0 + RATIO) / RATIO
    return Grip(RATIO * share * DAMPING, RATIO * share * STIFFNESS, share * DAMPING, share * STIFFNESS)


def _solve(matrix: np.ndarray, inertia: float, times: np.ndarray, torque: float) -> tuple[np.ndarray, np.ndarray]:
    """States and their rates at ``times``; the pulse acts on the second state's rate while t < ``PULSE_S``."""
    entry = np.zeros(len(matrix))
    entry[1] = 1.0 / inertia
    states = np.zeros((len(times), len(matrix)))
    start = np.zeros(len(matrix))
    inside = times < PULSE_S
    for chosen, span, push in (
        (inside, (0.0, PULSE_S), torque),
        (~inside, (PULSE_S, max(times[-1], 2 * PULSE_S)), 0.0),
    ):
        done = solve_ivp(
            lambda _, y, push=push: matrix @ y + entry * push,
            span,
            start,
            method="DOP853",
            t_eval=np.unique([*times[chosen], span[1]]),
            max_step=1e-4,
            rtol=1e-12,
            atol=1e-14,
        )
        states[chosen] = done.y.T[: chosen.sum()]
        start = done.y[:, -1]
    return states, states @ matrix.T + np.outer(inside * torque, entry)


def second_order(inertia: float, damping: float, stiffness: float) -> np.ndarray:
    """System matrix of (theta, omega)."""
    return np.array([[0.0, 1.0], [-stiffness / inertia, -damping / inertia]])


def fourth_order() -> np.ndarray:
    """System matrix of (theta_b, omega_b, theta_a, omega_a) from the network (Eq. 1; Eq. 2 misprints a sign)."""
    b1, k1, b2, k2 = grip()
    j1, j2 = FINGER_INERTIA, MOTOR_INERTIA
    return np.array(
        [
            [0.0, 1.0, 0.0, 0.0],
            [-k2 / j2, -b2 / j2, k2 / j2, b2 / j2],
            [0.0, 0.0, 0.0, 1.0],
            [k2 / j1, b2 / j1, -(k1 + k2) / j1, -(b1 + b2) / j1],
        ]
    )


def respond(times: np.ndarray) -> Response:
    """Both models at ``times`` [s], from 0 at rest; the pulse scaled so that the second-order peak is 0.08 rad."""
    dense = np.linspace(0.0, 0.06, 60_001)
    two = second_order(INERTIA, DAMPING, STIFFNESS)
    torque = PEAK_RAD / float(_solve(two, INERTIA, dense, 1.0)[0][:, 0].max())
    columns = []
    for matrix, inertia in (
        (two, INERTIA),
        (second_order(MOTOR_INERTIA, DAMPING, STIFFNESS), MOTOR_INERTIA),
        (fourth_order(), MOTOR_INERTIA),
    ):
        states, rates = _solve(matrix, inertia, times, torque)
        columns += [states[:, 0], rates[:, 1]]
        if len(matrix) == 4:
            columns += [states[:, 2], rates[:, 3]]
    return Response(times, torque, *columns)


def fitted() -> tuple[float, float, float]:
    """J, B, K of the second-order model whose angle is nearest, in least squares, to the fourth-order response."""
    times = np.linspace(0.0, 0.08, 801)
    response = respond(times)

    def residual(logs: np.ndarray) -> np.ndarray:
        inertia, damping, stiffness = np.exp(logs)
        model = second_order(inertia, damping, stiffness)
        return (_solve(model, inertia, times, response.torque_nm)[0][:, 0] - response.four_rad) / PEAK_RAD

    found = least_squares(residual, np.log([MOTOR_INERTIA, DAMPING, STIFFNESS]), xtol=1e-12, ftol=1e-12, gtol=1e-12)
    inertia, damping, stiffness = np.exp(found.x)
    return float(inertia), float(damping), float(stiffness)
