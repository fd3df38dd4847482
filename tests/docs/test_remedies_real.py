"""The numbers of docs/explanation/remedies.md about a knob with friction, delay and lag."""

import math
import subprocess
from functools import cache
from itertools import takewhile
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from hknob_cli.specs.load import load
from hknob_cli.stages.remedies.run import RemediesStage
from tests.conftest import EXPERIMENTS, HKNOB, ROOT

from .page import says, table

PAGE = "explanation/remedies.md"
LAG = "scene.controller={kind: bounded_lag, keep: 0.15, time_constant: 0.2}"
TRIED_ON_PRESETS = (
    *("bounded lag, tuned", "phase damping, both ways, tuned", "first-order hold, corrected"),
    *("impulse, whole sample", "half-sample prediction"),
)
CELL = "base.grid={sample_rate_hz: 1000, counts_per_rev: 512, "


@cache
def tried(name: str, *overrides: str) -> pd.DataFrame:
    """Rows of the grid of a trial of remedies."""
    with RemediesStage(load(Path(EXPERIMENTS / f"{name}.yaml"), overrides)) as stage:
        return stage.run()[0].to_pandas()


def times(row: Any) -> str:
    """How many times smaller the largest cycle of a cell is, as the page has it: a star where it is not proven."""
    if math.isnan(row.p2p_max_rad):
        return "?"
    text = "rest" if row.at_rest_fraction == 1.0 else f"{float(f'{row.p2p_ratio:.2g}'):g}"
    return text if row.certified_fraction == 1.0 else text + "*"


IN_README = {"none": "plain wall", "virtual damping": "virtual damping, differenced, tuned"}


def readme_table() -> dict[str, str]:
    """The buzz of each remedy in the README's table."""
    lines = (ROOT / "README.md").read_text().partition("| remedy | buzz | costs |")[2].splitlines()[2:]
    cells = [[cell.strip() for cell in line.split("|")] for line in takewhile(str.strip, lines)]
    return {row[1]: row[2] for row in cells}


def test_the_readme_has_a_few_of_them() -> None:
    """Each is a row of the page; the numbers are compared where all are tried."""
    printed = {row[0] for row in table(PAGE, "## On a knob with friction, delay and lag")}
    assert len(readme_table()) == 6
    assert {IN_README.get(name, name) for name in readme_table()} <= printed


@pytest.mark.long
def test_the_table_of_remedies() -> None:
    """Every remedy, cell by cell; the plain wall in mrad. The columns are the cells in the order of the grid."""
    rows = dict(iter(tried("remedies_real").groupby("remedy")))
    printed = {row[0]: row[1:] for row in table(PAGE, "## On a knob with friction, delay and lag")}
    assert set(printed) == set(rows)
    for name, cells in printed.items():
        if name == "plain wall":
            assert cells == [f"{1e3 * size:.3g} mrad" for size in rows[name].p2p_max_rad]
        else:
            assert cells == [times(row) for row in rows[name].itertuples()], name
    plain, lag = (rows[name].iloc[2] for name in ("plain wall", "bounded lag"))
    small, large = (f"{1e3 * one.p2p_max_rad:.2g} mrad at {one.frequency_at_max_hz:.0f} Hz" for one in (lag, plain))
    says(PAGE, f"at 1 kHz and 512 counts {small} in place of {large}")
    for name, shown in readme_table().items():
        one = rows[IN_README.get(name, name)].iloc[2]
        assert (one.sample_rate_hz, one.counts_per_rev, one.certified_fraction) == (1000.0, 512, 1.0)
        buzz = f"{1e3 * one.p2p_max_rad:.2g} mrad, {one.frequency_at_max_hz:.0f} Hz"
        assert shown == ("rest" if one.at_rest_fraction == 1.0 else buzz), name


@pytest.mark.long
@pytest.mark.parametrize("preset", ["idrive", "hapkit"])
def test_remedies_on_a_knob_that_is_sold_or_built(preset: str) -> None:
    """The largest cycle in mrad, remedy by remedy and hand by hand."""
    found = tried("remedies_presets", f"base.scene.from={preset}").set_index(["hand", "remedy"])
    names = ("plain wall", *TRIED_ON_PRESETS)
    printed = {row[0]: row[1:] for row in table(PAGE, "## On knobs that are sold or built")}
    for hand in found.index.unique("hand"):
        cells = []
        for row in (found.loc[hand, name] for name in names):
            text = "rest" if row.at_rest_fraction == 1.0 else f"{1e3 * row.p2p_max_rad:.3g}"
            cells.append(text if row.certified_fraction == 1.0 else f"{text}*")
        assert printed[f"{preset}, {hand}"] == cells


INERTIAS = "knob.inertia: [2.0e-6, 1.0e-5, 2.0e-5, 5.0e-5]}"
MARGINS = {  # by the first column of the page's table: the axis, and what varies it
    "`actuator.delay_samples`": (),
    "`knob.coulomb_torque`": (CELL + "knob.coulomb_torque: [0, 1.0e-5, 1.0e-4, 3.0e-4, 5.6e-4, 8.0e-4, 1.12e-3]}",),
    "`knob.inertia`": (CELL + "knob.inertia: [2.0e-6, 5.0e-6, 1.0e-5, 2.0e-5, 5.0e-5]}",),
    "`knob.inertia`, friction 0.1 mN·m": (CELL + INERTIAS, "base.scene.knob.coulomb_torque=1.0e-4"),
    "`knob.inertia`, no friction": (CELL + INERTIAS, "base.scene.knob.coulomb_torque=0.0"),
}


@pytest.mark.long
@pytest.mark.parametrize("label", MARGINS)
def test_the_margins_of_the_bounded_lag(label: str) -> None:
    found = tried("remedies_real_margins", *MARGINS[label])
    found = found[found.remedy == "bounded lag"]
    assert (found.certified_fraction == 1.0).all()
    axis = found[label.split("`")[1]]
    printed = {row[0]: row[1] for row in table(PAGE, "### Margins of the bounded lag")}
    assert set(printed) == set(MARGINS)
    shown = [f"{value:.3g}: {times(row)}" for value, row in zip(axis, found.itertuples(), strict=True)]
    assert printed[label] == ", ".join(shown)


@pytest.mark.long
def test_how_deep_a_push_goes(tmp_path: Path) -> None:
    """The deepest point of the first half second, under the plain wall and under the bounded lag, and its ratio."""
    depths = []
    for i, change in enumerate(((), ("--set", LAG))):
        spec = EXPERIMENTS / "remedies_real_depth.yaml"
        done = subprocess.run([HKNOB, "sweep", spec, "-q", "-o", tmp_path / str(i), *change], check=False, timeout=300)
        assert done.returncode == 0
        motion = pd.read_parquet(tmp_path / str(i) / "trajectories.parquet")
        depths.append(-1e3 * motion.groupby("bias.torque").angle_rad.min())
    plain, lag = depths
    printed = [cells[1:] for cells in table(PAGE, "### How deep a push goes")]
    assert printed == [[f"{plain[b]:.1f} mrad", f"{lag[b]:.1f} mrad", f"{lag[b] / plain[b]:.1f}"] for b in plain.index]
