"""Recordings, people and studies: what each rule of their specs allows last, and what it refuses first."""

from pathlib import Path
from typing import Any

import pytest

from hknob_cli.errors import SpecError
from hknob_cli.specs.find_people import Spread, _drawn, draw, find_people
from hknob_cli.specs.hand import PopulationSpec, same_grip
from hknob_cli.specs.hand_from import BEST_ESTIMATOR, ChoiceError, narrowed
from hknob_cli.specs.identification import ColumnPlan, SysidPlan
from hknob_cli.specs.load import load_text
from hknob_cli.specs.plan import SweepPlan
from hknob_cli.specs.source import Source
from hknob_cli.specs.sysid import MOST_TRIALS
from hknob_cli.specs.virtual_apparatus import VirtualSpec
from tests.conftest import SPEC
from tests.identified import condition, conditions, write_conditions
from tests.specs.test_edges_of_rules import HAND, wrong

SYSID = "kind: sysid\nname: s\nwhat: {what}\n{more}\nestimators: [output_error]\n"


def test_the_best_estimator_is_chosen_among_estimators_alone() -> None:
    """A subject may be called like it."""
    rows: list[dict[str, Any]] = [{"subject": one, "estimator": BEST_ESTIMATOR} for one in (BEST_ESTIMATOR, "S1")]
    with pytest.raises(ChoiceError, match="missing, and required"):
        narrowed(rows, {}, ["subject"])
    rows = [{"subject": "S1", "estimator": one} for one in (BEST_ESTIMATOR, "least_squares")]
    assert narrowed(rows, {}, ["estimator"]) == rows[:1]
    with pytest.raises(ChoiceError, match=r"^must be absent$"):
        narrowed([{"experiment": None}], {"experiment": "1"}, ["experiment"])
    with pytest.raises(ChoiceError):
        narrowed([{"estimator": "a"}, {"estimator": "b"}], {}, ["estimator"])


def test_a_mean_hand_without_damping_or_stiffness_is_not_drawn() -> None:
    spec = PopulationSpec(table=1, grip_n=0.71, people=3, seed=1)
    for damping, stiffness in ((0.0, 0.04), (3e-4, 0.0)):
        with pytest.raises(ChoiceError, match="has a mean damping of"):
            _drawn(Spread((3e-7, damping, stiffness), (1e-7, 1e-4, 0.01)), spec, 0.0)


def test_a_unit_of_a_column_that_is_no_quantity() -> None:
    text = SYSID.format(what="hand", more="recordings: [a.csv]\ncolumns: {trial: {from: no, unit: mm}}")
    assert wrong(text) == ["columns.trial.unit: must be absent: this column is no quantity"]


def test_the_most_virtual_trials() -> None:
    """Of one person in one block at one grip, with pulses of the usual length; a longer input counts as more."""
    one = "virtual: {subjects: 1, experiments: [EXPERIMENT], grips: GRIPS, blocks: BLOCKS, trials: 1000INPUT}"
    text = SYSID.format(what="hand", more=one).replace("EXPERIMENT", "1")
    most = text.replace("GRIPS", "[0]").replace("BLOCKS", str(MOST_TRIALS // 1000))
    assert wrong(most.replace("INPUT", "")) == []
    most += "excitation: continuous\n"
    assert wrong(most.replace("INPUT", ", input: {kind: step, duration: 0.065}")) == []
    assert wrong(most.replace("INPUT", ", input: {kind: step, duration: 0.02}")) == []
    assert wrong(most.replace("INPUT", ", input: {kind: step, duration: 0.13}")) == [
        "virtual: must make at most 25000 trials with these subjects, blocks and grips, got 50000"
    ]
    more = text.replace("GRIPS", "[0]").replace("BLOCKS", str(MOST_TRIALS // 1000 + 1)) + "excitation: continuous\n"
    for given in ("0.065", "0.02"):
        found = wrong(more.replace("INPUT", f", input: {{kind: step, duration: {given}}}"))
        assert found[0].startswith("virtual: must make at most 50000 trials with these ")


def test_a_torque_that_runs_straight_between_samples_does_not_settle() -> None:
    text = SYSID.format(what="hand", more="recordings: [a.csv]\nsettling_time_constant: 0.003")
    assert wrong(text) == []
    assert wrong(text + "torque_between_samples: linear\n") == [
        "settling_time_constant: must be 0 where the torque between samples is linear"
    ]


def test_keys_that_contradict_are_pointed_at() -> None:
    text = SYSID.format(what="hand", more="virtual: {}\nagainst: there")
    with pytest.raises(SpecError) as raised:
        load_text(text, "spec.yaml")
    assert [(fault.line, fault.column) for fault in raised.value.faults] == [(5, 1)]


def test_all_but_friction_may_be_known() -> None:
    known = "recordings: [a.csv]\nfix: {inertia: 1e-6, damping: 1e-4, stiffness: 0.1}"
    text = SYSID.format(what="hand", more=known)
    assert wrong(text) == ["fix: must leave a parameter to identify"]
    assert wrong(text.replace("output_error", "output_error_friction")) == []


def test_keys_that_virtual_recordings_do_not_have_are_pointed_at() -> None:
    with pytest.raises(SpecError) as raised:
        load_text(SYSID.format(what="hand", more="virtual: {}\nlimits: {}"), "spec.yaml")
    assert [(fault.key, fault.line, fault.column) for fault in raised.value.faults] == [("limits", 5, 1)]


@pytest.mark.parametrize("value", ["-1", ".nan", ".inf", "heavy"])
def test_a_constant_column_that_is_no_number(value: str) -> None:
    text = SYSID.format(what="hand", more=f"recordings: [a.csv]\ncolumns: {{grip_target_n: {{value: {value}}}}}")
    (said,) = wrong(text)
    assert said.startswith("columns.grip_target_n.value: must be a number >= 0, got ")


def test_constant_columns() -> None:
    text = SYSID.format(what="hand", more="recordings: [a.csv]\ncolumns: {grip_target_n: {value: VALUE}}")
    for value in (0, 0.5, 14.2):
        plan = load_text(text.replace("VALUE", str(value)), "spec.yaml")
        assert isinstance(plan, SysidPlan)
        assert plan.columns["grip_target_n"].value == value
        assert plan.against == ""


def test_what_a_virtual_apparatus_is_told_is_kept() -> None:
    spec = VirtualSpec.model_validate({"rig": {"ideal": True}, "input": {"kind": "step", "duration": 0.05}})
    plan = spec.plain()
    assert plan.ideal
    assert "ideal" not in plan.rig
    assert plan.input is not None
    assert VirtualSpec().plain().input is None


def test_people_of_a_mean_above_0_are_drawn_without_the_apparatus() -> None:
    spread = Spread((3e-7, 3e-4, 0.04), (1e-7, 1e-4, 0.01))
    hands, said = _drawn(spread, PopulationSpec(table=1, grip_n=0.71, people=3, seed=1), 1e-6)
    assert (hands, said) == (draw(spread, people=3, seed=1), ())
    light, apparatus = spread._replace(means=(-1e-7, 3e-4, 0.04)), 4e-7
    hands, (text,) = _drawn(light, PopulationSpec(table=1, grip_n=0.71, people=3, seed=1), apparatus)
    assert hands == [(j - apparatus, b, k) for j, b, k in draw(spread, people=3, seed=1)]
    assert text == "population: the hand's mean inertia is -1e-07 kg*m^2; it is drawn with the apparatus' 4e-07"


def test_a_column_keeps_its_name_where_its_unit_is_another() -> None:
    text = SYSID.format(what="hand", more="recordings: [a.csv]\ncolumns: {torque_nm: {unit: mN*m}}")
    plan = load_text(text, "spec.yaml")
    assert isinstance(plan, SysidPlan)
    assert plan.columns["torque_nm"] == ColumnPlan("torque_nm", 1e-3)
    scaled = load_text(text.replace("unit: mN*m", "from: t, scale: 2, sign: -1"), "spec.yaml")
    assert isinstance(scaled, SysidPlan)
    assert scaled.columns["torque_nm"] == ColumnPlan("t", -2.0)


PEOPLE = SPEC.replace(HAND, "") + "population: {from: people/conditions.parquet}\n"


def people(folder: Path, rows: list[dict[str, Any]], more: str = "") -> SweepPlan:
    """The plan of a population that is from these rows."""
    write_conditions(folder / "people" / "conditions.parquet", rows)
    plan = load_text(PEOPLE.replace("parquet}", f"parquet{more}}}"), str(folder / "spec.yaml"))
    assert isinstance(plan, SweepPlan)
    return plan


def test_a_file_without_people(tmp_path: Path) -> None:
    with pytest.raises(SpecError, match=r"population\.from: has no subjects"):
        people(tmp_path, [])


def test_people_that_contradict_are_not_looked_for() -> None:
    text = PEOPLE.replace("parquet}", "parquet, spread: subjects, people: 5}")
    assert wrong(text) == ["population.people: must be absent where the people are the subjects"]


def test_people_that_another_stage_is_yet_to_find_are_one() -> None:
    source = Source("spec.yaml")
    source.waiting = frozenset({"people"})
    for spread, count in (("subjects", 1), ("lognormal", 7)):
        spec = PopulationSpec.model_validate({"from": "people", "spread": spread, "people": 7})
        assert len(find_people(source, spec, 1e-6).hands) == count


def test_people_are_drawn_with_the_apparatus_that_is_subtracted(tmp_path: Path) -> None:
    """Of a file without it: 0.9, 1.1 and 1.3e-7, less 2e-7."""
    numbers = {f"s{i}": (j * 1e-7, 3e-4, 0.03 + 0.01 * i) for i, j in enumerate((0.9, 1.1, 1.3))}
    rows = conditions(numbers, apparatus_inertia_kg_m2=None)
    plan = people(tmp_path, rows, ", subtract_apparatus: 2.0e-7, people: 3")
    assert plan.scene.hand is not None
    assert plan.scene.hand.origin.notes == (
        "population: the hand's mean inertia is -9e-08 kg*m^2; it is drawn with the apparatus' 2e-07",
    )


def test_grips_are_the_same_to_nine_digits() -> None:
    assert same_grip(4.3, 4.3 * (1.0 + 0.9e-9))
    assert not same_grip(4.3, 4.3 * (1.0 + 1.1e-9))


def test_a_study_of_nuisances_lists_one() -> None:
    text = "kind: sysid\nname: s\nstudy: {bias: {nuisances: LISTED}}\n"
    assert wrong(text.replace("LISTED", "{noise_rad: [0, 1.0e-4]}")) == []
    assert wrong(text.replace("LISTED", "{}")) == [
        "study.bias.nuisances: must list one of: noise_rad, coulomb_nm, lag_s, counts_per_rev, decimation"
    ]


def test_where_a_fit_begins() -> None:
    text = SYSID.format(what="hand", more="recordings: [a.csv]")
    for more, free in (("", False), ("excitation: continuous\n", True), ("initial_state: free\n", True)):
        plan = load_text(text + more, "spec.yaml")
        assert isinstance(plan, SysidPlan)
        assert plan.motion.free_start is free


def test_rows_without_a_grip_are_no_row_of_one() -> None:
    rows: list[dict[str, Any]] = [{"grip_target_n": None}, {"grip_target_n": 0.71}]
    assert narrowed(rows, {"grip_n": 0.71}, ["grip_n"]) == rows[1:]


def test_whole_numbers_of_constant_columns() -> None:
    text = SYSID.format(what="hand", more="recordings: [a.csv]\ncolumns: {block: {value: VALUE}}")
    assert wrong(text.replace("VALUE", "2")) == []
    assert wrong(text.replace("VALUE", "2.5")) == ["columns.block.value: must be a whole number, got 2.5"]


def test_a_mean_over_persons_is_drawn_as_it_spreads(tmp_path: Path) -> None:
    plan = people(tmp_path, [condition((1e-7, 3e-4, 0.04))], ", people: 3")
    assert plan.scene.hand is not None
    assert len(plan.scene.hand.by_person) == 3


def test_a_mean_inertia_below_0_without_an_apparatus_cannot_be(tmp_path: Path) -> None:
    rows = [condition((-1e-7, 3e-4, 0.04), apparatus_inertia_kg_m2=0.0)]
    with pytest.raises(SpecError, match=r"has a mean inertia of -1e-07 kg\*m\^2, which must be > 0"):
        people(tmp_path, rows)


def test_levels_of_a_study_are_those_that_are_listed() -> None:
    text = "kind: sysid\nname: s\nstudy: {bias: {nuisances: {noise_rad: [0, 1.0e-4], decimation: [1, 10]}}}\n"
    plan = load_text(text, "spec.yaml")
    assert isinstance(plan, SysidPlan)
    assert plan.study is not None
    assert plan.study.bias is not None
    assert plan.study.bias.nuisances == {"noise_rad": (0.0, 1e-4), "decimation": (1.0, 10.0)}
