"""A hand from a file of identified conditions: which row it means, what it excludes, and what it costs others."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from jsonschema import Draft202012Validator

from hknob_cli.errors import SpecError
from hknob_cli.specs.cells import cells_of
from hknob_cli.specs.generated import json_schema
from hknob_cli.specs.load import load
from hknob_cli.specs.plan import Hand, scene_at
from hknob_cli.specs.source import parse
from tests.conftest import EXPERIMENTS, SPEC
from tests.identified import PEOPLE, condition, conditions, write_conditions

HAND = "hand: {inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}"


def spec(keys: str = "") -> str:
    return SPEC.replace(HAND, f"hand: {{from: results/conditions.parquet{keys}}}")


@pytest.fixture
def hand(tmp_path: Path, spec_file: Callable[..., Path]) -> Callable[..., Hand]:
    """The hand of a scene from a file of these rows."""

    def taken(keys: str = "", rows: list | None = None) -> Hand:
        write_conditions(tmp_path / "results" / "conditions.parquet", rows)
        found = load(spec_file(spec(keys))).scene.hand
        assert found
        return found

    return taken


def three(hand: Hand) -> tuple[float, ...]:
    return hand.inertia, hand.damping, hand.stiffness


def test_the_mean_over_persons_is_taken_unless_a_subject_is_named(hand) -> None:
    means = tuple(sum(column) / 4 for column in zip(*PEOPLE.values(), strict=True))
    assert three(hand()) == pytest.approx(means)
    assert three(hand(", subject: s3")) == PEOPLE["s3"]
    assert three(hand(", grip_n: 710 mN, experiment: 1, estimator: output_error, subject: s3")) == PEOPLE["s3"]


def test_a_folder_means_its_conditions(hand, tmp_path, spec_file) -> None:
    by_file = hand(", subject: s1")
    by_folder = load(spec_file(spec(", subject: s1").replace("/conditions.parquet", ""))).scene.hand
    assert by_file == by_folder
    assert by_file.origin.file.resolve() == (tmp_path / "results" / "conditions.parquet").resolve()
    assert len(by_file.origin.sha256) == 64
    assert not by_file.origin.notes


def test_output_error_is_the_default_estimator(hand) -> None:
    others = [condition((5e-7, 1e-3, 0.1), estimator=name) for name in ("least_squares", "fourth_order")]
    assert hand("", [*conditions(), *others]).inertia != 5e-7
    assert hand(", estimator: least_squares", [*conditions(), *others]).inertia == 5e-7
    with pytest.raises(
        SpecError, match=r"hand.estimator: missing, and required: one of 'fourth_order', 'least_squares'"
    ):
        hand("", others)


def test_a_single_person_needs_no_name(hand) -> None:
    assert three(hand("", conditions()[:1])) == PEOPLE["s1"]


@pytest.mark.parametrize(
    ("keys", "fault"),
    [
        (", subject: s9", "5:53: scene.hand.subject: must be one of 's1', 's2', 's3', 's4', got 's9'"),
        (", grip_n: 0.7", "5:52: scene.hand.grip_n: must be one of 0.71, 2.4, got 0.7"),
        ("", "5:3: scene.hand.grip_n: missing, and required: one of 0.71, 2.4"),
        (", grip_n: 2.4, estimator: best", "5:68: scene.hand.estimator: must be 'output_error', got 'best'"),
        (
            ", grip_n: 2.4, stiffness: 1.0",
            "5:68: scene.hand.stiffness: must be absent where the hand is from a file, which gives it",
        ),
        (
            ", grip_n: 0.72, table: 1",
            "5:52: scene.hand.grip_n: must be a grip force of Tables 1-5, 0.71, 1.3, 2.4",
        ),
        (
            ", grip_n: 2.4, table: 1",
            "5:64: scene.hand.table: must be absent where the hand is from a file, which gives it",
        ),
        (
            ", grip_n: 2.4, subtract_apparatus: 19.8 g*cm^2",
            "5:77: scene.hand.subtract_apparatus: must be absent: the file's inertia is without the apparatus' "
            "1.98e-06 kg*m^2",
        ),
        (", people: 3", "5:44: scene.hand.people: unknown key"),
    ],
)
def test_faults_have_their_place_and_say_what_there_is(hand, tmp_path, keys: str, fault: str) -> None:
    with pytest.raises(SpecError) as found:
        hand(keys, [*conditions(), *conditions(grip_target_n=2.4)])
    said = [str(one).removeprefix(f"{tmp_path}/spec.yaml:") for one in found.value.faults]
    assert any(one.startswith(fault) for one in said), said


def test_a_grip_of_a_file_need_not_be_printed(hand) -> None:
    assert hand(", grip_n: 0.9", conditions(grip_target_n=0.9)).stiffness


def test_keys_of_a_file_need_a_file(spec_file) -> None:
    with pytest.raises(
        SpecError, match=r"5:51: scene.hand.subject: must be absent where the hand is not 'from' a file"
    ):
        load(spec_file(SPEC.replace(HAND, "hand: {inertia: 1e-7, stiffness: 0.04, subject: s1}")))


def test_the_apparatus_is_subtracted_once(hand) -> None:
    whole = [condition((2.11e-6, 3.45e-4, 0.04), apparatus_inertia_kg_m2=None)]
    with pytest.raises(SpecError, match=r"hand.subtract_apparatus: missing, and required: the file's inertia includes"):
        hand("", whole)
    assert hand(", subtract_apparatus: 19.8 g*cm^2", whole).inertia == pytest.approx(1.3e-7)


@pytest.mark.parametrize(
    ("row", "fault"),
    [
        (condition((None, 1e-4, 0.1)), "has no inertia_kg_m2"),
        (condition((1e-7, float("nan"), 0.1)), "has no damping_nm_s_per_rad"),
        (condition((1e-7, 1e-4, -0.1)), "has a stiffness_nm_per_rad of -0.1, which is below 0"),
        (condition((1e-7, 1e-4, 1e15)), r"has a stiffness_nm_per_rad of 1e\+15, which is above 1e\+12"),
        (condition((1e-7, 1e-4, 0.1), grip_target_n=None), "conditions.parquet: grip_target_n: nothing in a row"),
        (condition((-2e-6, 1e-4, 0.1)), "must leave an inertia above 0"),
    ],
)
def test_rows_that_are_no_hand_are_faults(hand, row, fault: str) -> None:
    with pytest.raises(SpecError, match=fault):
        hand("", [row])


def test_two_rows_for_one_condition_are_a_fault(hand) -> None:
    with pytest.raises(SpecError, match=r"hand.from: has 2 rows for the mean over persons, experiment 1, 0.71 N"):
        hand("", [condition((1e-7, 1e-4, 0.1))] * 2)


def test_files_that_are_no_conditions_are_faults(tmp_path, spec_file) -> None:
    path = spec_file(spec())
    with pytest.raises(SpecError, match=r"5:16: scene.hand.from: .*conditions.parquet: No such file"):
        load(path)
    (tmp_path / "results").mkdir()
    (tmp_path / "results" / "conditions.parquet").write_text("no")
    with pytest.raises(SpecError, match=r"is not a Parquet file"):
        load(path)
    import pyarrow as pa
    import pyarrow.parquet as pq

    pq.write_table(pa.table({"level": ["all"]}), tmp_path / "results" / "conditions.parquet")
    with pytest.raises(SpecError, match=r"has no column experiment, .*sysid writes such a file"):
        load(path)


@pytest.mark.parametrize("column", ["grip_target_n", "stiffness_nm_per_rad", "experiment", "flags"])
def test_columns_of_another_type_are_faults(tmp_path, spec_file, column: str) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    path = write_conditions(tmp_path / "results" / "conditions.parquet")
    table = pq.read_table(path)
    pq.write_table(table.set_column(table.column_names.index(column), column, [[[1.0]] * table.num_rows]), path)
    with pytest.raises(SpecError, match=rf"5:16: scene.hand.from: .*: {column}: must be (numbers|text), is list"):
        load(spec_file(spec()))
    pq.write_table(table.append_column(column, table.column(column)), path)
    with pytest.raises(SpecError, match=f"has several columns {column}"):
        load(spec_file(spec()))
    pq.write_table(table.set_column(0, "level", pa.array(["all"] * table.num_rows).dictionary_encode()), path)
    with pytest.raises(SpecError, match=r"scene.hand.subject: missing"):
        load(spec_file(spec()))


def test_a_flagged_row_is_used_and_said(hand) -> None:
    notes = hand("", [condition((1e-7, 1e-4, 0.1), flags="stiffness not identifiable")]).origin.notes
    assert len(notes) == 1
    assert "used although flagged: the mean over persons, experiment 1, 0.71 N, output_error: stiffness not" in notes[0]


def test_axes_replace_its_numbers_and_grip_is_one(tmp_path, spec_file) -> None:
    rows = [*conditions(), *conditions(grip_target_n=2.4, flags="drift")]
    write_conditions(tmp_path / "results" / "conditions.parquet", rows)
    text = spec(", subject: s2").replace("grid:\n", "grid:\n  hand.damping: [1.0e-3]\n  hand.grip_n: [2.4, 0.71]\n")
    plan = load(spec_file(text))
    found = [scene_at(plan.scene, cell).hand for cell in cells_of(plan)]
    assert [(one.damping, one.stiffness) for one in found] == [(1e-3, 0.045)] * 2
    assert len(plan.scene.hand.origin.notes) == 1
    with pytest.raises(SpecError, match=r"hand.grip_n\"\]\[0\]: must be a grip force of the file, 0.71, 2.4, got 2.5"):
        load(spec_file(text.replace("[2.4,", "[2.5,")))


def test_other_kinds_take_it_too(tmp_path) -> None:
    write_conditions(tmp_path / "conditions.parquet")
    for kind in ("dfa", "predict"):
        path = tmp_path / f"{kind}.yaml"
        text = SPEC.replace("kind: sweep", f"kind: {kind}").replace("starts: {angle: 0.02, phases: 8}\n", "")
        path.write_text(text.replace(HAND, "hand: {from: conditions.parquet, subject: s4}"))
        assert three(load(path).scene.hand) == PEOPLE["s4"]
    (tmp_path / "bench.yaml").write_text((EXPERIMENTS / "bench_quick.yaml").read_text())
    sets = ("scenes={plain: {}, other: {scene: {hand: {subject: s1}}}}", "base.scene.hand={from: ., subject: s4}")
    plan = load(tmp_path / "bench.yaml", sets)
    assert [three(scene.scene.hand) for scene in plan.scenes] == [PEOPLE["s4"], PEOPLE["s1"]]


def test_an_editor_sees_faults() -> None:
    schema = Draft202012Validator(json_schema("sweep"))
    values = parse(spec(", subject: s1"), "").value
    assert schema.is_valid(values)
    for keys in ({"table": 1}, {"inertia": 1e-7}, {"level": "all"}):
        assert not schema.is_valid(
            {**values, "scene": {**values["scene"], "hand": {"from": "a", "grip_n": 1.3, **keys}}}
        )
    assert not schema.is_valid({**values, "scene": {**values["scene"], "hand": {"subject": "s1"}}})


def test_a_spec_without_a_file_loads_no_parquet(spec_file) -> None:
    code = (
        "import sys; from pathlib import Path; from hknob_cli.specs.load import load; "
        f"load(Path({str(spec_file())!r})); "
        "heavy = ('pyarrow', 'hknob_cli.specs.hand_from', 'hknob_cli.specs.hand_from'); "
        "print([name for name in heavy if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


def test_what_another_stage_is_yet_to_make_is_not_read(spec_file) -> None:
    text = spec().replace("results/conditions.parquet", "/nowhere/hands")
    assert load(spec_file(text), waiting=frozenset(["/nowhere/hands"])).scene.hand == Hand()
    with pytest.raises(SpecError, match="No such file"):
        load(spec_file(text))


def test_a_path_from_the_working_folder_is_noticed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Paths begin at the spec's folder; a reader may expect them to begin where the command runs."""
    write_conditions(tmp_path / "results" / "conditions.parquet")
    (tmp_path / "mine").mkdir()
    path = tmp_path / "mine" / "wall.yaml"
    path.write_text(spec())
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SpecError) as caught:
        load(path.relative_to(tmp_path))
    said = "a path in a spec begins at the folder of the spec, and results/conditions.parquet is in the working folder"
    assert said in str(caught.value)


def test_a_hand_that_takes_more_than_the_knob_has(hand) -> None:
    """The grip is named where there is one."""
    rows = conditions(dict.fromkeys(("s1", "s2"), (-3e-6, 3e-4, 0.03)))
    said = "the file has 3e-06 kg.m.2 less than its apparatus without a hand, and the knob has 1.9e-06$"
    with pytest.raises(SpecError, match=rf"scene\.hand\.from: must leave an inertia above 0: {said}"):
        hand("", rows)
    with pytest.raises(SpecError, match=rf"scene\.hand\.grip_n: must leave an inertia above 0: at 0.71 N, {said}"):
        hand(", grip_n: 0.71", rows)
