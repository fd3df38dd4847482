"""Counting words by their codes."""

import pyarrow as pa

from hknob_cli.results.arrays import tally


def test_words_are_counted_in_every_chunk_of_whatever_codes() -> None:
    first = pa.array(["rest", "cycle", "cycle"]).dictionary_encode()
    second = pa.array(["cycle", "diverged", "cycle", "undecided"]).dictionary_encode()
    column = pa.chunked_array([first, second.slice(1, 2), first.slice(0, 0)])
    assert +tally(column) == {"rest": 1, "cycle": 3, "diverged": 1}
