"""People: the printed means and spread come back from many of them, and nobody depends on anybody else."""

from math import sqrt

import numpy as np
import pytest

from hknob_cli.apparatus.people import (
    DAMPING_WITH_STIFFNESS,
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
from hknob_cli.printed.tables import table

PEOPLE = 2000


def crowd(number: int, grip: float) -> np.ndarray:
    """J, B, K of many subjects, shape (people, 3)."""
    return np.array([subject_hand(Place(number, one, grip), seed=5) for one in range(1, PEOPLE + 1)])


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


def test_who_is_stiff_is_stiff_at_every_grip_and_damped_with_it() -> None:
    soft, firm = np.log(crowd(1, 0.71)), np.log(crowd(1, 14.2))
    for parameter in range(3):
        assert np.corrcoef(soft[:, parameter], firm[:, parameter])[0, 1] == pytest.approx(1.0, abs=1e-12)
    found = np.corrcoef(soft[:, 1], soft[:, 2])[0, 1]
    assert found == pytest.approx(DAMPING_WITH_STIFFNESS, abs=5 * (1 - DAMPING_WITH_STIFFNESS**2) / sqrt(PEOPLE))


def test_the_correlation_is_what_the_printed_damping_ratios_imply() -> None:
    implied = []
    for number in EXPERIMENTS:
        for row in table(number):
            names = ("inertia", "damping", "stiffness", "damping_ratio")
            j, b, k, ratio = (np.log1p((float(row[f"{name}_cv_percent"]) / 100) ** 2) for name in names)
            implied.append((b + (j + k) / 4 - ratio) / sqrt(b * k))
    assert np.median(implied) == pytest.approx(DAMPING_WITH_STIFFNESS, abs=0.005)


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
