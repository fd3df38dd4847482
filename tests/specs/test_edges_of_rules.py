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
from hknob_cli.specs import cells, remedies
from hknob_cli.specs import size_limit as limits_of_size
from hknob_cli.specs.campaign import HwRunPlan
from hknob_cli.specs.capabilities import PARTS as PARTS_OF_TABLE
from hknob_cli.specs.conditions import BEST_ESTIMATOR, ChoiceError, narrowed
from hknob_cli.specs.declared import declared
from hknob_cli.specs.driven import limited
from hknob_cli.specs.electrical import _is_there
from hknob_cli.specs.find_people import _drawn, find_people
from hknob_cli.specs.grid import Grid, LinAxis, LogAxis, length
from hknob_cli.specs.grid_axes import Limit, too_many
from hknob_cli.specs.grip import same_grip
from hknob_cli.specs.identification import ColumnPlan, SysidPlan
from hknob_cli.specs.load import load, load_pipeline, load_text, validate
from hknob_cli.specs.motor import Cogging
from hknob_cli.specs.named_file import is_endless
from hknob_cli.specs.over_angle import Detents, ways_round
from hknob_cli.specs.parquet import opened
from hknob_cli.specs.part import model_of
from hknob_cli.specs.parts import Bias, Squeeze
from hknob_cli.specs.parts_there import parts_of
from hknob_cli.specs.people import Spread, draw
from hknob_cli.specs.perception import Background, Hearing, Perceive
from hknob_cli.specs.pipeline import RESERVED, validate_pipeline
from hknob_cli.specs.plan import (
    COUNTS,
    PERSON,
    RATE,
    Actuator,
    BenchPlan,
    Controller,
    Encoder,
    Finger,
    Fingerpad,
    Hand,
    Knob,
    Points,
    Scene,
    Starts,
    SweepPlan,
    Wall,
    may_roam,
    may_yield,
)
from hknob_cli.specs.population import PopulationSpec
from hknob_cli.specs.promise import _hindrance, not_proven
from hknob_cli.specs.remedies import RemediesPlan
from hknob_cli.specs.size_limit import VARIABLE, size_limit
from hknob_cli.specs.source import Source, dotted, parse
from hknob_cli.specs.starts import PHASES, StartsSpec, kind_of_starts, plain_starts
from hknob_cli.specs.sweep import RecordSpec
from hknob_cli.specs.sysid import MOST_TRIALS
from hknob_cli.specs.unit_points import UnitPoints
from hknob_cli.specs.usual import USUAL, _text, unusual
from hknob_cli.specs.virtual_apparatus import VirtualSpec
from tests.conftest import ROOT, SPEC
from tests.designs import DESIGN
from tests.hardware.campaigns import REMEDIES, planned
from tests.hardware.campaigns import SPEC as BENCH
from tests.identified import condition, conditions, write_conditions
from tests.specs.test_remedies import TRIAL

HAND = "  hand: {inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}\n"
SYSID = "kind: sysid\nname: s\nwhat: {what}\n{more}\nestimators: [output_error]\n"


def wrong(text: str, *overrides: str) -> list[str]:
    """Faults of a spec, as "key: message"; none where it is good."""
    try:
        load_text(text, "spec.yaml", overrides)
    except SpecError as error:
        return [f"{fault.key}: {fault.message}" for fault in error.faults]
    return []


def test_cells_of_a_design_are_the_same_in_any_pieces(monkeypatch: pytest.MonkeyPatch) -> None:
    design = cells.cells_over({"a": [0.0, 1.0], "b": [1.0, 9.0]}, Points("sobol", 10, 3, {"a": "lin", "b": "lin"}))
    columns = design.columns(0, 10)
    monkeypatch.setattr(cells, "_AT_ONCE", 3)
    assert [list(cell.values()) for cell in design.run(0, 10)] == [
        list(row) for row in zip(*(one.tolist() for one in columns.values()), strict=True)
    ]


def test_a_falling_range_on_a_log_scale_is_powers_of_its_ratio() -> None:
    shares = [i / 97 for i in range(98)]
    assert cells.log_between(7.0, 0.3, shares) == [7.0 * (0.3 / 7.0) ** share for share in shares]


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


def test_what_is_missing_at_the_end_of_a_list_has_its_place() -> None:
    detents = "{stiffness: 0.27}\n  profile: {points: [[0.1], [1, 2]]}"
    assert wrong(SPEC.replace("{stiffness: 0.27}", detents))[0].startswith("scene.profile.points[0][1]: missing")
    assert wrong(SPEC.replace("[1000]", "{log: [1, 10]}"))[0].startswith("grid.sample_rate_hz.log[2]: missing")


def test_a_unit_of_a_column_that_is_no_quantity() -> None:
    text = SYSID.format(what="hand", more="recordings: [a.csv]\ncolumns: {trial: {from: no, unit: mm}}")
    assert wrong(text) == ["columns.trial.unit: must be absent: this column is no quantity"]


def test_nuisances_and_person_are_kept() -> None:
    plan = validate(parse(BENCH + "nuisances: {jitter: 1e-6}\n", "spec.yaml"))
    assert isinstance(plan, HwRunPlan)
    assert plan.nuisances.jitter == 1e-6
    assert not plan.person.wandering_push


SERIAL = BENCH.replace("kind: hw-run\n", "kind: hw-run\ndevice: {driver: serial, url: socket://localhost:1}\n")
# A campaign's spec with one change, and what is wrong with it, if anything.
CAMPAIGNS: dict[str, tuple[str, str]] = {
    "grip as wide as its target": (BENCH + "grip: {target: 0.7, band: 0.7}\n", "grip.band: must be < the target of"),
    "a grip less wide": (BENCH + "grip: {target: 0.7, band: 0.69}\n", ""),
    "no grip": (BENCH + "grip: none\n", ""),
    "the slowest rate": (BENCH.replace("[1000, 2000]", "[1]"), ""),
    "slower": (BENCH.replace("[1000, 2000]", "[0.5]"), "grid.sample_rate_hz[0]: must be 1 to 1000000 Hz, got 0.5"),
    "the fastest rate": (BENCH.replace("[1000, 2000]", "[1000000]"), ""),
    "a trial as long as settling and the least buzz": (BENCH.replace("longest: 2", "longest: 0.15"), ""),
    "a shorter trial": (
        BENCH.replace("longest: 2", "longest: 0.14"), "trial.longest: must be >= 0.15, settle and the least buzz, got",
    ),
    "faster": (BENCH.replace("[1000, 2000]", "[1000001]"), "grid.sample_rate_hz[0]: must be 1 to 1000000 Hz"),
    "a watchdog of two samples": (SERIAL + "limits: {watchdog: 0.002}\n", ""),
    "a watchdog of less": (
        SERIAL + "limits: {watchdog: 0.0019}\n",
        "limits.watchdog: must be two samples at least, 0.002 s at 1000 Hz, got 0.0019",
    ),
    "the port of another driver": (BENCH + "device: {url: /dev/x}\n", "device.url: "),
}  # fmt: skip


@pytest.mark.parametrize("name", CAMPAIGNS)
def test_limits_of_a_campaign(name: str) -> None:
    text, said = CAMPAIGNS[name]
    found = wrong(text)
    assert len(found) == bool(said)
    assert not said or found[0].startswith(said)


def test_the_longest_trial_of_a_campaign() -> None:
    """20 million samples: 0.5 s before the wall, and 199.5 s with it, at 100 kHz."""
    text = BENCH.replace("[1000, 2000]", "[100000]").replace("zero: 0.05", "zero: 0.5")
    assert wrong(text.replace("longest: 2", "longest: 199.5")) == []
    assert [one.split(":")[0] for one in wrong(text.replace("longest: 2", "longest: 199.51"))] == ["trial.longest"]


def test_the_most_trials_of_a_campaign_count_its_remedies() -> None:
    remedies = "remedies: {plain wall: {}, soft: {change: {wall: {stiffness: 0.1}}}}\n"
    five = BENCH.replace("[1000, 2000]", "[1000, 1001, 1002, 1003, 1004]").replace("[256, 512]", "[256]")
    six = five.replace("1004", "1004, 1005")
    eleven = six.replace("1005", "1005, 1006, 1007, 1008, 1009, 1010")
    assert wrong(f"{eleven}repeats: 100\n") == ["grid: must be at most 1000 trials with repeats, got 1100"]
    assert wrong(f"{five}{remedies}repeats: 100\n") == []
    assert wrong(f"{six}{remedies}repeats: 100\n") == [
        "grid: must be at most 1000 trials with repeats and remedies, got 1200"
    ]


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


def test_a_grid_may_fill_the_limit_of_cells() -> None:
    text = SPEC + "limits: {max_cells: 2}\n"
    assert wrong(text.replace("[1024]", "[512, 1024]")) == []
    assert [one.split(":")[0] for one in wrong(text.replace("[1024]", "[512, 1024, 2048]"))] == ["grid"]


def test_a_population_may_fill_the_limit_of_cells() -> None:
    people = "population: {table: 1, grip_n: 0.71, people: PEOPLE, seed: 1}\nlimits: {max_cells: 100}\n"
    text = SPEC.replace(HAND, "") + people
    assert wrong(text.replace("PEOPLE", "100")) == []
    assert [one.split(":")[0] for one in wrong(text.replace("PEOPLE", "101"))] == ["population"]


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


@pytest.mark.parametrize(
    ("given", "key", "other"),
    [("angle: 0.02, velocity: [-1, 1]", "angle", 0.02), ("angle: [0, 1], velocity: 2", "velocity", 2)],
)
def test_one_range_of_starts_beside_a_recording(given: str, key: str, other: float) -> None:
    assert wrong(SPEC.replace("angle: 0.02, phases: 8", given) + "record: {duration: 0.1}\n") == [
        f"starts.{key}: must be a range, [least, largest], as the other one is, got {other:g}",
        "record: must be absent where starts are a range: a recording begins at one start",
    ]


def test_a_map_without_a_hand_is_what_has_to_go() -> None:
    text = SPEC.replace(HAND, "").replace("angle: 0.02, phases: 8", "angle: [-0.1, 0.1], velocity: [-1, 1]")
    assert wrong(text) == []
    assert wrong(text + "basins: {points: 10}\n") == [
        "basins: must be absent without a hand: nothing bounds how far motions part"
    ]


def test_rows_of_a_recording_count_those_between_samples() -> None:
    """20 s with 2,000 rows a second at the samples, and as many beside them as ``interval`` says."""
    text = SPEC + "record: {duration: 20, interval: INTERVAL}\n"
    assert wrong(text.replace("INTERVAL", "3.0e-5")) == []
    assert wrong(text.replace("INTERVAL", "2.0e-5")) == [
        "record.duration: must be shorter, or interval longer: 1e+06 rows would be recorded, at most 1000000"
    ]


def test_rows_of_a_recording_are_those_of_each_rate() -> None:
    """Of a grid some 2 * (1000 + 4000) / 2 a second; of a design as many as at the highest rate."""
    text = SPEC.replace("[1000]", "[1000, 4000]") + "record: {duration: 80, interval: 1.0}\n"
    assert wrong(text) == []
    design = text.replace("[1000, 4000]", "[1000, 4000]\n  design: {sobol: 2, seed: 1}")
    assert [one.split(":")[0] for one in wrong(design)] == ["record.duration"]


def test_the_largest_map() -> None:
    text = SPEC.replace("angle: 0.02, phases: 8", "angle: [-0.1, 0.1], velocity: [-1, 1]")
    assert wrong(text + "basins: {points: 1000}\n") == []
    assert [one.split(":")[0] for one in wrong(text + "basins: {points: 1001}\n")] == ["basins.points"]


def test_starts_of_a_sweep_are_looked_at() -> None:
    assert [one.split(":")[0] for one in wrong(SPEC.replace("phases: 8", "random: 8"))] == ["starts.random"]
    assert wrong(SPEC.replace("{angle: 0.02, phases: 8}", "anywhere")) == []


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


def velocity(text: str, **axes: str) -> list[str]:
    """Faults of a controller that damps with a velocity."""
    controller = f"\n  controller: {{kind: velocity_damping, damping: 1e-4, {text}}}"
    grid = "".join(f"\n  {key.replace('__', '.')}: {value}" for key, value in axes.items())
    text = SPEC.replace("  sample_rate_hz: [1000]\n", "") if RATE in axes else SPEC
    return wrong(text.replace("{stiffness: 0.27}", "{stiffness: 0.27}" + controller).replace("[1024]", "[1024]" + grid))


def test_windows_and_bandwidths_of_a_velocity() -> None:
    assert velocity("velocity: adaptive, window: 2") == []
    assert velocity("velocity: adaptive, window: 1")[0].startswith("scene.controller.window: ")
    assert velocity("velocity: tracking, bandwidth: 499") == []
    assert velocity("velocity: tracking, bandwidth: 100", controller__bandwidth="[100, 499]") == []
    assert velocity("velocity: tracking", controller__bandwidth="[100, 499]") == []
    assert velocity("velocity: tracking, bandwidth: 100", controller__bandwidth="[100, 500]")[0].startswith(
        'grid["controller.bandwidth"]: must be < 500 rad/s at 1000 Hz, got 500'
    )
    assert velocity("velocity: tracking, bandwidth: 500", sample_rate_hz="[1000, 4000]")[0].startswith(
        "scene.controller.bandwidth: must be < 500 rad/s at 1000 Hz, got 500"
    )
    assert velocity("velocity: differenced", controller__bandwidth="[2, 3]")[0].startswith(
        'grid["controller.bandwidth"]: must be absent where velocity is differenced: it is of velocity: tracking'
    )


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


def test_a_sampled_scene_needs_a_rate() -> None:
    assert wrong(SPEC.replace("  sample_rate_hz: [1000]\n", "")) == ["grid.sample_rate_hz: missing, and required"]


def test_a_form_of_a_grid_is_a_list() -> None:
    assert wrong(SPEC.replace("[1024]", "{log: 5}")) == ["grid.counts_per_rev.log: must be a list, got 5"]


def test_a_grid_without_a_form() -> None:
    assert wrong(SPEC.replace("[1024]", "{}")) == ["grid.counts_per_rev.log: missing, and required"]


def test_an_axis_of_the_grid_is_overridden_by_its_path() -> None:
    plan = load_text(SPEC, "spec.yaml", ("grid.wall.stiffness=[0.1, 0.2]",))
    assert isinstance(plan, SweepPlan)
    assert plan.axes["wall.stiffness"] == [0.1, 0.2]


def test_a_design_of_the_grid_is_overridden() -> None:
    plan = load_text(SPEC, "spec.yaml", ("grid.design={sobol: 8, seed: 1}", "grid.wall.stiffness.lin=[0.1, 0.2]"))
    assert isinstance(plan, SweepPlan)
    assert plan.points == Points("sobol", 8, 1, {"wall.stiffness": "lin"})


def test_cogging_of_one_torque_or_of_a_grid_may_keep_trials_from_repeating() -> None:
    for torque, axis, roams in (("0", "", False), ("1e-4", "", True), ("0", "\n  cogging.torque: [0, 1e-4]", True)):
        text = SPEC.replace("  bias:", f"  cogging: {{torque: {torque}, per_revolution: 7}}\n  bias:")
        plan = load_text(text.replace("[1024]", f"[1024]{axis}"), "spec.yaml")
        assert isinstance(plan, SweepPlan)
        assert may_roam(plan) is roams


def test_a_limit_beside_a_supply_voltage_is_a_fault_and_another_actuator_is_not() -> None:
    motor = "motor: {torque_constant: 0.0234, resistance: 12.3, winding: voltage, supply_voltage: 1.2}\n"
    assert wrong(f"{BENCH}{motor}actuator: {{delay_samples: 1}}\n") == []
    assert wrong(f"{BENCH}{motor}actuator: {{torque_limit: 0.1}}\n") == [
        "actuator.torque_limit: must be absent beside motor.supply_voltage: Kt V/R is the limit"
    ]


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


def test_values_of_a_spec_are_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    """The mapping, and four times a list of six, which is written once."""
    text = "a: &list [1, 2, 3, 4, 5, 6]\nb: *list\nc: *list\nd: *list\n"
    monkeypatch.setattr(limits_of_size, "_VALUES", 29)
    assert sum(map(len, parse(text, "spec.yaml").value.values())) == 24
    monkeypatch.setattr(limits_of_size, "_VALUES", 28)
    with pytest.raises(SpecError, match="more than 28 keys and values"):
        parse(text, "spec.yaml")


def test_all_but_friction_may_be_known() -> None:
    known = "recordings: [a.csv]\nfix: {inertia: 1e-6, damping: 1e-4, stiffness: 0.1}"
    text = SYSID.format(what="hand", more=known)
    assert wrong(text) == ["fix: must leave a parameter to identify"]
    assert wrong(text.replace("output_error", "output_error_friction")) == []


def test_keys_that_virtual_recordings_do_not_have_are_pointed_at() -> None:
    with pytest.raises(SpecError) as raised:
        load_text(SYSID.format(what="hand", more="virtual: {}\nlimits: {}"), "spec.yaml")
    assert [(fault.key, fault.line, fault.column) for fault in raised.value.faults] == [("limits", 5, 1)]


def test_what_a_remedy_on_a_knob_must_not_change_is_pointed_at() -> None:
    text = BENCH + REMEDIES.replace("  softer", "  faster: {change: {grid: {}}}\n  softer") + "reference: plain wall\n"
    with pytest.raises(SpecError) as raised:
        load_text(text, "spec.yaml")
    assert [(fault.line, fault.column) for fault in raised.value.faults] == [(8, 21)]


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


def test_a_campaign_without_a_grip_cell_has_no_grip() -> None:
    assert planned(BENCH + "grip: none\n").course.grip is None


def test_a_grip_that_is_wrong_within_is_said_to_be_wrong_there() -> None:
    assert wrong(BENCH + "grip: {target: -1}\n") == ["grip.target: must be > 0, got -1"]


def test_a_lag_of_the_winding_or_of_the_current_loop_is_the_lag() -> None:
    for winding, key in (("voltage, inductance: 1.0e-3", "inductance"), ("current, bandwidth: 100", "bandwidth")):
        motor = f"motor: {{torque_constant: 0.0234, resistance: 12.3, winding: {winding}}}\n"
        assert wrong(f"{BENCH}{motor}nuisances: {{amplifier: 1.0e-3}}\n") == [
            f"nuisances.amplifier: must be absent beside motor.{key}, which is the lag"
        ]
        assert wrong(f"{BENCH}{motor}nuisances: {{jitter: 1.0e-6}}\n") == []
    motor = "motor: {torque_constant: 0.0234, resistance: 12.3, winding: voltage}\n"
    assert wrong(f"{BENCH}{motor}nuisances: {{amplifier: 1.0e-3}}\n") == []


@pytest.mark.parametrize(
    ("own", "motor", "found"), [(0.01, 0.1, 0.01), (0.1, 0.01, 0.01), (None, 0.1, 0.1), (0.1, None, 0.1)]
)
def test_the_lower_limit_of_torque_holds(own: float | None, motor: float | None, found: float) -> None:
    assert limited(Actuator(torque_limit=own), motor).torque_limit == found
    assert motor is None or limited(None, motor).torque_limit == motor
    assert limited(Actuator(delay_samples=1.0, torque_limit=own), motor).delay_samples == 1.0


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
    said = "scene.bias.half_quantum: must not be given where encoder is none: there is no count"
    assert wrong(text)[-1] == f"base.{said}"
    own = text.replace("encoder: none}", "encoder: none, bias: {half_quantum: true}}")
    assert wrong(own)[-1] == f"scenes.bare.{said}"


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


def test_a_range_without_a_design_lacks_its_count() -> None:
    for form in ("log", "lin"):
        assert wrong(SPEC.replace("[1000]", f"{{{form}: [100, 1000]}}"))[0].startswith(
            f"grid.sample_rate_hz.{form}[2]: missing, and required: {{{form}: [first, last, count]}}; "
        )


def test_detents_of_a_campaign_take_the_place_of_its_wall() -> None:
    detents = "detents: {per_revolution: 12, torque: 0.01}\n"
    assert planned(BENCH + detents).first.wall.stiffness == 0.0
    assert planned(BENCH + detents + "wall: {stiffness: 0.3}\n").first.wall.stiffness == 0.3


def test_what_goes_with_remedies_alone() -> None:
    more = "reference: plain wall\nagainst: there\nhand: pinch\n"
    keys = ("reference", "against", "hand")
    assert wrong(BENCH + more) == [f"{key}: must be absent without remedies" for key in keys]
    assert wrong(BENCH + REMEDIES + more) == []


def test_an_actuator_of_a_device_gives_a_torque() -> None:
    assert wrong(BENCH + "actuator: {torque_limit: 1.0}\n") == []
    assert wrong(BENCH + "actuator: {torque_limit: 0}\n") == ["actuator.torque_limit: must be > 0 on a device"]


def test_a_spec_that_is_not_to_be_from_a_preset() -> None:
    source = parse(SPEC.replace("  knob:", "  from: smartknob\n  knob:"), "spec.yaml")
    with pytest.raises(SpecError, match=r"scene\.from: unknown key"):
        validate(source, presets=False)


def test_a_kind_that_there_is_not_has_no_keys_to_override() -> None:
    assert wrong("kind: sweeep\n", "name=a")[0].endswith("did you mean 'sweep'?")


@pytest.mark.parametrize(
    ("starts", "kind"),
    [
        (StartsSpec(), "one"),
        (StartsSpec(phases=8), "phases"),
        (StartsSpec(angle=(0.0, 1.0), velocity=(0.0, 1.0)), "ranges"),
        ("anywhere", "anywhere"),
    ],
)
def test_kinds_of_starts(starts: StartsSpec | str, kind: str) -> None:
    assert kind_of_starts(starts) == kind


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


def test_a_filter_without_a_sample_rate_is_not_looked_at() -> None:
    text = SPEC.replace("  sample_rate_hz: [1000]\n", "").replace(
        "grid:", "  controller: {kind: velocity_damping, damping: 1e-4, velocity: tracking, bandwidth: 100}\ngrid:"
    )
    assert wrong(text) == ["grid.sample_rate_hz: missing, and required"]


def test_which_lag_excludes_another() -> None:
    for winding, said in (
        ("voltage, inductance: 1.0e-3", "motor.inductance: L/R of the winding is the lag"),
        ("current, bandwidth: 100", "motor.bandwidth: the current loop is the lag"),
    ):
        motor = f"  motor: {{torque_constant: 0.0234, resistance: 12.3, winding: {winding}}}\n"
        text = SPEC.replace("grid:", motor + "  actuator: {time_constant: 1.0e-3}\ngrid:")
        assert wrong(text) == [f"scene.actuator.time_constant: must be absent beside {said}"]


def test_a_column_keeps_its_name_where_its_unit_is_another() -> None:
    text = SYSID.format(what="hand", more="recordings: [a.csv]\ncolumns: {torque_nm: {unit: mN*m}}")
    plan = load_text(text, "spec.yaml")
    assert isinstance(plan, SysidPlan)
    assert plan.columns["torque_nm"] == ColumnPlan("torque_nm", 1e-3)
    scaled = load_text(text.replace("unit: mN*m", "from: t, scale: 2, sign: -1"), "spec.yaml")
    assert isinstance(scaled, SysidPlan)
    assert scaled.columns["torque_nm"] == ColumnPlan("t", -2.0)


def test_what_the_last_cell_has_is_told() -> None:
    text = SPEC.replace("  bias:", "  cogging: {per_revolution: 7}\n  bias:")
    plan = load_text(text.replace("[1024]", "[1024]\n  cogging.torque: [0, 1.0e-4]"), "spec.yaml")
    assert isinstance(plan, SweepPlan)
    assert not_proven(plan) == ["what is found may stay unproven: the scene has cogging torque"]


def test_two_pushes_are_two() -> None:
    assert wrong(TRIAL + "press: {torques: [0.001, 0.002]}\n") == []
    assert wrong(TRIAL + "press: {torques: [0.002, 0.002]}\n") == [
        "press.torques: must be two pushes, the smaller first"
    ]
    assert wrong(TRIAL + "reference: none\n") == ["reference: must be one of remedies (plain wall, lag), got 'none'"]


@pytest.mark.parametrize("value", [np.array([0.0, 1.0]), np.array([1.0, 2.0]), 1.0])
def test_a_lag_of_any_cell_is_there(value: Any) -> None:
    assert _is_there(value) is True
    assert _is_there(0.0 * value) is False


def test_a_stage_of_a_folder_sets_nothing() -> None:
    stage = "kind: pipeline\nname: p\nstages: {hand: {folder: there}}\n"
    source = parse(stage, "spec.yaml")
    assert validate_pipeline(source).stages["hand"].folder == Path("there")
    with pytest.raises(SpecError, match="must have either spec"):
        validate_pipeline(parse(stage.replace("there", "there, set: {name: a}"), "spec.yaml"))


def test_points_in_no_order_are_none() -> None:
    for dimensions in (0, 2):
        assert UnitPoints("random", count=5, dimensions=dimensions, seed=1).run(4, 1).shape == (0, dimensions)


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


def test_a_bounce_needs_a_wall() -> None:
    text = SPEC.replace(HAND, "").replace("starts: {angle: 0.02, phases: 8}", "growth: {duration: 1}")
    assert wrong(text) == []
    assert wrong(text.replace("0.27", "0")) == [
        "growth: must be absent without a bias into the wall: nothing brings the knob back to it"
    ]


def test_a_low_pass_of_some_cells_filters_an_angle() -> None:
    assert velocity("angle: filtered", controller__low_pass="[0, 0.001]") == []
    assert velocity("angle: filtered", controller__low_pass="[0]") != []


@pytest.mark.parametrize(("axis", "count"), [(5.0, 1), ([1.0, 2.0, 3.0], 3), (LogAxis(log=(1, 100, 7)), 7)])
def test_lengths_of_axes(axis: Any, count: int) -> None:
    assert length(axis) == count


def test_a_fault_has_its_line_beside_an_override() -> None:
    with pytest.raises(SpecError) as raised:
        load_text(SPEC.replace("0.27", "-1"), "spec.yaml", ("scene.bias.torque=-1",))
    assert {(fault.where, fault.line, fault.column) for fault in raised.value.faults} == {
        ("spec.yaml", 6, 21), ("--set scene.bias.torque=-1", 0, 0),
    }  # fmt: skip


@pytest.mark.parametrize("text", ["scene..x=1", "=1", "name"])
def test_an_override_has_a_path_and_a_value(text: str) -> None:
    assert wrong(SPEC, text) == [": must be key.path=value"]


def test_stops_in_the_wrong_order_in_one_cell() -> None:
    stops = "  end_stops: {low: -0.1, high: 0.2, stiffness: 1}\n  bias:"
    text = SPEC.replace("  bias:", stops)
    assert wrong(text.replace("[1024]", "[1024]\n  end_stops.low: [-1, 0.1]\n  end_stops.high: [0.2, 0.3]")) == []
    (said,) = wrong(text.replace("[1024]", "[1024]\n  end_stops.low: [-1, 0.2]\n  end_stops.high: [0.1, 0.3]"))
    assert said == 'grid["end_stops.low"]: low must be below high all over the grid, got 0.2 and 0.1'
    (said,) = wrong(text.replace("[1024]", "[1024]\n  end_stops.high: [-0.1, 0.3]"))
    assert said == 'grid["end_stops.high"]: low must be below high all over the grid, got -0.1 and -0.1'


def test_rows_of_recordings_count_their_angles() -> None:
    """10 s with 3,000 rows a second, from so many angles."""
    text = SPEC + "record: {duration: 10, interval: 0.001, angles: ANGLES}\n"
    many = [0.001 * i for i in range(40)]
    assert wrong(text.replace("ANGLES", str(many[:20]))) == []
    assert [one.split(":")[0] for one in wrong(text.replace("ANGLES", str(many)))] == ["record.duration"]


def test_a_value_that_the_grid_overrules_is_a_fault_of_the_remedy() -> None:
    text = TRIAL.replace("counts_per_rev: [1024]}", "counts_per_rev: [1024], wall.stiffness: [0.1, 0.2]}")
    (said,) = wrong(text.replace("controller: {kind: bounded_lag}", "wall: {stiffness: 0.3}"))
    assert said.startswith("remedies.lag.change: must not set scene.wall.stiffness, which the grid of the base varies")


def test_gears_that_may_yield() -> None:
    for gear, axis, yields in (
        ("", "", False),
        (", stiffness: 10", "", True),
        ("", "\n  gear.stiffness: [10, 20]", True),
    ):
        text = SPEC.replace("  bias:", f"  gear: {{ratio: 8, motor_inertia: 1.0e-8{gear}}}\n  bias:")
        plan = load_text(text.replace("[1024]", f"[1024]{axis}"), "spec.yaml")
        assert isinstance(plan, SweepPlan)
        assert may_yield(plan) is yields


def test_the_speed_of_a_port() -> None:
    assert wrong(SERIAL.replace("url: socket://localhost:1", "url: COM3, baud: 9600")) == []
    assert wrong(SERIAL.replace("url: socket://localhost:1", "target: host, baud: 9600")) == [
        "device.baud: must be absent with target, which has no port to set"
    ]


def test_the_usual_limit_of_size() -> None:
    assert size_limit() == (1_000_000, 100_000, 1000, 1)


def test_the_largest_limit_of_size(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, "1000")
    assert size_limit() == (1_000_000_000, 100_000_000, 1_000_000, 1000)


def test_the_longest_key_that_is_said_whole() -> None:
    assert dotted(("a" * 60, "b" * 61)) == f"{'a' * 60}.{'b' * 57}..."


def test_rows_of_a_recording_without_a_clock_are_those_of_its_interval() -> None:
    text = SPEC.replace("  knob:", "  sampling: continuous\n  encoder: none\n  knob:").replace(", phases: 8", "")
    text += "record: {duration: 1000, interval: INTERVAL}\n"
    assert wrong(text.replace("INTERVAL", "0.002")) == []
    assert wrong(text.replace("INTERVAL", "0.001")) == []  # as many as there may be
    assert wrong(text.replace("INTERVAL", "0.002, trials: 3")) == []  # there is one
    assert [one.split(":")[0] for one in wrong(text.replace("INTERVAL", "0.0005"))] == ["record.duration"]


def test_grips_are_the_same_to_nine_digits() -> None:
    assert same_grip(4.3, 4.3 * (1.0 + 0.9e-9))
    assert not same_grip(4.3, 4.3 * (1.0 + 1.1e-9))


@pytest.mark.parametrize(
    ("part", "what"), [("finger", "a finger apart from the knob"), ("coil", "a winding with inductance")]
)
def test_a_controller_is_named_beside_what_hinders_it(part: str, what: str) -> None:
    for kind in ("one", "ranges"):
        assert _hindrance(frozenset({"controller", part}), kind) == f"a controller beside {what}"


def test_a_range_has_a_width() -> None:
    text = SPEC.replace("angle: 0.02, phases: 8", "angle: [0.1, 0.1], velocity: [-1, 1]")
    assert wrong(text) == ["starts.angle: must have its least value first, got [0.1, 0.1]"]


def test_a_study_of_nuisances_lists_one() -> None:
    text = "kind: sysid\nname: s\nstudy: {bias: {nuisances: LISTED}}\n"
    assert wrong(text.replace("LISTED", "{noise_rad: [0, 1.0e-4]}")) == []
    assert wrong(text.replace("LISTED", "{}")) == [
        "study.bias.nuisances: must list one of: noise_rad, coulomb_nm, lag_s, counts_per_rev, decimation"
    ]


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


def test_rows_of_recordings_count_their_trials() -> None:
    """10 s with 3,000 rows a second, of so many phases; of one start there are no more than these."""
    text = SPEC + "record: {duration: 10, interval: 0.001, trials: TRIALS}\n"
    assert wrong(text.replace("TRIALS", "1000")) == []
    more = text.replace("phases: 8", "phases: 40")
    assert wrong(more.replace("TRIALS", "30")) == []
    assert [one.split(":")[0] for one in wrong(more.replace("TRIALS", "40"))] == ["record.duration"]


def test_hysteresis_and_slack_add() -> None:
    assert Encoder(hysteresis_counts=0.5, backlash=0.003).width_counts(0.001) == 0.5 + 0.003 / 0.001


def test_a_folder_ends(tmp_path: Path) -> None:
    assert not is_endless(tmp_path)
    assert is_endless(Path("/dev/null"))


def test_axes_that_are_made_in_the_program() -> None:
    made = Grid.model_validate({"sample_rate_hz": LinAxis(lin=(1, 2, 3)), "counts_per_rev": LogAxis(log=(1, 2, 3))})
    assert (made.sample_rate_hz, made.counts_per_rev) == (LinAxis(lin=(1, 2, 3)), LogAxis(log=(1, 2, 3)))


def test_a_key_says_what_it_is_in_the_schema() -> None:
    text = model_of(Squeeze).model_json_schema()["properties"]["friction"]["description"]
    assert "coefficient of friction" in text


def test_counts_and_people_are_whole_numbers_in_columns() -> None:
    axes: dict[str, list[float | int]] = {"a": [1, 2], COUNTS: [512, 1024], PERSON: [1, 2]}
    points = Points("sobol", 4, 1, {"a": "lin"})
    for every in (cells.Cells(axes), cells.DesignCells({**axes, COUNTS: [512]}, points)):
        kinds = {name: column.dtype.kind for name, column in every.columns(0, 4).items()}
        assert kinds == {"a": "f", COUNTS: "i", PERSON: "i"}


def test_recordings_have_a_thousand_rows_between_samples_unless_said() -> None:
    assert RecordSpec(duration=0.5).plain().interval == 0.5 / 1000.0
    assert RecordSpec(duration=0.5, interval=0.1).plain().interval == 0.1


def test_starts_from_anywhere() -> None:
    assert plain_starts("anywhere") == Starts(0.0, 0.0, PHASES, False, anywhere=True)


def test_another_kind_than_is_wanted() -> None:
    with pytest.raises(SpecError, match=r"kind: must be dfa, got 'sweep'$"):
        load_text(SPEC, "spec.yaml", kind="dfa")
    assert load_text(SPEC, "spec.yaml", kind="sweep").name == "small"


def test_too_many_cells_are_said_with_and_without_a_remedy() -> None:
    assert too_many(5, Limit(3, "")) == "must span at most 3 cells, got 5"
    assert too_many(5, Limit(3, "give fewer"), " with the grid") == (
        "must span at most 3 cells with the grid, got 5; give fewer"
    )


def test_a_preset_has_a_name() -> None:
    said = "scene.from: must be the name of a preset, or the path of its file, got ''"
    assert wrong(SPEC.replace("  knob:", '  from: ""\n  knob:')) == [said]


def test_nobody_knows_the_model_of_a_knob_at_a_port() -> None:
    text = SERIAL + "controller: {kind: matched_wall}\n"
    assert wrong(text) == ["model: required: matched_wall acts by a model of knob and hand, which nobody knows here"]
    assert wrong(text.replace("url: socket://localhost:1", "target: host")) == []


def test_where_a_fit_begins() -> None:
    text = SYSID.format(what="hand", more="recordings: [a.csv]")
    for more, free in (("", False), ("excitation: continuous\n", True), ("initial_state: free\n", True)):
        plan = load_text(text + more, "spec.yaml")
        assert isinstance(plan, SysidPlan)
        assert plan.motion.free_start is free


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


def test_rows_without_a_grip_are_no_row_of_one() -> None:
    rows: list[dict[str, Any]] = [{"grip_target_n": None}, {"grip_target_n": 0.71}]
    assert narrowed(rows, {"grip_n": 0.71}, ["grip_n"]) == rows[1:]


def test_a_controller_of_which_a_part_hinders_is_not_named_twice() -> None:
    said = _hindrance(frozenset({"controller", "speed_sensor", "finger"}), "one")
    assert said == "a finger apart from the knob and a controller that reads a velocity sensor"


def test_numbers_of_a_motor_that_are_varied() -> None:
    motor = "  motor: {torque_constant: 0.0234, resistance: 12.3, winding: WINDING}\n  bias:"
    text = SPEC.replace("  bias:", motor).replace("[1024]", "[1024]\n  motor.inductance: [0, 1.0e-3]")
    for winding in ("shorted", "voltage"):
        assert wrong(text.replace("WINDING", winding)) == []
    assert wrong(text.replace("WINDING", "current")) == [
        'grid["motor.inductance"]: must be absent where winding is current'
    ]


def test_a_winding_without_inductance_is_no_lag() -> None:
    motor = "  motor: {torque_constant: 0.0234, resistance: 12.3, winding: voltage}\n"
    assert wrong(SPEC.replace("grid:", motor + "  actuator: {time_constant: 1.0e-3}\ngrid:")) == []
    device = SERIAL.replace("url: socket://localhost:1", "target: host")
    assert wrong(device + motor.strip() + "\n") == []


def test_a_passivity_controller_damps_in_every_cell() -> None:
    controller = "  controller: {kind: passivity, damping: 1.0e-4}\ngrid:"
    text = SPEC.replace("grid:", controller)
    assert wrong(text) == []
    assert wrong(text.replace("[1024]", "[1024]\n  controller.damping: [0, 1.0e-4]")) == [
        'grid["controller.damping"]: must have a damping > 0 where kind is passivity: the most that it adds'
    ]


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


def test_levels_of_a_study_are_those_that_are_listed() -> None:
    text = "kind: sysid\nname: s\nstudy: {bias: {nuisances: {noise_rad: [0, 1.0e-4], decimation: [1, 10]}}}\n"
    plan = load_text(text, "spec.yaml")
    assert isinstance(plan, SysidPlan)
    assert plan.study is not None
    assert plan.study.bias is not None
    assert plan.study.bias.nuisances == {"noise_rad": (0.0, 1e-4), "decimation": (1.0, 10.0)}


def test_what_is_present_is_overridden_as_a_whole() -> None:
    assert wrong(DESIGN, "present={}") == []
    assert wrong(DESIGN, "present.sample_rate_hz=3")[0].startswith("present.sample_rate_hz: must be one of its choices")
