"""Tests of `perception.level`: the data are found wherever the program is, each with its source."""

import tomllib
from pathlib import Path

import pytest

from hknob_cli.errors import UsageError
from hknob_cli.perception import level as module
from hknob_cli.perception.level import FOLDERS, SENSES, columns, data_digest, folder, published
from tests.conftest import ROOT


def test_the_wheel_carries_the_data_where_it_is_looked_for() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    included = project["tool"]["hatch"]["build"]["targets"]["wheel"]["force-include"]
    assert included["data/perception"] == "hknob_cli/perception/data"
    assert FOLDERS[0] == Path(module.__file__).parent / "data"
    assert folder((ROOT / "nowhere", ROOT / "data" / "perception")) == ROOT / "data" / "perception"


def test_data_that_is_missing_is_said(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="no thresholds of perception in"):
        folder((tmp_path,))


@pytest.mark.parametrize("sense", SENSES)
def test_every_entry_says_its_source_and_where_it_was_read(sense: str) -> None:
    data = published(sense)
    entries = data.get("thresholds") or data["editions"]
    assert data["default"] in entries
    for entry in entries.values():
        assert len(entry["source"]) > 20
        assert len(entry["read_in"]) > 20


def test_the_digest_is_of_the_content() -> None:
    assert len(data_digest()) == 64
    assert set(columns("iso226_2003.csv")) == {"frequency_hz", "alpha", "transfer_db", "threshold_db"}


@pytest.mark.parametrize("sense", ["touch", "torque"])
def test_every_set_says_what_was_not_read_and_how_well_it_is_known(sense: str) -> None:
    for entry in published(sense)["thresholds"].values():
        assert len(entry["not_read"]) > 20
        assert entry["known_to_db"] > 0
    assert len(published("hearing")["not_read"]) > 20


def test_no_number_is_called_read_in_a_full_text() -> None:
    """Abstracts were read, and another's extracts; a set that says more than that must say where."""
    for entry in published("touch")["thresholds"].values():
        assert "full text" not in entry["read_in"]
        assert "ledger" in entry["read_in"] or "abstract" in entry["read_in"]
