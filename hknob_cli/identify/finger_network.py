"""The hand of fourth order as a network, finger to ground, fingerpad between finger and knob, and its exact motion.

Equation 1 gives -(B1 + B2)/J1 as the last element of Equation 2, which prints -(B1 - B2).

Exact motion of any linear plant under a held torque, and its derivatives by whatever its matrix depends on.
"""

from collections.abc import Mapping
from math import ceil, log2

import numpy as np

from hknob_cli.recordings.trial import Array

ORDER = ("inertia", "finger_inertia", "finger_damping", "finger_stiffness", "pad_damping", "pad_stiffness")
FINGER_INERTIA = 3.0e-7  # Section 4.4.1: "a generous estimate"
SPLIT = 10.0  # Section 4.4.1: K1 = 10 K2, B1 = 10 B2


def hold_matrices(
    matrix: Array, push: Array, dt_s: float, matrices: Array | None = None, pushes: Array | None = None
) -> tuple[Array, Array]:
    """What a hold does to the state, (1 + p, m, m), and what a unit torque adds, (1 + p, m): values, then derivatives.

    ``matrix`` (m, m) and ``push`` (m,) of x' = matrix x + push torque, the states angles and velocities in turn;
    ``matrices`` (p, m, m), ``pushes`` (p, m): their derivatives by each of p parameters, if any. The exponential of
    [[A, b], [0, 0]] dt, by `pulse.exponential`.
    """
    from hknob_cli.engine.jit import compiled

    order = len(push)
    if matrices is None or pushes is None:
        matrices, pushes = np.empty((0, order, order)), np.empty((0, order))
    whole = np.zeros((1 + len(pushes), order + 1, order + 1))
    whole[0, :order, :order], whole[0, :order, order] = matrix, push
    whole[1:, :order, :order], whole[1:, :order, order] = matrices, pushes
    # Velocities in rad per hold, and torque in what moves the first velocity by 1: elements of like size.
    unit = np.ones(order + 1)
    unit[1:order:2] = dt_s
    unit[order] = 1.0 / max(float(np.max(np.abs(push))) * dt_s * dt_s, np.finfo(float).tiny)
    whole *= dt_s * unit[:, None] / unit
    norm = float(np.max(np.sum(np.abs(whole[0]), axis=1)))
    squarings = max(0, ceil(log2(norm)) + 1) if norm > 0.0 else 0
    whole *= 0.5**squarings
    total, spare = np.empty_like(whole), np.empty_like(whole)
    with np.errstate(over="ignore", invalid="ignore"):
        kernel = compiled("pulse")["exponential"]
        kernel(whole[0], whole[1:], squarings, total[0], total[1:], spare[0], spare[1:], np.empty_like(whole[0]))
    total *= unit / unit[:, None]
    return np.ascontiguousarray(total[:, :order, :order]), np.ascontiguousarray(total[:, :order, order])


def respond_linear(move: Array, push: Array, torque_nm: Array) -> tuple[Array, Array]:
    """First state (n,) from rest, and its derivatives (n, p), of what `hold_matrices` gives."""
    from hknob_cli.engine.jit import compiled

    count, order = len(push) - 1, push.shape[1]
    torque = np.ascontiguousarray(torque_nm, dtype=float)
    angle, slopes = np.empty(len(torque)), np.empty((len(torque), count))
    with np.errstate(over="ignore", invalid="ignore"):
        kernel = compiled("pulse")["follow_linear"]
        kernel(torque, move[0], push[0], move[1:], push[1:], np.zeros((count + 2, order)), angle, slopes)
    return angle, slopes


def network(parameters: Mapping[str, float]) -> tuple[Array, Array]:
    """Matrix (4, 4) and input (4,) of knob angle, knob velocity, finger angle, finger velocity.

    Source: Section 4.4.1, Equation 1. Without the knob it is of third order, as Karason and Srinivasan's (1995) model.
    """
    knob, tip, b1, k1, b2, k2 = (parameters[name] for name in ORDER)
    matrix = np.array(
        [
            [0.0, 1.0, 0.0, 0.0],
            [-k2 / knob, -b2 / knob, k2 / knob, b2 / knob],
            [0.0, 0.0, 0.0, 1.0],
            [k2 / tip, b2 / tip, -(k1 + k2) / tip, -(b1 + b2) / tip],
        ]
    )
    return matrix, np.array([0.0, 1.0 / knob, 0.0, 0.0])


def network_slopes(parameters: Mapping[str, float]) -> tuple[Array, Array]:
    """Derivatives (6, 4, 4) and (6, 4) of matrix and input by the parameters' logarithms, in their `ORDER`."""
    knob, tip, b1, k1, b2, k2 = (parameters[name] for name in ORDER)
    matrix, push = network(parameters)
    matrices, pushes = np.zeros((6, 4, 4)), np.zeros((6, 4))
    matrices[0, 1], pushes[0] = -matrix[1], -push
    matrices[1, 3] = -matrix[3]
    matrices[2, 3, 3], matrices[3, 3, 2] = -b1 / tip, -k1 / tip
    for which, here, there, value in ((4, 1, 3, b2), (5, 0, 2, k2)):
        matrices[which, 1, [here, there]] = -value / knob, value / knob
        matrices[which, 3, [here, there]] = value / tip, -value / tip
    return matrices, pushes


def split(damping: float, stiffness: float, ratio: float = SPLIT) -> dict[str, float]:
    """Finger and fingerpad in series that have ``damping`` and ``stiffness`` between knob and ground, in this ratio."""
    pad = (1.0 + ratio) / ratio
    return {
        "finger_damping": ratio * pad * damping,
        "finger_stiffness": ratio * pad * stiffness,
        "pad_damping": pad * damping,
        "pad_stiffness": pad * stiffness,
    }


def respond_fourth(parameters: Mapping[str, float], torque_nm: Array, dt_s: float) -> Array:
    """Angle (n,) rad of the knob, from rest at 0, under a torque held from sample i to i + 1."""
    move, push = hold_matrices(*network(parameters), dt_s)
    return respond_linear(move, push, torque_nm)[0]


def respond_with_slopes(
    parameters: Mapping[str, float], torque_nm: Array, dt_s: float, by: Array
) -> tuple[Array, Array]:
    """`respond_fourth`, and its derivatives (n, p) by what moves the logarithms of the parameters as ``by`` (6, p)."""
    matrices, pushes = network_slopes(parameters)
    moves = np.tensordot(by.T, matrices, axes=1), by.T @ pushes
    return respond_linear(*hold_matrices(*network(parameters), dt_s, *moves), torque_nm)
