"""What each rule of the specs allows last, and what it refuses first."""

from math import pi
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from hknob_cli.errors import SpecError, UsageError
from hknob_cli.specs import cells
from hknob_cli.specs.campaign import HwRunPlan
from hknob_cli.specs.conditions import BEST_ESTIMATOR, ChoiceError, narrowed
from hknob_cli.specs.find_people import _drawn
from hknob_cli.specs.load import load, load_text, validate
from hknob_cli.specs.over_angle import ways_round
from hknob_cli.specs.parquet import opened
from hknob_cli.specs.parts import Bias
from hknob_cli.specs.parts_there import parts_of
from hknob_cli.specs.people import Spread
from hknob_cli.specs.plan import (
    Actuator,
    Controller,
    Encoder,
    Finger,
    Fingerpad,
    Hand,
    Knob,
    Points,
    Scene,
    Wall,
)
from hknob_cli.specs.population import PopulationSpec
from hknob_cli.specs.remedies import RemediesPlan
from hknob_cli.specs.size_limit import VARIABLE, size_limit
from hknob_cli.specs.source import parse
from hknob_cli.specs.sysid import MOST_TRIALS
from tests.conftest import ROOT, SPEC
from tests.hardware.campaigns import SPEC as BENCH
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
    ("text", "key"), [("grid", ""), ("scene.knob.inertia.x=1", "scene.knob.inertia.x"), ("scne.knob=1", "scne.knob")]
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
    "nothing": (SCENE, {"handless", "unpushed", "undamped", "unheld"}, {"friction", "pulses", "knob_model", "delay"}),
    "friction": (SCENE._replace(knob=Knob(1.9e-6, coulomb_torque=1e-4)), {"friction"}, {"undamped"}),
    "a delay": (SCENE._replace(actuator=Actuator(delay_samples=1.0)), {"delay"}, {"lag"}),
    "a finger held through its pad": (
        SCENE._replace(hand=Hand(finger=Finger(1e-6, stiffness=0.1), fingerpad=Fingerpad(stiffness=0.2))),
        {"finger"}, {"unheld", "handless"},
    ),
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


@pytest.mark.parametrize("text", ["1.5", "-1", "0", "+2", "10000", "1e3", "\u0663", "x"])
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
    return wrong(SPEC.replace("{stiffness: 0.27}", "{stiffness: 0.27}" + controller).replace("[1024]", "[1024]" + grid))


def test_windows_and_bandwidths_of_a_velocity() -> None:
    assert velocity("velocity: adaptive, window: 2") == []
    assert velocity("velocity: adaptive, window: 1")[0].startswith("scene.controller.window: ")
    assert velocity("velocity: tracking, bandwidth: 499") == []
    assert velocity("velocity: tracking, bandwidth: 100", controller__bandwidth="[100, 499]") == []
    assert velocity("velocity: tracking, bandwidth: 100", controller__bandwidth="[100, 500]")[0].startswith(
        'grid["controller.bandwidth"]: must be < 500 rad/s at 1000 Hz, got 500'
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
