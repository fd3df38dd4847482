"""Checks that put one result beside a sweep, against tables made by hand."""

from typing import Any

import pytest

from hknob_cli.errors import UsageError
from hknob_cli.page.claims.checks import compute
from hknob_cli.results.result_set import MissingError
from tests.page.claims.conftest import Made, cell


def predicted(rate: float, p2p: float | None, frequency: float, method: str = "df1", orbit: int = 0) -> dict[str, Any]:
    return {
        "sample_rate_hz": float(rate),
        "counts_per_rev": 128,
        "method": method,
        "orbit": orbit,
        "p2p_rad": p2p,
        "amplitude_rad": None if p2p is None else p2p / 2,
        "frequency_hz": frequency,
    }


DFA = {"result": "dfa", "against": "sweep", "file": "dfa", "where": {"method": "df1"}}


@pytest.fixture
def evidence(made: Made) -> Any:
    made(
        "sweep",
        {
            "cells": [
                cell(100, 128, 1.0, 10.0),
                cell(200, 128, 2.0, 20.0),
                cell(400, 128, 0.0, 0.0, at_rest_fraction=1.0),
                cell(800, 128, 2.0, 20.0, at_rest_fraction=0.5),
            ]
        },
    )
    rows = [
        predicted(100, 0.5, 11.0),
        predicted(200, 9.0, 1.0),
        predicted(200, 2.2, 22.0, orbit=1),
        predicted(400, 1.0, 10.0),
        predicted(800, 1.0, 20.0),
        predicted(100, 1.0, 10.0, method="df4"),
    ]
    return made("dfa", {"dfa": rows}, stage="dfa")


def test_differences_are_like_with_like(evidence: Any) -> None:
    """Of two cycles the nearer counts; what rests does not; half a cell at rest leaves the mean of the other half."""
    values = [-50.0, 10.0, -50.0]
    assert compute("difference", evidence, DFA) == pytest.approx(sum(values) / 3)
    assert compute("difference", evidence, {**DFA, "statistic": "least"}) == pytest.approx(-50.0)
    assert compute("difference", evidence, {**DFA, "statistic": "count"}) == 3
    assert compute("agreement", evidence, {**DFA, "least": -20, "largest": 20}) == pytest.approx(100.0 / 3.0)
    frequency = {**DFA, "quantity": "frequency"}
    assert compute("difference", evidence, frequency) == pytest.approx((10.0 + 10.0 + 0.0) / 3)
    assert compute("accuracy_ratio", evidence, DFA) == pytest.approx(20.0 / 110.0)


def test_half_of_one_with_the_whole_of_the_other(evidence: Any) -> None:
    found = compute("difference", evidence, {**DFA, "quantity": "amplitude", "statistic": "largest"})
    assert found == pytest.approx(-45.0), "of the cycle that is nearer in peak to peak"


def test_another_method_is_another_number(evidence: Any) -> None:
    assert compute("difference", evidence, {**DFA, "where": {"method": "df4"}}) == pytest.approx(0.0)


def test_two_sweeps(made: Made) -> None:
    made("a", {"cells": [cell(100, 128, 3.0, 30.0), cell(200, 128, 0.0, 0.0, at_rest_fraction=1.0)]})
    evidence = made("b", {"cells": [cell(100, 128, 2.0, 10.0), cell(200, 128, 5.0, 10.0)]})
    beside = {"result": "a", "against": "b"}
    assert compute("ratio", evidence, {**beside, "quantity": "frequency"}) == pytest.approx(3.0)
    assert compute("difference", evidence, beside) == pytest.approx(50.0)
    cells = {"column": "p2p_rad", "result": "a", "where": {"sample_rate_hz": 100}, "to": "b"}
    assert compute("of_two_cells", evidence, cells) == pytest.approx(3.0 / 3.5)
    evidence = made("c", {"orbits": [{"p2p_rad": 4.0}, {"p2p_rad": 2.0}], "cells": [cell(100, 128, 9.0, 30.0)]})
    orbits = {"column": "p2p_rad", "result": "c", "to": "c", "file": "orbits"}
    pair = {"where": {"p2p_rad": 4.0}, "to_where": {"p2p_rad": 2.0}}
    assert compute("of_two_cells", evidence, {**orbits, **pair}) == 2.0


def test_what_cannot_be_compared_is_said(evidence: Any, made: Made) -> None:
    with pytest.raises(UsageError, match="quantity"):
        compute("difference", evidence, {**DFA, "quantity": "rms"})
    elsewhere = made("elsewhere", {"cells": [cell(123, 128, 1.0, 1.0)]})
    with pytest.raises(UsageError, match="no cell"):
        compute("difference", elsewhere, {**DFA, "against": "elsewhere"})
    resting = made("resting", {"cells": [cell(100, 128, 0.0, 0.0, at_rest_fraction=1.0)]})
    with pytest.raises(MissingError, match="cycles in no cell"):
        compute("difference", resting, {**DFA, "against": "resting"})


def test_one_reading_has_to_give_every_number(evidence: Any) -> None:
    """The mean is -30 %, the largest 10 %: as far from -30 and 25 as the worse of them is."""
    asked = {**DFA, "printed": {"mean": -30.0, "largest": 25.0}}
    assert compute("largest_deviation", evidence, asked) == pytest.approx(15.0)
    assert compute("largest_deviation", evidence, {**DFA, "printed": {"least": -50.0}}) == pytest.approx(0.0)


def test_the_most_that_another_axis_gives_a_cell(made: Made) -> None:
    made("one", {"cells": [cell(100, 128, 1.0, 10.0), cell(200, 128, 1.0, 20.0), cell(400, 128, 0.0, 0.0)]})
    rows = [
        {**cell(rate, 128, 1.0, pitch), "push": push}
        for rate, pitches in ((100, (15.0, 20.0)), (200, (20.0, 10.0)), (400, (5.0, 5.0)))
        for push, pitch in enumerate(pitches)
    ]
    evidence = made("many", {"cells": rows}, axes=("sample_rate_hz", "counts_per_rev", "push"))
    asked = {"result": "many", "column": "frequency_hz", "to": "one"}
    assert compute("largest_beside", evidence, asked) == pytest.approx(1.5)
    assert compute("largest_beside", evidence, {**asked, "statistic": "largest"}) == pytest.approx(2.0)
    assert compute("largest_beside", evidence, {**asked, "reaching": 1.8}) == pytest.approx(50.0)
