"""A trial of remedies judges by the largest cycle, says the mean beside it, and compares like with like."""

import json
from math import isnan
from typing import Any

import pytest

from hknob_cli.specs.load import validate
from hknob_cli.specs.source import parse
from hknob_cli.stages.remedies.run import RemediesStage
from hknob_cli.stages.sweep.perceived import End, sizes_of

Row = dict[str, Any]


def tried(**changed: Any) -> tuple[list[Row], list[Row]]:
    """Rows of the grid and of the cases."""
    spec: Row = {
        "kind": "remedies",
        "name": "s",
        "base": {
            "scene": {"knob": {"inertia": 1.9e-6}, "wall": {"stiffness": 0.27}, "bias": {"torque": 0.007}},
            "grid": {"sample_rate_hz": 455.0, "counts_per_rev": 256},
            "starts": {"phases": 64},
        },
        "hands": {"pinch": {"inertia": 3.0e-7, "damping": 3.45e-4, "stiffness": 0.04}},
        "remedies": {
            "plain wall": {},
            "lag": {"change": {"scene": {"controller": {"kind": "bounded_lag", "keep": 0.15}}}, "source": "own"},
        },
        **changed,
    }
    plan = validate(parse(json.dumps(spec), "spec.yaml"))
    with RemediesStage(plan, jobs=1) as stage:
        grid, cases = stage.run()
    return grid.to_pylist(), cases.to_pylist()


def test_a_cell_with_two_cycles_and_rest_is_judged_by_its_largest_cycle() -> None:
    """455 Hz, 256 counts, a push of 7 mN*m: 57.4 mrad at 56.9 Hz and 87.3 mrad at 50.6 Hz, beside rest."""
    plain = tried()[0][0]
    assert 0.3 < plain["at_rest_fraction"] < 0.45
    assert plain["p2p_max_rad"] == pytest.approx(87.3e-3, rel=1e-3)
    assert plain["frequency_at_max_hz"] == pytest.approx(50.6, rel=1e-3)
    # The mean is between the two cycles, where rest counted as 0 made it smaller than either.
    assert 57.3e-3 < plain["p2p_rad"] < 87.3e-3
    assert 50.5 < plain["frequency_hz"] < 57.0


def test_means_are_of_what_cycles_and_none_where_all_rest() -> None:
    rest, small, large = End(30.0, True, 0.0, 0.0), End(20.0, False, 1.0, 90.0), End(10.0, False, 4.0, 60.0)
    assert sizes_of([rest, small, large]) == (2.0, 80.0, 4.0, 60.0)
    assert sizes_of([rest]) == (None, None, 0.0, None)
    assert sizes_of([]) == (None, None, None, None)


def test_a_remedy_is_compared_at_every_value_of_a_further_axis() -> None:
    """Six times smaller on a light knob, larger on a heavy one: 1 kHz and 2650 counts, a light pinch."""
    base = {
        "scene": {"knob": {"inertia": 1.98e-6}, "wall": {"stiffness": 0.27}, "bias": {"torque": 0.001}},
        "grid": {"sample_rate_hz": 1000.0, "counts_per_rev": 2650, "knob.inertia": [2e-6, 2e-5]},
        "starts": {"phases": 4},
    }
    rows = {(row["remedy"], row["knob.inertia"]): row for row in tried(base=base)[0]}
    assert rows["lag", 2e-6]["p2p_ratio"] > 4.0
    assert rows["lag", 2e-6]["in_domain"]
    assert rows["lag", 2e-5]["p2p_ratio"] < 1.0
    assert rows["lag", 2e-5]["in_domain"] is False
    for inertia in (2e-6, 2e-5):
        ratio = rows["plain wall", inertia]["p2p_max_rad"] / rows["lag", inertia]["p2p_max_rad"]
        assert rows["lag", inertia]["p2p_ratio"] == ratio
        assert rows["plain wall", inertia]["p2p_ratio"] == 1.0
        assert rows["plain wall", inertia]["in_domain"] is None


def test_a_remedy_at_a_rate_of_its_own_is_compared_where_the_base_has_one_rate() -> None:
    base = {
        "scene": {"knob": {"inertia": 1.98e-6}, "wall": {"stiffness": 0.27}, "bias": {"torque": 0.001}},
        "grid": {"sample_rate_hz": 1000.0, "counts_per_rev": [1024, 2650]},
        "starts": {"phases": 2},
    }
    remedies = {"plain wall": {}, "faster": {"change": {"grid": {"sample_rate_hz": 4000.0}}}}
    grid = tried(base=base, remedies=remedies)[0]
    faster = [row for row in grid if row["remedy"] == "faster"]
    assert all(row["p2p_ratio"] > 1.5 for row in faster)
    base["grid"] = {"sample_rate_hz": [500.0, 1000.0], "counts_per_rev": 1024}
    grid = tried(base=base, remedies=remedies)[0]
    assert all(row["p2p_ratio"] is None or isnan(row["p2p_ratio"]) for row in grid if row["remedy"] == "faster")


def test_a_remedy_that_diverges_is_the_worst_and_one_that_buzzes_alone_too() -> None:
    from hknob_cli.stages.remedies.run import _ratios

    rest = {"p2p_max_rad": 0.0, "p2p_rad": None, "diverged_fraction": 0.0}
    moves = {"p2p_max_rad": 2.0, "p2p_rad": 1.0, "diverged_fraction": 0.0}
    away = {"p2p_max_rad": None, "p2p_rad": None, "diverged_fraction": 1.0}
    partly = {**moves, "diverged_fraction": 0.1}
    assert _ratios(moves, partly)["p2p_ratio"] == _ratios(moves, away)["p2p_ratio"] == 0.0
    assert _ratios(rest, moves)["p2p_ratio"] == 0.0
    assert isnan(_ratios(moves, rest)["p2p_ratio"])
    assert isnan(_ratios(partly, moves)["p2p_ratio"])
    assert isnan(_ratios(None, moves)["p2p_ratio"])
    undecided = {"p2p_max_rad": None, "p2p_rad": None, "diverged_fraction": 0.0}
    assert isnan(_ratios(moves, undecided)["p2p_ratio"])
    assert _ratios(moves, moves) == {"p2p_ratio": 1.0, "p2p_mean_ratio": 1.0}


TUNED = {
    "change": {"scene": {"controller": {"kind": "bounded_lag", "time_constant": 0.2}}},
    "tune": {"controller.keep": [0.05, 0.15, 0.4, 1.0]},
}
FIRM = {"inertia": 3.0e-7, "damping": 1.0e-3, "stiffness": 0.1}
PINCH = {"inertia": 3.0e-7, "damping": 3.45e-4, "stiffness": 0.04}


def test_a_tuned_remedy_has_at_each_cell_the_value_whose_largest_cycle_of_any_hand_is_smallest() -> None:
    """By brute force: each value as a remedy of its own."""
    base = {
        "scene": {"knob": {"inertia": 1.98e-6}, "wall": {"stiffness": 0.27}, "bias": {"torque": 0.001}},
        "grid": {"sample_rate_hz": 1000.0, "counts_per_rev": 2650, "knob.inertia": [2e-6, 2e-5]},
        "starts": {"phases": 2},
    }
    fixed = {
        f"{keep:g}": {"change": {"scene": {"controller": {"kind": "bounded_lag", "keep": keep, "time_constant": 0.2}}}}
        for keep in TUNED["tune"]["controller.keep"]
    }
    remedies = {"plain wall": {}, "tuned": TUNED, **fixed}
    grid, cases = tried(
        base=base,
        hands={"pinch": PINCH, "firm": FIRM},
        remedies=remedies,
        cases={"fine": {"sample_rate_hz": 1000.0, "counts_per_rev": 2650}},
    )
    chosen = {}
    for name, rows, inertias in (("knob.inertia", grid, (2e-6, 2e-5)), ("case", cases, ("fine",))):
        for value in inertias:
            here = [row for row in rows if row[name] == value]
            worst = {
                keep: max(row["p2p_max_rad"] for row in here if row["remedy"] == f"{keep:g}")
                for keep in TUNED["tune"]["controller.keep"]
            }
            mine = [row for row in here if row["remedy"] == "tuned"]
            best = min(worst, key=worst.__getitem__)
            assert {row["tuned"] for row in mine} == {best}
            assert max(row["p2p_max_rad"] for row in mine) == worst[best]
            assert all(row["tuned"] is None for row in here if row["remedy"] != "tuned")
            chosen[value] = best
    assert chosen[2e-5] > chosen[2e-6]  # a heavier knob asks for more of the step at once


def test_without_a_tuned_remedy_there_is_no_column_for_it() -> None:
    assert "tuned" not in tried()[0][0]
