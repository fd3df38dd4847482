"""Tests of `identify.identified`: calibrations; damping ratio, models at the skin, means over blocks and persons."""

import math

import numpy as np
import pytest

from hknob_cli.errors import UsageError
from hknob_cli.identify.fit import Estimate, Fit
from hknob_cli.identify.identified import (
    at_the_skin,
    damping_ratio,
    grip_cell,
    motor,
    over_blocks,
    over_subjects,
    without_apparatus,
)
from hknob_cli.identify.least_squares import least_squares
from hknob_cli.identify.output_error import output_error
from tests.identify.pulses import LIGHT, motion, pulse, seen


def test_damping_ratio_has_the_spread_of_repeated_fits() -> None:
    """The delta method against 200 fits: their spread is known to 5 %."""
    rng, true = np.random.default_rng(0), motion(LIGHT, pulse(350))
    found = [damping_ratio(output_error(seen(true, rng, 1e-4, 0, 1, 50))) for _ in range(200)]
    values = [one.value for one in found]
    assert np.mean(values) == pytest.approx(LIGHT[1] / (2.0 * math.sqrt(LIGHT[0] * LIGHT[2])), rel=1e-3)
    assert np.mean([one.std for one in found]) == pytest.approx(np.std(values), rel=0.2)


def test_no_damping_ratio_of_next_to_nothing() -> None:
    """1e-200 kg·m² on 1e-200 N·m/rad: both are positive, their product is no number any more."""
    tiny = {name: Estimate(1e-200, 1e200) for name in ("inertia", "damping", "stiffness")}
    assert math.isnan(damping_ratio(Fit("least_squares", tiny, 0.0)).value)
    vague = {name: Estimate(1.0, 1e200) for name in tiny}
    assert not damping_ratio(Fit("least_squares", vague, 0.0)).identifiable
    assert not without_apparatus(Estimate(1.0, 1e200), 0.5)[0].identifiable


def test_no_damping_ratio_without_a_spring() -> None:
    fit = output_error(motion(LIGHT))
    none = {**fit.parameters, "stiffness": Estimate(-0.01, 0.1)}
    assert math.isnan(damping_ratio(fit._replace(parameters=none)).value)
    assert damping_ratio(fit._replace(covariance=None)).value == pytest.approx(damping_ratio(fit).value)


def test_the_apparatus_is_subtracted_with_its_error() -> None:
    hand, flags = without_apparatus(Estimate(2.11e-6, 3e-8), Estimate(1.98e-6, 4e-8))
    assert hand.value == pytest.approx(1.3e-7)
    assert hand.std == pytest.approx(5e-8)
    assert (hand.identifiable, flags) == (True, ())
    _, flags = without_apparatus(Estimate(1.67e-6, 1e-8), 1.98e-6)
    assert flags == ("inertia is below the apparatus's own: 1.67e-06 less 1.98e-06",)


def test_models_at_the_skin() -> None:
    found = at_the_skin({"stiffness": Estimate(0.04, 0.01), "coulomb": Estimate(1e-3, 1e-4)}, 8.9e-3)
    assert found["stiffness"].value == pytest.approx(0.04 / 8.9e-3**2)
    assert found["coulomb"] == pytest.approx((1e-3 / 8.9e-3, 1e-4 / 8.9e-3, True, 0.0))
    with pytest.raises(UsageError, match="radius must be > 0, got 0"):
        at_the_skin({}, 0.0)


def test_blocks_give_a_mean_and_its_error() -> None:
    found = over_blocks([Estimate(1.0, 0.01), Estimate(2.0, 0.01), Estimate(3.0, 0.01), Estimate(math.nan, math.nan)])
    assert found == pytest.approx((2.0, 1.0 / math.sqrt(3.0), True, 0.0))
    assert over_blocks([Estimate(1.0, 0.01)]) == Estimate(1.0, 0.01)
    assert not over_blocks([]).identifiable


def test_subjects_give_a_row_of_table_1() -> None:
    found = over_subjects([1.0, 2.0, 3.0, math.nan])
    assert found == pytest.approx((2.0, 1.0, 0.5, 3))
    assert math.isnan(over_subjects([1.0]).std)
    assert over_subjects([]).number == 0


@pytest.mark.parametrize("radius_m", [8.9e-3, 14.95e-3])
def test_models_at_the_skin_are_those_of_section_2_2(radius_m: float) -> None:
    """Hajian's recipe on metres and newtons: the matrix of acceleration, velocity and displacement divided into f."""
    exact = motion(LIGHT, pulse(350))
    noise = np.random.default_rng(1).normal(0.0, 1e-4, len(exact.torque_nm))
    one = exact._replace(torque_nm=exact.torque_nm + noise)
    rates = [one.acceleration_rad_s2, one.velocity_rad_s, one.angle_rad]
    columns = radius_m * np.stack(rates, axis=1)
    m, b, k = np.linalg.lstsq(columns, one.torque_nm / radius_m, rcond=None)[0]
    skin = at_the_skin(least_squares(one).parameters, radius_m)
    assert [skin[name].value for name in ("inertia", "damping", "stiffness")] == pytest.approx([m, b, k], rel=1e-6)


FORCE = np.array([0.0, 1.0, 2.0, 3.0])


def cell(*voltages: np.ndarray, force: np.ndarray = FORCE) -> dict[str, np.ndarray]:
    """Readings at one position after the other."""
    count = len(voltages)
    return {
        "position_m": np.repeat(0.003 * np.arange(1.0, count + 1.0), len(force)),
        "force_n": np.tile(force, count),
        "voltage_v": np.concatenate(voltages),
    }


def test_the_ratio_is_of_the_largest_slope_to_the_least() -> None:
    *_, ratio = grip_cell(cell(0.2 * FORCE, 0.1 * FORCE, 0.3 * FORCE))
    assert ratio.value == pytest.approx(3.0, rel=1e-12)
    *_, turned = grip_cell(cell(-0.2 * FORCE, -0.1 * FORCE, -0.3 * FORCE))
    assert turned.value == pytest.approx(3.0, rel=1e-12)


def test_its_error_is_of_these_two() -> None:
    """The middle position is the noisiest and has the least slope; slopes at the ends are exact except for rounding."""
    noise = 0.01 * np.array([1.0, -1.0, -1.0, 1.0])  # no slope of its own
    *slopes, ratio = grip_cell(cell(0.2 * FORCE, 0.1 * FORCE + noise, 0.2 * FORCE))
    assert ratio.std == pytest.approx(2.0 * slopes[1].std / slopes[1].value, rel=1e-9)


@pytest.mark.parametrize(
    "voltages",
    [
        (0.1 * FORCE, 0.0 * FORCE),
        (0.0 * FORCE, 0.0 * FORCE, 0.1 * FORCE),
        (0.1 * FORCE, -0.1 * FORCE),
        (0.1 * FORCE, 1e-300 * FORCE),
    ],
    ids=["flat", "mostly flat", "turned round", "all but flat"],
)
def test_no_ratio_where_a_slope_is_none(voltages: tuple[np.ndarray, ...]) -> None:
    *_, ratio = grip_cell(cell(*voltages))
    assert math.isnan(ratio.value)
    assert math.isnan(ratio.std)
    assert ratio.flags == ("a position has no slope, or one of another sign",)


@pytest.mark.parametrize("scale", [1e-300, 5e-324, 1e-200])
def test_forces_that_hardly_differ_tell_no_slope(scale: float) -> None:
    (slope,) = grip_cell(cell(0.1 * FORCE, force=FORCE * scale))
    assert math.isnan(slope.value)
    assert slope.flags == ("readings that hardly differ",)
    assert slope.line is None


def test_currents_that_hardly_differ_tell_no_constant() -> None:
    ways = np.array([1.0, -1.0])
    found = motor(
        {
            "range_index": np.zeros(8),
            "current_a": np.repeat(1e-250 * FORCE, 2),
            "direction": np.tile(ways, 4),
            "torque_nm": np.arange(8.0),
        }
    )
    assert found[0].flags == ("readings that hardly differ",)
    assert found[1].flags == ()
