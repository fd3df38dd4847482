"""The printed tables: read as described, found wherever the program is, and rounded as their digits say."""

import csv
import re
import shutil
import tomllib
from pathlib import Path

import pytest

from hknob_cli.errors import UsageError
from hknob_cli.printed import (
    FOLDERS,
    NUMBERS,
    catalogue,
    cell,
    file_of,
    folder,
    half_width,
    half_widths,
    printed,
    table,
)
from tests.conftest import ROOT


@pytest.mark.parametrize("number", NUMBERS)
def test_columns_are_those_described(number: int) -> None:
    entry = catalogue()[number]
    assert entry["file"] == file_of(number).name
    names = [column["name"] for column in entry["columns"]]
    for row in printed(number):
        assert list(row) == names
    assert entry["title"]
    assert entry["place"]
    assert all(column["meaning"] and "unit" in column for column in entry["columns"])
    assert all(isinstance(note, str) for note in entry["notes"])


def digits_ok(text: str, digits: str) -> bool:
    count, _, kind = digits.partition(" ")
    mantissa = text.upper().partition("E")[0]
    if kind.startswith("decimal"):
        return "E" not in text.upper() and len(mantissa.partition(".")[2]) == int(count)
    return len(mantissa.replace(".", "").lstrip("-0")) == int(count)


@pytest.mark.parametrize("number", NUMBERS)
def test_digits_are_those_described(number: int) -> None:
    for column in catalogue()[number]["columns"]:
        cells = [row[column["name"]] for row in printed(number) if row[column["name"]] not in ("", "N/A")]
        if column["digits"] == "text":
            continue
        if column["digits"] != "as printed":
            assert all(digits_ok(cell, column["digits"]) for cell in cells), column["name"]


def test_values_are_numbers_text_or_nothing() -> None:
    first = table(1)[0]
    assert first["inertia_kg_m2"] == 2.11e-6
    assert first["stiffness_nm_per_rad"] == 0.04
    assert len(table(1)) == 6
    assert [row["symbol"] for row in table(7)] == ["g", "K", "k", "b", "j", "B", "J"]
    totals = table(9)[-1]
    assert totals["medium_experimental_g_cm2"] == "N/A"
    assert table(9)[0]["small_experimental_g_cm2"] is None


@pytest.mark.parametrize(
    ("text", "half"), [("0.04", 0.005), ("2.11E-06", 5e-9), ("14.2", 0.05), ("3e-7", 5e-8), ("-12.0", 0.05), ("1", 0.5)]
)
def test_half_a_digit(text: str, half: float) -> None:
    assert half_width(text) == pytest.approx(half, rel=1e-12)


def test_one_cell_by_symbol_or_first_column() -> None:
    assert cell(7, "k", "value") == 0.08
    assert cell(7, "K", "value") == 0.27
    assert cell(1, 1.3, "damping_nm_s_per_rad") == 4.20e-4
    assert cell(8, "mean", "mean_n") == 0.72
    for number, row, column in (
        (1, 1.4, "damping_ratio"),
        (9, "TOTALS", "medium_experimental_g_cm2"),
        (7, "q", "value"),
    ):
        with pytest.raises(UsageError, match=f"table {number} has no number at"):
            cell(number, row, column)
    with pytest.raises(UsageError, match="table 1 has no column 'damp'; it has: grip_n, "):
        cell(1, 1.3, "damp")


def test_half_widths_are_of_numbers_only() -> None:
    assert set(half_widths(10)[3]) == {"small_proof", "small_experimental", "medium_proof", "large_proof"}


def test_found_in_the_package_first_then_in_the_repository(tmp_path: Path) -> None:
    assert folder() == ROOT / "data" / "printed"
    installed = tmp_path / "package" / "data"
    shutil.copytree(folder(), installed)
    assert folder((installed, folder())) == installed
    assert folder((tmp_path / "nowhere", installed)) == installed
    with pytest.raises(UsageError, match=r"no printed tables in .*nowhere"):
        folder((tmp_path / "nowhere",))


def test_a_wheel_has_them_where_the_package_looks() -> None:
    wheel = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["hatch"]["build"]["targets"]["wheel"]
    assert wheel["force-include"]["data/printed"] == "hknob_cli/data/printed"
    assert FOLDERS[0] == ROOT / "hknob_cli" / "data" / "printed"


def test_faults_say_which_table(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="no table 11; there are tables 1 to 10"):
        table(11)
    (tmp_path / "table_01.csv").write_text("a,b\n1\n")
    with pytest.raises(UsageError, match=r"table_01\.csv: not a table of rows and columns"):
        table(1, tmp_path)
    with pytest.raises(UsageError, match=r"table_02\.csv"):
        table(2, tmp_path)


def test_files_are_plain() -> None:
    for number in NUMBERS:
        text = file_of(number).read_text(encoding="utf-8")
        assert text.endswith("\n")
        assert not re.search(r"[ \t]\n|\r", text)
        assert len({len(row) for row in csv.reader(text.splitlines())}) == 1
