"""Tests of `specs.capabilities`: the program does what the table says, pair by pair, on a cell that is done quickly."""

from copy import deepcopy
from typing import Any

import pytest

from hknob_cli.errors import SpecError
from hknob_cli.specs.bench import merged
from hknob_cli.specs.capabilities import (
    COLUMNS,
    PARTS,
    PROVEN,
    REFUSED,
    STARTS,
    VERDICTS,
    WHY,
    engine_of,
    parts_of,
    takes,
    verdict_of,
)
from hknob_cli.specs.cells import cells_of
from hknob_cli.specs.generated import capabilities_page
from hknob_cli.specs.load import validate
from hknob_cli.specs.plan import SweepPlan, scene_at
from hknob_cli.specs.remarks import not_proven
from hknob_cli.specs.source import Source
from hknob_cli.stages.sweep.run import SweepStage
from tests.conftest import ROOT
from tests.specs.small_cells import BASE, BESIDE, CHANGES, KINDS, check_sweep, planned


def test_every_part_has_its_change() -> None:
    assert set(CHANGES) == set(PARTS) - {"people"}
    for part in CHANGES:
        plan = planned(part)
        assert isinstance(plan, SweepPlan)
        assert part in parts_of(plan.scene)
    assert set(WHY) <= set(VERDICTS)


# Trials that bounce on teeth take seconds; of a clock that jitters, as long as they may be, they are compiled.
@pytest.mark.parametrize(
    "part", [pytest.param(part, marks=pytest.mark.long) if part in ("play", "jitter") else part for part in CHANGES]
)
def test_trials_are_proven_where_the_table_says(part: str) -> None:
    check_sweep(part, "phases")


FEW_STARTS = [(part, "phases") for part in BESIDE]
FEW_STARTS += [(part, "phases") for part in ("profile", "end_stops", "dead_zone")]
FEW_STARTS += [(part, "phases") for part in ("hysteresis", "finger", "backlash")]


@pytest.mark.parametrize(("part", "starts"), FEW_STARTS)
def test_a_controller_goes_with_what_the_table_says(part: str, starts: str) -> None:
    """In the general loop, from sampled starts: what is found is proven, that the list is complete is not."""
    both = merged(CHANGES[part], CHANGES["controller"])
    source = Source("spec.yaml")
    source.value = {**merged(deepcopy(BASE), both), "starts": {**KINDS[starts], "phases": 2}}
    if starts != "phases":
        source.value["starts"] = KINDS[starts]
    plan = validate(source)
    assert isinstance(plan, SweepPlan)
    plan = plan._replace(starts=plan.starts._replace(phases=2)) if starts == "one" else plan
    scene = scene_at(plan.scene, next(iter(cells_of(plan))))
    assert engine_of(scene, STARTS[starts]) == "laws"
    assert verdict_of(parts_of(scene), "laws")[0] == PROVEN
    cell = SweepStage(plan, jobs=1).run().cells.to_pylist()[0]
    assert cell["certified_fraction"] == 1.0
    assert not cell.get("complete", False)


# Pairs that go together, with the engine of their trials.
PAIRS = [
    ("hysteresis", "virtual_damping", "laws"),
    ("backlash", "virtual_damping", "laws"),
    ("controller", "play", "laws"),
    ("estimated_speed", "play", "laws"),
    ("rubbing_motor", "play", "general"),
    ("play", "cogging", "general"),
    ("backlash", "play", "general"),
    ("squeeze", "play", "general"),
    ("friction", "cogging", "general"),
    ("finger", "cogging", "general"),
    ("hysteresis", "cogging", "general"),
    ("backlash", "cogging", "general"),
    ("jitter", "cogging", "general"),
    ("mesh", "cogging", "general"),
    ("gear", "cogging", "general"),
    pytest.param("controller", "cogging", "laws", marks=pytest.mark.long),  # compiles a loop that no quick test takes
    ("speed_sensor", "cogging", "laws"),
    ("detents", "cogging", "general"),
    ("squeeze", "cogging", "general"),
    ("squeeze", "mesh", "general"),
    *(("bare", part, "general") for part in ("profile", "detents", "end_stops", "dead_zone")),
    ("hysteresis", "play", "general"),  # of the pairs with play the one that is soon done
    *(("bare", part, "general") for part in ("jitter", "cogging", "play")),
]


@pytest.mark.one_in(8)
@pytest.mark.parametrize(("one", "other", "engine"), PAIRS)
def test_pairs_are_as_the_table_says(one: str, other: str, engine: str) -> None:
    source = Source("spec.yaml")
    change = CHANGES.get(one, {"scene": {"gear": {"motor_coulomb_torque": 1e-5}}})
    source.value = {**merged(deepcopy(BASE), merged(change, CHANGES[other])), "starts": KINDS["phases"]}
    plan = validate(source)
    assert isinstance(plan, SweepPlan)
    parts = parts_of(plan.scene)
    assert {one if one in CHANGES else "friction", other} <= parts
    assert engine_of(plan.scene, STARTS["phases"]) == engine
    cell = SweepStage(plan, jobs=1).run().cells.to_pylist()[0]
    if verdict_of(parts, engine)[0] == PROVEN:
        assert cell["certified_fraction"] == 1.0
        assert not_proven(plan) == []
    else:
        assert not_proven(plan) != []


ASKED: dict[str, dict[str, Any]] = {
    "basins": {"starts": KINDS["ranges"], "basins": {"points": 2}},
    "record": {"starts": KINDS["one"], "record": {"duration": 0.01}},
    "pulse": {"starts": KINDS["one"], "record": {"duration": 0.01, "pulse": {"torque": 0.01, "duration": 0.001}}},
    "perceive": {"starts": KINDS["phases"], "perceive": {"knob_radius": 0.0089}},
    "describing": {"kind": "dfa", "methods": ["df1", "tsypkin"]},
    "relay": {"kind": "dfa", "methods": ["sampled"]},
    "formulas": {"kind": "predict"},
}


@pytest.mark.parametrize("column", ASKED)
@pytest.mark.parametrize("part", CHANGES)
def test_specs_are_refused_where_the_table_says(part: str, column: str) -> None:
    """One fault or more where the table refuses the part, none where it does not."""
    try:
        planned(part, **ASKED[column])
        refused = False
    except SpecError:
        refused = True
    base = parts_of(planned(part).scene)  # type: ignore[union-attr]
    assert refused == (not takes(column, base))


@pytest.mark.parametrize("part", CHANGES)
def test_a_benchmark_refuses_what_the_table_says(part: str) -> None:
    scene = merged(deepcopy(BASE), CHANGES[part])["scene"]
    trial = {"scene": scene, "sample_rate_hz": 1000.0, "counts_per_rev": 256, "duration": 0.01}
    try:
        planned("bias", kind="bench", scene=None, grid=None, base=trial, scenes={"one": {}})
        refused = False
    except SpecError:
        refused = True
    assert refused == (VERDICTS[part, "bench"] == REFUSED)


@pytest.mark.parametrize("part", CHANGES)
def test_growth_refuses_what_the_table_says(part: str) -> None:
    """Of a scene without a hand, which is the bouncing ball, and with the part."""
    ball = {"scene": {"hand": CHANGES[part].get("scene", {}).get("hand")}}
    values = merged(merged(deepcopy(BASE), CHANGES[part]), ball if part not in ("hand",) else {})
    source = Source("spec.yaml")
    source.value = {**values, "starts": KINDS["phases"], "growth": {"duration": 0.01}}
    source.value["scene"].setdefault("knob", {}).pop("damping", None) if part == "handless" else None
    try:
        plan = validate(source)
    except SpecError:
        plain = {**source.value}
        plain.pop("growth")
        source.value = plain
        found = validate(source)
        assert isinstance(found, SweepPlan)
        assert not takes("bounces", parts_of(found.scene))
        return
    assert isinstance(plan, SweepPlan)
    assert takes("bounces", parts_of(plan.scene))


def test_every_column_has_a_title_of_its_own() -> None:
    assert len({row.title for row in COLUMNS.values()}) == len(COLUMNS)


def test_stored_page_is_current() -> None:
    assert (ROOT / "docs" / "reference" / "capabilities.md").read_text() == capabilities_page(), "make schemas"


def test_a_velocity_sensor_beside_friction_is_labelled() -> None:
    source = Source("spec.yaml")
    source.value = merged(merged(deepcopy(BASE), CHANGES["friction"]), CHANGES["speed_sensor"])
    source.value["starts"] = KINDS["phases"]
    plan = validate(source)
    assert isinstance(plan, SweepPlan)
    what = "Coulomb friction with a controller that reads a velocity sensor"
    assert not_proven(plan) == [f"what is found may stay unproven: the scene has {what}"]
    assert SweepStage(plan, jobs=1).run().cells.to_pylist()[0]["certified_fraction"] == 0.0
