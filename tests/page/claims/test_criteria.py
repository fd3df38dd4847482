"""Checks of the criteria of section 6.2, on rows whose verdicts are known."""

import pytest

from hknob_cli.errors import UsageError
from hknob_cli.page.claims.checks import compute
from tests.page.claims.conftest import Made, cell


def test_cells_that_cycle_where_a_criterion_holds(made: Made) -> None:
    """At 200 Hz the wall without counts is too stiff by Tsai and Colgate, at 1 kHz not, and never by Tsypkin."""
    cells = [cell(200, 1024, 1e-3, 80.0), cell(1000, 1024, 1e-3, 80.0)]
    rests = cell(2000, 1024, 0.0, 0.0, at_rest_fraction=1.0)
    evidence = made("a", {"cells": [*cells, rests]})
    with_one = {"result": "a", "criterion": "tsai_colgate"}
    assert compute("cycles_where_criterion", evidence, {**with_one, "holds": True}) == 50.0
    assert compute("cycles_where_criterion", evidence, {**with_one, "holds": False}) == 100.0
    assert compute("cycles_where_criterion", evidence, {**with_one, "criterion": "tsypkin", "holds": True}) is None
    with pytest.raises(UsageError, match="criterion: must be one of"):
        compute("cycles_where_criterion", evidence, {**with_one, "criterion": "popov", "holds": True})


def test_what_one_criterion_allows_over_another(made: Made) -> None:
    """Miller's limit is 2 b / T, and goes with the damping; Tsai and Colgate's is hardly more on this knob."""
    evidence = made("a", {"cells": [cell(1000, 1024, 1e-3, 80.0)]})
    ratio = compute("criterion_over", evidence, {"result": "a", "criterion": "tsai_colgate", "over": "miller"})
    assert ratio == pytest.approx(0.70946 / 0.69, rel=1e-4)
    less = {"result": "a", "criterion": "miller", "factor": 0.1}
    assert compute("criterion_with_damping", evidence, less) == pytest.approx(0.1)


def test_bounds_of_virtual_damping(made: Made) -> None:
    """The knob of Table 7 has no damping: at 200 Hz no virtual damping makes its wall stable, at 1 kHz a range does."""
    evidence = made("a", {"cells": [cell(200, 1024, 1e-3, 80.0), cell(1000, 1024, 1e-3, 80.0)]})
    assert compute("damping_bounded", evidence, {"result": "a"}) == 50.0


def test_the_exponent_of_the_stiffest_wall_that_rests(made: Made) -> None:
    """Walls rest up to 1 at 100 Hz and up to 10 at 1 kHz; a rate with all at rest, or none, says nothing."""
    last = {100: 1.0, 1000: 10.0, 2000: 100.0, 50: 0.0}
    cells = [
        cell(rate, 1024, 0.0 if wall <= most else 1e-3, 80.0, **{"wall.stiffness": wall}) | resting(wall <= most)
        for rate, most in last.items()
        for wall in (0.1, 1.0, 10.0, 100.0)
    ]
    evidence = made("a", {"cells": cells}, axes=("sample_rate_hz", "wall.stiffness"))
    assert compute("resting_stiffness_exponent", evidence, {"result": "a"}) == pytest.approx(1.0)


def resting(still: bool) -> dict[str, float]:
    return {"at_rest_fraction": float(still)}
