"""What each rule of the specs allows last, and what it refuses first."""

from math import pi
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from pydantic import TypeAdapter, ValidationError

from hknob_cli.errors import SpecError, UsageError
from hknob_cli.specs import named_file as limits_of_size
from hknob_cli.specs.capabilities import PARTS as PARTS_OF_TABLE
from hknob_cli.specs.capabilities import parts_of
from hknob_cli.specs.drive import _is_there
from hknob_cli.specs.load import load_text
from hknob_cli.specs.motor import Cogging
from hknob_cli.specs.named_file import VARIABLE, is_endless, size_limit
from hknob_cli.specs.over_angle import Detents, ways_round
from hknob_cli.specs.parquet import opened
from hknob_cli.specs.part import model_of
from hknob_cli.specs.parts import Bias, Squeeze
from hknob_cli.specs.perception import Background, Hearing, Perceive
from hknob_cli.specs.plan import (
    Actuator,
    Controller,
    Encoder,
    Finger,
    Fingerpad,
    Hand,
    Knob,
    Scene,
    SweepPlan,
    Wall,
)
from hknob_cli.specs.quantity import declared
from hknob_cli.specs.remarks import USUAL, _hindrance, _text, unusual
from hknob_cli.specs.source import dotted, parse
from tests.conftest import SPEC

HAND = "  hand: {inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}\n"


def wrong(text: str, *overrides: str) -> list[str]:
    """Faults of a spec, as "key: message"; none where it is good."""
    try:
        load_text(text, "spec.yaml", overrides)
    except SpecError as error:
        return [f"{fault.key}: {fault.message}" for fault in error.faults]
    return []


def test_what_is_missing_at_the_end_of_a_list_has_its_place() -> None:
    detents = "{stiffness: 0.27}\n  profile: {points: [[0.1], [1, 2]]}"
    assert wrong(SPEC.replace("{stiffness: 0.27}", detents))[0].startswith("scene.profile.points[0][1]: missing")
    assert wrong(SPEC.replace("[1000]", "{log: [1, 10]}"))[0].startswith("grid.sample_rate_hz.log[2]: missing")


@pytest.mark.parametrize(
    ("span", "found"),
    [(0.5, None), (1e-300, None), (2.0, None), (pi, (2, 1)), (4.0 * pi, (1, 2)), (2.0 * pi, (1, 1))],
)
def test_patterns_and_revolutions(span: float, found: tuple[int, int] | None) -> None:
    assert ways_round(span) == found


def test_half_a_quantum_needs_a_wall_in_one_cell() -> None:
    text = SPEC.replace("{torque: 0.001}", "{half_quantum: true}\n  detents: {per_revolution: 12, torque: 0.006}")
    assert wrong(text.replace("counts_per_rev", "wall.stiffness: [0, 0.1]\n  counts_per_rev")) == []
    assert wrong(text.replace("stiffness: 0.27", "stiffness: 0"))[0].startswith("scene.bias.half_quantum: ")


def test_a_page_of_a_table_that_has_changed_is_noticed(tmp_path: Path) -> None:
    """Of tables that other programs wrote with checksums of pages, too."""
    path = tmp_path / "a.parquet"
    pq.write_table(pa.table({"a": pa.array(range(1000), pa.float64())}), path, write_page_checksum=True,
                   use_dictionary=False, compression="none")  # fmt: skip
    data = bytearray(path.read_bytes())
    data[2000] ^= 1
    path.write_bytes(data)
    with opened(path) as parquet, pytest.raises(OSError, match=r"CRC|checksum"):
        parquet.read()


def test_a_bias_is_either() -> None:
    assert Bias(0.001).wrong() == Bias(half_quantum=True).wrong() == ""
    assert Bias().wrong() == Bias(0.001, half_quantum=True).wrong() != ""


SCENE = Scene(Knob(1.9e-6), Wall(0.27), encoder=Encoder())


IMPULSE = Controller("impulse_damping")


PARTS: dict[str, tuple[Scene, set[str], set[str]]] = {
    "nothing": (
        SCENE,
        {"handless", "unpushed", "undamped", "unheld"},
        set(PARTS_OF_TABLE) - {"handless", "unpushed", "undamped", "unheld"},
    ),
    "an encoder with all there is to it": (
        SCENE._replace(encoder=Encoder("nearest", 1.0, 1.0, 1.0)),
        {"rounding", "offset", "hysteresis", "backlash"}, set(),
    ),
    "an amplifier with all there is to it": (
        SCENE._replace(actuator=Actuator(1.0, 1.0, 1.0, 1.0, 1.0)),
        {"delay", "lag", "torque_limit", "torque_step", "dead_band"}, set(),
    ),
    "friction": (SCENE._replace(knob=Knob(1.9e-6, coulomb_torque=1e-4)), {"friction"}, {"undamped"}),
    "a delay": (SCENE._replace(actuator=Actuator(delay_samples=1.0)), {"delay"}, {"lag"}),
    "a finger held through its pad": (
        SCENE._replace(hand=Hand(finger=Finger(1e-6, stiffness=0.1), fingerpad=Fingerpad(stiffness=0.2))),
        {"finger"}, {"unheld", "handless"},
    ),
    "a knob as damped as its finger": (
        SCENE._replace(
            knob=Knob(1.9e-6, damping=1e-3), hand=Hand(finger=Finger(1e-6, damping=1e-3), fingerpad=Fingerpad())
        ),
        {"finger", "knob_damping"}, {"undamped"},
    ),
    "a finger that nothing holds": (
        SCENE._replace(hand=Hand(finger=Finger(1e-6), fingerpad=Fingerpad(stiffness=1.0))), {"unheld"}, set(),
    ),
    "a finger held by a pad of 1 N*m/rad": (
        SCENE._replace(hand=Hand(finger=Finger(1e-6, stiffness=0.1), fingerpad=Fingerpad(stiffness=1.0))),
        {"finger"}, {"unheld"},
    ),
    "two torques in an interval": (
        SCENE._replace(controller=Controller("first_order_hold", steps=2)), {"pulses"}, set(),
    ),
    "two readings in an interval": (
        SCENE._replace(controller=Controller("bounded_lag", detections=2)), {"several_readings"}, set(),
    ),
    "a push without a wall": (SCENE._replace(wall=Wall(0.0), bias=Bias(0.001)), {"bias", "unpushed"}, set()),
    "a push of nothing": (SCENE._replace(bias=Bias(0.0)), {"bias", "unpushed"}, set()),
    "a push into detents": (
        SCENE._replace(wall=Wall(0.0), bias=Bias(0.001), detents=Detents(0.001, 12)), {"detents"}, {"unpushed"},
    ),
    "a push of half a count": (SCENE._replace(bias=Bias(half_quantum=True)), {"bias"}, {"unpushed"}),
    "a push into a wall": (SCENE._replace(bias=Bias(0.001)), {"bias"}, {"unpushed"}),
    "cogging of no torque": (SCENE._replace(cogging=Cogging(7, 0.0)), set(), {"cogging"}),
    "a whole pulse": (SCENE._replace(controller=IMPULSE._replace(pulse=1.0)), {"controller"}, {"pulses", "knob_model"}),
    "a short pulse": (SCENE._replace(controller=IMPULSE._replace(pulse=0.9)), {"pulses"}, {"knob_model"}),
    "a short pulse of another kind": (
        SCENE._replace(controller=Controller("bounded_lag", pulse=0.9)), {"controller"}, {"pulses"},
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", PARTS)
def test_parts_of_a_scene(name: str) -> None:
    scene, there, absent = PARTS[name]
    found = parts_of(scene)
    assert there <= found
    assert not absent & found


@pytest.mark.parametrize("text", ["1.5", "-1", "0", "+2", "10000", "1e3", "\u0663", "x", "00001", "1" * 5000])
def test_a_limit_of_size_that_is_no_whole_number(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, text)
    with pytest.raises(UsageError, match="must be a whole number from 1 to "):
        size_limit()


@pytest.mark.parametrize(
    "text",
    [
        "".join("  " * i + "a:\n" for i in range(150)),
        "a: " + "[" * 150,
        "".join("  " * i + "a:\n" for i in range(30)) + "  " * 30 + "a: " + "[" * 30,
    ],
    ids=["blocks", "flows", "flows in blocks"],
)
def test_a_spec_nested_too_deeply(text: str) -> None:
    with pytest.raises(SpecError, match="more than 50 levels"):
        parse(text, "spec.yaml")


def test_squeeze_without_a_hand() -> None:
    text = SPEC.replace(
        "  hand: {inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}\n", "  squeeze: {friction: 0.5, radius: 0.01}\n"
    )
    assert "scene.squeeze: must be absent where the hand has no table: it is of one grip" in wrong(text)


def test_values_of_a_spec_are_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    """The mapping, and four times a list of six, which is written once."""
    text = "a: &list [1, 2, 3, 4, 5, 6]\nb: *list\nc: *list\nd: *list\n"
    monkeypatch.setattr(limits_of_size, "_VALUES", 29)
    assert sum(map(len, parse(text, "spec.yaml").value.values())) == 24
    monkeypatch.setattr(limits_of_size, "_VALUES", 28)
    with pytest.raises(SpecError, match="more than 28 keys and values"):
        parse(text, "spec.yaml")


def test_a_noise_masks_what_has_a_level() -> None:
    noise = Hearing(background=Background(60.0))
    assert Perceive(0.02, hearing=noise, sound_gain=1.0).wrong() == ""
    assert Perceive(0.02, hearing=noise).wrong().startswith("hearing.background: must be absent without sound_gain")


def test_a_frequency_out_of_order_is_named_by_its_number() -> None:
    said = Perceive(0.02, sound_response=((10.0, 1.0), (100.0, 1.0), (50.0, 1.0))).wrong()
    assert said == "sound_response: frequencies must increase, got 50 after 100 (point 3)"


def test_what_is_usual_is_not_warned_of() -> None:
    assert unusual(load_text(SPEC, "spec.yaml")) == []
    for limit in ("1.0e-4", "10"):
        text = SPEC.replace("  bias:", f"  actuator: {{torque_limit: {limit}}}\n  bias:")
        assert unusual(load_text(text, "spec.yaml")) == []
    light = load_text(SPEC.replace(HAND, "  hand: {table: 1, grip_n: 14.2}\n"), "spec.yaml")
    assert isinstance(light, SweepPlan)
    assert light.scene.hand is not None
    assert light.scene.hand.inertia < 0.0
    assert unusual(light) == []
    heavy, heavier = (_text("knob.inertia", value, USUAL["knob.inertia"]) for value in (19.0, 1e12))
    assert heavy.endswith("; if 19 g*cm^2 is meant, write the unit")
    assert "meant" not in heavier
    most = USUAL["knob.inertia"].largest / 1e-7  # in g*cm^2
    assert "meant" in _text("knob.inertia", 0.9 * most, USUAL["knob.inertia"])
    assert "meant" not in _text("knob.inertia", 1.1 * most, USUAL["knob.inertia"])
    slow = load_text(SPEC.replace("[1000]", "[1, 1000]"), "spec.yaml")
    assert [one.partition(" Hz")[0] for one in unusual(slow)] == ["warning: sample_rate_hz: 1"]
    said = _text("hand.inertia", -1.5, USUAL["hand.inertia"])  # of a file, without its apparatus
    assert said.startswith("warning: hand.inertia: -1.5 kg*m^2 is unusually large; ")


@pytest.mark.parametrize("value", [np.array([0.0, 1.0]), np.array([1.0, 2.0]), 1.0])
def test_a_lag_of_any_cell_is_there(value: Any) -> None:
    assert _is_there(value) is True
    assert _is_there(0.0 * value) is False


def test_the_usual_limit_of_size() -> None:
    assert size_limit() == (1_000_000, 100_000, 1000, 1)


def test_the_largest_limit_of_size(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, "1000")
    assert size_limit() == (1_000_000_000, 100_000_000, 1_000_000, 1000)


def test_the_longest_key_that_is_said_whole() -> None:
    assert dotted(("a" * 60, "b" * 61)) == f"{'a' * 60}.{'b' * 57}..."


@pytest.mark.parametrize(
    ("part", "what", "kinds"),
    [("play", "backlash of a gear", ("one", "ranges")), ("cogging", "cogging torque", ("ranges",))],
)
def test_a_controller_is_named_beside_what_hinders_it(part: str, what: str, kinds: tuple[str, ...]) -> None:
    for kind in kinds:
        assert _hindrance(frozenset({"controller", part}), kind) == f"a controller beside {what}"


def test_hysteresis_and_slack_add() -> None:
    assert Encoder(hysteresis_counts=0.5, backlash=0.003).width_counts(0.001) == 0.5 + 0.003 / 0.001


def test_a_folder_ends(tmp_path: Path) -> None:
    assert not is_endless(tmp_path)
    assert is_endless(Path("/dev/null"))


def test_a_key_says_what_it_is_in_the_schema() -> None:
    text = model_of(Squeeze).model_json_schema()["properties"]["friction"]["description"]
    assert "coefficient of friction" in text


def test_a_controller_of_which_a_part_hinders_is_not_named_twice() -> None:
    said = _hindrance(frozenset({"controller", "speed_sensor", "cogging"}), "ranges")
    assert said == "a controller that reads a velocity sensor and cogging torque"


def test_each_of_two_parts_that_hinder_one_engine_is_named() -> None:
    said = _hindrance(frozenset({"controller", "friction", "finger"}), "ranges")
    assert said == "a controller beside Coulomb friction and a finger apart from the knob"


def test_patterns_go_round_to_nine_digits() -> None:
    assert ways_round(2.0 * pi / 7.0 * (1.0 + 0.9e-9)) == (7, 1)
    assert ways_round(2.0 * pi / 7.0 * (1.0 + 1.1e-9)) is None


def test_a_part_that_is_wrong_by_itself() -> None:
    assert wrong(SPEC.replace("{torque: 0.001}", "{}")) == [f"scene.bias: {Bias().wrong()}"]


def test_a_part_that_is_declared_says_what_is_wrong() -> None:
    """Of one that is declared here: those of the specs have been made when the program began."""

    @declared()
    class Stop(NamedTuple):
        low: Annotated[float, "where it begins"] = 0.0

        def wrong(self) -> str:
            return "must be above 0" if self.low <= 0.0 else ""

    adapter: TypeAdapter[Stop] = TypeAdapter(Stop)
    assert adapter.validate_python({"low": 1.0}) == Stop(1.0)
    with pytest.raises(ValidationError, match="must be above 0"):
        adapter.validate_python({})
