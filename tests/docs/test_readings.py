"""The numbers of docs/explanation/readings.md: every reading of the printed comparisons, over the 49 cells."""

import re
from pathlib import Path

import pandas as pd
import pytest

from tests.conftest import EXPERIMENTS, Command
from tests.forked import Forks

from .page import agrees, says, table

PAGE = "explanation/readings.md"
# Rows of both tables: the experiment, and the hand stiffness that predictions are given.
READINGS = {
    "hand_on_knob": "0.04",
    "hand_on_knob_half_quantum": "0.04",
    "hand_on_knob_stiffer": "0.08",
    "hand_on_knob_stiffer_half_quantum": "0.08",
}
KEYS = ["sample_rate_hz", "counts_per_rev"]


def ran(hknob: Command, *args: object) -> None:
    done = hknob(*args)
    assert done.returncode == 0, done.stderr


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory, forks: Forks) -> dict[str, Path]:
    """Folders with the sweep of each reading, and what the page says to run beside it."""
    hknob = Command(forks, EXPERIMENTS)
    folders = {}
    for name, stiffness in READINGS.items():
        folder = folders[name] = tmp_path_factory.mktemp(name)
        ran(hknob, "sweep", EXPERIMENTS / f"{name}.yaml", "-o", folder / "sweep", "-q")
        beside = ["-q", "--set", f"against={folder / 'sweep'}", "--set", f"scene.hand.stiffness={stiffness}"]
        dfa, laws = (EXPERIMENTS / f"{stage}_hand_on_knob.yaml" for stage in ("dfa", "predict"))
        ran(hknob, "dfa", dfa, "-o", folder / "dfa", *beside, "--set", "methods=[df1, df4]")
        ran(hknob, "predict", laws, "-o", folder / "predict", *beside, "--set", "constant=500.0")
    return folders


def percent(found: "pd.Series[float]", sweep: "pd.Series[float]") -> "pd.Series[float]":
    return (100.0 * (found / sweep - 1.0))[sweep > 0.0]


def compare(printed: str, values: "pd.Series[float]") -> list[str]:
    """The faults of a cell of a table, ``mean ± standard deviation [least, largest]``, against the values."""
    text = printed.replace("\u2212", "-").replace("*", "")
    numbers = re.fullmatch(r"(-?\d+) ± (\d+)(?: \[(-?\d+), (-?\d+)\])?", text)
    assert numbers, printed
    computed = (values.mean(), values.std(), values.min(), values.max())
    pairs = zip(numbers.groups(), computed, strict=True)
    return [f"{printed}: {value:.2f}" for number, value in pairs if number is not None and not agrees(number, value)]


def test_describing_functions_in_every_reading(results: dict[str, Path]) -> None:
    wrong = []
    for row, folder in zip(table(PAGE, "## Section 7.3"), results.values(), strict=True):
        found = pd.read_parquet(folder / "dfa" / "dfa.parquet")
        columns = [(method, column) for method in ("df1", "df4") for column in ("p2p_rad", "amplitude_rad")]
        for printed, (method, column) in zip(row[1:], columns, strict=True):
            here = found[found.method == method]
            values = percent(here[column], here.sweep_p2p_rad)
            assert len(values) == (41 if "41 cells" in row[0] else 49)
            wrong += [f"{row[0]}: {method} {column}: {fault}" for fault in compare(printed, values)]
    assert not wrong


def test_the_law_in_every_reading(results: dict[str, Path]) -> None:
    """Peak to peak, the same from 464 Hz, as amplitude, and RMS; of trials that cycle, from their orbits."""
    wrong = []
    for row, folder in zip(table(PAGE, "## Section 9.3"), results.values(), strict=True):
        found = pd.read_parquet(folder / "predict" / "predict.parquet")
        found = found[found.law == "quantum_period"]
        orbits = pd.read_parquet(folder / "sweep" / "orbits.parquet")
        orbits = orbits[orbits.outcome == "cycle"]
        share = orbits.basin_fraction.groupby([orbits[key] for key in KEYS]).sum()
        sums = (orbits.rms_rad * orbits.basin_fraction).groupby([orbits[key] for key in KEYS]).sum()
        found = found.join((sums / share).rename("sweep_rms_rad"), on=KEYS)
        p2p = percent(found.p2p_rad, found.sweep_p2p_rad)
        series = (
            p2p,
            p2p[found.sample_rate_hz > 400.0],
            percent(2.0 * found.p2p_rad, found.sweep_p2p_rad),
            percent(found.rms_sine_rad, found.sweep_rms_rad),
        )
        for printed, values in zip(row[1:], series, strict=True):
            wrong += [f"{row[0]}: {fault}" for fault in compare(printed, values)]
    assert not wrong


def test_cells_that_rest(results: dict[str, Path]) -> None:
    cells = pd.read_parquet(results["hand_on_knob_stiffer"] / "sweep" / "cells.parquet")
    rests, nearly = (cells.at_rest_fraction == 1.0).sum(), (cells.at_rest_fraction.between(0.9, 0.999)).sum()
    assert nearly == 1
    assert (cells.at_rest_fraction > 0.0).sum() == rests + nearly
    says(PAGE, f"the knob rests in {rests} cells, and in a ninth in nearly all trials")


@pytest.mark.long
def test_against_the_largest_of_all_cycles(hknob: Command, tmp_path: Path) -> None:
    wrong = []
    bias = {"0.001 N·m": "{torque: 0.001}", "half a count": "{half_quantum: true}"}
    for i, row in enumerate(table(PAGE, "## Against the largest")):
        stiffness, push = row[0].removesuffix(" (41 cells)").split(", ")
        hand = ["-q", "--set", f"scene.hand.stiffness={stiffness}"]
        sweep = tmp_path / f"sweep{i}"
        ran(hknob, "sweep", EXPERIMENTS / "every_start.yaml", "-o", sweep, *hand, "--set", f"scene.bias={bias[push]}")
        dfa, laws = (EXPERIMENTS / f"{stage}_hand_on_knob.yaml" for stage in ("dfa", "predict"))
        against = [*hand, "--set", f"against={sweep}"]
        ran(hknob, "dfa", dfa, "-o", tmp_path / f"dfa{i}", *against, "--set", "methods=[df1, df4]")
        ran(hknob, "predict", laws, "-o", tmp_path / f"laws{i}", *against, "--set", "constant=500.0")
        found = pd.read_parquet(tmp_path / f"dfa{i}" / "dfa.parquet")
        law = pd.read_parquet(tmp_path / f"laws{i}" / "predict.parquet")
        several = [found[found.method == "df1"], found[found.method == "df4"], law[law.law == "quantum_period"]]
        for printed, here in zip(row[1:], several, strict=True):
            values = 100.0 * here.p2p_max_difference.dropna()
            assert len(values) == (41 if "41 cells" in row[0] else 49)
            wrong += [f"{row[0]}: {fault}" for fault in compare(printed, values)]
    assert not wrong
