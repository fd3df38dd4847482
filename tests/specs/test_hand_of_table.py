"""A hand that is a row of a printed table: what it stands for, what it excludes, and what it costs others."""

import sys

import pytest
from jsonschema import Draft202012Validator

from hknob_cli.errors import SpecError
from hknob_cli.printed import grasps
from hknob_cli.specs.cells import cells_of
from hknob_cli.specs.generated import json_schema
from hknob_cli.specs.load import load, validate
from hknob_cli.specs.plan import Hand, Knob, scene_at
from hknob_cli.specs.source import parse
from tests.conftest import EXPERIMENTS, SPEC, faults_of, loaded

HAND = "hand: {inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}"
TABLE = SPEC.replace(HAND, "hand: {table: 1, grip_n: 0.71}")


def hand_of(text: str) -> Hand:
    hand = loaded(text).scene.hand
    assert hand
    return hand._replace(by_grip=())


def test_a_row_is_plain_numbers_without_the_apparatus() -> None:
    assert hand_of(TABLE) == Hand(inertia=1.3e-7, damping=3.45e-4, stiffness=0.04)
    assert hand_of(TABLE.replace("table: 1", "table: 5")) == Hand(inertia=1e-8, damping=1.48e-3, stiffness=0.17)
    assert hand_of(TABLE.replace("0.71", "1.3 N")) == hand_of(TABLE.replace("0.71", "1.3"))
    assert hand_of(TABLE.replace("0.71", "710 mN")) == hand_of(TABLE)


def test_a_firm_grip_may_take_inertia_away_but_not_all() -> None:
    firm = TABLE.replace("0.71", "14.2")
    assert hand_of(firm).inertia == -3.1e-7
    assert faults_of(firm.replace("1.9e-6", "3.0e-7")).splitlines() == [
        "spec.yaml:5:28: scene.hand.grip_n: must leave an inertia above 0: at 14.2 N, table 1 has 3.1e-07 kg*m^2 less "
        "than its apparatus without a hand, and the knob has 3e-07"
    ]
    lighter = firm.replace("grid:\n", "grid:\n  knob.inertia: [1.9e-6, 3.1e-7]\n")
    assert "the knob has 3.1e-07" in faults_of(lighter).splitlines()[0]
    assert loaded(lighter.replace("3.1e-7", "3.2e-7"))
    heavier = lighter.replace("grid:\n", "grid:\n  hand.inertia: [0.0, 1.0e-7]\n")
    assert loaded(heavier)


@pytest.mark.parametrize(
    ("hand", "fault"),
    [
        ("{table: 6, grip_n: 0.71}", "5:17: scene.hand.table: must be 1, 2, 3, 4 or 5, got 6"),
        ("{table: 0, grip_n: 0.71}", "5:17: scene.hand.table: must be 1, 2, 3, 4 or 5, got 0"),
        ("{table: 1.0, grip_n: 0.71}", "5:17: scene.hand.table: must be a whole number, got 1.0"),
        ("{table: true, grip_n: 0.71}", "5:17: scene.hand.table: must be a whole number, got true"),
        ("{table: one, grip_n: 0.71}", "5:17: scene.hand.table: must be 1, 2, 3, 4 or 5, got 'one'"),
        (
            "{table: 1, grip_n: 0.72}",
            "5:28: scene.hand.grip_n: must be a grip force of Tables 1-5, 0.71, 1.3, 2.4, 4.3, 7.8, 14.2, got 0.72",
        ),
        ("{table: 1, grip_n: 1.3 kg}", "5:28: scene.hand.grip_n: '1.3 kg' is in kilogram, which is not a kind of N"),
        ("{table: 1}", "5:9: scene.hand: must have both 'table' and 'grip_n', or neither"),
        ("{grip_n: 1.3}", "5:9: scene.hand: must have both 'table' and 'grip_n', or neither"),
        (
            "{table: 1, grip_n: 1.3, stiffness: 0.0}",
            "5:44: scene.hand.stiffness: must be absent where the hand has a table, which gives it",
        ),
        (
            "{table: 1, grip_n: 1.3, finger: {inertia: 1.0e-7}, fingerpad: {stiffness: 1.0}}",
            "5:41: scene.hand.finger: must be absent where the hand has a table, which gives it",
        ),
    ],
)
def test_faults_have_their_place(hand: str, fault: str) -> None:
    assert f"spec.yaml:{fault}" in faults_of(SPEC.replace(HAND, f"hand: {hand}")).splitlines()


def test_its_numbers_are_axes() -> None:
    plan = loaded(TABLE.replace("grid:\n", "grid:\n  hand.stiffness: [0.04, 0.08]\n"))
    hands = [scene_at(plan.scene, cell).hand for cell in cells_of(plan)]
    assert [(hand.inertia, hand.damping, hand.stiffness) for hand in hands if hand] == [
        (1.3e-7, 3.45e-4, 0.04),
        (1.3e-7, 3.45e-4, 0.08),
    ]


def test_grip_is_an_axis_and_others_replace_what_it_gives() -> None:
    text = TABLE.replace("grid:\n", "grid:\n  hand.damping: [1.0e-3]\n  hand.grip_n: [14.2, 0.71]\n")
    plan = loaded(text)
    assert plan.units["hand.grip_n"] == "N"
    hands = [scene_at(plan.scene, cell).hand for cell in cells_of(plan)]
    rows = {grasp.grip_n: grasp for grasp in grasps(1)}
    for hand, grip in zip(hands, (14.2, 0.71), strict=True):
        assert hand
        assert (hand.inertia, hand.damping, hand.stiffness) == (rows[grip].inertia, 1e-3, rows[grip].stiffness)
    wrong = faults_of(text.replace("14.2, 0.71", "14.2, 0.7")).splitlines()
    assert 'hand.grip_n"][1]: must be a grip force of Tables 1-5' in wrong[0]
    assert (
        "must be absent where the hand has no table"
        in faults_of(text.replace("{table: 1, grip_n: 0.71}", "{}")).splitlines()[0]
    )
    light = faults_of(text.replace("1.9e-6", "3.0e-7")).splitlines()
    assert len(light) == 1
    assert "at 14.2 N, table 1 has" in light[0]


def test_what_it_gives_counts_as_given() -> None:
    bouncing = TABLE + "growth: {duration: 1.0}\n"
    assert "scene.hand.table: must be absent where 'growth' is given" in faults_of(bouncing)


def test_a_bench_takes_it_too() -> None:
    text = (EXPERIMENTS / "bench_quick.yaml").read_text()
    values = parse(text, "bench.yaml").value
    values["base"]["scene"]["hand"] = {"table": 1, "grip_n": 2.4}
    source = parse(text, "bench.yaml")
    source.value = values
    values["scenes"] = {"plain": {}, "firm": {"scene": {"hand": {"grip_n": 4.3}}}}
    plan = validate(source)
    assert [scene.scene.hand.inertia for scene in plan.scenes] == [1e-7, -4e-8]
    values["scenes"] = {"mixed": {"scene": {"hand": {"stiffness": 1.0}}}}
    with pytest.raises(SpecError, match="must be absent where the hand has a table"):
        validate(source)


def test_an_editor_sees_faults() -> None:
    schema = Draft202012Validator(json_schema("sweep"))
    values = parse(TABLE, "").value
    assert schema.is_valid(values)
    for hand in (
        {"table": 1},
        {"table": 6, "grip_n": 1.3},
        {"table": 1, "grip_n": 1},
        {"table": 1, "grip_n": 1.3, "inertia": 0},
    ):
        values["scene"]["hand"] = hand
        assert not schema.is_valid(values), hand


def test_a_spec_without_a_table_reads_none(spec_file, monkeypatch) -> None:
    for name in [name for name in sys.modules if name.startswith("hknob_cli.printed")]:
        monkeypatch.delitem(sys.modules, name)
    plan = load(spec_file())
    assert plan.scene.knob == Knob(1.9e-6)
    assert not [name for name in sys.modules if name.startswith("hknob_cli.printed")]
