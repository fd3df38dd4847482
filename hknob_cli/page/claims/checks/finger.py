"""The hand with a finger of its own beside the hand as one body: motions recorded, and fits (Hasser, sec. 4.4.1)."""

import numpy as np

from hknob_cli.page.claims.checks import check
from hknob_cli.page.claims.checks.rows import one_number, rows_of
from hknob_cli.results.result_set import MissingError, ResultSet, Where

Values = np.ndarray

_NEEDS = ("time_s", "angle_rad", "velocity_rad_s")


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
