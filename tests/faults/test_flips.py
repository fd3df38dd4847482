"""A share of the campaign of flipped bits (`flips.py`)."""

from pathlib import Path

import pytest

from tests.faults.flips import flip_over_and_over


@pytest.mark.long
def test_no_flipped_bit_is_believed(tmp_path: Path) -> None:
    found = flip_over_and_over(tmp_path, flips=300, seed=20261123, rerun_every=150)
    assert found["made again by the command"] == 2
    assert {".parquet", ".html", ".svg", ".png", ".piece", ".nbi", ".nbc", ".json"} <= set(found)
