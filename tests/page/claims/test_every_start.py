"""Claims about all limit cycles of a cell: how many there are, and how large the largest."""

from typing import Any

import pytest

from hknob_cli.page.claims.checks import compute
from hknob_cli.results.result_set import MissingError

from .conftest import Made, cell

QUANTUM = 6.283185307179586 / 128


def all_cells(*rows: dict[str, Any], complete: bool = True) -> list[dict[str, Any]]:
    return [{"complete": complete, "orbit_count": 1, **row} for row in rows]


def test_share_of_cells_whose_largest_cycle_stays_within_counts(made: Made) -> None:
    """By the largest, not by the mean; exactly two counts are not below two, and rest is."""
    sizes = [(1.5, 0.9), (2.0, 0.9), (2.5, 0.9), (0.0, 0.0)]
    rows = [
        cell(rate, 128, mean * QUANTUM, 80.0, p2p_max_rad=largest * QUANTUM)
        for rate, (largest, mean) in zip((100, 200, 300, 400), sizes, strict=True)
    ]
    evidence = made("every", {"cells": all_cells(*rows)})
    assert compute("largest_within", evidence, {"result": "every", "counts": 2}) == 50.0
    assert compute("largest_within", evidence, {"result": "every", "counts": 3}) == 100.0
    assert (
        compute("largest_within", evidence, {"result": "every", "counts": 2, "where": {"sample_rate_hz": 300}}) == 0.0
    )


def test_share_of_cells_with_one_attractor(made: Made) -> None:
    rows = [cell(100 * (i + 1), 128, 0.01, 80.0, orbit_count=count) for i, count in enumerate((1, 1, 2, 7))]
    assert compute("alone", made("every", {"cells": all_cells(*rows)}), {"result": "every"}) == 50.0


@pytest.mark.parametrize(("name", "more"), [("alone", {}), ("largest_within", {"counts": 2})])
def test_a_list_that_is_not_complete_decides_nothing(name: str, more: dict[str, Any], made: Made) -> None:
    rows = [cell(100, 128, 0.01, 80.0, orbit_count=1)]
    with pytest.raises(MissingError, match="not complete"):
        compute(name, made("some", {"cells": all_cells(*rows, complete=False)}), {"result": "some", **more})
    with pytest.raises(MissingError, match="no column complete"):
        compute(name, made("sampled", {"cells": rows}), {"result": "sampled", **more})


def test_differences_from_the_largest_cycle(made: Made) -> None:
    """A prediction of half the largest is 50 % low, whatever the mean."""
    made("every", {"cells": [cell(100, 128, 0.01, 80.0, p2p_max_rad=0.04)]})
    said = {"sample_rate_hz": 100.0, "counts_per_rev": 128, "method": "df1", "p2p_rad": 0.02, "frequency_hz": 80.0}
    evidence = made("dfa", {"dfa": [{**said, "in_domain": True, "orbit": 0}]}, stage="dfa")
    arguments = {"result": "dfa", "against": "every", "file": "dfa"}
    assert compute("difference", evidence, {**arguments, "quantity": "largest"}) == pytest.approx(-50.0)
    assert compute("difference", evidence, arguments) == pytest.approx(100.0)


def test_cells_in_which_a_larger_cycle_exists(made: Made) -> None:
    """More than so many times: exactly twice is not more than twice, and anything is more than rest."""
    rates, sizes, there = (100, 200, 300, 400), (0.02, 0.021, 0.005, 0.001), (0.01, 0.01, 0.01, 0.0)
    made("one", {"cells": [cell(rate, 128, size, 80.0) for rate, size in zip(rates, there, strict=True)]})
    rows = [cell(rate, 128, size, 80.0) for rate, size in zip(rates, sizes, strict=True)]
    evidence = made("every", {"cells": all_cells(*rows)})
    assert compute("cells_larger", evidence, {"result": "every", "than": "one"}) == 3.0
    assert compute("cells_larger", evidence, {"result": "every", "than": "one", "times": 2.0}) == 2.0
    assert compute("rows_in", evidence, {"result": "every", "where": {"sample_rate_hz": [100, 300]}}) == 2.0
