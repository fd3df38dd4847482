"""Axes and cells."""

from math import ulp

import numpy as np
import pytest

from hknob_cli.specs.cells import Cells
from hknob_cli.specs.grid import AxisError, LinAxis, LogAxis, _snapped, axis_values
from hknob_cli.specs.scene_paths import axis_unit, scalar_paths
from tests.conftest import SPEC, loaded


def test_log_axis_of_the_main_grid() -> None:
    values = axis_values("sample_rate_hz", LogAxis(log=(100, 10000, 7)))
    # Half a unit in the exponent, times ln(last/first) = 4.6, and a rounding on each side.
    np.testing.assert_allclose(values, np.logspace(2, 4, 7), rtol=2e-15)
    assert values[0] == 100.0
    assert values[3] == 1000.0
    assert values[-1] == 10000.0


def test_log_axis_of_counts_is_whole() -> None:
    assert axis_values("counts_per_rev", LogAxis(log=(128, 8192, 7))) == [2**i for i in range(7, 14)]


def test_lin_axis() -> None:
    assert axis_values("bias.torque", LinAxis(lin=(0.0, 0.4, 5))) == [0.0, 0.1, 0.2, 0.3, 0.4]


def test_units_in_axes() -> None:
    assert axis_values("sample_rate_hz", ["1 kHz", 2000]) == [1000.0, 2000.0]
    assert axis_values("bias.torque", LinAxis(lin=("1 mN*m", "3 mN*m", 3))) == [1e-3, 2e-3, 3e-3]


@pytest.mark.parametrize(
    ("name", "axis", "steps", "reason"),
    [
        ("sample_rate_hz", [1000, -1], (1,), "must be >= 0.001, got -1"),
        ("sample_rate_hz", -1, (), "must be >= 0.001, got -1"),
        ("sample_rate_hz", [1000, 1000.0], (1,), "must not repeat"),
        ("counts_per_rev", [12.5], (0,), "whole number"),
        ("counts_per_rev", 2**31 + 1, (), "must be <= "),
        ("counts_per_rev", [0], (0,), "must be >= 1"),
        ("bias.torque", LogAxis(log=(0.0, 1.0, 3)), ("log", 0), "must be > 0"),
        ("bias.torque", LogAxis(log=(1.0, 0.0, 3)), ("log", 1), "must be > 0"),
        ("bias.torque", LinAxis(lin=(0.0, 1.0, 1)), ("lin", 2), "must be >= 2"),
        ("sample_rate_hz", ["2 s"], (0,), "not a kind of Hz"),
        ("sample_rate_hz", [float("nan")], (0,), "must be"),
    ],
)
def test_faulty_axes(name: str, axis: object, steps: tuple[str | int, ...], reason: str) -> None:
    with pytest.raises(AxisError) as caught:
        axis_values(name, axis)  # type: ignore[arg-type]
    assert caught.value.steps == steps
    assert reason in str(caught.value)


def test_cells_vary_the_last_axis_fastest() -> None:
    assert list(Cells({"a": [1, 2], "b": [3, 4]})) == [
        {"a": 1, "b": 3},
        {"a": 1, "b": 4},
        {"a": 2, "b": 3},
        {"a": 2, "b": 4},
    ]


def test_every_number_of_the_scene_is_an_axis() -> None:
    assert {"knob.inertia", "hand.stiffness", "bias.torque", "actuator.delay_samples"} <= set(scalar_paths())
    assert axis_unit("hand.damping") == "N*m*s/rad"
    assert axis_unit("actuator.delay_samples") == "1"


def test_axis_over_the_scene() -> None:
    text = SPEC.replace("counts_per_rev: [1024]", "counts_per_rev: [1024]\n  hand.stiffness: {lin: [0.04, 0.08, 3]}")
    assert loaded(text).axes["hand.stiffness"] == [0.04, 0.06, 0.08]


def test_values_of_an_axis_that_miss_a_short_number_by_four_roundings_are_that_number() -> None:
    assert _snapped(1000.0 + 4.0 * ulp(1000.0)) == 1000.0
    assert _snapped(1000.0 + 5.0 * ulp(1000.0)) == 1000.0 + 5.0 * ulp(1000.0)
