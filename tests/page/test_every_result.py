"""A report that lists nothing but a result shows it, whatever its kind and shape: its rows, and a picture."""

from html.parser import HTMLParser
from math import isnan
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from hknob_cli.figures.numbers import numeral
from hknob_cli.page.tables import WHOLE
from tests.page.shapes import SHAPES, make_report, make_result

# Of every file of results that is a table: a column of numbers that a reader looks for, and the factor to its unit.
LOOKED_FOR = {
    "cells": ("p2p_rad", 1e3),
    "orbits": ("p2p_rad", 1e3),
    "dfa": ("p2p_rad", 1e3),
    "predict": ("p2p_rad", 1e3),
    "passivity": ("colgate_schenkel_load", 1.0),
    "differences": ("mean", 100.0),
    "remedies": ("p2p_rad", 1e3),
    "cases": ("p2p_rad", 1e3),
    "design": ("cost", 1.0),
    "conditions": ("inertia_kg_m2", 1e7),
    "trials": ("inertia_kg_m2", 1e7),
    "calibration": ("value", 1.0),
    "bias": ("bias_percent", 1.0),
    "hidden_inertia": ("inertia_kg_m2", 1e7),
    "bench": ("seconds", 1.0),
}
RECORDED = {"samples", "timing", "trajectories", "recordings", "calibration_points"}  # drawn, not listed


class Shown(HTMLParser):
    """Tables of results on a page, by id: rows of texts without their head; and the texts in the page's pictures."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.tables: dict[str, list[list[str]]] = {}
        self.pictures: list[list[str]] = []
        self.missing = "No picture here" in page
        self._rows: list[list[str]] | None = None
        self._in_body = self._in_cell = self._in_svg = False
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        if "rows" in (given.get("class") or "").split():
            self._rows = self.tables.setdefault(str(given["id"]), [])
        if tag == "figure":
            self.pictures.append([])
        self._in_svg |= tag == "svg" and given.get("role") == "img"
        self._in_body |= tag == "tbody"
        if self._rows is not None and self._in_body:
            if tag == "tr":
                self._rows.append([])
            elif tag in ("td", "th"):
                self._rows[-1].append("")
                self._in_cell = True

    def handle_endtag(self, tag: str) -> None:
        self._in_cell &= tag not in ("td", "th")
        self._in_svg &= tag != "svg"
        if tag == "tbody":
            self._in_body, self._rows = False, None

    def handle_data(self, data: str) -> None:
        if self._in_cell and self._rows is not None:
            self._rows[-1][-1] += data
        elif self._in_svg and self.pictures and data.strip():
            self.pictures[-1].append(data.strip())


@pytest.mark.one_in(16)
@pytest.mark.parametrize("name", SHAPES)
def test_a_result_is_shown_with_its_rows_and_a_picture(name: str, tmp_path: Path) -> None:
    folder = make_result(name, tmp_path)
    shown = Shown(make_report({"mine": folder}, tmp_path).read_text(encoding="utf-8"))
    assert not shown.missing
    assert shown.pictures
    assert all(len(texts) >= 2 for texts in shown.pictures)  # axes with their names
    files = {path.stem: pq.read_table(path) for path in folder.glob("*.parquet") if path.stem not in RECORDED}
    full = {file: table for file, table in files.items() if table.num_rows}
    assert set(full) <= {one.removeprefix("table-mine-").replace("-", "_") for one in shown.tables}
    for file, table in full.items():
        rows = shown.tables[f"table-mine-{file.replace('_', '-')}"]
        column, factor = LOOKED_FOR[file]
        if column not in table.column_names:  # trials of a campaign
            column, factor = "p2p_rad", 1e3
        if table.num_rows <= WHOLE and table.num_rows > 1:
            assert len(rows) == table.num_rows
        written = {cell.split(" ")[0] for row in rows for cell in row}
        values = [value for value in table.column(column).to_pylist() if value is not None and not isnan(value)]
        if table.num_rows > WHOLE:
            values = [max(values)]
        assert {numeral(factor * value).split(" ")[0] for value in values} <= written, (file, column)
