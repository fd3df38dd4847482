"""Trends of the hand models in Tables 1-5: over grip force, between grasps, and against their own definitions."""

from math import pi, sqrt

import numpy as np

from hknob_cli.page.claims.checks import check
from hknob_cli.printed.tables import Row, cell, half_widths, table
from hknob_cli.results.result_set import ResultSet

GRIP = "grip_n"
# Radius (m) of the knob that each table was measured with: 17.8 mm and 29.9 mm across.
RADIUS_M = {1: 8.9e-3, 2: 8.9e-3, 3: 14.95e-3, 4: 14.95e-3, 5: 14.95e-3}
_J, _B, _K, _RATIO = "inertia_kg_m2", "damping_nm_s_per_rad", "stiffness_nm_per_rad", "damping_ratio"


def column(number: int, name: str, grips: list[float] | None = None, *, translational: bool = False) -> list[float]:
    """A column of a table at the given grip forces, the lightest first; all by default.

    ``translational``: divided by the square of the knob's radius, as for motion along its rim. Raises `UsageError`.
    """
    scale = RADIUS_M[number] ** 2 if translational else 1.0
    rows = sorted(grips or [float(row[GRIP] or 0) for row in table(number)])
    return [cell(number, grip, name) / scale for grip in rows]


@check
def share_of_steps(_: ResultSet, *, tables: list[int], quantity: str, way: str) -> float:
    """Share of the steps from one grip force to the next in which a column rises or falls (``way``); a fraction."""
    sign = {"rises": 1.0, "falls": -1.0}[way]
    steps = [sign * step > 0 for number in tables for step in np.diff(column(number, quantity))]
    return sum(steps) / len(steps)


@check
def least_r_squared(_: ResultSet, *, tables: list[int], quantities: list[str]) -> float:
    """Least share of the variance of a column over the grips that a straight line over grip force explains."""
    fits = [np.corrcoef(column(n, GRIP), column(n, quantity))[0, 1] ** 2 for n in tables for quantity in quantities]
    return float(min(fits))


@check
def share_of_grips_above(
    _: ResultSet,
    *,
    pairs: list[tuple[int, int]],
    quantity: str,
    grips: list[float] | None = None,
    translational: bool = False,
) -> float:
    """Share of grip forces and pairs of tables at which a column is larger in the second table; a fraction."""
    above = [
        b > a
        for one, other in pairs
        for a, b in zip(
            column(one, quantity, grips, translational=translational),
            column(other, quantity, grips, translational=translational),
            strict=True,
        )
    ]
    return sum(above) / len(above)


@check
def largest_difference_percent(
    _: ResultSet, *, pairs: list[tuple[int, int]], quantity: str, grips: list[float] | None = None
) -> float:
    """Largest difference of a column between two tables, in % of the first."""
    return 100.0 * max(
        abs(b / a - 1.0)
        for one, other in pairs
        for a, b in zip(column(one, quantity, grips), column(other, quantity, grips), strict=True)
    )


@check
def share_within_deviation(
    _: ResultSet, *, pairs: list[tuple[int, int]], quantity: str, deviation: str, grips: list[float] | None = None
) -> float:
    """Share of grip forces at which two tables differ by less than the smaller standard deviation of the two."""
    inside = [
        abs(b - a) < min(spread_a, spread_b)
        for one, other in pairs
        for a, b, spread_a, spread_b in zip(
            column(one, quantity, grips),
            column(other, quantity, grips),
            column(one, deviation, grips),
            column(other, deviation, grips),
            strict=True,
        )
    ]
    return sum(inside) / len(inside)


@check
def extreme(_: ResultSet, *, tables: list[int], quantity: str, which: str, grips: list[float] | None = None) -> float:
    """Least or largest value of a column, in its unit."""
    return {"least": min, "largest": max}[which](value for n in tables for value in column(n, quantity, grips))


@check
def share_below(
    _: ResultSet, *, tables: list[int], quantity: str, limit: float, grips: list[float] | None = None
) -> float:
    """Share of the values of a column that are below a limit; a fraction."""
    values = [value for number in tables for value in column(number, quantity, grips)]
    return sum(value < limit for value in values) / len(values)


@check
def share_of_ratios_of_means(_: ResultSet, *, tables: list[int]) -> float:
    """Share of the printed damping ratios that B/(2 sqrt(J K)) of the printed means gives, within all rounding."""
    met = []
    for number in tables:
        for row, half in zip(table(number), half_widths(number), strict=True):
            low, high = _ratio(row, half, -1.0), _ratio(row, half, 1.0)
            printed, slack = float(row[_RATIO] or 0), half[_RATIO] + 1e-12
            met.append(low <= printed + slack and printed - slack <= high)
    return sum(met) / len(met)


def _ratio(row: Row, half: dict[str, float], side: float) -> float:
    """Damping ratio at the low (-1) or high (+1) end of what the rounding of J, B and K allows."""
    j, b, k = (float(row[name] or 0) for name in (_J, _B, _K))
    return (b + side * half[_B]) / (2.0 * sqrt((j - side * half[_J]) * (k - side * half[_K])))


@check
def share_of_variations(_: ResultSet, *, tables: list[int], quantities: dict[str, tuple[str, str]]) -> float:
    """Share of printed coefficients of variation that standard deviation over mean gives, within all rounding.

    ``quantities``: columns of mean and standard deviation by the column of the coefficient, which is in %.
    """
    met = []
    for number in tables:
        for row, half in zip(table(number), half_widths(number), strict=True):
            for name, (middle, spread) in quantities.items():
                mean, deviation, printed = (float(row[key] or 0) for key in (middle, spread, name))
                low = 100.0 * (deviation - half[spread]) / (mean + half[middle])
                high = 100.0 * (deviation + half[spread]) / (mean - half[middle])
                met.append(low <= printed + half[name] + 1e-12 and printed - half[name] - 1e-12 <= high)
    return sum(met) / len(met)


@check
def oscillation_torque(_: ResultSet, *, number: int, grip_n: float, amplitude_rad: float, frequency_hz: float) -> float:
    """Amplitude (N·m) of the torque that moves a hand of a table, apparatus included, in a sinusoid."""
    omega = 2.0 * pi * frequency_hz
    inertia, damping, stiffness = (cell(number, grip_n, name) for name in (_J, _B, _K))
    return amplitude_rad * abs(complex(stiffness - inertia * omega**2, damping * omega))
