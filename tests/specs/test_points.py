"""Points of a design by number: those of scipy and numpy, the same however runs are cut, evenly spread on the axes."""

import pickle
from collections import Counter

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import qmc

from hknob_cli.specs.cells import DesignCells, cells_of
from hknob_cli.specs.plan import COUNTS, PERSON, RATE
from hknob_cli.specs.unit_points import MOST_POINTS, Points, UnitPoints
from tests.conftest import SPEC, loaded

METHODS = sorted(MOST_POINTS)
DESIGN = SPEC.replace(
    "  sample_rate_hz: [1000]\n  counts_per_rev: [1024]",
    "  design: {sobol: 64, seed: 3}\n  sample_rate_hz: {log: [100, 10000]}\n  counts_per_rev: {log: [128, 8192]}\n"
    "  hand.stiffness: {lin: [0.02, 0.2]}\n  wall.stiffness: [0.1, 0.2, 0.3, 0.4]\n  bias.torque: 0.001",
)


def whole(method: str, count: int, dimensions: int, seed: int) -> np.ndarray:
    """All points at once, as the libraries give them."""
    if method == "random":
        return np.random.Generator(np.random.PCG64(seed)).random((count, dimensions))
    kinds = {"sobol": qmc.Sobol, "halton": qmc.Halton, "latin_hypercube": qmc.LatinHypercube}
    return kinds[method](dimensions, rng=seed).random(count)


@pytest.mark.parametrize("method", METHODS)
def test_points_are_those_of_the_library(method: str) -> None:
    found = UnitPoints(method, count=256, dimensions=5, seed=7).run(0, 256)
    assert np.array_equal(found, whole(method, 256, 5, 7))


@pytest.mark.one_in(2)
@pytest.mark.parametrize("method", METHODS)
@given(data=st.data())
def test_runs_of_points_do_not_depend_on_how_they_are_cut(method: str, data: st.DataObject) -> None:
    count = data.draw(st.integers(1, 40))
    seed = data.draw(st.integers(0, 2**32 - 1))
    every = UnitPoints(method, count=count, dimensions=3, seed=seed)
    at_once = every.run(0, count)
    for _ in range(4):  # of one object, forwards and backwards
        start = data.draw(st.integers(0, count))
        stop = data.draw(st.integers(start, count))
        assert np.array_equal(every.run(start, stop), at_once[start:stop])
    there = pickle.loads(pickle.dumps(every))  # another process goes on anywhere
    assert np.array_equal(there.run(count // 2, count), at_once[count // 2 :])


@pytest.mark.one_in(3)
@pytest.mark.parametrize("method", ["halton", "sobol", "random"])
def test_far_points_are_reached_without_those_before(method: str) -> None:
    far = MOST_POINTS[method] - 3
    found = UnitPoints(method, count=MOST_POINTS[method], dimensions=2, seed=1).run(far, far + 3)
    again = UnitPoints(method, count=MOST_POINTS[method], dimensions=2, seed=1).run(far + 1, far + 2)
    assert found.shape == (3, 2)
    assert np.array_equal(found[1:2], again)


@pytest.mark.parametrize("method", METHODS)
def test_cells_of_a_design_by_run_and_by_column(method: str) -> None:
    cells = cells_of(loaded(DESIGN.replace("sobol: 64", f"{method}: 64")))
    listed = list(cells)
    assert len(listed) == len(cells) == 64
    for start, stop in ((0, 64), (0, 1), (5, 5), (7, 40), (63, 64)):
        assert list(cells.run(start, stop)) == listed[start:stop]
        columns = cells.columns(start, stop)
        assert list(columns) == [RATE, COUNTS, "hand.stiffness", "wall.stiffness", "bias.torque"]
        assert columns[COUNTS].dtype == np.int64
        rows = zip(*(column.tolist() for column in columns.values()), strict=True)
        assert [dict(zip(columns, row, strict=True)) for row in rows] == listed[start:stop]


def test_a_sobol_design_fills_its_ranges_evenly() -> None:
    # Of 2^m points of a (t, m, s)-net in base 2 each of 2^k equal parts of an axis has 2^(m - k).
    columns = cells_of(loaded(DESIGN)).columns(0, 64)
    for name, low, high in ((RATE, 100.0, 1e4), ("hand.stiffness", 0.02, 0.2)):
        place = np.log(columns[name] / low) / np.log(high / low) if name == RATE else (columns[name] - low) / 0.18
        assert np.array_equal(np.histogram(place, bins=16, range=(0, 1))[0], np.full(16, 4))
        assert low <= columns[name].min() < columns[name].max() <= high
    assert set(Counter(columns["wall.stiffness"].tolist()).values()) == {16}
    assert columns[COUNTS].min() >= 128
    assert columns[COUNTS].max() <= 8192
    assert set(columns["bias.torque"].tolist()) == {0.001}


def test_a_single_value_takes_no_dimension() -> None:
    without = loaded(DESIGN.replace("\n  bias.torque: 0.001", ""))
    first, second = (cells_of(plan).columns(0, 64) for plan in (without, loaded(DESIGN)))
    assert all(np.array_equal(first[name], second[name]) for name in first)


def test_the_seed_chooses_the_points() -> None:
    one, same, other = (
        list(cells_of(loaded(DESIGN.replace("seed: 3", f"seed: {seed}"))).run(0, 9)) for seed in (3, 3, 4)
    )
    assert one == same
    assert one != other


def test_a_range_wider_than_floats_divide() -> None:
    axes = {"hand.stiffness": [1e-300, 1e300]}
    points = Points("random", 100, 1, {"hand.stiffness": "log"})
    values = DesignCells(axes, points).columns(0, 100)["hand.stiffness"]
    assert np.isfinite(values).all()
    assert 5 < (values < 1.0).sum() < 95


def test_people_are_crossed_with_the_points_fastest() -> None:
    text = DESIGN.replace("  hand: {inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}\n", "")
    text = text.replace("  hand.stiffness: {lin: [0.02, 0.2]}\n", "")
    plan = loaded(text + "population: {table: 1, grip_n: 0.71, people: 3}\n")
    cells = cells_of(plan)
    assert len(cells) == 3 * 64
    listed = list(cells)
    assert [cell[PERSON] for cell in listed] == [1, 2, 3] * 64
    points = [{name: value for name, value in cell.items() if name != PERSON} for cell in listed]
    assert points[0::3] == points[1::3] == points[2::3]
    assert list(cells.run(4, 9)) == listed[4:9]
    assert list(plan.axes)[-1] == PERSON


def test_pieces_go_on_where_the_last_stood() -> None:
    plan = loaded(DESIGN)
    first, second = cells_of(plan), cells_of(plan)
    assert isinstance(first, DesignCells)
    assert isinstance(second, DesignCells)
    assert first._unit is second._unit


@pytest.mark.parametrize("method", METHODS)
def test_points_without_ranges_are_counted_all_the_same(method: str) -> None:
    assert UnitPoints(method, count=5, dimensions=0, seed=1).run(1, 4).shape == (3, 0)
