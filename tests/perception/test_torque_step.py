"""The torque step of a count against what was detected of torque variations."""

from math import pi

import numpy as np
import pytest

from hknob_cli.errors import UsageError
from hknob_cli.perception.level import published
from hknob_cli.perception.touch import step_in_range, step_level, torque_step

SET = published("torque")["thresholds"]["sinusoid"]


def test_the_numbers_follow_from_the_abstract() -> None:
    """Yang et al. (2003): averages from 0.37 to 26.17 % of 30 N mm; half a printed digit is 0.005 %."""
    assert SET["torque_nm"] == pytest.approx(0.37e-2 * 30e-3, abs=0.005e-2 * 30e-3)
    assert SET["largest_nm"] == pytest.approx(26.17e-2 * 30e-3, abs=0.005e-2 * 30e-3)
    assert SET["period_deg"] == [2.8, 180.0]
    assert SET["base_torque_nm"] == 30e-3


def test_a_step_at_threshold_is_at_0_db() -> None:
    assert step_level(SET["torque_nm"], 100) == pytest.approx(0.0, abs=1e-12)
    assert step_level(10.0 * SET["torque_nm"], 100) == pytest.approx(20.0)
    assert step_level(0.0, 100) == -np.inf


def test_the_step_of_a_count() -> None:
    assert torque_step(0.27, [128, 256]) == pytest.approx([0.27 * 2.0 * pi / 128, 0.27 * 2.0 * pi / 256])
    # Twice the counts, half the step.
    steps = torque_step(0.27, [32, 64])
    assert np.diff(step_level(steps, [32, 64])) == pytest.approx(-20.0 * np.log10(2.0))


def test_counts_finer_than_the_experiments_are_refused_unless_asked_for() -> None:
    assert step_in_range([1, 2, 128, 129]).tolist() == [False, True, True, False]
    with pytest.raises(UsageError, match=r"2\.79.* degrees is outside 2\.8 to 180 degrees"):
        step_level(1e-3, 129)
    assert step_level(1e-3, [129, 8192], extrapolate=True) == pytest.approx(20.0 * np.log10(1e-3 / SET["torque_nm"]))


def test_what_is_no_step_is_refused() -> None:
    with pytest.raises(UsageError, match="counts"):
        torque_step(0.27, 0)
    with pytest.raises(UsageError, match="stiffness"):
        torque_step(-0.27, 100)
    with pytest.raises(UsageError, match="below 0"):
        step_level(-1.0, 100)
    with pytest.raises(UsageError, match="no thresholds of torque 'step'"):
        step_level(1.0, 100, name="step")
