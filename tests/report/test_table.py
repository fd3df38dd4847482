"""Tables and text in the width of the terminal: no line is wider, and every value is there, whole."""

import pytest

from hknob_cli.report.table import NO_TERMINAL, columns, folded, grid, table

WIDTHS = (40, 60, 80, 100, 120)
NUMBERS = [[f"{1000.0 / (7 * i + j + 1):.6g}" for j in range(14)] for i in range(5)]


def words(lines: list[str]) -> list[str]:
    return [word for line in lines for word in line.split()]


@pytest.mark.parametrize("width", WIDTHS)
def test_a_wide_list_is_given_to_several_tables_that_repeat_the_keys(width: int) -> None:
    heads = ["key", *(f"column{j}" for j in range(13))]
    rows = [[f"k{i}", *line[1:]] for i, line in enumerate(NUMBERS)]
    lines = table(heads, rows, width=width)
    assert max(map(len, lines)) <= width
    found = words(lines)
    assert all(number in found for line in rows for number in line)
    assert found.count("k3") == found.count("key")


def test_a_list_that_fits_is_one_table() -> None:
    assert table(["a", "b"], [["1", "22"], ["333", "4"]], left={1}, width=80) == ["  a  b", "  1  22", "333  4"]


def test_few_rows_become_columns() -> None:
    lines = table([f"quantity{i}" for i in range(9)], [[f"{i}.25" for i in range(9)]], width=60)
    assert lines[3] == "quantity3  3.25"
    assert len(lines) == 9


@pytest.mark.parametrize("width", WIDTHS)
def test_long_text_is_broken_between_words_beside_its_row(width: int) -> None:
    why = "the push is far from half a torque step, and the motion spans more than the counts beside one edge"
    lines = table(["law", "why"], [["first", why], ["second", ""]], left={0, 1}, flow=1, width=width)
    assert max(map(len, lines)) <= width
    assert " ".join(words(lines[1:])) == f"first {why} second"


@pytest.mark.parametrize("width", WIDTHS)
def test_a_grid_is_exchanged_or_given_to_several_tables(width: int) -> None:
    names, heads = [str(i) for i in range(5)], [str(100 * j) for j in range(14)]
    lines = grid("sizes", "sample_rate_hz", "counts_per_rev", names, heads, NUMBERS, width=width)
    assert max(map(len, lines)) <= width
    assert all(number in words(lines) for line in NUMBERS for number in line)
    if width == 60:
        assert lines[1] == "counts_per_rev  sample_rate_hz"


@pytest.mark.parametrize("width", WIDTHS)
def test_text_is_broken_between_words_and_a_value_stays_with_its_deviation(width: int) -> None:
    text = "grip 0.72 ± 0.04 N, " * 12 + "\n  second line " + "1.2345678e-05 " * 12
    lines = folded(text, width).split("\n")
    assert max(map(len, lines)) <= width
    assert words(lines) == text.split()
    assert not any(line.endswith("±") or line.lstrip().startswith("±") for line in lines)


def test_the_width_is_that_of_columns_else_80(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "61")
    assert columns() == 61
    monkeypatch.setenv("COLUMNS", "not a number")
    for name in ("stdin", "stdout", "stderr"):
        monkeypatch.setattr(f"sys.{name}", None)
    assert columns() == NO_TERMINAL == 80
