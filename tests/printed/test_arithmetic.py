"""The tables against their own arithmetic, within what the rounding of the print allows.

Every printed number stands for the interval of half a last digit about it. Where not even the intervals meet, the print
does not hold together; those places are listed, so that a slip of a copied digit would show as one more.
"""

from collections.abc import Iterator
from math import sqrt
from statistics import mean, stdev

import pytest

from hknob_cli.printed import apparatus_inertia, grasps, half_widths, table

QUANTITIES = {
    "inertia": "inertia_kg_m2",
    "damping": "damping_nm_s_per_rad",
    "stiffness": "stiffness_nm_per_rad",
    "damping_ratio": "damping_ratio",
}
# Printed damping ratios that no values within the rounding of the printed means give: grips by table.
RATIOS_ABOVE_THOSE_OF_THE_MEANS = {
    3: [2.4],
    4: [0.71, 1.3, 2.4, 7.8],
    5: [0.71, 1.3, 2.4, 14.2],
}

Interval = tuple[float, float]


def intervals(number: int) -> Iterator[dict[str, Interval]]:
    for row, half in zip(table(number), half_widths(number), strict=True):
        yield {name: (row[name] - half[name], row[name] + half[name]) for name in half}


def meet(one: Interval, other: Interval) -> bool:
    slack = 1e-9 * max(map(abs, (*one, *other)))
    return one[0] <= other[1] + slack and other[0] <= one[1] + slack


@pytest.mark.parametrize("number", range(1, 6))
@pytest.mark.parametrize("quantity", QUANTITIES)
def test_variation_is_deviation_over_mean(number: int, quantity: str) -> None:
    column = QUANTITIES[quantity]
    spread = column.replace(quantity, f"{quantity}_std", 1)
    for row in intervals(number):
        low, high = (100 * row[spread][0] / row[column][1], 100 * row[spread][1] / row[column][0])
        assert meet((low, high), row[f"{quantity}_cv_percent"]), row["grip_n"]


def test_damping_ratios_are_of_the_means_but_where_listed() -> None:
    apart: dict[int, list[float]] = {}
    for number in range(1, 6):
        for row, printed in zip(intervals(number), table(number), strict=True):
            j, b, k = (row[QUANTITIES[name]] for name in ("inertia", "damping", "stiffness"))
            of_means = (b[0] / (2 * sqrt(j[1] * k[1])), b[1] / (2 * sqrt(j[0] * k[0])))
            if not meet(of_means, row["damping_ratio"]):
                apart.setdefault(number, []).append(printed["grip_n"])
                # a mean of ratios lies above the ratio of the means, by convexity; a misprint could lie either side
                assert row["damping_ratio"][0] > of_means[1]
    assert apart == RATIOS_ABOVE_THOSE_OF_THE_MEANS


def test_margins_of_the_grip_forces() -> None:
    rows = table(8)
    trials = [name for name in rows[0] if name.startswith("grip_")]
    grid = [[row[name] for name in trials] for row in rows[:4]]
    slack = 0.005 + 0.005 + 1e-9  # what is printed, and what it is the mean of, both rounded
    for row, values in zip(rows, grid, strict=False):
        assert row["mean_n"] == pytest.approx(mean(values), abs=slack)
        assert row["std_n"] == pytest.approx(stdev(values), abs=slack)
    for name, values in zip(trials, zip(*grid, strict=True), strict=True):
        assert rows[4][name] == pytest.approx(mean(values), abs=slack)
        assert rows[5][name] == pytest.approx(stdev(values), abs=slack)
    every = [value for values in grid for value in values]
    assert rows[4]["mean_n"] == pytest.approx(mean(every), abs=slack)
    assert rows[5]["std_n"] == pytest.approx(stdev(every), abs=slack)


def test_calculated_totals() -> None:
    *parts, totals = table(9)
    for name in (key for key in totals if key != "part"):
        if totals[name] == "N/A":
            assert any(row[name] == "N/A" for row in parts)
        else:
            assert totals[name] == pytest.approx(sum(row[name] for row in parts if row[name]), abs=1e-9)


def test_differences_and_errors_of_the_estimates() -> None:
    whole, shaft, total, error = table(10)
    calculated = table(9)[-1]
    for name in (key for key in whole if key not in ("quantity", "unit")):
        # 8.14 and 20.6 are printed for 8.2 and 20.7: off by at most the half digits of the two that are subtracted
        assert total[name] == pytest.approx(whole[name] + shaft[name], abs=0.1 + 1e-9)
        if error[name] is not None:
            of = calculated[f"{name}_g_cm2"]
            assert error[name] == pytest.approx(100 * (total[name] / of - 1), abs=0.05 + 100 * 0.05 / of)


def test_grasps_are_rows_without_the_apparatus() -> None:
    lightest = grasps(1)[0]
    assert lightest == (0.71, 1.3e-7, 3.45e-4, 0.04)
    for number in range(1, 6):
        for grasp, row in zip(grasps(number), table(number), strict=True):
            assert grasp.inertia == pytest.approx(row["inertia_kg_m2"] - apparatus_inertia(number), abs=1e-21)
    assert apparatus_inertia(2) == 1.98e-6
    assert apparatus_inertia(3) == 3.27e-6
    assert [grasp.inertia < 0 for grasp in grasps(1)] == [False] * 3 + [True] * 3
