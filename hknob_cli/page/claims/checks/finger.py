"""The hand with a finger of its own: its equations, and beside the hand as one body (Hasser, sec. 4.4.1).

The fourth-order network of Hasser's section 4.4.1: Equation 1 in state-space form, against Equation 2 as printed.

The state is knob angle and velocity, finger angle and velocity; the input is the torque on the knob.
"""

from typing import Any

import numpy as np

from hknob_cli.page.claims.checks import check, one_number, rows_of
from hknob_cli.page.claims.checks.printed import Names, bound, evaluate
from hknob_cli.results.result_set import MissingError, ResultSet, Where

Matrix = np.ndarray[Any, np.dtype[np.float64]]

Values = np.ndarray
_NEEDS = ("time_s", "angle_rad", "velocity_rad_s")


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
def network_order(_: ResultSet, *, where: Names) -> float:
    """Number of states of the network: the degree of torque over angle; a ``where`` with J2 of 0 has no actuator."""
    names = bound(where)
    pad = np.polynomial.Polynomial([names["K2"], names["B2"]])
    finger = np.polynomial.Polynomial([names["K1"], names["B1"], names["J1"]])
    knob = np.polynomial.Polynomial([0.0, 0.0, names["J2"]])
    whole = (knob + pad) * (finger + pad) - pad * pad
    return float(whole.trim().degree())


@check
def dip_depth(_: ResultSet, *, where: Names, pulse_s: float = 0.02, samples: int = 2000) -> float:
    """How far the network's knob falls back after its first peak before it rises again, % of the peak.

    While a torque is on that began at rest; 0 where it does not fall, or does not rise again.
    """
    rates, enters = network(bound(where))
    values, vectors = np.linalg.eig(rates)
    rest = -np.linalg.solve(rates, enters)
    free = vectors[0] * np.linalg.solve(vectors, -rest)  # of the knob's angle, by each motion of its own
    times = np.linspace(0.0, pulse_s, samples + 1)
    angle = rest[0] + np.real(np.exp(np.outer(times, values)) @ free)
    falls = np.flatnonzero(np.diff(angle) < 0.0)
    if not falls.size:
        return 0.0
    peak = int(falls[0])
    rises = peak + np.flatnonzero(np.diff(angle[peak:]) > 0.0)
    return float(100.0 * (angle[peak] - angle[rises[0]]) / angle[peak]) if rises.size else 0.0


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


def _recording(evidence: ResultSet, result: str, where: Where | None, *more: str) -> dict[str, Values]:
    """Columns of the first trial recorded."""
    rows = rows_of(evidence, result, "trajectories", where, needs=[*_NEEDS, *more, "trial"])
    rows = [row for row in rows if row["trial"] == rows[0]["trial"]]
    return {name: np.array([row[name] for row in rows], dtype=float) for name in (*_NEEDS, *more)}


def _rates(time: Values, velocity: Values) -> tuple[Values, Values]:
    """Mean accelerations between rows, and their instants; rows of one instant, as where a pulse ends, are one."""
    spans = np.diff(time)
    kept = spans > 0.0
    return (time[:-1] + 0.5 * spans)[kept], np.diff(velocity)[kept] / spans[kept]


@check
def motion_difference(
    evidence: ResultSet,
    result: str,
    to: str,
    quantity: str = "angle",
    where: Where | None = None,
    to_where: Where | None = None,
) -> float:
    """Largest difference between two recorded motions, in % of the largest value of the second.

    ``quantity``: angle, or acceleration as its mean between rows; ``where`` picks in the first, ``to_where`` in the
    second. Raises `MissingError` for another quantity.
    """
    found = []
    for name, asked in ((result, where), (to, to_where)):
        one = _recording(evidence, name, asked)
        if quantity == "acceleration":
            found.append(_rates(one["time_s"], one["velocity_rad_s"]))
        elif quantity == "angle":
            found.append((one["time_s"], one["angle_rad"]))
        else:
            raise MissingError(f"no {quantity}; there are angle and acceleration")
    (times, values), (others, reference) = found
    off = np.interp(others, times, values) - reference
    return float(100.0 * np.max(np.abs(off)) / np.max(np.abs(reference)))


@check
def finger_share(evidence: ResultSet, result: str, where: Where | None = None) -> float:
    """Largest acceleration of the finger, in % of the knob's."""
    one = _recording(evidence, result, where, "finger_velocity_rad_s")
    knob, finger = (
        np.max(np.abs(_rates(one["time_s"], one[name])[1])) for name in ("velocity_rad_s", "finger_velocity_rad_s")
    )
    return float(100.0 * finger / knob)


@check
def dips(evidence: ResultSet, result: str, where: Where | None = None) -> float:
    """Number of times that the angle falls and rises again while the pulse lasts."""
    one = _recording(evidence, result, where)
    pulse = (evidence[result].provenance["spec"].get("record") or {}).get("pulse")
    if not pulse:
        raise MissingError(f"'{result}' is not of a pulse")
    pushed = one["velocity_rad_s"][one["time_s"] <= pulse["duration"]]
    moving = np.sign(pushed[np.abs(pushed) > 1e-9 * np.max(np.abs(pushed))])
    return float(np.sum((moving[:-1] < 0.0) & (moving[1:] > 0.0)))


@check
def share_falling(
    evidence: ResultSet, result: str, file: str, column: str, along: str, where: Where | None = None
) -> float:
    """Share of the steps of one column, in ascending order, %, at which another falls."""
    rows = rows_of(evidence, result, file, where, needs=[column, along])
    values = [row[column] for row in sorted(rows, key=lambda row: float(row[along]))]
    steps = np.diff(np.array(values, dtype=float))
    if not len(steps):
        raise MissingError(f"'{result}' has one {along} only")
    return float(100.0 * np.mean(steps < 0.0))


@check
def unexplained(
    evidence: ResultSet, result: str, estimator: str, where: Where | None = None, statistic: str = "largest"
) -> float | None:
    """A statistic of the variance of the angle that fits leave unexplained, %."""
    asked = {"estimator": estimator, **(where or {})}
    rows = rows_of(evidence, result, "trials", asked, needs=["vaf"])
    return one_number((100.0 * (1.0 - row["vaf"]) for row in rows if row["vaf"] is not None), statistic)
