"""A scene from a preset: the merge, what a grid takes from it, faults with their places, and the presets that ship."""

import json
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path

import pytest
from jsonschema import Draft202012Validator

from hknob_cli.errors import SpecError
from hknob_cli.specs import preset
from hknob_cli.specs.generated import json_schema, presets_page
from hknob_cli.specs.load import load
from hknob_cli.specs.plan import COUNTS, RATE, Hand
from hknob_cli.specs.source import parse, read
from hknob_cli.stages.job import Job, work_of
from hknob_cli.stages.make import stamp_of
from hknob_cli.stages.work import preset_files, preset_inputs
from tests.conftest import EXPERIMENTS, ROOT, faults_of, loaded

HEAD = "kind: sweep\nname: knob\n"
SMARTKNOB = read(ROOT / "data" / "knobs" / "smartknob.yaml").value
INERTIA = SMARTKNOB["scene"]["knob"]["inertia"]["value"]

OWN = """\
title: a knob of one's own
grid: {sample_rate_hz: 2000, counts_per_rev: {value: 4096, source: its data sheet}}
scene:
  knob: {inertia: {value: 2 g*cm^2, assumed: a guess}, damping: 1.0e-5}
  wall: {stiffness: {value: 0.2, source: "main.c: K"}}
  encoder: {rounding: {value: nearest, source: "main.c: round()"}}
left_out: [cogging]
"""


@pytest.fixture
def own(tmp_path: Path, spec_file: Callable[..., Path]) -> Callable[..., Path]:
    """A spec whose scene is from a file beside it."""

    def write(scene: str = "scene: {from: own.yaml}\n", preset: str = OWN) -> Path:
        (tmp_path / "own.yaml").write_text(preset)
        return spec_file(HEAD + scene)

    return write


def test_three_lines_are_a_cell_of_the_knob() -> None:
    plan = loaded(HEAD + "scene: {from: smartknob, hand: {table: 1, grip_n: 0.71}, bias: {torque: 0.001}}\n")
    assert plan.axes == {RATE: [1000.0], COUNTS: [16384]}
    assert plan.scene.knob.inertia == INERTIA
    assert plan.scene.hand.stiffness == 0.04
    assert plan.scene.bias.torque == 0.001
    assert plan.scene.actuator.delay_samples == 2


def test_a_spec_says_no_less_than_the_preset_beside_it() -> None:
    """The same values, written out, are the same plan except for the preset."""
    short = loaded(HEAD + "scene: {from: smartknob, wall: {damping: 1.0e-4}}\n")
    scene = {
        "knob": {"inertia": INERTIA, "damping": 1.5e-4},
        "wall": {"stiffness": 0.017, "damping": 1.0e-4},
        "actuator": {"delay_samples": 2},
    }
    grid = {RATE: 1000, COUNTS: 16384}
    long = loaded(HEAD + f"scene: {json.dumps(scene)}\ngrid: {json.dumps(grid)}\n")
    assert short.values == long.values
    assert short._replace(preset=None) == long


def test_null_removes_a_part_and_a_value_replaces_one() -> None:
    plan = loaded(HEAD + "scene: {from: smartknob, actuator: null, knob: {damping: 0.001, coulomb_torque: 1 mN*m}}\n")
    assert plan.scene.actuator is None
    assert plan.scene.knob == (INERTIA, 0.001, 0.001)
    plain = loaded(HEAD + "scene: {from: smartknob, encoder: none}\ngrid: {sample_rate_hz: [100, 200]}\n")
    assert plain.scene.encoder is None
    assert plain.axes == {RATE: [100.0, 200.0]}


def test_the_grid_takes_what_it_lacks() -> None:
    other = loaded(HEAD + "scene: {from: idrive}\ngrid: {counts_per_rev: [128, 256], wall.stiffness: [0.1, 0.2]}\n")
    assert other.axes == {RATE: [1000.0], COUNTS: [128, 256], "wall.stiffness": [0.1, 0.2]}
    continuous = loaded(HEAD + "scene: {from: idrive, sampling: continuous}\n")
    assert list(continuous.axes) == [COUNTS]


def test_options_are_merged_as_the_file_is(spec_file) -> None:
    path = spec_file(HEAD + "scene: {from: smartknob}\n")
    plan = load(path, ("scene.from=idrive", "scene.wall.stiffness=0.3", "grid.counts_per_rev=360"))
    assert plan.scene.wall.stiffness == 0.3
    assert plan.axes[COUNTS] == [360]
    assert plan.preset.name == "idrive"
    with pytest.raises(SpecError, match=r"--set scene.from=idriv: scene.from: unknown preset 'idriv'; did you mean"):
        load(path, ("scene.from=idriv",))


def test_a_file_of_ones_own(own) -> None:
    plan = load(own())
    assert plan.scene.knob == pytest.approx((2e-7, 1e-5, 0.0))
    assert plan.scene.encoder.rounding == "nearest"
    assert plan.axes == {RATE: [2000.0], COUNTS: [4096]}
    assert plan.preset.lines == [
        "preset own.yaml: a knob of one's own",
        "  scene.knob.inertia = 2 g*cm^2: assumed: a guess",
        "  scene.knob.damping = 1e-05: no source",
        "  scene.wall.stiffness = 0.2: main.c: K",
        "  scene.encoder.rounding = nearest: main.c: round()",
        "  grid.sample_rate_hz = 2000: no source",
        "  grid.counts_per_rev = 4096: its data sheet",
        "  left out: cogging",
    ]


def test_what_a_spec_overrides_is_not_said_to_be_the_presets(own) -> None:
    scene = (
        "scene: {from: own.yaml, knob: {inertia: 1.0e-6, damping: null}, encoder: none}\ngrid: {sample_rate_hz: 1}\n"
    )
    assert [one.path for one in load(own(scene)).preset.values] == ["scene.wall.stiffness"]


def test_results_know_the_preset(own) -> None:
    path = own()
    plan = load(path)
    digest = sha256((path.parent / "own.yaml").read_bytes()).hexdigest()
    assert preset_inputs(plan) == {"preset": "own.yaml", "preset_sha256": digest}
    assert preset_files(plan) == (path.parent / "own.yaml",)
    job = Job(kind="sweep", plan=plan, out=path.parent / "out")
    work = work_of("sweep")
    assert path.parent / "own.yaml" in work.input_files(job)
    record = json.loads(stamp_of(job, work))
    assert record["inputs"]["preset_sha256"] == digest
    assert record["spec"]["scene"]["wall"] == {"stiffness": 0.2}  # the numbers, whatever becomes of the file
    assert preset_inputs(loaded()) == {}


@pytest.mark.parametrize(
    ("scene", "fault"),
    [
        (
            "{from: smartnob}",
            "3:15: scene.from: unknown preset 'smartnob'; did you mean 'smartknob'? allowed: hapkit, ",
        ),
        ("{from: 3}", "3:15: scene.from: must be the name of a preset, or the path of its file, got 3"),
        ("{from: null}", "3:15: scene.from: must be the name of a preset, or the path of its file, got null"),
        ("{from: ./nowhere.yaml}", "3:15: scene.from: nowhere.yaml: No such file or directory"),
        ("{from: /dev/zero}", "3:15: scene.from: /dev/zero: is not a file"),
        ("{from: smartknob, wal: {}}", "3:26: scene.wal: unknown key; did you mean 'wall'?"),
        ("{from: smartknob, wall: {stiffness: -1}}", "3:44: scene.wall.stiffness: must be >= 0, got -1"),
        ("{from: smartknob, wall: null}", "3:32: scene.wall: missing, and required"),
        ("{from: smartknob, knob: {inertia: null}}", "3:42: scene.knob.inertia: missing, and required"),
        ("{from: smartknob, wall: 3}", "3:32: scene.wall: must be a mapping of keys to values, got 3"),
    ],
)
def test_faults_stand_in_the_users_file(scene: str, fault: str) -> None:
    assert f"spec.yaml:{fault}" in faults_of(f"{HEAD}scene: {scene}\n")


def test_what_does_not_go_with_a_preset_is_told_where_it_is_named() -> None:
    found = faults_of(HEAD + "scene: {from: smartknob, bias: {torque: 0.001}}\nstarts: anywhere\n")
    file = ROOT / "data" / "knobs" / "smartknob.yaml"
    line = next(i for i, text in enumerate(file.read_text().splitlines(), 1) if text.strip() == "value: 2")
    assert "spec.yaml:3:15: scene.actuator.delay_samples: must be absent where starts are anywhere" in found
    assert f"; the preset has it at {file}:{line}:" in found


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        (
            "0.2, source",
            "-0.2, source",
            "spec.yaml:3:15: scene.wall.stiffness: must be >= 0, got -0.2; the preset",
        ),
        ("2000", "-1", "spec.yaml:3:15: grid.sample_rate_hz: must be >= 0.001, got -1; the preset has it at"),
        ("source: its data sheet", "sorce: its", "own.yaml:2:60: grid.counts_per_rev.sorce: unknown key; did you mean"),
        (", source: its data sheet", "", "own.yaml:2:46: grid.counts_per_rev: must have one of 'source' and 'assumed'"),
        ("its data sheet", "3", "own.yaml:2:68: grid.counts_per_rev.source: must be text"),
        ("counts_per_rev:", "counts:", "own.yaml:2:30: grid.counts: unknown key; did you mean 'counts_per_rev'?"),
        ("left_out: [cogging]", "left_out: cogging", "own.yaml:7:11: left_out: must be a list, got 'cogging'"),
        ("title: a knob of one's own\n", "", "own.yaml:1:1: title: missing, and required"),
        (
            "scene:\n",
            "scene:\n  from: idrive\n",
            "own.yaml:4:3: scene.from: must be absent: a preset stands",
        ),
        ("title", "titel", "own.yaml:1:1: titel: unknown key; did you mean 'title'?"),
    ],
)
def test_faults_of_a_preset(own, old: str, new: str, fault: str) -> None:
    assert old in OWN
    with pytest.raises(SpecError) as caught:
        load(own(preset=OWN.replace(old, new, 1)))
    assert fault in str(caught.value).replace(f"{own().parent}/", "")


def test_remedies_and_designs_start_from_one() -> None:
    text = (EXPERIMENTS / "remedies.yaml").read_text()
    begin, end = text.index("  scene:\n"), text.index("  starts:")
    base = "  scene: {from: idrive, bias: {torque: 0.001}}\n"
    plan = loaded(text[:begin] + base + text[end:])
    assert plan.preset.name == "idrive"
    assert plan.remedies[0].grid.axes[COUNTS] == [2650]
    assert plan.remedies[0].grid.scene.wall.stiffness == 0.27
    design = (EXPERIMENTS / "idrive.yaml").read_text()
    begin, end = design.index("  scene:\n"), design.index("  starts:")
    found = loaded(design[:begin] + base + design[end:])
    assert found.preset.name == "idrive"
    assert found.candidates[0].sweep.scene.knob.inertia == 1.9e-6
    text = (EXPERIMENTS / "remedies.yaml").read_text()
    wrong = text.replace("source: the reference", "change: {scene: {from: idrive}}")
    assert "remedies" in faults_of(wrong)
    assert "unknown key" in faults_of(wrong)


def test_an_editor_knows_presets() -> None:
    schema = Draft202012Validator(json_schema("sweep"))
    short = parse(HEAD + "scene: {from: smartknob, wall: {damping: 1}, actuator: null}\n", "").value
    assert schema.is_valid(short)
    for wrong in ({"wal": {}}, {"wall": {"stiffness": -1}}, {"from": 3}, {"knob": {"mass": 1}}):
        assert not schema.is_valid({**short, "scene": {**short["scene"], **wrong}}), wrong
    assert not schema.is_valid({**short, "scene": {"knob": {"inertia": 1}, "wall": {"stiffness": 1}}})  # no grid


def test_every_preset_validates_and_every_number_says_where_it_is_from() -> None:
    assert len(preset.names()) == 7
    for name in preset.names():
        plan = loaded(HEAD + f"scene: {{from: {name}, hand: {{table: 1, grip_n: 0.71}}, bias: {{torque: 0.001}}}}\n")
        assert plan.preset.left_out
        assert plan.preset.about
        assert {"scene.knob.inertia", f"grid.{RATE}", f"grid.{COUNTS}"} <= {one.path for one in plan.preset.values}
        for one in plan.preset.values:
            assert len(one.source or one.assumed) > 20, (name, one)
        assert isinstance(plan.scene.hand, Hand)


def test_the_page_of_presets_is_current() -> None:
    assert (ROOT / "docs" / "reference" / "presets.md").read_text() == presets_page(), "make schemas"


def test_presets_ship() -> None:
    assert '"data/knobs" = "hknob_cli/specs/knobs"' in (ROOT / "pyproject.toml").read_text()
    assert preset.folder() == ROOT / "data" / "knobs"
