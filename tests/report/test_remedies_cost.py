"""Tests of `report.remedies`: what a change takes, and which remedy is named."""

import pytest

from hknob_cli.report.remedies import cost_lines, effort_of, most_of


@pytest.mark.parametrize(
    ("remedy", "cost"),
    [
        ({}, "nothing"),
        ({"change": {"scene": {"controller": {"kind": "bounded_lag"}}}}, "firmware only"),
        ({"change": {"scene": {"controller": None}}}, "firmware only"),
        ({"change": {"scene": {"wall": {"damping": 1e-5}}}}, "firmware only"),
        ({"change": {"scene": {"wall": {"stiffness": 0.1}}}}, "stiffness"),
        ({"change": {"scene": {"controller": {"kind": "half_sample", "velocity": "sensor"}}}}, "a new part"),
        ({"change": {"grid": {"sample_rate_hz": 2000}}}, "a faster loop"),
        ({"change": {"grid": {"counts_per_rev": 4096}}}, "a new part"),
        ({"change": {"scene": {"wall": {"damping": 1e-5}, "knob": {"damping": 1e-3}}}}, "a new part"),
        ({"tune": {"controller.keep": [0.1, 1]}}, "firmware only"),
        ({"tune": {"knob.damping": [0, 1]}, "change": {"scene": {"controller": {}}}}, "a new part"),
    ],
)
def test_what_a_change_takes(remedy: dict, cost: str) -> None:
    assert effort_of(remedy) == cost


def row(times: float | None, rest: float = 0.0) -> dict:
    return {"ratio_median": times, "at_rest_fraction": rest}


GRID = {"plain": row(1.0), "soft": row(None, 1.0), "lag": row(4.0), "brake": row(9.0), "hold": row(1.3)}
COSTS = {
    "plain": "nothing",
    "soft": "stiffness",
    "lag": "firmware only",
    "brake": "a new part",
    "hold": "firmware only",
}
NEEDS = {"plain": "", "soft": "", "lag": "a running mean", "brake": "a brake", "hold": ""}
KEPT = {"plain": 1.0, "soft": 0.512, "lag": 0.97, "brake": None, "hold": 0.5}


def lines(names: tuple[str, ...], quietest: str) -> list[str]:
    return cost_lines({name: GRID[name] for name in names}, quietest, needs=NEEDS, costs=COSTS, kept=KEPT)


def test_the_quietest_says_what_it_costs_and_firmware_has_its_own() -> None:
    assert lines(("plain", "soft", "lag", "brake"), "brake") == [
        "soft costs stiffness. It keeps 0.51 of the stiffness.",
        "brake costs a new part: a brake.",
        "In firmware alone: lag, 4 times smaller.",
        "lag costs firmware only: a running mean.",
    ]
    assert lines(("plain", "lag", "hold"), "lag") == ["lag costs firmware only: a running mean."]
    assert lines(("plain", "brake"), "brake")[-1] == "None in firmware alone makes the buzz smaller."
    assert lines(("plain",), "") == []


def test_what_is_taken_along_gives_up_no_stiffness() -> None:
    assert most_of(GRID, COSTS) == "brake"
    assert most_of({name: GRID[name] for name in ("plain", "soft", "lag")}, COSTS) == "lag"
    assert most_of({"plain": GRID["plain"], "soft": GRID["soft"]}, COSTS) == ""
    rest = {**GRID, "hold": row(None, 1.0), "brake": row(None, 1.0)}
    assert most_of(rest, COSTS) == "hold"  # the cheaper of two that rest
