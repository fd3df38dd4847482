"""Broken designs of a grid, and grids too large: a fault with its place, which says what is allowed."""

import pytest

from hknob_cli.errors import SpecError
from hknob_cli.specs.load import load
from tests.conftest import EXPERIMENTS, SPEC, faults_of, loaded

GRID = "  sample_rate_hz: [1000]\n  counts_per_rev: [1024]\n"
DESIGN = SPEC.replace(GRID, "  design: {sobol: 8}\n  sample_rate_hz: {log: [100, 1000]}\n  counts_per_rev: 1024\n")

# What is replaced, by what, and what must be said.
BROKEN = {
    "no method": ("{sobol: 8}", "{}", "9:11: grid.design: must have exactly one of sobol, halton, latin_hypercube"),
    "two methods": ("{sobol: 8}", "{sobol: 8, random: 8}", "9:11: grid.design: must have exactly one of"),
    "unknown method": ("sobol", "sobbol", "9:12: grid.design.sobbol: unknown key; did you mean 'sobol'?"),
    "a number": ("{sobol: 8}", "8", "9:11: grid.design: must be a mapping of keys to values, got 8"),
    "no points": ("sobol: 8", "sobol: 0", "9:19: grid.design.sobol: must be >= 1, got 0"),
    "part of a point": ("sobol: 8", "sobol: 2.5", "9:19: grid.design.sobol: must be a whole number, got 2.5"),
    "true points": ("sobol: 8", "sobol: true", "9:19: grid.design.sobol: must be a whole number, got true"),
    "a whole float": ("sobol: 8", "sobol: 1e7", "must span at most 1000000 cells, got 10000000; limits.max_cells"),
    "too many": ("sobol: 8", "sobol: 1e12", "9:19: grid.design.sobol: must be <= 1e+09"),
    "a large hypercube": ("sobol: 8", "latin_hypercube: 1000001", "grid.design.latin_hypercube: must be <= 1e+06"),
    "negative seed": ("sobol: 8", "sobol: 8, seed: -1", "9:28: grid.design.seed: must be >= 0, got -1"),
    "a counted axis": (
        "[100, 1000]}", "[100, 1000, 7]}",
        "10:37: grid.sample_rate_hz.log[2]: must be absent where the grid has a design: {log: [first, last]}, a list",
    ),
    "half a range": ("[100, 1000]", "[100]", "grid.sample_rate_hz.log[1]: missing, and required"),
    "no range": ("[100, 1000]", "[100, 100]", "10:19: grid.sample_rate_hz: must not repeat a value, got 100 twice"),
    "a range from zero": ("[100, 1000]", "[0, 1000]", "10:26: grid.sample_rate_hz.log[0]: must be >= 0.001, got 0"),
    "nothing varies": ("{log: [100, 1000]}", "100", "9:11: grid.design: must have an axis to vary: a range"),
    "a range of grips": (
        "1024\n", "1024\n  hand.grip_n: {lin: [0.7, 3]}\n", 'grid["hand.grip_n"].lin: must be a list of grip forces',
    ),
    "a range without a design": (
        "  design: {sobol: 8}\n", "", "9:20: grid.sample_rate_hz.log[2]: missing, and required: {log: [first, last, c",
    ),
    "a design of nothing": ("{sobol: 8}", "null", "log[2]: missing, and required: {log: [first, last, count]}"),
    "friction in dfa": (
        "kind: sweep", "kind: dfa", "must be absent: Coulomb friction is not in dfa's method sampled",
    ),
    "range of counts": ("counts_per_rev: 1024", "counts_per_rev: {log: [0, 5]}", "counts_per_rev.log[0]: must be"),
}  # fmt: skip


@pytest.mark.parametrize("name", BROKEN)
def test_broken_design(name: str) -> None:
    old, new, message = BROKEN[name]
    text = DESIGN.replace("starts: {angle: 0.02, phases: 8}\n", "") if "kind: dfa" in new else DESIGN
    if "dfa" in name:  # an end of a range that is not absent is enough
        text = text.replace("counts_per_rev: 1024", "counts_per_rev: 1024\n  knob.coulomb_torque: {lin: [0, 1e-4]}")
    assert old in text
    assert message in faults_of(text.replace(old, new, 1))


def test_cells_may_be_more_where_the_spec_says_so() -> None:
    large = SPEC.replace(
        GRID, "  sample_rate_hz: {log: [100, 1e4, 2000]}\n  counts_per_rev: {lin: [101, 1100, 1000]}\n"
    )
    message = faults_of(large)
    assert "8:1: grid: must span at most 1000000 cells, got 2000000; limits.max_cells allows up to 1e+13" in message
    plan = loaded(large + "limits: {max_cells: 2e6}\n")
    assert len(plan.axes["sample_rate_hz"]) == 2000
    assert loaded(DESIGN.replace("sobol: 8", "random: 1e7") + "limits: {max_cells: 1e7}\n").points.number == 10**7
    for wrong in ("1.5", "0", "1e14", "true", "many"):
        assert "limits.max_cells: must be" in faults_of(SPEC + f"limits: {{max_cells: {wrong}}}\n")
    people = "population: {table: 1, grip_n: 0.71, people: 200}\n"
    crowd = large.replace("  hand: {inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}\n", "") + people
    message = faults_of(crowd + "limits: {max_cells: 2e6}\n")
    assert "population: must span at most 2000000 cells with the grid, got 400000000" in message


def test_a_grid_too_large_is_refused_before_it_is_made() -> None:
    axes = "".join(
        f"  {name}: {{lin: [0.1, 0.9, 1000000]}}\n" for name in ("hand.stiffness", "hand.damping", "wall.stiffness")
    )
    assert "must span at most 1000000 cells, got 1000000000000000000" in faults_of(SPEC.replace(GRID, GRID + axes))


def test_an_analysis_keeps_all_in_memory() -> None:
    text = DESIGN.replace("kind: sweep", "kind: predict").replace("starts: {angle: 0.02, phases: 8}\n", "")
    assert "at most 1000000 cells, got 2000000; predict keeps all in memory" in faults_of(text.replace("8}", "2e6}", 1))


def test_campaigns_and_remedies_have_no_design() -> None:
    campaign = "kind: hw-run\nname: x\ngrid: {design: {sobol: 8}, sample_rate_hz: {log: [455, 4000]}}\n"
    assert "3:8: grid.design: must be absent: trials are run for every combination" in faults_of(campaign)
    with pytest.raises(SpecError, match=r"base\.grid\.design: must be absent: remedies are compared over every"):
        load(EXPERIMENTS / "remedies.yaml", ("base.grid.design={sobol: 8}",))
    change = "remedies.plain wall.change.grid={design: {sobol: 8}, sample_rate_hz: [100, 1000]}"
    with pytest.raises(SpecError, match=r"plain wall\.change: must leave a grid without a design"):
        load(EXPERIMENTS / "remedies.yaml", (change,))


def test_one_value_of_a_design_is_set_by_its_path() -> None:
    source = EXPERIMENTS / "hand_on_knob.yaml"
    sets = ("grid.design.halton=16", "grid.sample_rate_hz.log=[100, 1000]", "grid.design.seed=5")
    points = load(source, sets).points
    assert points is not None
    assert points._replace(scales={}) == ("halton", 16, 5, {})
