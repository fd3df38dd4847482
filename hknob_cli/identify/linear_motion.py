"""Exact motion of any linear plant under a held torque, from matrices that may be complex."""

from collections.abc import Sequence
from math import ceil, log2
from typing import Any

import numpy as np

from hknob_cli.recordings.trial import Array

TERMS = 18  # of a Taylor series at norm 1/2: 0.5^19/19! is 2e-23


def hold_matrices(systems: Sequence[tuple[Any, Any]], dt_s: float) -> tuple[Any, Any]:
    """What a hold does to the state, (s, m, m), and what a unit torque adds, (s, m), of systems (matrix, input).

    The exponential of [[A, b], [0, 0]] dt by Taylor series, scaling and squaring: arithmetic alone, so that a complex
    step through it gives derivatives to rounding (Higham, *Functions of Matrices*, sec. 10.3 and 11.5).
    """
    order = len(systems[0][1])
    whole = np.zeros((len(systems), order + 1, order + 1), dtype=complex)
    for one, (matrix, push) in zip(whole, systems, strict=True):
        one[:order, :order], one[:order, order] = matrix, push
    # Velocities in rad per hold, and torque in what moves the first velocity by 1: elements of like size.
    unit = np.ones(order + 1)
    unit[1:order:2] = dt_s
    unit[order] = 1.0 / max(float(np.max(np.abs(whole[:, :order, order]))) * dt_s * dt_s, np.finfo(float).tiny)
    whole *= dt_s * unit[:, None] / unit
    norm = float(np.max(np.sum(np.abs(whole), axis=2)))
    squarings = max(0, ceil(log2(norm)) + 1) if norm > 0.0 else 0
    whole /= 2.0**squarings
    identity = np.eye(order + 1)
    term = whole
    total = identity + whole
    for n in range(2, TERMS):
        term = term @ whole / n
        total = total + term
    for _ in range(squarings):
        total = total @ total
    total = total * unit / unit[:, None]
    return np.ascontiguousarray(total[:, :order, :order]), np.ascontiguousarray(total[:, :order, order])


def respond_linear(
    move: Array, push: Array, torque_nm: Array, moves: Array | None = None, pushes: Array | None = None
) -> tuple[Array, Array]:
    """First state (n,) of the first system from rest, and its derivatives (n, p) where ``moves``, ``pushes`` are given.

    ``move`` (s, m, m), ``push`` (s, m) of which the first is followed; ``moves`` (p, m, m), ``pushes`` (p, m).
    """
    from hknob_cli.engine.jit import compiled

    order = push.shape[1]
    if moves is None or pushes is None:
        moves, pushes = np.empty((0, order, order)), np.empty((0, order))
    torque = np.ascontiguousarray(torque_nm, dtype=float)
    angle, slopes = np.empty(len(torque)), np.empty((len(torque), len(moves)))
    work = np.zeros((len(moves) + 2, order))
    first = np.ascontiguousarray(move[0]), np.ascontiguousarray(push[0])
    with np.errstate(over="ignore", invalid="ignore"):
        kernel = compiled("pulse")["follow_linear"]
        kernel(torque, *first, np.ascontiguousarray(moves), np.ascontiguousarray(pushes), work, angle, slopes)
    return angle, slopes
