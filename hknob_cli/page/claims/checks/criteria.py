"""Stability of sampled walls: the criteria of section 6.2 beside sweeps, and what fast sampling does to numbers.

What sampling does to a controller's numbers: differenced velocity, zeros, coefficients, and a linkage's Jacobian.
Source: Hasser, sec. 10.6, items 1-3; of a velocity from coarse counts, sec. 10.2, item 6; of a linkage, whose tip moves
for one interval, Section 11.4.
"""

from collections.abc import Iterator
from itertools import pairwise
from math import expm1, floor, pi, sqrt, tan
from typing import TYPE_CHECKING, Any

import numpy as np

from hknob_cli.errors import UsageError
from hknob_cli.page.claims.checks import check, one_number, percent, rests, rows_of
from hknob_cli.page.claims.checks.grid import exponent
from hknob_cli.page.claims.checks.motion import motion
from hknob_cli.results.result_set import MissingError, ResultSet, Where
from hknob_cli.specs.plan import COUNTS, RATE

if TYPE_CHECKING:
    from hknob_cli.theory.criteria import Case, Criterion


def _cases(evidence: ResultSet, result: str, where: Where | None) -> "Iterator[tuple[dict[str, Any], Case]]":
    """The rows of a sweep's cells, each with what the criteria need of it."""
    from hknob_cli.specs.plan import scene_at
    from hknob_cli.theory.criteria import case_of
    from hknob_cli.theory.laws import working_edge

    for row in rows_of(evidence, result, "cells", where, needs=["at_rest_fraction"]):
        cell = {axis: row[axis] for axis in evidence[result].axes}
        scene = scene_at(evidence[result].scene, cell)
        # A continuous sensor is the limit of many counts.
        yield row, case_of(scene, working_edge(scene, {COUNTS: 2**31, **cell}))


def _word(name: str, case: "Case") -> "Criterion":
    from hknob_cli.theory.criteria import CRITERIA, judge

    if name not in CRITERIA:
        raise UsageError(f"criterion: must be one of {', '.join(CRITERIA)}, got '{name}'")
    return judge(name, case)


@check
def cycles_where_criterion(
    evidence: ResultSet, result: str, criterion: str, holds: bool, where: Where | None = None
) -> float | None:
    """Share of a sweep's cells, %, with any trial that cycles, of those where the wall without counts satisfies it.

    ``criterion``: tsypkin, tsai_colgate, miller, love_book or llewellyn; ``holds``: false for where it does not.
    """
    rows = [row for row, case in _cases(evidence, result, where) if _word(criterion, case).holds is holds]
    return percent(row["at_rest_fraction"] < 1.0 for row in rows)


@check
def criterion_over(
    evidence: ResultSet,
    result: str,
    criterion: str,
    over: str,
    where: Where | None = None,
    statistic: str = "least",
) -> float | None:
    """A statistic of the largest stiffness that one criterion allows over that of another, over the cells."""
    found = []
    for _, case in _cases(evidence, result, where):
        one, other = _word(criterion, case).stiffness, _word(over, case).stiffness
        if one is not None and other:
            found.append(one / other)
    return one_number(found, statistic)


@check
def criterion_with_damping(
    evidence: ResultSet,
    result: str,
    criterion: str,
    factor: float,
    where: Where | None = None,
    statistic: str = "mean",
) -> float | None:
    """The largest stiffness that a criterion allows with ``factor`` times the damping, over that as it is."""
    found = []
    for _, case in _cases(evidence, result, where):
        edge = case.edge
        less = edge._replace(damping=factor * edge.damping, knob_damping=factor * edge.knob_damping)
        one, other = _word(criterion, case._replace(edge=less)).stiffness, _word(criterion, case).stiffness
        if one is not None and other:
            found.append(one / other)
    return one_number(found, statistic)


@check
def damping_bounded(evidence: ResultSet, result: str, where: Where | None = None) -> float | None:
    """Share of the cells, %, where love_book bounds the virtual damping from below, above 0, and from above."""
    words = (_word("love_book", case) for _, case in _cases(evidence, result, where))
    return percent(bool(word.least_damping) and bool(word.most_damping) for word in words)


@check
def resting_stiffness_exponent(
    evidence: ResultSet, result: str, stiffness: str = "wall.stiffness", where: Where | None = None
) -> float | None:
    """Exponent of the largest stiffness up to which every trial rests, as a power of the sample rate.

    ``stiffness``: the axis. A rate at which the softest wall does not rest, or the stiffest does, is left out.
    """
    by: dict[float, list[tuple[float, bool]]] = {}
    for row in rows_of(evidence, result, "cells", where, needs=[RATE, stiffness, "at_rest_fraction"]):
        by.setdefault(row[RATE], []).append((row[stiffness], rests(row)))
    found = []
    for rate, walls in by.items():
        walls.sort()
        ends = next((i for i, (_, still) in enumerate(walls) if not still), 0)
        if ends:
            found.append((rate, walls[ends - 1][0]))
    return exponent(found)


SAMPLE = "sample"


@check
def velocity_jump(_: ResultSet, *, counts_per_rev: int, sample_rate_hz: float, low_pass: float = 0.0) -> float:
    """Jump (rad/s) of a velocity differenced over one sample when the angle moves by one count.

    ``low_pass``: time constant (s) of a filter behind it, y += a (x - y) with a = 1 - exp(-T / low_pass), as
    `velocity_damping` has it; 0: none.
    """
    goes = -expm1(-1.0 / (sample_rate_hz * low_pass)) if low_pass > 0.0 else 1.0
    return goes * sample_rate_hz * 2.0 * pi / counts_per_rev


@check
def sampling_zero(
    _: ResultSet, *, inertia: float, damping: float, stiffness: float, sample_rate_hz: float, lag_s: float = 0.0
) -> float:
    """Distance from 0 of the farthest zero of knob and hand behind a zero-order hold; above 1: not minimum phase.

    From torque to angle; ``lag_s``: time constant of the amplifier, which passes the torque on, 0: none. SI units.
    The zeros are those of C adj(zI - Phi) Gamma = det(zI - Phi + Gamma C) - det(zI - Phi).
    """
    from scipy.linalg import expm

    period = 1.0 / sample_rate_hz
    # States angle, velocity in rad per sample, and torque in what moves the velocity by 1 in a sample.
    rates = [
        [0.0, 1.0, 0.0],
        [-stiffness * period**2 / inertia, -damping * period / inertia, 1.0],
        [0.0, 0.0, -period / lag_s if lag_s else 0.0],
    ]
    order = 3 if lag_s else 2
    whole = np.zeros((order + 1, order + 1))
    whole[:3, :3] = rates
    if lag_s:
        whole[2, 3] = period / lag_s
    held = expm(whole)
    move, push = held[:order, :order], held[:order, order]
    drawn = move - np.outer(push, np.eye(order)[0])
    return float(np.max(np.abs(np.roots((np.poly(drawn) - np.poly(move))[1:]))))


@check
def coefficient_error(_: ResultSet, *, cut_off_hz: float, sample_rate_hz: float, bits: int) -> float | None:
    """Most (%) by which rounding its coefficients can change the static gain of a low-pass of second order.

    A Butterworth filter by the bilinear transform, in direct form, its coefficients two's-complement numbers of
    ``bits`` from -2 to 2. The gain is 4 b / (1 + a1 + a2), and 1 + a1 + a2 = 4 b before rounding. In steps of the
    numbers, rounding moves 4 b by less than 2 and 1 + a1 + a2 by less than 1; both are whole numbers then, so that they
    differ by 2 at most. None where the rounded 1 + a1 + a2 may be 0, and the filter an integrator.
    """
    warped = tan(pi * cut_off_hz / sample_rate_hz)
    steps = 4.0 * warped**2 / (1.0 + 2.0**0.5 * warped + warped**2) * 2.0**bits / 4.0
    return 100.0 * 2.0 / (steps - 1.0) if steps > 1.0 else None


@check
def velocity_error(evidence: ResultSet, result: str, counts_per_rev: int, where: Where | None = None) -> float | None:
    """Error (% of its rms) of the velocity of a recorded motion if its samples were read by an encoder of such counts.

    The error is the difference of two readings less that of the two angles, over the sample period; rms. The motion is
    that of the recording, whatever sensor it was under.
    """
    samples = [point for point in motion(evidence, result, where) if point.event == SAMPLE]
    if len(samples) < 3:
        raise MissingError(f"no samples are recorded in '{result}'")
    count = 2.0 * pi / counts_per_rev
    wrong, whole = 0.0, 0.0
    for before, now in pairwise(samples):
        true = now.angle - before.angle
        read = count * (floor(now.angle / count) - floor(before.angle / count))
        wrong, whole = wrong + (read - true) ** 2, whole + true**2
    return 100.0 * sqrt(wrong / whole) if whole else None


@check
def velocity_error_exponent(
    evidence: ResultSet, result: str, counts_per_rev: list[int], where: Where | None = None
) -> float | None:
    """Exponent of `velocity_error` as a power of the counts per revolution; -1: in proportion to the count."""
    line = [(float(counts), velocity_error(evidence, result, counts, where)) for counts in counts_per_rev]
    return exponent([(at, value) for at, value in line if value is not None])


_CONFIGURATIONS, _DIRECTIONS = 91, 72


@check
def jacobian_change(
    _: ResultSet,
    *,
    links_m: list[float],
    speed_m_s: float,
    interval_s: float,
    elbow_deg: list[float],
    inverse: bool = True,
) -> float:
    """Most (%) by which the Jacobian of a planar arm of two links changes while its tip moves at a speed for a time.

    The tip moves in every direction, from every angle of the elbow in a range (degrees, 0: straight) that leaves out
    the singular ones. The change is the largest singular value of the difference over that of the Jacobian before, or,
    with ``inverse``, of the inverses. Raises `UsageError` for a range with a singular elbow.
    """
    first, second = links_m
    low, high = (pi * value / 180.0 for value in elbow_deg)
    if not 0.0 < low <= high < pi:
        raise UsageError("elbow_deg: must lie between 0 and 180, where the arm is straight or folded")
    most = 0.0
    for elbow in np.linspace(low, high, _CONFIGURATIONS):
        here = _jacobian(first, second, 0.0, elbow)
        for angle in np.linspace(0.0, 2.0 * pi, _DIRECTIONS, endpoint=False):
            shoulder, bent = np.linalg.solve(here, speed_m_s * interval_s * np.array([np.cos(angle), np.sin(angle)]))
            there = _jacobian(first, second, shoulder, elbow + bent)
            old, new = (np.linalg.inv(here), np.linalg.inv(there)) if inverse else (here, there)
            most = max(most, float(np.linalg.norm(new - old, 2) / np.linalg.norm(old, 2)))
    return 100.0 * most


def _jacobian(first: float, second: float, shoulder: float, elbow: float) -> np.ndarray:
    """Velocity of the tip by the two joint speeds, m/rad; the shoulder's and the elbow's angle in rad."""
    near = first * np.array([-np.sin(shoulder), np.cos(shoulder)])
    far = second * np.array([-np.sin(shoulder + elbow), np.cos(shoulder + elbow)])
    return np.stack([near + far, far], axis=1)
