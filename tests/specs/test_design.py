"""The spec of a search for a design: what it says, and its faults with their places."""

from pathlib import Path

import pytest

from hknob_cli.errors import SpecError
from hknob_cli.printed import grasps
from hknob_cli.specs import design
from hknob_cli.specs.load import load
from hknob_cli.specs.plan import PERSON
from hknob_cli.specs.stage_plans import DesignPlan
from hknob_cli.stages.work import hand_inputs
from tests.designs import DESIGN, planned
from tests.identified import PEOPLE, write_conditions


def faults(text: str) -> list[str]:
    with pytest.raises(SpecError) as caught:
        planned(text)
    return str(caught.value).splitlines()


def place(marked: str) -> str:
    """Line and column of the mark in a text."""
    before = marked[: marked.index("@")]
    return f"design.yaml:{before.count(chr(10)) + 1}:{len(before) - before.rfind(chr(10))}: "


def test_the_plan_has_every_design_for_every_person() -> None:
    plan = planned()
    assert plan.size == 12 + 12 + 6
    assert plan.people == 2
    assert [one.fixed for one in plan.candidates] == [(), (), ("sample_rate_hz",)]
    rates = plan.choices[0]
    assert [(one.value, one.cost) for one in rates.options] == [(500.0, 0.0), (1000.0, 0.5)]
    assert rates.unit == "Hz"
    for one in plan.candidates:
        assert list(one.sweep.axes)[-1] == PERSON
        assert len(one.sweep.scene.hand.by_person) == 2


def test_people_are_a_population_too() -> None:
    hands = "people:\n  - {table: 1, grip_n: 0.71}\n  - {table: 2, grip_n: 2.4}\n"
    plan = planned(DESIGN.replace(hands, "people: {table: 1, grip_n: 0.71, people: 7, seed: 3}\n"))
    assert plan.people == 7
    assert len(plan.scene.hand.by_person) == 7


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("{value: 500,", "{value: @fast,", "is not a number with a unit"),
        ("{value: 1 kHz,", "{value: @1 kg,", "is in kilogram, which is not a kind of Hz"),
        ("{value: 1440,", "{value: @360,", "must not repeat a value, got 360 twice"),
        ("cost: 0.5", "cost: @-1", "must be >= 0, got -1"),
        ("knob.damping:\n", "@knob.dampling:\n", "did you mean 'knob.damping'?"),
        ("knob.damping:\n", "@hand.damping:\n", "must be of the device"),
        ("- {table: 1,", "- {@tabel: 1,", "unknown key; did you mean 'table'? "),
        (
            "- {table: 2, grip_n: 2.4}",
            "- @{finger: {inertia: 1.0e-6, stiffness: 1}, fingerpad: {stiffness: 1}}",
            "must be a table's or by inertia, damping and stiffness",
        ),
        ("{at_least: 0.26}", "{at_least: 0.26, @at_leas: 1}", "did you mean 'at_least'?"),
        ("touch: {above_present: 0}", "touch: @{people: 0.1}", "must have exactly one of 'at_most' and"),
        ("touch: {above_present: 0}", "touch: {above_present: 0, people: @1.5}", "must be < 1, got 1.5"),
        ("touch: {above_present: 0}", "hearing: {at_most: @3}", "without it only differences mean something"),
        ("counts_per_rev: 2650}\n", "counts_per_rev: @2000}\n", "must be one of its choices (360, 1440, 2650)"),
        ("present: {sample", "present: {@simple", "did you mean 'sample_rate_hz'?"),
        ("  plain wall: {}", "  plain wall: {cost: @1}", "must be 0"),
        ("remedies:\n", "reference: @plane wall\nremedies:\n", "must be one of remedies"),
        ("keep: 0.15", "@kept: 0.15", "did you mean 'keep'?"),
        ("change: {grid: {sample_rate_hz: 4000}}", "@change: {starts: {phases: 3}}", "must not have starts"),
        ("change: {grid: {sample_rate_hz: 4000}}", "@change: {scene: {hand: {}}}", "hands are listed under people"),
        ("{sample_rate_hz: 4000}", "{sample_rate_hz: @[4000, 5000]}", "must have one value"),
        ("{sample_rate_hz: 4000}", "{@hand.stiffness: 1}", "which has no 'hand'"),
        ("{sample_rate_hz: 4000}", "@3", "must be a mapping of keys to values, got 3"),
        ("change: {grid: {sample_rate_hz: 4000}}", "change: {scene: @3}", "must be a mapping of keys to values, got 3"),
        ("inertia: 19.8", "inertia: @-19.8", "must be > 0"),
        ("    bias: {torque: 0.001}", "    @hand: {inertia: 1}", "hands are listed under people"),
        ("    bias: {torque: 0.001}", "    encoder: @none", "must be an encoder"),
        ("    bias: {torque: 0.001}", "    @clock: {jitter: 0.1}", "that jitters no motion repeats"),
        ("  starts: {phases: 2}", "  @grid: {}", "scene, starts and limits are known"),
        ("  - {table: 2, grip_n: 2.4}", "  - {table: 2, grip_n: @2.5}", "2.5"),
        ("perceive: {knob_radius", "perceive: {@knob_radios: 1, knob_radius", "did you mean 'knob_radius'?"),
    ],
)
def test_a_fault_has_its_place(old: str, new: str, says: str) -> None:
    marked = DESIGN.replace(old, new, 1)
    assert marked != DESIGN
    found = faults(marked.replace("@", ""))
    assert len(found) == 1, found
    assert says in found[0]
    assert found[0].startswith(place(marked)), (found[0], place(marked))


@pytest.mark.parametrize(
    ("change", "key", "says"),
    [
        ("{scene: [1]}", "change.scene", "must be a mapping of keys to values, got a list of 1"),
        ("{scene: null}", "change.scene", "missing, and required"),
        ("{scene: {wall: {stiffness: -1}}}", "change.scene.wall.stiffness", "must be >= 0, got -1"),
        ("{scene: {hand: {inertia: 1}}}", "change", "must not have scene.hand: hands are listed under people"),
        ("{kind: sweep}", "change", "must not have kind: a remedy changes scene and grid"),
    ],
)
def test_a_fault_in_a_change_set_as_a_whole_is_not_the_base_s(tmp_path: Path, change: str, key: str, says: str) -> None:
    path = tmp_path / "design.yaml"
    path.write_text(DESIGN)
    setting = f"remedies.bounded lag.change={change}"
    with pytest.raises(SpecError) as error:
        load(path, (setting,))
    (fault,) = error.value.faults
    assert (fault.where, fault.key, fault.message) == (f"--set {setting}", f"remedies.bounded lag.{key}", says)


def test_a_remedy_set_as_a_whole_may_change_nothing(tmp_path: Path) -> None:
    path = tmp_path / "design.yaml"
    path.write_text(DESIGN)
    assert isinstance(load(path, ("remedies.bounded lag={cost: 1}",)), DesignPlan)


def test_choices_by_dotted_path_can_be_set(tmp_path: Path) -> None:
    path = tmp_path / "design.yaml"
    path.write_text(DESIGN)
    plan = load(path, ("choices.knob.damping=[{value: 0}, {value: 2.0e-3}]", "present.knob.damping=2.0e-3"))
    assert isinstance(plan, DesignPlan)
    damping = next(one for one in plan.choices if one.name == "knob.damping")
    assert [one.value for one in damping.options] == [0.0, 2.0e-3]
    assert plan.present["knob.damping"] == 2.0e-3


def test_a_knob_too_light_for_a_hand_is_a_fault() -> None:
    text = DESIGN.replace("  - {table: 2, grip_n: 2.4}", "  - {table: 4, grip_n: 1.1}").replace("19.8", "0.5")
    negative = [
        (number, grasp.grip_n, grasp[1]) for number in (1, 2, 3, 4, 5) for grasp in grasps(number) if grasp[1] < -5e-8
    ]
    assert negative  # as printed, less the apparatus
    number, grip, _ = negative[0]
    found = faults(text.replace("{table: 4, grip_n: 1.1}", f"{{table: {number}, grip_n: {grip}}}"))
    assert found[0].startswith("design.yaml:11:5: people[1]: must leave an inertia above 0: ")


def test_people_from_a_file_are_its_subjects(tmp_path: Path) -> None:
    write_conditions(tmp_path / "hands" / "conditions.parquet")
    hands = "people:\n  - {table: 1, grip_n: 0.71}\n  - {table: 2, grip_n: 2.4}\n"
    path = tmp_path / "design.yaml"
    path.write_text(DESIGN.replace(hands, "people: {from: hands, spread: subjects}\n"))
    plan = load(path)
    assert plan.people == len(PEOPLE)
    assert set(hand_inputs(plan)) >= {"population_sha256"}
    path.write_text(DESIGN.replace(hands, "people: {from: nowhere}\n"))
    with pytest.raises(SpecError, match=r"design.yaml:9:16: people.from: .*nowhere"):
        load(path)


def test_rate_and_counts_must_be_chosen() -> None:
    text = DESIGN.replace("  sample_rate_hz:\n    - {value: 500, cost: 0}\n    - {value: 1 kHz, cost: 0.5}\n", "")
    found = faults(text.replace("present: {sample_rate_hz: 1000, ", "present: {"))
    assert any("choices: must have sample_rate_hz; a single value is a choice of one" in one for one in found)


def test_a_controller_goes_with_friction_as_a_choice() -> None:
    text = DESIGN.replace("knob.damping:", "knob.coulomb_torque:")
    assert planned(text).candidates[1].fixed == ()
    free = text.replace("{scene: {controller:", "{scene: {knob: {coulomb_torque: 0}, controller:")
    assert planned(free).candidates[1].fixed == ("knob.coulomb_torque",)


def test_too_many_designs_are_refused() -> None:
    many = "\n".join(f"    - {{value: {one}}}" for one in range(100, 1000))
    listed = "\n".join(f"    - {{value: {one}.0e-6}}" for one in range(1, 30))
    text = DESIGN.replace("    - {value: 360, cost: 0, label: direct}\n", many + "\n")
    text = text.replace("    - {value: 5.0e-4, cost: 1}\n", listed + "\n").replace("    - {value: 1440, cost: 2}\n", "")
    assert "must span at most 20000 designs" in faults(text)[0]


def test_the_most_designs(monkeypatch: pytest.MonkeyPatch) -> None:
    size = planned().size
    monkeypatch.setattr(design, "MOST_DESIGNS", size)
    assert planned().size == size
    monkeypatch.setattr(design, "MOST_DESIGNS", size - 1)
    (found,) = faults(DESIGN)
    assert f"at most {size - 1}" in found
