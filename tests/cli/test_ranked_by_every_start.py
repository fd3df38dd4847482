"""Remedies and designs judged by the largest cycle of every start in a range, through the installed command."""

import json
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from tests.cli.test_remedies import SMALL
from tests.designs import DESIGN

RANGE = "{angle: [-50 mrad, 50 mrad], velocity: [-5, 5], random: 24}"
REMEDIES = SMALL.replace("starts: {phases: 4}", f"starts: {RANGE}").replace("[1000, 2000]", "[1000]")
# With a velocity sensor sets of starts are not followed.
SENSED = REMEDIES.replace("bounded_lag, keep: 0.15, time_constant: 0.05", "half_sample, velocity: sensor")
SEARCH = DESIGN.replace("starts: {phases: 2}", f"starts: {RANGE}")


@pytest.mark.long
def test_remedies_are_compared_by_their_largest_cycles(hknob, spec_file, tmp_path: Path) -> None:
    """Lists are complete, with a controller too; what is found from one start stands beside."""
    done = hknob("remedies", spec_file(REMEDIES), "-o", "out")
    assert done.returncode == 0, done.stderr
    grid, cases = (pq.read_table(tmp_path / "out" / f"{name}.parquet").to_pylist() for name in ("remedies", "cases"))
    for row in (*grid, *cases):
        assert (row["complete"], row["random_starts"]) == (True, None)
    plain, lag = (
        next(row for row in cases if (row["remedy"], row["hand"]) == (name, "light"))
        for name in ("plain wall", "bounded lag")
    )
    assert plain["p2p_max_rad"] > 1.5 * plain["p2p_one_start_rad"]
    assert lag["p2p_ratio"] == plain["p2p_max_rad"] / lag["p2p_max_rad"]
    assert plain["stiffness_kept"] == 1.0
    assert lag["stiffness_kept"] == pytest.approx(1.0, abs=0.02)
    (head,) = (line for line in done.stdout.splitlines() if line.split()[:5] == ["max", "mrad", "from", "one", "start"])
    assert head
    words = {
        line.split()[0]: line.split() for line in done.stdout.splitlines() if line.startswith(("plain", "bounded"))
    }
    assert words["plain"][3] == "all"
    assert words["bounded"][3] == "all"


@pytest.mark.long
def test_one_start_is_as_before(hknob, spec_file, tmp_path: Path) -> None:
    """The column of one start is what the trial of that start finds; without ranges there is no such column."""
    assert hknob("remedies", spec_file(REMEDIES), "-o", "all").returncode == 0
    alone = spec_file(REMEDIES.replace(RANGE, "{phases: 16}"), "alone.yaml")
    done = hknob("remedies", alone, "-o", "one")
    assert "one start" not in done.stdout
    every, one = (pq.read_table(tmp_path / out / "cases.parquet") for out in ("all", "one"))
    assert every["p2p_one_start_rad"].to_pylist() == one["p2p_max_rad"].to_pylist()
    assert not {"complete", "random_starts", "p2p_one_start_rad"} & set(one.column_names)
    for column in ("stiffness_kept", "knock_ratio"):
        assert every[column].to_pylist() == one[column].to_pylist()


@pytest.mark.long
def test_designs_are_judged_by_their_largest_cycles(hknob, spec_file, tmp_path: Path) -> None:
    done = hknob("design", spec_file(SEARCH), "-o", "out")
    assert (done.returncode, done.stderr) == (0, "")
    rows = pq.read_table(tmp_path / "out" / "design.parquet").to_pylist()
    for row in rows:
        assert (row["complete"], row["random_starts"]) == (True, None)
    there = next(row for row in rows if row["present"])
    assert there["p2p_max_rad"] > there["p2p_one_start_rad"]
    words = " ".join(done.stdout.split())
    size, single = f"{1e3 * there['p2p_max_rad']:.3g}", f"{1e3 * there['p2p_one_start_rad']:.3g}"
    said = f"its largest cycle is {size} mrad, of every start in the ranges, as is proven; from one start {single} mrad"
    assert said in words
    again = json.loads(hknob("design", spec_file(SEARCH), "-o", "out", "--json").stdout)
    assert again["present"]["complete"]


@pytest.mark.long
def test_how_many_are_drawn_where_sets_cannot_be_followed(hknob, spec_file, tmp_path: Path) -> None:
    """As many as the spec says, or 256: the row says so."""
    for text, drawn in ((SENSED, 24), (SENSED.replace(", random: 24", ""), 256)):
        done = hknob("remedies", spec_file(text.replace("[360, 1024]", "[360]")), "-o", "out", "--force")
        assert done.returncode == 0, done.stderr
        rows = pq.read_table(tmp_path / "out" / "remedies.parquet").to_pylist()
        assert {(row["remedy"], row["random_starts"]) for row in rows} == {("plain wall", None), ("bounded lag", drawn)}
        words = {line.split()[0]: line.split() for line in done.stdout.splitlines() if line.startswith("bounded")}
        assert words["bounded"][3] == str(drawn)


@pytest.mark.parametrize(("command", "text"), [("remedies", REMEDIES), ("design", SEARCH)])
def test_faults_of_ranges_stand_in_the_base(command: str, text: str, hknob, spec_file) -> None:
    done = hknob(command, spec_file(text.replace("[-5, 5]", "0")))
    assert done.returncode == 2
    assert "base.starts.velocity: must be a range, [least, largest], as the other one is" in done.stderr
