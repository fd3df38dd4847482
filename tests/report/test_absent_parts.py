"""Summaries on the terminal say nothing of what is not in them: no footnote without its table, no word of a figure."""

from pathlib import Path

import pyarrow.parquet as pq
import pytest

from hknob_cli.stages.remedies.text import describe_trial, trial_text
from tests.page.shapes import SHAPES, make_result

FOOTNOTES = ("static K", "knock", "max mrad", "grid: median")


def said(folder: Path) -> str:
    """What the terminal shows of a trial of remedies."""
    grid, cases = (pq.read_table(folder / f"{name}.parquet") for name in ("remedies", "cases"))
    return trial_text({"name": "x", "status": "computed", **describe_trial(grid, cases)})


@pytest.mark.parametrize("shape", ["one cell", "two axes"])
def test_remedies_without_cases_print_no_footnotes_of_cases(shape: str, tmp_path: Path) -> None:
    text = said(make_result(f"remedies, {shape}", tmp_path))
    assert not [note for note in FOOTNOTES if note in text]
    lines = text.splitlines()
    heads = next(line for line in lines if "at rest %" in line)
    plain = next(line for line in lines if line.startswith("plain wall"))
    assert len(heads.split("  ")) > 4
    assert plain.split()[2:4] == ["1", "1"]  # times smaller than itself: median and least
    assert any(line.startswith("smaller: ") for line in lines)
    assert max(map(len, lines)) <= 110


def test_remedies_with_cases_explain_their_columns(tmp_path: Path) -> None:
    text = said(make_result("remedies with cases, one axis", tmp_path))
    assert all(note in text for note in FOOTNOTES)
    assert "over the grid, all cells and hands" not in text


def test_a_design_of_one_rate_has_no_word_of_a_surface_above(tmp_path: Path) -> None:
    from hknob_cli.report.design import describe_design, design_text
    from hknob_cli.specs.load import validate
    from hknob_cli.specs.source import parse

    for shape, shown in (("one axis", False), ("two axes", True)):
        name = f"design, {shape}"
        plan = validate(parse(SHAPES[name], "design.yaml"))
        table = pq.read_table(make_result(name, tmp_path / shape) / "design.parquet")
        text = design_text(plan, {"name": "x", "status": "computed", **describe_design(plan, table)})
        assert ("(above)" in text) == shown
        assert ("notional, 0 to 1" in text) == shown
