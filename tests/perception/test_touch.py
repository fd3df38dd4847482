"""Tests of `perception.touch`: what the sources say, in the words of each, and how levels follow from it."""

from math import log2, pi, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hknob_cli.errors import UsageError
from hknob_cli.perception.level import published
from hknob_cli.perception.touch import (
    detection_threshold,
    in_range,
    judge,
    sensation_level,
    skin_displacement,
    step_in_range,
    step_level,
    thresholds,
    torque_step,
)

NAMES = tuple(published("touch")["thresholds"])
UM = 1e-6


def db_um(metres: object) -> object:
    """Level re 1 micrometre."""
    return 20.0 * np.log10(np.asarray(metres) / UM)


def test_pen_hold_has_the_numbers_of_its_source() -> None:
    """Israr, Choi and Tan (2006), two significant digits each."""
    for hertz, metres, half_digit in (
        (10.0, 26.0 * UM, 0.5 * UM),
        (20.0, 8.5 * UM, 0.05 * UM),
        (320.0, 0.06 * UM, 5e-9),
    ):
        assert detection_threshold(hertz) == pytest.approx(metres, abs=half_digit)


def test_pen_hold_falls_by_13_db_per_octave_from_10_to_160_hz_on_average() -> None:
    low, high = db_um(detection_threshold([10.0, 160.0]))
    assert (high - low) / log2(16.0) == pytest.approx(-13.0, abs=0.5)  # printed to whole dB


def test_pen_hold_is_most_sensitive_at_320_hz_of_the_frequencies_tested() -> None:
    tested = np.array([10.0, 20.0, 40.0, 80.0, 160.0, 320.0])
    assert tested[np.argmin(detection_threshold(tested))] == 320.0


def test_thenar_is_flat_to_40_hz_then_falls_by_12_db_per_octave_to_250_hz() -> None:
    """Verrillo (1963), as told by Gescheider and Verrillo; the level of the flat part is about 28 dB re 1 um."""
    levels = db_um(detection_threshold([10.0, 20.0, 40.0, 80.0, 160.0, 250.0], name="thenar"))
    assert levels[:3] == pytest.approx(28.0, abs=0.5)
    assert np.diff(levels)[2:4] == pytest.approx(-12.0, abs=0.1)
    assert thresholds("thenar").high_hz == 250.0
    assert np.argmin(levels) == 5


def test_thenar_1988_and_the_cylinder_at_the_values_cited() -> None:
    assert detection_threshold(300.0, name="thenar_1988") == pytest.approx(0.13 * UM, abs=5e-9)
    assert db_um(detection_threshold(25.0, name="thenar_1988")) == pytest.approx(28.0, abs=0.5)
    assert detection_threshold(150.0, name="cylinder") == pytest.approx(0.03 * UM, abs=5e-9)
    assert (thresholds("cylinder").low_hz, thresholds("cylinder").high_hz) == (150.0, 200.0)


def test_what_is_grasped_is_felt_at_smaller_amplitudes_than_a_probe_above_20_hz() -> None:
    """Brisben et al. (1999): thresholds of a grasped cylinder above 20 Hz were lower than those reported before."""
    hertz = np.geomspace(20.0, 250.0, 30)
    assert (detection_threshold(hertz) < detection_threshold(hertz, name="thenar")).all()
    assert (
        detection_threshold(160.0, name="cylinder")
        < detection_threshold(160.0)
        < detection_threshold(160.0, name="thenar")
    )


@pytest.mark.parametrize("name", NAMES)
def test_every_set_says_where_it_is_from_and_where_it_holds(name: str) -> None:
    entry, found = published("touch")["thresholds"][name], thresholds(name)
    assert all(entry[key] for key in ("title", "source", "read_in", "contact", "subjects", "spread"))
    assert found.points[0, 0] == found.low_hz
    assert found.points[-1, 0] == found.high_hz
    assert (np.diff(found.points[:, 0]) > 0.0).all()
    # No set has its sensitivity fall within its range, so that thresholds never rise.
    assert (np.diff(found.points[:, 1]) <= 0.0).all()


@pytest.mark.parametrize("name", NAMES)
def test_outside_its_range_a_set_is_refused_unless_extrapolation_is_asked_for(name: str) -> None:
    found = thresholds(name)
    for hertz in (0.99 * found.low_hz, 1.01 * found.high_hz, 0.0, -1.0, float("nan")):
        with pytest.raises(UsageError, match="outside"):
            detection_threshold(hertz, name=name)
    ends = detection_threshold([0.99 * found.low_hz, 1.01 * found.high_hz], name=name, extrapolate=True)
    assert ends == pytest.approx(found.points[[0, -1], 1], rel=0.03)  # 14 dB per octave is 2.3 % over 1 %
    for hertz in (0.0, 1001.0, float("nan")):
        with pytest.raises(UsageError, match="outside 1 to 1000 Hz"):
            detection_threshold(hertz, name=name, extrapolate=True)


def test_a_set_that_does_not_exist_is_refused_by_naming_the_others() -> None:
    with pytest.raises(UsageError, match="there are: pen_hold, cylinder"):
        detection_threshold(100.0, name="elbow")


@given(hertz=st.floats(10.0, 320.0), metres=st.floats(1e-12, 1e-2), factor=st.floats(1.0, 1e4))
def test_levels_follow_amplitudes_in_db(hertz: float, metres: float, factor: float) -> None:
    """At threshold 0 dB; ten times the amplitude 20 dB; three conventions of one sinusoid, one level."""
    assert sensation_level(hertz, detection_threshold(hertz)) == pytest.approx(0.0, abs=1e-12)
    level = sensation_level(hertz, metres)
    # A few roundings of numbers of size 200 dB.
    assert sensation_level(hertz, factor * metres) - level == pytest.approx(20.0 * np.log10(factor), abs=1e-10)
    assert sensation_level(hertz, metres / sqrt(2.0), convention="rms") == pytest.approx(level, abs=1e-10)
    assert sensation_level(hertz, 2.0 * metres, convention="peak_to_peak") == pytest.approx(level, abs=1e-10)


def test_levels_broadcast_frequencies_over_amplitudes() -> None:
    levels = sensation_level([20.0, 80.0, 320.0], np.array([[1e-6], [1e-5]]))
    assert levels.shape == (2, 3)
    assert levels[1] - levels[0] == pytest.approx(20.0, abs=1e-10)


def test_what_is_no_amplitude_is_refused() -> None:
    with pytest.raises(UsageError, match="below 0"):
        sensation_level(80.0, -1e-6)
    with pytest.raises(UsageError, match="there are: peak, rms, peak_to_peak"):
        sensation_level(80.0, 1e-6, convention="mean")


def test_the_rim_of_the_printed_knobs() -> None:
    """The radius is half of the printed diameter, 17.8 mm: a milliradian moves the skin by 8.9 um."""
    assert skin_displacement(1e-3, knob_radius_m=17.8e-3 / 2.0) == pytest.approx(8.9 * UM)


def test_a_cycle_is_judged_by_the_harmonic_that_is_felt_best() -> None:
    hertz = [40.0, 80.0, 160.0]
    # The fundamental is the largest part, and not the most noticeable one.
    parts = np.array([2e-6, 1e-7, 5e-7])
    found = judge(hertz, parts)
    assert found.frequency_hz == 160.0
    assert found.level_db == pytest.approx(float(sensation_level(160.0, 5e-7)))
    assert judge(hertz, np.stack([parts, 10.0 * parts])).level_db == pytest.approx(
        found.level_db + np.array([0.0, 20.0])
    )


def test_a_power_sum_of_equal_parts_is_3_db_above_one_of_them() -> None:
    parts = detection_threshold([40.0, 80.0])
    assert judge([40.0, 80.0], parts, how="power_sum").level_db == pytest.approx(10.0 * np.log10(2.0))
    assert judge([40.0], parts[:1], how="power_sum").level_db == pytest.approx(0.0, abs=1e-12)
    # Far from the range of powers of ten that a float has.
    assert judge([40.0], [1e250], how="power_sum").level_db == pytest.approx(20.0 * np.log10(1e250 / parts[0]))
    with pytest.raises(UsageError, match="there are: most_effective, power_sum"):
        judge([40.0], [1e-6], how="loudest")


def test_parts_outside_the_range_are_left_out_and_nothing_is_said_without_others() -> None:
    found = judge([5.0, 100.0, 5000.0], [1.0, 1e-6, 1.0])
    assert found.frequency_hz == 100.0
    assert np.isnan(judge([5.0, 5000.0], [1.0, 1.0]).level_db)
    assert np.isnan(judge([], np.zeros((2, 0))).level_db).all()
    assert np.isnan(judge([100.0], [0.0]).level_db)
    # Extrapolation ends where vibration is no longer felt.
    assert judge([500.0, 5000.0], [1e-6, 1.0], extrapolate=True).frequency_hz == 500.0
    assert np.isnan(judge([5000.0], [1.0], extrapolate=True).level_db)
    assert in_range([5.0, 10.0, 320.0, 321.0]).tolist() == [False, True, True, False]


def test_how_well_thresholds_are_known_follows_from_what_was_read() -> None:
    """Half a dB per octave of a printed slope over the octaves it spans; and sets against each other."""
    sets = published("touch")["thresholds"]
    assert sets["pen_hold"]["known_to_db"] == pytest.approx(0.5 * log2(160.0 / 10.0))
    assert sets["thenar"]["known_to_db"] == pytest.approx(0.5 * log2(250.0 / 40.0) + 0.5, abs=0.3)
    by_slope = db_um(detection_threshold(30.0, name="thenar_1988")) - 12.0 * log2(300.0 / 30.0)
    by_value = db_um(detection_threshold(300.0, name="thenar_1988"))
    assert sets["thenar_1988"]["known_to_db"] == pytest.approx(by_slope - by_value, abs=0.3)
    at_150 = [db_um(detection_threshold(150.0, name=name)) for name in NAMES]
    assert max(at_150) - min(at_150) == pytest.approx(36.0, abs=0.5)
    assert published("touch")["within_set_db"] == sets["pen_hold"]["known_to_db"]


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
