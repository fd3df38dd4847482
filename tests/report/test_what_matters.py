"""What each axis explains of the order of sizes: against Kruskal and Wallis, and on sizes that are known."""

from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from scipy.stats import kruskal, qmc, rankdata, spearmanr

from hknob_cli.report import large
from hknob_cli.report.large import thinned
from hknob_cli.report.what_matters import (
    MOST_BINS,
    describe_matters,
    is_map,
    matters_of,
    matters_text,
    ranks,
    what_matters,
)
from hknob_cli.results.parted import as_file, part_metadata, put_part, read_parted

COUNT = 1024
UNIT = qmc.Sobol(3, rng=1).random(COUNT)


def columns(size: np.ndarray, **others: np.ndarray) -> dict[str, np.ndarray]:
    """Cells of a design of the axes a, b, c."""
    axes = dict(zip("abc", UNIT.T, strict=True))
    rest = (size == 0.0).astype(float)
    return {
        **axes,
        "p2p_max_rad": size,
        "frequency_at_max_hz": np.full(COUNT, 80.0),
        "at_rest_fraction": rest,
        **others,
    }


def explained(found: dict[str, np.ndarray]) -> dict[str, float]:
    return {one.axis: one.explained for one in what_matters(found, "abc")}


def test_ranks_share_places() -> None:
    values = np.array([3.0, 1.0, 3.0, 0.0, 0.0, 0.0, 9.0])
    assert ranks(values).tolist() == rankdata(values).tolist()


def test_what_is_explained_is_epsilon_squared() -> None:
    size = UNIT[:, 0] ** 2 + 0.3 * UNIT[:, 1]
    size[UNIT[:, 2] < 0.2] = 0.0
    levels = np.floor(5 * UNIT[:, 0])
    (one,) = what_matters(columns(size, level=levels), ["level"])
    groups = [size[levels == level] for level in range(5)]
    eta = kruskal(*groups).statistic / (COUNT - 1)
    # Both are a few sums of 1024 terms; 1e-9 is far above their rounding.
    assert one.explained == pytest.approx(1.0 - (1.0 - eta) * (COUNT - 1) / (COUNT - 5), abs=1e-9)
    assert one.correlation == pytest.approx(spearmanr(levels, size).statistic, abs=1e-9)
    assert [found.value for found in one.bins] == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert sum(found.cells for found in one.bins) == COUNT


def test_the_axis_that_matters_most_comes_first() -> None:
    found = what_matters(columns(1e-3 * 10.0 ** (2.0 * UNIT[:, 1] - UNIT[:, 0])), "abc")
    assert [one.axis for one in found] == ["b", "a", "c"]
    assert [np.sign(round(one.correlation, 1)) for one in found] == [1.0, -1.0, 0.0]
    assert found[0].explained > 0.6 > found[1].explained > 0.1
    # Of nothing, bins explain nothing on average; over 1024 points their scatter is (k - 1) / n, about 0.01.
    assert found[2].explained < 0.03
    assert all(len(one.bins) == MOST_BINS for one in found)


def test_any_scale_is_the_same() -> None:
    size = 0.1 + UNIT[:, 0] * UNIT[:, 1]
    assert explained(columns(size)) == explained(columns(np.exp(5.0 * size)))


def test_a_turn_is_seen() -> None:
    one = what_matters(columns(0.1 + np.abs(UNIT[:, 0] - 0.5)), "abc")[0]
    assert one.axis == "a"
    assert abs(one.correlation) < 0.05
    assert one.explained > 0.9


def test_rest_is_the_smallest_and_told_apart() -> None:
    size = np.where(UNIT[:, 2] < 0.5, 0.0, 1e-3)
    one = what_matters(columns(size), "abc")[0]
    assert one.axis == "c"
    assert one.explained > 0.95
    assert one.bins[0].share == 1.0
    assert one.bins[0].p2p_rad is None
    assert one.bins[-1].share == 0.0
    assert one.bins[-1].p2p_rad == (1e-3, 1e-3, 1e-3)
    text = "\n".join(matters_text(describe_matters([one]), str(COUNT)))
    assert "- to 1" in text
    assert "100 to 0" in text


def test_unknown_sizes_are_left_out_and_few_say_nothing() -> None:
    size = 0.1 + UNIT[:, 0]
    size[::2] = np.nan
    assert sum(found.cells for found in what_matters(columns(size), "a")[0].bins) == COUNT // 2
    size[20:] = np.nan
    assert what_matters(columns(size), "abc") == []
    assert what_matters(columns(np.zeros(COUNT)), "abc")[0].explained == 0.0


@pytest.mark.parametrize(
    ("a", "b", "c", "there"),
    [
        ([1, 1, 2, 2], [1, 2, 1, 2], [5, 5, 5, 5], True),
        ([1, 1, 2, 2], [1, 2, 1, 1], [5, 5, 5, 5], False),
        ([1, 2, 3, 4], [1, 1, 1, 1], [5, 5, 5, 5], True),
        ([1, 1, 2, 2], [1, 2, 1, 2], [1, 1, 1, 2], False),
        ([1, 1, 1, 1], [1, 1, 1, 1], [1, 1, 1, 1], True),
    ],
)
def test_a_map_has_two_axes_and_every_cell(a: list, b: list, c: list, there: bool) -> None:
    assert is_map({"a": np.array(a), "b": np.array(b), "c": np.array(c)}, "abc") == there


def test_what_does_not_repeat_has_the_size_of_its_swing() -> None:
    """Beside a clock that jitters: else only what rests would be left, and jitter would quiet the knob."""
    rows = [
        {
            **{"clock.jitter": jitter, "a": a, "b": b, "p2p_max_rad": None if jitter else 1e-3 * a},
            **{"frequency_at_max_hz": None if jitter else 80.0, "jitter_max_rad": 3e-3 * a if jitter else None},
            "at_rest_fraction": 0.0,
        }
        for jitter in (0.0, 0.2)
        for a in (1.0, 2.0, 3.0)
        for b in (1.0, 2.0, 3.0)
    ]
    found = {one.axis: one for one in matters_of(rows, ["clock.jitter", "a", "b"])}
    first, last = found["clock.jitter"].bins
    assert (first.cells, last.cells) == (9, 9)
    assert first.p2p_rad
    assert last.p2p_rad
    assert (first.p2p_rad[1], last.p2p_rad[1]) == (2e-3, pytest.approx(6e-3))
    assert last.frequency_hz is None
    assert found["clock.jitter"].correlation > 0.5


def test_persons_matter_by_their_hands() -> None:
    size = 0.1 + UNIT[:, 0]
    table = pa.table(columns(size, person=np.arange(COUNT), hand_stiffness_nm_per_rad=UNIT[:, 1]))
    assert {one.axis for one in matters_of(table.to_pylist(), ["a", "b", "c", "person"])} == {
        "a", "b", "c", "hand_stiffness_nm_per_rad",
    }  # fmt: skip


def write_part(table: pa.Table, folder: Path, number: int, count: int) -> None:
    put_part(as_file(table, part_metadata(number, count, b"stamp")), folder, number)


def test_large_tables_are_looked_at_all_over(tmp_path: Path) -> None:
    for number in range(3):
        write_part(pa.table({"a": np.arange(100.0) + 100 * number}), tmp_path, number, 3)
    parted = read_parted(tmp_path)
    assert parted is not None
    values = thinned(parted, ["a"])["a"]
    assert sorted(values.tolist()) == list(range(300))  # fewer than may be looked at: all


def test_cells_of_a_short_last_part_count_as_much_as_others(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(large, "PART_CELLS", 100)
    for number, rows in enumerate((100, 20)):
        write_part(pa.table({"part": np.full(rows, float(number))}), tmp_path, number, 2)
    parted = read_parted(tmp_path)
    assert parted is not None
    values = thinned(parted, ["part"])["part"]
    assert [int((values == number).sum()) for number in range(2)] == [84, 17]  # 100 of 120 cells, rounded up


def test_parts_are_looked_at_out_of_step_with_the_grid(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # An axis of two values, each a part long: parts evenly spaced would all have the same.
    monkeypatch.setattr(large, "MOST_LOOKED_AT", 16)
    for number in range(64):
        write_part(pa.table({"a": np.full(4, float(number % 2))}), tmp_path, number, 64)
    parted = read_parted(tmp_path)
    assert parted is not None
    values = thinned(parted, ["a"])["a"]
    assert len(values) == 4 * 16
    assert set(values.tolist()) == {0.0, 1.0}
    assert thinned(parted, ["a"])["a"].tolist() == values.tolist()
