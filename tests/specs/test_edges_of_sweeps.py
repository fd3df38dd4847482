"""Sweeps: what each rule of starts, grids, recordings and controllers allows last, and what it refuses first."""

from typing import Any

import pytest

from hknob_cli.specs import cells
from hknob_cli.specs.grid import Grid, LinAxis, LogAxis, length
from hknob_cli.specs.load import load_text
from hknob_cli.specs.plan import (
    COUNTS,
    PERSON,
    RATE,
    ROAMS,
    YIELDS,
    Points,
    Starts,
    SweepPlan,
    may_have,
)
from hknob_cli.specs.refusals import Limit, too_many
from hknob_cli.specs.remarks import not_proven
from hknob_cli.specs.sweep import PHASES, RecordSpec, StartsSpec, kind_of_starts, plain_starts
from hknob_cli.specs.unit_points import UnitPoints
from tests.conftest import SPEC
from tests.specs.test_edges_of_rules import HAND, wrong


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


def test_a_sampled_scene_needs_a_rate() -> None:
    assert wrong(SPEC.replace("  sample_rate_hz: [1000]\n", "")) == ["grid.sample_rate_hz: missing, and required"]


def test_a_form_of_a_grid_is_a_list() -> None:
    assert wrong(SPEC.replace("[1024]", "{log: 5}")) == ["grid.counts_per_rev.log: must be a list, got 5"]


def test_a_grid_without_a_form() -> None:
    assert wrong(SPEC.replace("[1024]", "{}")) == ["grid.counts_per_rev.log: missing, and required"]


def test_cogging_of_one_torque_or_of_a_grid_may_keep_trials_from_repeating() -> None:
    for torque, axis, roams in (("0", "", False), ("1e-4", "", True), ("0", "\n  cogging.torque: [0, 1e-4]", True)):
        text = SPEC.replace("  bias:", f"  cogging: {{torque: {torque}, per_revolution: 7}}\n  bias:")
        plan = load_text(text.replace("[1024]", f"[1024]{axis}"), "spec.yaml")
        assert isinstance(plan, SweepPlan)
        assert may_have(plan.scene, plan.axes, *ROAMS) is roams


def test_a_range_without_a_design_lacks_its_count() -> None:
    for form in ("log", "lin"):
        assert wrong(SPEC.replace("[1000]", f"{{{form}: [100, 1000]}}"))[0].startswith(
            f"grid.sample_rate_hz.{form}[2]: missing, and required: {{{form}: [first, last, count]}}; "
        )


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


def test_what_the_last_cell_has_is_told() -> None:
    text = SPEC.replace("  bias:", "  clock: {jitter: 0}\n  bias:")
    plan = load_text(text.replace("[1024]", "[1024]\n  clock.jitter: [0, 1.0e-5]"), "spec.yaml")
    assert isinstance(plan, SweepPlan)
    assert not_proven(plan) == ["what is found may stay unproven: the scene has a sample clock that jitters"]


def test_points_in_no_order_are_none() -> None:
    for dimensions in (0, 2):
        assert UnitPoints("random", count=5, dimensions=dimensions, seed=1).run(4, 1).shape == (0, dimensions)


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


def test_gears_that_may_yield() -> None:
    for gear, axis, yields in (
        ("", "", False),
        (", stiffness: 10", "", True),
        ("", "\n  gear.stiffness: [10, 20]", True),
    ):
        text = SPEC.replace("  bias:", f"  gear: {{ratio: 8, motor_inertia: 1.0e-8{gear}}}\n  bias:")
        plan = load_text(text.replace("[1024]", f"[1024]{axis}"), "spec.yaml")
        assert isinstance(plan, SweepPlan)
        assert may_have(plan.scene, plan.axes, *YIELDS) is yields


def test_rows_of_a_recording_without_a_clock_are_those_of_its_interval() -> None:
    text = SPEC.replace("  knob:", "  sampling: continuous\n  encoder: none\n  knob:").replace(", phases: 8", "")
    text += "record: {duration: 1000, interval: INTERVAL}\n"
    assert wrong(text.replace("INTERVAL", "0.002")) == []
    assert wrong(text.replace("INTERVAL", "0.001")) == []  # as many as there may be
    assert wrong(text.replace("INTERVAL", "0.002, trials: 3")) == []  # there is one
    assert [one.split(":")[0] for one in wrong(text.replace("INTERVAL", "0.0005"))] == ["record.duration"]


def test_a_range_has_a_width() -> None:
    text = SPEC.replace("angle: 0.02, phases: 8", "angle: [0.1, 0.1], velocity: [-1, 1]")
    assert wrong(text) == ["starts.angle: must have its least value first, got [0.1, 0.1]"]


def test_rows_of_recordings_count_their_trials() -> None:
    """10 s with 3,000 rows a second, of so many phases; of one start there are no more than these."""
    text = SPEC + "record: {duration: 10, interval: 0.001, trials: TRIALS}\n"
    assert wrong(text.replace("TRIALS", "1000")) == []
    more = text.replace("phases: 8", "phases: 40")
    assert wrong(more.replace("TRIALS", "30")) == []
    assert [one.split(":")[0] for one in wrong(more.replace("TRIALS", "40"))] == ["record.duration"]


def test_axes_that_are_made_in_the_program() -> None:
    made = Grid.model_validate({"sample_rate_hz": LinAxis(lin=(1, 2, 3)), "counts_per_rev": LogAxis(log=(1, 2, 3))})
    assert (made.sample_rate_hz, made.counts_per_rev) == (LinAxis(lin=(1, 2, 3)), LogAxis(log=(1, 2, 3)))


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


def test_too_many_cells_are_said_with_and_without_a_remedy() -> None:
    assert too_many(5, Limit(3, "")) == "must span at most 3 cells, got 5"
    assert too_many(5, Limit(3, "give fewer"), " with the grid") == (
        "must span at most 3 cells with the grid, got 5; give fewer"
    )


def test_numbers_of_a_motor_that_are_varied() -> None:
    motor = "  motor: {torque_constant: 0.0234, resistance: 12.3, winding: WINDING}\n  bias:"
    text = SPEC.replace("  bias:", motor).replace("[1024]", "[1024]\n  motor.inductance: [0, 1.0e-3]")
    for winding in ("shorted", "voltage"):
        assert wrong(text.replace("WINDING", winding)) == []
    assert wrong(text.replace("WINDING", "current")) == [
        'grid["motor.inductance"]: must be absent where winding is current'
    ]


def test_a_passivity_controller_damps_in_every_cell() -> None:
    controller = "  controller: {kind: passivity, damping: 1.0e-4}\ngrid:"
    text = SPEC.replace("grid:", controller)
    assert wrong(text) == []
    assert wrong(text.replace("[1024]", "[1024]\n  controller.damping: [0, 1.0e-4]")) == [
        'grid["controller.damping"]: must have a damping > 0 where kind is passivity: the most that it adds'
    ]
