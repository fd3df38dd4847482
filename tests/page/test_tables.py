"""Tables of a page: which rows of a long file they show, in which units, and that names in them stay names."""

from pathlib import Path
from typing import Any

import pyarrow as pa

from hknob_cli.page.book import Chapter
from hknob_cli.page.compose import tables_of
from hknob_cli.page.layout import lay_out
from hknob_cli.page.tables import CUT, WHOLE, table_of
from hknob_cli.results.columns import CELLS
from hknob_cli.results.parted import Parting, as_file, put_part
from hknob_cli.results.provenance import describe
from hknob_cli.results.result_set import ResultSet
from hknob_cli.results.store import write
from tests.page.sample import page
from tests.page.test_layout import Tree

HOSTILE = "<script>alert(1)</script>\"'&</td></table>"


def cells(count: int, **columns: Any) -> pa.Table:
    """Cells over the sample rate whose size is largest in the middle."""
    rates = [100.0 + i for i in range(count)]
    sizes = [1e-3 / (1.0 + abs(i - count // 2)) for i in range(count)]
    given = {
        "sample_rate_hz": rates,
        "p2p_rad": sizes,
        "p2p_max_rad": sizes,
        "frequency_hz": [80.0] * count,
        "frequency_at_max_hz": [80.0] * count,
        "certified_fraction": [1.0] * count,
        "at_rest_fraction": [0.0] * count,
        **columns,
    }
    fields = {column.name: column.field() for column in CELLS}
    schema = pa.schema([fields.get(name, pa.field(name, pa.array(values).type)) for name, values in given.items()])
    return pa.table(given, schema=schema)


def evidence(folder: Path, table: pa.Table, *, parts: int = 1) -> ResultSet:
    """A sweep of these cells, in one file or in parts."""
    rates = table.column("sample_rate_hz").to_pylist()
    stamp = describe(stage="sweep", values={"name": "x", "grid": {"sample_rate_hz": rates}}, overrides=())
    folder.mkdir(exist_ok=True)
    if parts == 1:
        write({folder / "cells.parquet": table}, stamp)
        return ResultSet({"tried": folder})
    parting = Parting(table.num_rows, stamp, most=-(-table.num_rows // parts))
    (folder / "cells.parquet").mkdir()
    for number in range(parts):
        start, stop = parting.range(number)
        data = as_file(table.slice(start, stop - start), parting.metadata(number))
        put_part(data, folder / "cells.parquet", number)
    return ResultSet({"tried": folder})


def shown(found: ResultSet) -> Any:
    (plan,) = tables_of(found["tried"])
    return table_of(plan, found)


def test_a_short_table_is_whole_and_a_long_one_has_the_largest_and_says_of_how_many(tmp_path: Path) -> None:
    short = shown(evidence(tmp_path / "short", cells(WHOLE)))
    assert len(short.rows) == WHOLE
    assert short.caption.startswith(f"All {WHOLE} rows of cells.parquet.")
    long = shown(evidence(tmp_path / "long", cells(2001)))
    assert len(long.rows) == CUT
    assert long.caption.startswith("40 of 2,001 rows of cells.parquet: those with the largest values")
    assert long.rows[0][:2] == ("1100", "1")  # 1 mrad, in the middle
    assert {row[0] for row in long.rows} == {str(1100 + i) for i in range(-20, 20)}  # of equals the first


def test_a_table_in_parts_is_cut_to_the_same_rows(tmp_path: Path) -> None:
    whole, parted = (shown(evidence(tmp_path / f"{n}", cells(2001), parts=n)) for n in (1, 3))
    assert parted == whole


def test_units_are_those_of_the_file_and_shares_are_in_per_cent(tmp_path: Path) -> None:
    half = cells(2, p2p_max_rad=[2e-3, 1e-3], frequency_at_max_hz=[80.0, 90.0], at_rest_fraction=[0.5, 0.0])
    table = shown(evidence(tmp_path, half))
    units = {head.name: head.unit for head in table.heads}
    assert units["sample rate"] == "Hz"
    assert units["peak to peak, largest cycle"] == units["peak to peak"] == "mrad"
    assert units["at rest"] == "%"
    assert [head.name for head in table.heads][1:4] == [
        "peak to peak, largest cycle",
        "frequency, largest cycle",
        "peak to peak",
    ]
    assert [row[1] for row in table.rows] == ["2", "1"]
    assert "50" in table.rows[0]
    assert all(head.meaning for head in table.heads if head.name != "sample rate")


def test_what_is_the_same_in_every_row_is_said_once_and_what_has_no_value_too(tmp_path: Path) -> None:
    still = cells(2, p2p_rad=[None, None], p2p_max_rad=[0.0, 0.0], frequency_hz=[None, None])
    table = shown(evidence(tmp_path, still.drop(["frequency_at_max_hz"])))
    assert "peak to peak" not in {head.name for head in table.heads}
    notes = " ".join(table.notes)
    assert "proven 100 %" in notes
    assert "Without a value in any row: peak to peak; frequency." in notes


def test_names_in_tables_stay_names(tmp_path: Path) -> None:
    one = cells(3, reason=[HOSTILE, "b", ""])
    found = shown(evidence(tmp_path, one))._replace(title=HOSTILE, notes=(HOSTILE,))
    given = page(2)._replace(chapters=(Chapter("a", "A", (), (), (found,)),))
    tree = Tree(lay_out(given))
    assert tree.open == []
    assert sum(tag == "script" for tag, _ in tree.elements) == 1
    assert sum(HOSTILE in text for text in tree.text) == 3
