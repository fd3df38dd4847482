"""Overrides, pipelines, remedies, benchmarks: what each rule allows last, and what it refuses first."""

from pathlib import Path

import pytest

from hknob_cli.errors import SpecError
from hknob_cli.specs import remedies
from hknob_cli.specs.load import load, load_pipeline, load_text, validate
from hknob_cli.specs.pipeline import RESERVED, validate_pipeline
from hknob_cli.specs.plan import (
    BenchPlan,
    Points,
    SweepPlan,
)
from hknob_cli.specs.remedies import RemediesPlan
from hknob_cli.specs.source import parse
from tests.conftest import ROOT, SPEC
from tests.designs import DESIGN
from tests.specs.test_edges_of_rules import wrong
from tests.specs.test_remedies import TRIAL


def test_a_stage_is_read_by_its_kind() -> None:
    assert load(ROOT / "experiments" / "smoke_grid.yaml", kind="sweep").name == "smoke-grid"


def test_a_pipeline_is_no_stage() -> None:
    text = "kind: pipeline\nname: p\nstages: {}\n"
    with pytest.raises(SpecError, match=r"got 'pipeline'$") as raised:
        validate(parse(text, "spec.yaml"))
    assert "one of: sysid, sweep, " in str(raised.value)


def test_a_file_of_a_pipeline_is_no_stage(tmp_path: Path) -> None:
    path = tmp_path / "pages.yaml"
    path.write_text("kind: pipeline\nname: p\nstages: {knob: {spec: knob.yaml}}\n")
    with pytest.raises(SpecError, match=r"kind: must be one of: sysid, .* got 'pipeline'$"):
        load(path)


def test_a_stage_that_has_the_name_of_a_file_is_pointed_at() -> None:
    text = "kind: pipeline\nname: p\nstages:\n  RESERVED: {spec: knob.yaml}\n"
    for name in RESERVED:
        with pytest.raises(SpecError) as raised:
            validate_pipeline(parse(text.replace("RESERVED", name), "spec.yaml"))
        assert [(fault.line, fault.column) for fault in raised.value.faults] == [(4, 3)]


def test_a_stage_that_has_neither_spec_nor_folder_is_pointed_at() -> None:
    with pytest.raises(SpecError) as raised:
        validate_pipeline(parse("kind: pipeline\nname: p\nstages:\n  knob: {set: {name: a}}\n", "spec.yaml"))
    assert [(fault.line, fault.column) for fault in raised.value.faults] == [(4, 3)]


@pytest.mark.parametrize(
    ("text", "key"),
    [
        ("grid", ""),
        ("scene.knob.inertia.x=1", "scene.knob.inertia.x"),
        ("scne.knob=1", "scne.knob"),
        ("name=[", "name"),
    ],
)
def test_a_fault_of_an_override_has_no_line(text: str, key: str) -> None:
    with pytest.raises(SpecError) as raised:
        load(ROOT / "experiments" / "smoke_grid.yaml", (text,))
    (fault,) = raised.value.faults
    assert (fault.where, fault.line, fault.column, fault.key) == (f"--set {text}", 0, 0, key)


def test_every_value_of_a_tuned_remedy_is_planned() -> None:
    text = TRIAL.replace(
        "    change: {scene: {con", "    tune: {controller.keep: [0.1, 0.2]}\n    change: {scene: {con"
    )
    plan = validate(parse(text, "spec.yaml"))
    assert isinstance(plan, RemediesPlan)
    assert [[one.value for one in remedy.tuned] for remedy in plan.remedies] == [[], [0.1, 0.2]]


@pytest.mark.parametrize(
    ("scene", "grid"),
    [("{sampling: continuous, ", "{counts_per_rev: [1024]}"), ("{encoder: none, ", "{sample_rate_hz: [1000]}")],
    ids=["no clock", "no counts"],
)
def test_remedies_act_at_a_rate_and_on_counts(scene: str, grid: str) -> None:
    text = TRIAL.replace("  scene:\n    knob: {inertia: 1.9e-6}\n    wall: {stiffness: 0.27}\n", f"  scene: {scene}"
                         "knob: {inertia: 1.9e-6}, wall: {stiffness: 0.27}}\n")  # fmt: skip
    text = text.replace("{sample_rate_hz: [1000], counts_per_rev: [1024]}", grid)
    assert wrong(text) == ["base.scene: must be sampled, and have an encoder: remedies act at a sample rate, on counts"]


def test_an_axis_of_the_grid_is_overridden_by_its_path() -> None:
    plan = load_text(SPEC, "spec.yaml", ("grid.wall.stiffness=[0.1, 0.2]",))
    assert isinstance(plan, SweepPlan)
    assert plan.axes["wall.stiffness"] == [0.1, 0.2]


def test_a_design_of_the_grid_is_overridden() -> None:
    plan = load_text(SPEC, "spec.yaml", ("grid.design={sobol: 8, seed: 1}", "grid.wall.stiffness.lin=[0.1, 0.2]"))
    assert isinstance(plan, SweepPlan)
    assert plan.points == Points("sobol", 8, 1, {"wall.stiffness": "lin"})


def test_scenes_of_a_benchmark() -> None:
    text = (
        "kind: bench\nname: b\nbase:\n  scene: {knob: {inertia: 1.9e-6}, wall: {stiffness: 0.27}}\n"
        "  sample_rate_hz: 2000\n  counts_per_rev: 1024\n  duration: 0.12\n"
        "scenes: {plain: {}, bare: {scene: {encoder: none}}}\n"
    )
    plan = load_text(text, "spec.yaml")
    assert isinstance(plan, BenchPlan)
    assert [(one.name, one.counts_per_rev, one.samples) for one in plan.scenes] == [
        ("plain", 1024, 240), ("bare", None, 240),
    ]  # fmt: skip


def test_a_kind_that_is_no_word_has_no_keys_to_override() -> None:
    assert wrong("kind: [sweep]\n", "name=a")[0].startswith("kind: must be one of: ")


def test_an_override_of_a_stage_is_by_its_path(tmp_path: Path) -> None:
    (tmp_path / "pages.yaml").write_text("kind: pipeline\nname: p\nstages: {knob: {spec: knob.yaml}}\n")
    plan = load_pipeline(tmp_path / "pages.yaml", ("stages.knob.set.scene.wall.stiffness=0.3",))
    assert plan.stages["knob"].settings == ("scene.wall.stiffness=0.3",)
    plan = load_pipeline(tmp_path / "pages.yaml", ("stages.knob.set={name: a}",))
    assert plan.stages["knob"].settings == ('name="a"',)


def test_a_remedy_without_an_encoder_is_said_once() -> None:
    text = TRIAL.replace("controller: {kind: bounded_lag}", "encoder: none")
    assert wrong(text) == ["remedies.lag.change: must leave a sample clock and an encoder"]
    bare = "{scene: {encoder: none}, grid: {counts_per_rev: null}}"
    slow = "{scene: {sampling: continuous, encoder: none}, grid: {sample_rate_hz: null, counts_per_rev: null}}"
    for change in (bare, slow):
        text = TRIAL.replace("{scene: {controller: {kind: bounded_lag}}}", change)
        assert wrong(text) == ["remedies.lag.change: must leave a sample clock and an encoder"]


def test_a_benchmark_needs_counts() -> None:
    text = (
        "kind: bench\nname: b\nbase:\n  scene: {knob: {inertia: 1.9e-6}, wall: {stiffness: 0.27}}\n"
        "  sample_rate_hz: 2000\n  duration: 0.12\nscenes: {plain: {}}\n"
    )
    assert wrong(text) == ["scenes.plain.counts_per_rev: missing, and required"]


def test_what_a_scene_of_a_benchmark_changes_is_wrong_there() -> None:
    text = (
        "kind: bench\nname: b\nbase:\n"
        "  scene: {knob: {inertia: 1.9e-6}, wall: {stiffness: 0.27}, bias: {half_quantum: true}}\n"
        "  sample_rate_hz: 2000\n  counts_per_rev: 1024\n  duration: 0.12\nscenes: {bare: {scene: {encoder: none}}}\n"
    )
    said = "scene.bias.half_quantum: must be absent where encoder is none, which has no counts"
    assert wrong(text)[-1] == f"base.{said}"
    own = text.replace("encoder: none}", "encoder: none, bias: {half_quantum: true}}")
    assert wrong(own)[-1] == f"scenes.bare.{said}"


def test_a_spec_that_is_not_to_be_from_a_preset() -> None:
    source = parse(SPEC.replace("  knob:", "  from: smartknob\n  knob:"), "spec.yaml")
    with pytest.raises(SpecError, match=r"scene\.from: unknown key"):
        validate(source, presets=False)


def test_a_kind_that_there_is_not_has_no_keys_to_override() -> None:
    assert wrong("kind: sweeep\n", "name=a")[0].endswith("did you mean 'sweep'?")


def test_two_pushes_are_two() -> None:
    assert wrong(TRIAL + "press: {torques: [0.001, 0.002]}\n") == []
    assert wrong(TRIAL + "press: {torques: [0.002, 0.002]}\n") == [
        "press.torques: must be two pushes, the smaller first"
    ]
    assert wrong(TRIAL + "reference: none\n") == ["reference: must be one of remedies (plain wall, lag), got 'none'"]


def test_a_stage_of_a_folder_sets_nothing() -> None:
    stage = "kind: pipeline\nname: p\nstages: {hand: {folder: there}}\n"
    source = parse(stage, "spec.yaml")
    assert validate_pipeline(source).stages["hand"].folder == Path("there")
    with pytest.raises(SpecError, match="must have either spec"):
        validate_pipeline(parse(stage.replace("there", "there, set: {name: a}"), "spec.yaml"))


def test_a_fault_has_its_line_beside_an_override() -> None:
    with pytest.raises(SpecError) as raised:
        load_text(SPEC.replace("0.27", "-1"), "spec.yaml", ("scene.bias.torque=-1",))
    assert {(fault.where, fault.line, fault.column) for fault in raised.value.faults} == {
        ("spec.yaml", 6, 21), ("--set scene.bias.torque=-1", 0, 0),
    }  # fmt: skip


@pytest.mark.parametrize("text", ["scene..x=1", "=1", "name"])
def test_an_override_has_a_path_and_a_value(text: str) -> None:
    assert wrong(SPEC, text) == [": must be key.path=value"]


def test_a_value_that_the_grid_overrules_is_a_fault_of_the_remedy() -> None:
    text = TRIAL.replace("counts_per_rev: [1024]}", "counts_per_rev: [1024], wall.stiffness: [0.1, 0.2]}")
    (said,) = wrong(text.replace("controller: {kind: bounded_lag}", "wall: {stiffness: 0.3}"))
    assert said.startswith("remedies.lag.change: must not set scene.wall.stiffness, which the grid of the base varies")


def test_a_stage_that_needs_another_is_not_read_alone(tmp_path: Path) -> None:
    (tmp_path / "knob.yaml").write_text(SPEC)
    stages = "{knob: {spec: knob.yaml, set: {name: {from: other}}}, other: {folder: there}}"
    (tmp_path / "pages.yaml").write_text(f"kind: pipeline\nname: p\nstages: {stages}\n")
    with pytest.raises(SpecError, match="is a pipeline; hknob run runs it"):
        load(tmp_path / "pages.yaml", kind="sweep")


def test_remedies_without_a_scene() -> None:
    scene = "  scene:\n    knob: {inertia: 1.9e-6}\n    wall: {stiffness: 0.27}\n"
    assert wrong(TRIAL.replace(scene, "  scene: null\n")) == [
        "base.scene: must be a mapping of keys to values, got null"
    ]


def test_another_kind_than_is_wanted() -> None:
    with pytest.raises(SpecError, match=r"kind: must be dfa, got 'sweep'$"):
        load_text(SPEC, "spec.yaml", kind="dfa")
    assert load_text(SPEC, "spec.yaml", kind="sweep").name == "small"


def test_a_preset_has_a_name() -> None:
    said = "scene.from: must be the name of a preset, or the path of its file, got ''"
    assert wrong(SPEC.replace("  knob:", '  from: ""\n  knob:')) == [said]


def test_hands_of_a_trial_are_not_in_its_scene() -> None:
    text = TRIAL.replace("    wall:", "    hand: {inertia: 1.0e-6}\n    wall:", 1)
    with pytest.raises(SpecError) as raised:
        load_text(text, "spec.yaml")
    assert [(fault.key, fault.line, fault.column) for fault in raised.value.faults] == [("base.scene.hand", 6, 5)]


def test_the_largest_grid_of_all_remedies_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    text = TRIAL.replace("{scene: {controller: {kind: bounded_lag}}}", "{grid: {sample_rate_hz: 2000}}")
    text = text.replace("[1000], counts_per_rev: [1024]", "[1000, 2000], counts_per_rev: [1024]")
    assert wrong(text) == []
    monkeypatch.setattr(remedies, "MAX_CELLS", 1)
    with pytest.raises(SpecError) as raised:
        load_text(text, "spec.yaml")
    assert [str(fault) for fault in raised.value.faults] == [
        "spec.yaml:9:1: hands: must span at most 1 cells with the grid, got 2"
    ]


def test_what_is_present_is_overridden_as_a_whole() -> None:
    assert wrong(DESIGN, "present={}") == []
    assert wrong(DESIGN, "present.sample_rate_hz=3")[0].startswith("present.sample_rate_hz: must be one of its choices")
