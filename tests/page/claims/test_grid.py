"""Checks of grids, against tables made by hand."""

import pytest

from hknob_cli.errors import UsageError
from hknob_cli.page.claims.checks import compute
from hknob_cli.results.result_set import MissingError
from tests.page.claims.conftest import Made, cell, lawful


def test_values_shares_and_counts(made: Made) -> None:
    evidence = made(
        "a", {"cells": [cell(100, 128, 4.0, 10.0), cell(100, 256, 1.0, 30.0), cell(215.44, 128, 2.0, 50.0)]}
    )

    def of(name: str, **arguments: object) -> float | None:
        return compute(name, evidence, {"result": "a", **arguments})

    assert of("cell_statistic", column="p2p_rad") == pytest.approx(7.0 / 3.0)
    assert of("cell_statistic", column="p2p_rad", statistic="median") == 2.0
    assert of("cell_statistic", column="p2p_rad", where={"sample_rate_hz": 215}) == 2.0, "rates are printed rounded"
    assert of("cell_statistic", column="p2p_rad", over="frequency_hz", statistic="largest") == 0.4
    assert of("share_of_cells", having={"p2p_rad": {"at_least": 2}}) == pytest.approx(200.0 / 3.0)
    assert of("share_of_cells", having={"p2p_rad": {"above": 2}}) == pytest.approx(100.0 / 3.0)
    assert of("count_of_cells", having={"p2p_rad": {"below": 1}}) == 0.0
    assert of("largest_over", column="frequency_hz", at={"sample_rate_hz": 100, "counts_per_rev": 128}) == 5.0


def test_a_bound_keeps_what_where_has_for_the_same_column(made: Made) -> None:
    evidence = made("a", {"cells": [cell(100, n, 1.0 / n, 10.0) for n in (1, 2, 4)]})
    having, where = {"p2p_rad": {"below": 0.6}}, {"p2p_rad": {"above": 0.3}}
    assert compute("count_of_cells", evidence, {"result": "a", "having": having, "where": where}) == 1.0


def test_trends_count_steps_of_every_line(made: Made) -> None:
    rows = [cell(rate, counts, 1.0, rate + counts) for rate in (100, 200, 400) for counts in (128, 256)]
    rows[2]["frequency_hz"] = 1.0
    evidence = made("a", {"cells": rows})
    up = {"result": "a", "column": "frequency_hz", "along": "sample_rate_hz", "direction": "up"}
    assert compute("trend", evidence, up) == 75.0
    assert compute("trend", evidence, {**up, "direction": "down"}) == 25.0
    assert compute("trend", evidence, {**up, "column": "p2p_rad"}) == 0.0, "level is neither up nor down"


def test_exponents_are_those_of_a_law(made: Made) -> None:
    evidence = made("a", {"cells": lawful()})

    def of(name: str, **arguments: object) -> float | None:
        return compute(name, evidence, {"result": "a", **arguments})

    assert of("slope", column="p2p_rad", along="sample_rate_hz") == pytest.approx(-1.0)
    assert of("slope", column="p2p_rad", along="counts_per_rev", average=True) == pytest.approx(-1.0)
    assert of("slope", column="frequency_hz", along="sample_rate_hz") == pytest.approx(0.5)
    assert of("slope_ratio", column="frequency_hz", to="p2p_rad", along="sample_rate_hz") == pytest.approx(0.5)
    assert of("spread_along", column="p2p_rad", along="counts_per_rev") == pytest.approx(16.0)
    assert of("end_to_end", column="p2p_rad", along="sample_rate_hz") == pytest.approx(0.01)
    assert of("planarity", column="p2p_rad") == pytest.approx(100.0)
    assert of("product_explains") == pytest.approx(100.0)
    stepped = made("b", {"cells": [{**one, "step": 1.0 / one["counts_per_rev"]} for one in lawful()]})
    assert compute("product_explains", stepped, {"result": "b", "step": "step"}) == pytest.approx(100.0)
    assert of("fitted_constant") == pytest.approx(600.0)
    assert of("from_one_case", case={"sample_rate_hz": 100, "counts_per_rev": 128}) == pytest.approx(0.0, abs=1e-9)


def test_pairs_go_together(made: Made) -> None:
    rows = [
        {**cell(rate, 128, 1.0 / (x * y) if x * y > 1 else 0.1, 1.0), "x": float(x), "y": float(y)}
        for rate in (100, 200)
        for x in (1, 2, 3)
        for y in (1, 2, 3)
    ]
    evidence = made("a", {"cells": rows}, axes=("sample_rate_hz", "counts_per_rev", "x", "y"))
    pairs = {"result": "a", "column": "p2p_rad", "pairs": {"x": [1, 2, 3], "y": [1, 2, 3]}, "direction": "down"}
    assert compute("paired_trend", evidence, pairs) == 50.0
    assert compute("paired_trend", evidence, {**pairs, "first_only": True}) == 0.0


def test_the_trough_is_where_size_and_pitch_meet(made: Made) -> None:
    rows = [
        cell(rate, counts, 10.0**-step, 100.0 * step)
        for step, rate in enumerate((100, 1000, 10000))
        for counts in (128, 256)
    ]
    assert compute("trough", made("a", {"cells": rows}), {"result": "a"}) == 1000.0


def test_what_is_not_there_is_said(made: Made) -> None:
    evidence = made("a", {"cells": lawful()})
    for arguments in (
        {"result": "b", "column": "p2p_rad"},
        {"result": "a", "column": "p2q_rad"},
        {"result": "a", "column": "p2p_rad", "file": "orbits"},
        {"result": "a", "column": "p2p_rad", "where": {"sample_rate_hz": 123}},
    ):
        with pytest.raises(MissingError):
            compute("cell_statistic", evidence, arguments)
    for arguments in (
        {"result": "a", "column": "p2p_rad", "statistic": "meen"},
        {"result": "a", "column": "p2p_rad", "where": {"p2p_rad": {"over": 1}}},
    ):
        with pytest.raises(UsageError, match="unknown") as caught:
            compute("cell_statistic", evidence, arguments)
        assert not isinstance(caught.value, MissingError), "a mistake in the ledger is not missing evidence"
    along = {"result": "a", "column": "p2p_rad", "along": "sample_rate_hz", "direction": "upward"}
    with pytest.raises(UsageError, match="direction"):
        compute("trend", evidence, along)


def test_a_cell_at_rest_has_the_size_0_and_no_pitch(made: Made) -> None:
    """From rest to rest nothing falls, and no pitch rises to or from a cell without one."""
    rows = [
        cell(rate, counts, 0.0 if counts == 2048 else 1.0 / rate, 0.1 * rate, at_rest_fraction=float(counts == 2048))
        for rate in (100, 200, 400)
        for counts in (128, 2048)
    ]
    evidence = made("a", {"cells": rows})
    size = {"result": "a", "column": "p2p_rad", "direction": "down"}
    assert compute("trend", evidence, {**size, "along": "sample_rate_hz"}) == 50.0
    assert compute("trend", evidence, {**size, "along": "counts_per_rev"}) == 100.0
    pitch = {"result": "a", "column": "frequency_hz", "along": "sample_rate_hz"}
    assert compute("trend", evidence, {**pitch, "direction": "up"}) == 50.0
    assert compute("trend", evidence, {**pitch, "along": "counts_per_rev", "direction": "down"}) == 0.0
    assert compute("end_to_end", evidence, pitch) == 4.0
    assert compute("end_to_end", evidence, {"result": "a", "column": "p2p_rad", "along": "counts_per_rev"}) == 0.0
    assert compute("count_of_cells", evidence, {"result": "a", "having": {"p2p_rad": {"below": 1e-9}}}) == 3


def test_a_cell_that_partly_rests_is_sized_by_its_cycles(made: Made) -> None:
    evidence = made("a", {"cells": [cell(100, 128, 2.0, 50.0, at_rest_fraction=0.9)]})
    assert compute("cell_statistic", evidence, {"result": "a", "column": "p2p_rad"}) == 2.0
