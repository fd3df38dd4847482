"""People: the printed means and spread come back from many of them, and nobody depends on anybody else."""

from math import sqrt

import numpy as np
import pytest

from hknob_cli.apparatus.people import (
    EXPERIMENTS,
    Place,
    Variation,
    grips,
    mean_hand,
    spread,
    subject_hand,
    trial_hand,
)
from hknob_cli.errors import UsageError
from hknob_cli.printed import table

PEOPLE = 2000


def crowd(number: int, grip: float) -> np.ndarray:
    """J, B, K of many subjects, shape (people, 3)."""
    return np.array([subject_hand(Place(number, one, grip), seed=5) for one in range(1, PEOPLE + 1)])


def damping_with_stiffness(number: int, grip: float) -> float:
    """Correlation of ln B with ln K that the printed spread of ζ = B/(2 sqrt(J K)) implies; J is independent."""
    (row,) = (row for row in table(number) if row["grip_n"] == grip)
    names = ("inertia", "damping", "stiffness", "damping_ratio")
    j, b, k, ratio = (np.log1p((float(row[f"{name}_cv_percent"]) / 100.0) ** 2) for name in names)
    return float((b + (j + k) / 4.0 - ratio) / np.sqrt(b * k))


@pytest.mark.parametrize(("number", "grip"), [(1, 0.71), (1, 14.2), (2, 0.71), (4, 1.3), (5, 1.3)])
def test_means_and_spread_are_the_tables(number: int, grip: float) -> None:
    """Within five standard errors of a lognormal sample's mean and coefficient of variation.

    Var(cv) / cv² = ((kurtosis - 1) / 4 - skewness cv + cv²) / n, by the delta method.
    """
    values = crowd(number, grip)
    for column, mean, cv in zip(values.T, mean_hand(number, grip), spread(number, grip), strict=True):
        w = 1.0 + cv * cv
        kurtosis, skewness = w**4 + 2 * w**3 + 3 * w**2 - 3.0, (w + 2.0) * sqrt(w - 1.0)
        error = sqrt(((kurtosis - 1.0) / 4 - skewness * cv + cv * cv) / PEOPLE)
        assert column.mean() == pytest.approx(mean, rel=5 * cv / sqrt(PEOPLE))
        assert column.std(ddof=1) / column.mean() == pytest.approx(cv, rel=5 * error)
        assert column.min() > 0.0


def test_who_is_stiff_is_stiff_at_every_grip_and_damped_as_the_row_has_it() -> None:
    soft, firm = np.log(crowd(1, 0.71)), np.log(crowd(1, 14.2))
    for parameter in (0, 2):
        assert np.corrcoef(soft[:, parameter], firm[:, parameter])[0, 1] == pytest.approx(1.0, abs=1e-12)
    for values, grip in ((soft, 0.71), (firm, 14.2)):
        rho = damping_with_stiffness(1, grip)
        assert -1.0 < rho < 1.0
        found = np.corrcoef(values[:, 1], values[:, 2])[0, 1]
        assert found == pytest.approx(rho, abs=5 * (1 - rho**2) / sqrt(PEOPLE))


@pytest.mark.parametrize(("number", "grip"), [(1, 1.3), (1, 14.2), (2, 0.71), (3, 7.8), (5, 1.3)])
def test_the_damping_ratio_spreads_as_printed(number: int, grip: float) -> None:
    """What the correlation is derived from: the printed coefficient of variation of ζ, which is lognormal, too."""
    (row,) = (row for row in table(number) if row["grip_n"] == grip)
    inertia, damping, stiffness = crowd(number, grip).T
    ratio = np.log(damping / (2.0 * np.sqrt(inertia * stiffness)))
    printed = float(row["damping_ratio_cv_percent"]) / 100
    # Standard error of a normal's standard deviation: s / sqrt(2 n).
    assert np.sqrt(np.expm1(ratio.var(ddof=1))) == pytest.approx(printed, rel=5 / sqrt(2 * PEOPLE))


def test_a_correlation_that_cannot_be_is_the_next_that_can() -> None:
    """Table 4's lightest grips: ζ spreads more than any two correlated lognormals make it, Table 5's never."""
    for grip in (0.71, 1.3, 2.4):
        assert damping_with_stiffness(4, grip) < -1.0
        found = np.log(crowd(4, grip))
        assert np.corrcoef(found[:, 1], found[:, 2])[0, 1] == pytest.approx(-1.0, abs=1e-12)
    assert all(0.0 < damping_with_stiffness(5, grip) < 1.0 for grip in grips(5))


def test_mean_hands_where_nobody_differs() -> None:
    for number in EXPERIMENTS:
        for grip in grips(number):
            hand = trial_hand(Place(number, 3, grip, 2, 1), variation=Variation.none())
            assert hand == pytest.approx(mean_hand(number, grip), rel=1e-15)


def test_blocks_and_trials_vary_by_what_is_stated() -> None:
    """Standard deviations of logarithms, within five standard errors, s / sqrt(2 n)."""
    own = Variation(0.0, (0.02, 0.04, 0.06), (0.0, 0.0, 0.0))
    values = [trial_hand(Place(1, 1, 0.71, block, 1), variation=own) for block in range(1, 1001)]
    assert np.log(values).std(axis=0) == pytest.approx([0.02, 0.04, 0.06], rel=5 / sqrt(2000))
    same = {trial_hand(Place(1, 1, 0.71, 1, trial), variation=own) for trial in range(1, 4)}
    assert len(same) == 1
    own = Variation(0.0, (0.0, 0.0, 0.0), (0.01, 0.03, 0.05))
    values = [trial_hand(Place(1, 1, 0.71, 1, trial), variation=own) for trial in range(1, 1001)]
    assert np.log(values).std(axis=0) == pytest.approx([0.01, 0.03, 0.05], rel=5 / sqrt(2000))


def test_what_is_not_in_the_tables_is_said() -> None:
    with pytest.raises(UsageError, match=r"no grip of 0.72 N; it has: 0.71, 1.3"):
        mean_hand(1, 0.72)
    with pytest.raises(UsageError, match="no experiment 6; there are: 1, 2, 3, 4, 5"):
        grips(6)
