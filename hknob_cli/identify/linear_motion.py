"""Exact motion of any linear plant under a held torque, and its derivatives by whatever its matrix depends on."""

from math import ceil, log2

import numpy as np

from hknob_cli.recordings.trial import Array


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
