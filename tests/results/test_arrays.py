"""Counting words by their codes."""

import pyarrow as pa

from hknob_cli.results.arrays import build_array, tally


def test_words_are_counted_in_every_chunk_of_whatever_codes() -> None:
    first = pa.array(["rest", "cycle", "cycle"]).dictionary_encode()
    second = pa.array(["cycle", "diverged", "cycle", "undecided"]).dictionary_encode()
    column = pa.chunked_array([first, second.slice(1, 2), first.slice(0, 0)])
    assert +tally(column) == {"rest": 1, "cycle": 3, "diverged": 1}


def test_lists_of_records_are_as_arrow_makes_them() -> None:
    """Empty lists, missing texts and numbers, and NaN, which is no number."""
    kind = pa.list_(pa.struct([("name", pa.string()), ("value", pa.float64())]))
    rows = [[{"name": "a", "value": 1.5}, {"name": None, "value": None}], [], [{"name": "µ", "value": 2.0}]]
    made = build_array(kind, rows)
    made.validate(full=True)
    assert made.equals(pa.array(rows, kind))
    assert build_array(kind, [[{"name": "a", "value": float("nan")}]]).to_pylist() == [[{"name": "a", "value": None}]]
    assert build_array(kind, []).to_pylist() == []
