"""The record of `make bench`: what is written is read again, and what has changed notably is said."""

from pathlib import Path

import pytest

from tests.benchmarks import record

ROW = {"date": "2026-01-02", "commit": "abc", "load": "0.1", "--help": "2"}


def test_what_is_written_is_read_again() -> None:
    assert record.rows("") == []
    table = [ROW, {**ROW, "date": "2026-02-03", "NumPy": "11", "--help": ""}]
    found = record.rows(record.page(table))
    assert [{key: value for key, value in row.items() if value} for row in found] == [
        {key: value for key, value in row.items() if value} for row in table
    ]
    assert record.rows(record.page(found)) == found


def test_a_notable_change_is_said_against_the_last_that_was_measured() -> None:
    before = [ROW, {**ROW, "--help": "4"}, {**ROW, "--help": "", "NumPy": "10"}]
    assert record.changes(before, {"--help": 4.9, "NumPy": 8.1, "SciPy": 9000.0}) == []
    for worse in (5.1, 3.1):
        (said,) = record.changes(before, {"--help": worse})
        assert said.startswith(f"--help: {worse:.3g}, was 4 on 2026-01-02 (abc): time over")


def test_scripts_put_their_ratios_aside(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(record.PLACE, raising=False)
    record.put("NumPy", 1.0)  # a script by itself keeps nothing
    monkeypatch.setenv(record.PLACE, str(tmp_path / "ratios"))
    record.put("NumPy", 11.0)
    assert (tmp_path / "ratios").read_text() == '["NumPy", 11.0]\n'
    with pytest.raises(KeyError, match="NunPy"):
        record.put("NunPy", 1.0)


def test_every_ratio_is_put_by_a_script() -> None:
    text = "".join(record.RECORD.with_name(f"{name}.py").read_text() for name in record.SCRIPTS)
    assert all(f'"{name}"' in text for name in record.RATIOS)


def test_the_record_is_whole() -> None:
    text = record.RECORD.read_text()
    assert record.page(record.rows(text)) == text
    assert len(record.rows(text)) > 0
