"""The main grid: every cell certified, rest points where theory puts them, the known orbits found."""

from typing import Any

import pytest

Rows = dict[str, list[dict[str, Any]]]


@pytest.mark.parametrize("reading", ["printed", "half_quantum"])
def test_every_cell_is_certified(main_grid: Rows, reading: str) -> None:
    cells = main_grid[f"{reading}:cells"]
    assert len(cells) == 49
    assert all(cell["certified_fraction"] == 1.0 for cell in cells)
    assert all(cell["at_rest_fraction"] == cell["diverged_fraction"] == 0.0 for cell in cells)


@pytest.mark.parametrize("reading", ["printed", "half_quantum", "stiffer", "stiffer_half_quantum"])
def test_orbits_close_to_a_trillionth_of_their_size(main_grid: Rows, reading: str) -> None:
    for orbit in main_grid[f"{reading}:orbits"]:
        if orbit["outcome"] == "cycle":
            assert orbit["closure_rad"] <= 1e-12 * orbit["p2p_rad"]
            assert orbit["margin_counts"] > 0.0


def test_orbits_of_10_12_and_14_samples_at_1_khz(main_grid: Rows) -> None:
    periods = {row["period_samples"] for row in main_grid["half_quantum:orbits"] if row["sample_rate_hz"] == 1000.0}
    assert periods == {10, 12, 14}


def test_stiffness_as_printed_gives_rest(main_grid: Rows) -> None:
    """the known print errors, and its condition for a rest point: g / ((K + k) q) in (m - k / (K + k), m]."""
    from math import ceil, pi

    seen = set()
    for orbit in main_grid["stiffer:orbits"]:
        load = 0.001 / ((0.27 + 0.08) * 2 * pi / orbit["counts_per_rev"])
        m = ceil(load)
        exists = m - 0.08 / 0.35 < load <= m
        if orbit["outcome"] == "rest":
            assert exists
            assert orbit["p2p_rad"] == orbit["rms_rad"] == orbit["frequency_hz"] == 0.0
            assert orbit["certified"]
            seen.add(orbit["counts_per_rev"])
    assert seen == {2048, 4096}


def test_every_stiffer_trial_is_certified_too(main_grid: Rows) -> None:
    for reading in ("stiffer", "stiffer_half_quantum"):
        assert all(cell["certified_fraction"] == 1.0 for cell in main_grid[f"{reading}:cells"])


def test_rest_needs_the_bias_inside_a_count(main_grid: Rows) -> None:
    assert not any(row["outcome"] == "rest" for row in main_grid["stiffer_half_quantum:orbits"])
