"""Calibrations of readings from which no slope, or no ratio of slopes, can be told."""

import math

import numpy as np
import pytest

from hknob_cli.identify.identified import grip_cell, motor

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
