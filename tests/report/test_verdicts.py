"""The answer first: what the sentences say of made-up results, at their ends and where there is nothing."""

from typing import Any

import pyarrow as pa
import pytest

from hknob_cli.report.sweep_words import undecided_in
from hknob_cli.report.verdicts import biased, calibrated, compared, grid_verdict, identified, people_buzz
from hknob_cli.stages.remedies.text import _line as remedy_line
from hknob_cli.stages.sweep.text import one_cell_text

Row = dict[str, Any]


def cell(size: float, **more: Any) -> Row:
    pitch = 80.0 if size else None
    return {"p2p_max_rad": size, "frequency_at_max_hz": pitch, "at_rest_fraction": 0.0 if size else 1.0, **more}


def condition(estimator: str, stiffness: float | None, *, std: float | None = 1e-3, flags: str = "") -> Row:
    return {
        "estimator": estimator,
        "stiffness_nm_per_rad": stiffness,
        "stiffness_nm_per_rad_std": std if stiffness is not None else None,
        **{name: None for one in ("inertia_kg_m2", "damping_nm_s_per_rad") for name in (one, f"{one}_std")},
        "flags": flags,
        "vaf": 0.99,
    }


def test_every_start_is_said_of_complete_lists_only() -> None:
    """The columns are the same for one start and for ranges of them."""
    complete, other = (cell(1e-3, complete=whole) for whole in (True, False))
    assert grid_verdict([complete, complete], []).startswith("It buzzes in all 2 cells, from every start of the spec. ")
    for cells in ([complete, other], [cell(1e-3), cell(2e-3)]):
        assert grid_verdict(cells, []).startswith("It buzzes in all 2 cells, from the starts tried. ")


RANGE = {"complete": False, "piece_count": 9, "undecided_fraction": 1.0}


def test_a_range_without_a_proven_end_is_never_assured() -> None:
    """Random starts that rest prove nothing of the others."""
    rest = {"outcome": "rest", "basin_fraction": 1.0, "certified": True, "reason": ""}
    assert one_cell_text([rest], unproven=1.0, trials=4096) == [
        "No limit cycle was found. All 4096 random starts come to rest; 100 % of the range has no proven end."
    ]
    assert "Every start tried comes to rest; almost 100 % of" in one_cell_text([rest], unproven=0.9999)[0]
    assert one_cell_text([rest], trials=4096) == [
        "It does not buzz: it comes to rest, from every start tried (proven)."
    ]
    cycle = {**rest, "outcome": "cycle", "p2p_rad": 1e-3, "frequency_hz": 80.0}
    assert one_cell_text([cycle], unproven=0.123, trials=4096) == [
        "It buzzes, from all 4096 random starts: 1 mrad peak to peak at 80 Hz (proven). "
        "12.3 % of the range has no proven end."
    ]


def test_a_grid_says_how_much_of_its_ranges_has_no_proven_end() -> None:
    open_, closed = cell(0.0, **RANGE), cell(0.0, **RANGE) | {"complete": True, "undecided_fraction": 0.0}
    said = grid_verdict([closed, open_, open_ | {"undecided_fraction": 0.25}], [])
    assert said.endswith(", from the starts tried. In 2 of 3 cells up to 100 % of the range has no proven end.")
    assert grid_verdict([open_], []).endswith(" the starts tried. 100 % of the range has no proven end.")
    sampled = open_ | {"piece_count": 0, "undecided_fraction": 0.0}
    assert "100 % of the range" in grid_verdict([sampled], [])
    for other in (closed, open_ | {"share_error": 0.0}, open_ | {"grows_rad": 1.0}):
        assert "proven" not in grid_verdict([other], [])


def test_of_recorded_trials_it_says_so() -> None:
    recorded = {"sustained": 1, "x": 1.0}
    assert grid_verdict([], ["x"]) == "No trial could be measured."
    assert grid_verdict([cell(0.0, **recorded)] * 3, ["x"]) == (
        "No sustained buzz in any of 3 cells, in the trials recorded."
    )
    assert (
        grid_verdict([cell(2e-3, **recorded)], []) == "It buzzes in this cell, in the trials recorded: 2 mrad at 80 Hz."
    )
    some = grid_verdict([cell(2e-3, **recorded), cell(1e-3, sustained=1, x=2.0), cell(0.0, **recorded)], ["x"])
    assert some.startswith("It buzzes in 2 of 3 cells, in the trials recorded. The most: 2 mrad at 80 Hz (x = 1).")


def test_the_least_doubted_estimator_speaks() -> None:
    rows = [condition("a", 0.04, flags="odd"), condition("b", 0.05), condition("b", 0.2, flags="odd")]
    said = identified(rows, errors="standard error")
    assert said == (
        "By b (± standard error): stiffness 50 ± 1 to 200 ± 1 mN·m/rad, over 2 conditions. "
        "It is doubtful in 1 of these: their flags say why."
    )
    (one,) = (condition("a", 0.04),)
    assert identified([one], errors="e").endswith("stiffness 40 ± 1 mN·m/rad. Nothing in the data speaks against it.")


@pytest.mark.parametrize("rows", [[], [condition("a", None)], [condition("a", 0.0, std=0.0)]])
def test_what_was_given_or_is_not_known_was_not_identified(rows: list[Row]) -> None:
    assert identified(rows, errors="standard error") == "Nothing could be identified."


def test_a_calibration_says_how_many_are_doubtful() -> None:
    assert calibrated([{"flags": ""}]) == "Nothing speaks against it."
    assert calibrated([{"flags": "odd"}, {"flags": ""}]) == "1 of 2 quantities are doubtful: their flags say why."


def test_a_study_names_the_least_biased_first() -> None:
    rows = [{"estimator": name, "bias_percent": bias} for name, bias in (("a", -9.0), ("b", 2.0), ("a", 3.0))]
    assert biased(rows) == "Largest bias of a parameter over everything tried: b 2 %, a 9 %."


def test_people_are_counted() -> None:
    some = {"people": 20, "buzzing_fraction": 0.5, "p2p_max_rad_median": 1e-3, "p2p_max_rad_p95": 4e-3}
    rows = [{**some, "frequency_at_max_hz_median": 50.0}, {"people": 20, "buzzing_fraction": 0.0}]
    assert people_buzz(rows) == (
        "It buzzes for 0 to 50 % of 20 people, depending on the cell (2 cells), from the starts tried. "
        "The median of all people is 1 mrad; one in twenty has more than 4 mrad; median pitch 50 Hz."
    )
    assert people_buzz(rows[1:]) == "It buzzes for 0 % of 20 people, from the starts tried."


def test_a_bench_says_where_nobody_else_is_accurate() -> None:
    rows = [{"exact_seconds": 1.0, "ratio": 3.0}, {"exact_seconds": 1.0, "ratio": None}, {"exact_seconds": None}]
    assert compared(rows) == (
        "The exact engine is accurate in 2 of 3 scenes. The fastest accurate rival takes 3 times as long; "
        "in 1 of these scenes no rival is accurate."
    )


def test_a_remedy_whose_trials_have_no_decided_end_does_not_diverge() -> None:
    row = {"p2p_max_rad": None, "diverged_fraction": 0.0}
    grid = {"ratio_median": 2.0}
    assert remedy_line(row, grid, 8)[0] == "undecided"
    assert remedy_line({**row, "diverged_fraction": 0.5}, grid, 8)[0] == "diverges"


def test_teeth_that_rattle_are_said_beside_the_cycles() -> None:
    """An end that no cycle tells of is no silence."""
    calm, loose = cell(2e-3, rattle_max_rad=None), cell(0.0, rattle_max_rad=3e-3) | {"at_rest_fraction": 0.0}
    said = "It moves on in 1 of 2 cells and no trial repeats: the knob swings by 3 mrad (one trial "
    assert said in grid_verdict([calm, loose], [])
    both = grid_verdict([loose, {**loose, "rattle_max_rad": 7.152e-3}], [])
    assert both.startswith("No limit cycle in any of 2 cells")
    assert "It moves on in all 2 cells and no trial repeats: the knob swings by 3 to 7.152 mrad (one trial each" in both
    assert "moves on" not in grid_verdict([calm, calm], [])


def test_one_cell_that_rattles_says_so() -> None:
    end = {"outcome": "undecided", "basin_fraction": 1.0, "certified": False, "reason": "unproven: x"}
    (said,) = one_cell_text([{**end, "rattle_p2p_rad": 4e-3}])
    assert said.startswith("No limit cycle was found")
    assert said.endswith(" It moves on and no trial repeats: the knob swings by 4 mrad (one trial each, not proven).")
    assert "moves on" not in one_cell_text([end])[0]


def test_a_clock_that_jitters_is_said_beside_the_cycles() -> None:
    calm, loose = cell(2e-3, jitter_max_rad=None), cell(0.0, jitter_max_rad=3e-3) | {"at_rest_fraction": 0.0}
    said = "It buzzes in 1 of 2 cells without repeating, because the sample clock jitters: the knob swings by 3 mrad on"
    assert said in grid_verdict([calm, loose], [])
    both = grid_verdict([loose, {**loose, "jitter_max_rad": 7.152e-3}], [])
    assert "in all 2 cells without repeating" in both
    assert "swings by 3 to 7.152 mrad on average (one trial each, not proven)" in both
    assert "jitters" not in grid_verdict([calm, calm], [])


def test_what_is_proven_for_every_clock_is_said() -> None:
    bound = {"clock_bound_rad": 7e-3, "jitter_max_rad": 3e-3, "at_rest_fraction": 0.0}
    still = {"clock_bound_rad": 0.0, "jitter_max_rad": None}
    unknown = {"clock_bound_rad": None, "jitter_max_rad": 3e-3, "at_rest_fraction": 0.0}
    said = grid_verdict([cell(0.0) | one for one in (bound, still, unknown)], [])
    assert said.endswith(
        " Whatever the intervals are, it comes to rest in 1 of 3 cells and in the end it swings by at most 7 mrad in "
        "1 of 3 cells, largest less smallest angle (proven)."
    )
    assert "Whatever" not in grid_verdict([cell(0.0) | unknown] * 2, [])
    end = {"outcome": "undecided", "basin_fraction": 1.0, "certified": False, "reason": "no two are alike"}
    (one,) = one_cell_text([end], bound=0.0)
    assert one.endswith(" Whatever the intervals are, it comes to rest (proven).")
    (one,) = one_cell_text([end], bound=2e-3)
    assert one.endswith(" in the end it swings by at most 2 mrad, largest less smallest angle (proven).")
    assert "Whatever" not in one_cell_text([end])[0]


def test_one_cell_whose_clock_jitters_says_so() -> None:
    end = {"outcome": "undecided", "basin_fraction": 1.0, "certified": False, "reason": "x"}
    (said,) = one_cell_text([{**end, "jitter_p2p_rad": 4e-3}])
    assert said.startswith("No limit cycle was found")
    assert " It buzzes without repeating, because the sample clock jitters: the knob swings by 4 mrad" in said
    assert "jitters" not in one_cell_text([end])[0]


def test_a_knob_behind_a_gear_that_yields_is_told_from_its_motor() -> None:
    cycle = {"outcome": "cycle", "basin_fraction": 1.0, "certified": True, "reason": ""}
    cycle |= {"p2p_rad": 1e-3, "frequency_hz": 50.0}
    assert "tried: 1 mrad peak to peak at 50 Hz" in one_cell_text([cycle])[0]
    (said,) = one_cell_text([{**cycle, "knob_p2p_rad": 3e-3}])
    assert "tried: the knob swings by 3 mrad, the motor by 1 mrad peak to peak at 50 Hz" in said
    end = {"outcome": "undecided", "basin_fraction": 1.0, "certified": False, "reason": "x", "jitter_p2p_rad": 4e-3}
    assert "the motor swings by 4 mrad on average" in one_cell_text([{**end, "knob_p2p_rad": 5e-3}])[0]


def test_undecided_ends_of_one_reason_are_one_cell() -> None:
    rows = [("undecided", "long", 0.25, 1.0), ("undecided", "long", 0.5, 1.0), ("rest", "", 0.25, 1.0)]
    rows += [("undecided", "long", 0.5, 2.0), ("undecided", "fine", 0.5, 2.0)]
    names = ("outcome", "reason", "basin_fraction", "sample_rate_hz")
    table = pa.table(dict(zip(names, zip(*rows, strict=True), strict=True)))
    assert undecided_in(table, ["sample_rate_hz"], 8) == [
        {"reason": "long", "cells": 2, "trials": 10},
        {"reason": "fine", "cells": 1, "trials": 4},
    ]


def test_random_starts_are_as_many_as_the_engine_counts() -> None:
    """The terminal loads no engine to say so."""
    from hknob_cli.engine.sets.search import SAMPLED
    from hknob_cli.stages.sweep.completeness_text import COUNTED

    assert COUNTED == SAMPLED
