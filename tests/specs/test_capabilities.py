"""Tests of `specs.capabilities`: the program does what the table says, pair by pair, on a cell that is done quickly."""

from copy import deepcopy
from typing import Any, get_args, get_type_hints

import pytest

from hknob_cli.errors import SpecError
from hknob_cli.specs.bench import merged
from hknob_cli.specs.capabilities import (
    COLUMNS,
    EXACT,
    EXCEPTIONS,
    PARTS,
    PROVEN,
    REFUSED,
    STARTS,
    VERDICTS,
    WHY,
    engine_of,
    parts_of,
    takes,
    verdict_of,
)
from hknob_cli.specs.capabilities_page import page
from hknob_cli.specs.capability_reasons import SETS
from hknob_cli.specs.cells import cells_of
from hknob_cli.specs.controller import BY_COUNTS, Controller
from hknob_cli.specs.controller import KINDS as CONTROLLERS
from hknob_cli.specs.load import validate
from hknob_cli.specs.over_angle import OVER_ANGLE
from hknob_cli.specs.plan import Plan, SweepPlan, scene_at
from hknob_cli.specs.promise import not_proven
from hknob_cli.specs.source import Source
from hknob_cli.stages.sweep.run import SweepStage
from tests.conftest import ROOT

BASE: dict[str, Any] = {
    "kind": "sweep",
    "name": "small",
    "scene": {
        "knob": {"inertia": 1.9e-6},
        "hand": {"inertia": 3.0e-7, "damping": 3.45e-4, "stiffness": 0.04},
        "wall": {"stiffness": 0.27},
        "bias": {"torque": 0.001},
    },
    "grid": {"sample_rate_hz": [1000.0], "counts_per_rev": [256]},
}
FINGER = {
    "inertia": None,
    "damping": None,
    "stiffness": None,
    "finger": {"inertia": 3e-7, "damping": 3e-4, "stiffness": 0.5},
    "fingerpad": {"damping": 1e-3, "stiffness": 20.0},
}
MOTOR = {"torque_constant": 0.0234, "resistance": 2.32, "winding": "shorted"}
BRAKE = {
    "flux_density": 0.3,
    "conductivity": 5.8e7,
    "thickness": 1e-3,
    "area": 1e-4,
    "radius": 0.02,
    "share": 0.5,
}
# How the base gets each part; what it has anyway takes nothing.
CHANGES: dict[str, dict[str, Any]] = {
    "bias": {},
    "hand": {},
    "grip": {"scene": {"hand": {"inertia": None, "damping": None, "stiffness": None, "table": 1, "grip_n": 0.71}}},
    "knob_damping": {"scene": {"knob": {"damping": 1e-5}}},
    "friction": {"scene": {"knob": {"coulomb_torque": 1e-5}}},
    "hand_damping": {},
    "hand_stiffness": {},
    "finger": {"scene": {"hand": FINGER}},
    "virtual_damping": {"scene": {"wall": {"damping": 2e-5}}},
    "delay": {"scene": {"actuator": {"delay_samples": 0.5}}},
    "lag": {"scene": {"actuator": {"time_constant": 1e-4}}},
    "torque_limit": {"scene": {"actuator": {"torque_limit": 0.005}}},
    "torque_step": {"scene": {"actuator": {"torque_step": 1e-4}}},
    "dead_band": {"scene": {"actuator": {"dead_band": 2e-3}}},
    "rounding": {"scene": {"encoder": {"rounding": "nearest"}}},
    "offset": {"scene": {"encoder": {"offset_counts": 0.3}}},
    "hysteresis": {"scene": {"encoder": {"hysteresis_counts": 0.5}}},
    "backlash": {"scene": {"encoder": {"backlash": 0.004}}},
    "bare": {"scene": {"encoder": "none"}, "grid": {"counts_per_rev": None}},
    "jitter": {"scene": {"clock": {"jitter": 0.05}}},
    "unsampled": {"scene": {"sampling": "continuous"}, "grid": {"sample_rate_hz": None}},
    "controller": {"scene": {"controller": {"kind": "bounded_lag"}}},
    "speed_sensor": {"scene": {"controller": {"kind": "half_sample", "velocity": "sensor"}}},
    "estimated_speed": {
        "scene": {"controller": {"kind": "velocity_damping", "damping": 1e-4, "velocity": "adaptive", "window": 4}}
    },
    "kalman": {"scene": {"controller": {"kind": "phase_damping", "estimate": "kalman"}}},
    "several_readings": {"scene": {"controller": {"kind": "impulse_damping", "pulse": 1.0, "detections": 4}}},
    "pulses": {"scene": {"controller": {"kind": "impulse_damping"}}},
    "knob_model": {"scene": {"controller": {"kind": "half_sample"}}},
    "by_counts": {"scene": {"controller": {"kind": "phase_damping"}}},
    "profile": {"scene": {"profile": {"points": [[-0.5, 0.002], [0.0, 0.0], [0.5, -0.002]]}}},
    "detents": {"scene": {"detents": {"per_revolution": 12, "torque": 0.002}}},
    "end_stops": {"scene": {"end_stops": {"low": -0.5, "high": 0.5, "stiffness": 0.3}}},
    "dead_zone": {"scene": {"dead_zone": {"width": 0.1, "stiffness": 0.1}}},
    "motor": {"scene": {"motor": MOTOR}},
    "coil": {"scene": {"motor": {**MOTOR, "inductance": 2.4e-4}}},
    "current_loop": {"scene": {"motor": {**MOTOR, "winding": "current", "bandwidth": 1000.0}}},
    "supply": {"scene": {"motor": {**MOTOR, "winding": "voltage", "supply_voltage": 0.5}}},
    "eddy_brake": {"scene": {"eddy_brake": BRAKE}},
    "gear": {"scene": {"gear": {"ratio": 2.5, "motor_inertia": 1e-8}}},
    "mesh": {"scene": {"gear": {"ratio": 2.5, "motor_inertia": 1e-8, "stiffness": 20.0, "mesh_damping": 1e-3}}},
    "play": {"scene": {"gear": {"ratio": 2.5, "motor_inertia": 1e-8, "stiffness": 20.0, "backlash": 0.002}}},
    "cogging": {"scene": {"cogging": {"torque": 1e-3, "per_revolution": 84, "centre": 0.03}}},
    "squeeze": {
        "scene": {
            "hand": {"inertia": None, "damping": None, "stiffness": None, "table": 1, "grip_n": 0.71},
            "squeeze": {"friction": 0.7, "radius": 8.9e-3},
        }
    },
    "undamped": {"scene": {"hand": {"damping": 0.0}}},
    "unheld": {"scene": {"hand": {"stiffness": 0.0}}},
    "unpushed": {"scene": {"bias": None}},
    "handless": {"scene": {"hand": None, "knob": {"damping": 3.45e-4}}},
}
KINDS: dict[str, Any] = {
    "phases": {"angle": 0.02, "phases": 2},
    "one": {"angle": 0.02},
    "ranges": {"angle": [-0.01, 0.01], "velocity": [-0.5, 0.5], "random": 2},
    "anywhere": "anywhere",
}


def planned(part: str, **more: Any) -> Plan:
    """The plan of the base with a part and with more keys; without those that are None."""
    source = Source("spec.yaml")
    values = {**merged(deepcopy(BASE), CHANGES[part]), **more}
    source.value = {name: value for name, value in values.items() if value is not None}
    return validate(source)


def swept(*changes: dict[str, Any]) -> SweepPlan:
    """The base from four clock phases with each of the changes in turn; without keys that are None."""
    values: dict[str, Any] = merged(deepcopy(BASE), {"starts": {"angle": 0.02, "phases": 4}})
    for change in changes:
        values = merged(values, change)
    source = Source("spec.yaml")
    source.value = {name: value for name, value in values.items() if value is not None}
    plan = validate(source)
    assert isinstance(plan, SweepPlan)
    return plan


def test_every_part_has_its_change() -> None:
    assert set(CHANGES) == set(PARTS) - {"people"}
    for part in CHANGES:
        plan = planned(part)
        assert isinstance(plan, SweepPlan)
        assert part in parts_of(plan.scene)
    assert set(WHY) <= set(VERDICTS)


def _sweeps_as_the_table_says(part: str, starts: str) -> None:
    engines = [one for one in STARTS[starts] if one != "bounces"]
    try:
        plan = planned(part, starts=KINDS[starts])
    except SpecError:
        assert all(VERDICTS[part, one] == REFUSED for one in engines)
        return
    assert isinstance(plan, SweepPlan)
    assert not all(VERDICTS[part, one] == REFUSED for one in engines)
    scene = scene_at(plan.scene, next(iter(cells_of(plan))))
    engine = engine_of(scene, STARTS[starts])
    verdict, _ = verdict_of(parts_of(scene), engine)
    if engine not in SETS and plan.starts != "anywhere":
        plan = plan._replace(starts=plan.starts._replace(phases=2))  # of one start, few samples
    tables = SweepStage(plan, jobs=1).run()
    cell = tables.cells.to_pylist()[0]
    if verdict == PROVEN:
        assert cell["certified_fraction"] == 1.0
        assert cell.get("complete", engine in SETS) == (engine in SETS)
    else:
        assert verdict == EXACT
        assert cell["certified_fraction"] < 1.0 or (engine in SETS and not cell["complete"])


# Trials that bounce on teeth take seconds.
@pytest.mark.parametrize(
    "part", [pytest.param(part, marks=pytest.mark.long) if part == "play" else part for part in CHANGES]
)
def test_trials_are_proven_where_the_table_says(part: str) -> None:
    _sweeps_as_the_table_says(part, "phases")


# What sets are followed with.
BESIDE = ("friction", "virtual_damping", "delay", "torque_step", "lag", "detents")
MORE_STATES = ("finger", "coil", "mesh", "hysteresis", "backlash")  # than angle and speed, or another count
FEW_STARTS = [(part, "phases") for part in BESIDE]
FEW_STARTS += [(part, "phases") for part in ("profile", "end_stops", "dead_zone")]
FEW_STARTS += [(part, "phases") for part in ("hysteresis", "finger", "backlash")]


@pytest.mark.parametrize(("part", "starts"), FEW_STARTS)
def test_a_controller_goes_with_what_the_table_says(part: str, starts: str) -> None:
    """In the general loop, from sampled starts: what is found is proven, that the list is complete is not."""
    both = merged(CHANGES[part], CHANGES["controller"])
    source = Source("spec.yaml")
    source.value = {**merged(deepcopy(BASE), both), "starts": {**KINDS[starts], "phases": 2}}
    if starts != "phases":
        source.value["starts"] = KINDS[starts]
    plan = validate(source)
    assert isinstance(plan, SweepPlan)
    plan = plan._replace(starts=plan.starts._replace(phases=2)) if starts == "one" else plan
    scene = scene_at(plan.scene, next(iter(cells_of(plan))))
    assert engine_of(scene, STARTS[starts]) == "laws"
    assert verdict_of(parts_of(scene), "laws")[0] == PROVEN
    cell = SweepStage(plan, jobs=1).run().cells.to_pylist()[0]
    assert cell["certified_fraction"] == 1.0
    assert not cell.get("complete", False)


def bare_with(change: dict[str, Any], starts: str = "phases") -> SweepPlan:
    """A sweep of the base with a continuous sensor and another change."""
    source = Source("spec.yaml")
    source.value = {**merged(deepcopy(BASE), merged(change, CHANGES["bare"])), "starts": KINDS[starts]}
    plan = validate(source)
    assert isinstance(plan, SweepPlan)
    return plan


@pytest.mark.parametrize(("part", "torque"), [("dead_band", 3e-3), ("torque_step", 1e-4)])
def test_a_continuous_sensor_goes_with_torques_that_jump(part: str, torque: float) -> None:
    """The knob buzzes about a jump deep in the wall, far from its edge. About some dead bands no motion repeats."""
    plan = bare_with({"scene": {"actuator": {part: torque}}})
    parts = parts_of(scene_at(plan.scene, next(iter(cells_of(plan)))))
    assert {"bare", part} <= parts
    assert (engine_of(plan.scene, STARTS["phases"]), verdict_of(parts, "general")[0]) == ("general", PROVEN)
    tables = SweepStage(plan, jobs=1).run()
    assert tables.cells.to_pylist()[0]["certified_fraction"] == 1.0
    assert tables.orbits.num_rows
    assert all(row["max_rad"] < 0.0 for row in tables.orbits.to_pylist())


READ_AN_ANGLE: list[dict[str, Any]] = [
    {"kind": "stiffening"},
    {"kind": "passivity", "damping": 3e-4},
    {"kind": "first_order_hold"},
    {"kind": "first_order_hold", "steps": 2},
    {"kind": "half_sample"},
    {"kind": "matched_wall", "velocity": "sensor"},
    {"kind": "velocity_damping", "damping": 1e-4, "low_pass": 1e-3, "angle": "filtered"},
    {"kind": "velocity_damping", "damping": 1e-4, "velocity": "tracking", "bandwidth": 200.0},
]


@pytest.mark.parametrize("starts", ["phases", "one", "ranges"])
@pytest.mark.parametrize("controller", READ_AN_ANGLE, ids=lambda one: "-".join(map(str, one.values())))
def test_a_controller_reads_a_continuous_sensor(controller: dict[str, Any], starts: str) -> None:
    """In the general loop, from some starts: what it comes to is named, and not proven."""
    plan = bare_with({"scene": {"controller": controller}}, starts)
    parts = parts_of(plan.scene)
    assert {"bare", "controller"} <= parts
    assert "by_counts" not in parts
    assert (engine_of(plan.scene, STARTS[starts]), verdict_of(parts, "laws")[0]) == ("laws", EXACT)
    assert not_proven(plan)[-1] == "what is found may stay unproven: the scene has a continuous sensor"
    if starts == "one":
        plan = plan._replace(starts=plan.starts._replace(phases=2))
    cell = SweepStage(plan, jobs=1).run().cells.to_pylist()[0]
    assert cell["certified_fraction"] == 0.0
    assert cell["undecided_fraction"] == 0.0
    assert not cell.get("complete", False)


@pytest.mark.parametrize(
    ("controller", "said"),
    [
        ({"kind": "bounded_lag"}, "kind: must not be bounded_lag where encoder is none: it has a say over"),
        ({"kind": "phase_damping"}, "kind: must not be phase_damping where encoder is none: its torque is a part"),
        ({"kind": "impulse_damping"}, "kind: must not be impulse_damping where encoder is none: its pulse makes good"),
        (
            {"kind": "velocity_damping", "damping": 1e-4, "velocity": "timed"},
            "velocity: must not be timed where encoder is none: it times changes of the count",
        ),
        (
            {"kind": "velocity_damping", "damping": 1e-4, "velocity": "adaptive", "window": 4},
            "velocity: must not be adaptive where encoder is none: its line is within a count of the readings",
        ),
        (
            {"kind": "velocity_damping", "damping": 1e-4, "velocity": "kalman", "acceleration": 300.0},
            "velocity: must not be kalman where encoder is none: its gains follow from the rounding to counts",
        ),
        (
            {"kind": "first_order_hold", "detections": 4},
            "detections: must not be 4 where encoder is none: readings in an interval find when a count changes",
        ),
    ],
)
def test_a_controller_that_is_defined_by_counts_needs_them(controller: dict[str, Any], said: str) -> None:
    with pytest.raises(SpecError) as error:
        bare_with({"scene": {"controller": controller}})
    (fault,) = error.value.faults
    assert f"{fault.key}: {fault.message}".startswith(f"scene.controller.{said}")
    assert EXCEPTIONS["bare", "by_counts", "laws"][0] == REFUSED
    scene = planned("bias").scene._replace(controller=Controller(**controller), encoder=None)  # type: ignore[union-attr]
    assert verdict_of(parts_of(scene), "laws")[0] == REFUSED


def test_what_goes_by_counts_is_a_kind_or_a_velocity() -> None:
    assert set(BY_COUNTS) <= {*CONTROLLERS, *get_args(get_type_hints(Controller)["velocity"])}


@pytest.mark.parametrize("part", ["profile", "detents", "end_stops", "dead_zone", "jitter", "cogging", "play"])
def test_a_continuous_sensor_needs_no_counts_beside(part: str) -> None:
    """Nor under a controller that reads an angle; one that is defined by counts still does."""
    change = CHANGES[part]
    plan = bare_with(change)
    assert {"bare", part} <= parts_of(plan.scene)
    assert engine_of(plan.scene, STARTS["phases"]) == "general"
    reads, counts = ({"scene": {"controller": {"kind": kind}}} for kind in ("stiffening", "bounded_lag"))
    plan = bare_with(merged(change, reads))
    assert engine_of(plan.scene, STARTS["phases"]) == "laws"
    with pytest.raises(SpecError) as error:
        bare_with(merged(change, counts))
    (fault,) = error.value.faults
    assert f"{fault.key}: {fault.message}".startswith(
        "scene.controller.kind: must not be bounded_lag where encoder is none"
    )


# Pairs that go together, with the engine of their trials.
PAIRS = [
    ("hysteresis", "virtual_damping", "laws"),
    ("backlash", "virtual_damping", "laws"),
    ("controller", "play", "laws"),
    ("estimated_speed", "play", "laws"),
    ("rubbing_motor", "play", "general"),
    ("hysteresis", "play", "general"),
    ("backlash", "play", "general"),
    ("play", "cogging", "general"),
    ("friction", "cogging", "general"),
    ("finger", "cogging", "general"),
    ("hysteresis", "cogging", "general"),
    ("backlash", "cogging", "general"),
    ("jitter", "cogging", "general"),
    ("mesh", "cogging", "general"),
    ("gear", "cogging", "general"),
    ("controller", "cogging", "laws"),
    ("speed_sensor", "cogging", "laws"),
    ("detents", "cogging", "general"),
    ("squeeze", "cogging", "general"),
    ("squeeze", "mesh", "general"),
    *(("bare", part, "general") for part in ("profile", "detents", "end_stops", "dead_zone")),
    ("squeeze", "play", "general"),
    *(("bare", part, "general") for part in ("jitter", "cogging", "play")),
]


@pytest.mark.one_in(5)
@pytest.mark.parametrize(("one", "other", "engine"), PAIRS)
def test_pairs_are_as_the_table_says(one: str, other: str, engine: str) -> None:
    source = Source("spec.yaml")
    change = CHANGES.get(one, {"scene": {"gear": {"motor_coulomb_torque": 1e-5}}})
    source.value = {**merged(deepcopy(BASE), merged(change, CHANGES[other])), "starts": KINDS["phases"]}
    plan = validate(source)
    assert isinstance(plan, SweepPlan)
    parts = parts_of(plan.scene)
    assert {one if one in CHANGES else "friction", other} <= parts
    assert engine_of(plan.scene, STARTS["phases"]) == engine
    cell = SweepStage(plan, jobs=1).run().cells.to_pylist()[0]
    if verdict_of(parts, engine)[0] == PROVEN:
        assert cell["certified_fraction"] == 1.0
        assert not_proven(plan) == []
    else:
        assert not_proven(plan) != []


@pytest.mark.long
@pytest.mark.drawn(3)
@pytest.mark.parametrize("starts", ["one", "ranges"])
@pytest.mark.parametrize("part", [*BESIDE, *MORE_STATES])
def test_every_start_of_a_controller_beside_more(part: str, starts: str) -> None:
    """All of them are proven to end in what is listed."""
    source = Source("spec.yaml")
    source.value = {
        **merged(deepcopy(BASE), merged(CHANGES[part], CHANGES["controller"])),
        "starts": KINDS[starts],
    }
    plan = validate(source)
    assert isinstance(plan, SweepPlan)
    scene = scene_at(plan.scene, next(iter(cells_of(plan))))
    assert engine_of(scene, STARTS[starts]) == ("law_sets" if part in MORE_STATES else "friction_sets")
    cell = SweepStage(plan, jobs=1).run().cells.to_pylist()[0]
    assert (cell["certified_fraction"], cell["complete"]) == (1.0, True)


# Teeth that do not ring within a sample period, and friction that brings them to rest.
SOFT_TEETH = {
    "ratio": 2.0,
    "motor_inertia": 1e-7,
    "stiffness": 3.0,
    "mesh_damping": 4e-4,
    "motor_coulomb_torque": 1e-3,
}


@pytest.mark.long
@pytest.mark.drawn(3)
@pytest.mark.parametrize("beside", ["friction", "controller", "several_readings"])
@pytest.mark.parametrize("part", ["finger", "coil", "mesh"])
def test_every_phase_beside_friction_and_more(part: str, beside: str) -> None:
    """All of them are proven to end in what is listed."""
    source = Source("spec.yaml")
    rubs = {"scene": {"gear": SOFT_TEETH}} if part == "mesh" else CHANGES["friction"]
    more = {} if beside == "friction" else CHANGES[beside]
    change = merged(merged(CHANGES[part], rubs), more)
    source.value = {**merged(deepcopy(BASE), change), "starts": KINDS["one"]}
    plan = validate(source)
    assert isinstance(plan, SweepPlan)
    assert engine_of(scene_at(plan.scene, next(iter(cells_of(plan)))), STARTS["one"]) == "friction_arcs"
    assert not_proven(plan) == []
    cell = SweepStage(plan, jobs=1).run().cells.to_pylist()[0]
    assert (cell["certified_fraction"], cell["complete"]) == (1.0, True)


@pytest.mark.long
@pytest.mark.drawn(3)
@pytest.mark.parametrize("starts", ["one", "ranges", "anywhere"])
@pytest.mark.parametrize("part", CHANGES)
def test_sets_of_starts_are_proven_where_the_table_says(part: str, starts: str) -> None:
    _sweeps_as_the_table_says(part, starts)


ASKED: dict[str, dict[str, Any]] = {
    "basins": {"starts": KINDS["ranges"], "basins": {"points": 2}},
    "record": {"starts": KINDS["one"], "record": {"duration": 0.01}},
    "pulse": {"starts": KINDS["one"], "record": {"duration": 0.01, "pulse": {"torque": 0.01, "duration": 0.001}}},
    "perceive": {"starts": KINDS["phases"], "perceive": {"knob_radius": 0.0089}},
    "describing": {"kind": "dfa", "methods": ["df1", "tsypkin"]},
    "relay": {"kind": "dfa", "methods": ["sampled"]},
    "formulas": {"kind": "predict"},
}


@pytest.mark.parametrize("column", ASKED)
@pytest.mark.parametrize("part", CHANGES)
def test_specs_are_refused_where_the_table_says(part: str, column: str) -> None:
    """One fault or more where the table refuses the part, none where it does not."""
    try:
        planned(part, **ASKED[column])
        refused = False
    except SpecError:
        refused = True
    base = parts_of(planned(part).scene)  # type: ignore[union-attr]
    assert refused == (not takes(column, base))


@pytest.mark.parametrize("part", CHANGES)
def test_a_benchmark_refuses_what_the_table_says(part: str) -> None:
    scene = merged(deepcopy(BASE), CHANGES[part])["scene"]
    trial = {"scene": scene, "sample_rate_hz": 1000.0, "counts_per_rev": 256, "duration": 0.01}
    try:
        planned("bias", kind="bench", scene=None, grid=None, base=trial, scenes={"one": {}})
        refused = False
    except SpecError:
        refused = True
    assert refused == (VERDICTS[part, "bench"] == REFUSED)


TOLD = ("controller", "encoder", "actuator")  # what a device is told beside its wall
CONTROLLED = [part for part in CHANGES if part not in ("bare",) and {*TOLD} & {*CHANGES[part].get("scene", {})}]


@pytest.mark.parametrize("part", CONTROLLED)
def test_a_campaign_on_a_knob_refuses_what_the_table_says(part: str) -> None:
    source = Source("spec.yaml")
    told = {key: value for key, value in CHANGES[part]["scene"].items() if key in TOLD}
    source.value = {"kind": "hw-run", "name": "small", **told}
    if VERDICTS[part, "device"] != REFUSED:
        validate(source)
        return
    with pytest.raises(SpecError) as error:
        validate(source)
    assert all(one.message.startswith("must be one that a device can run") for one in error.value.faults)


HOST, REPLAYED = {"driver": "serial", "target": "host"}, {"driver": "replay", "recordings": ["a"]}
SENSING = CHANGES["speed_sensor"]["scene"]["controller"]
READING = CHANGES["several_readings"]["scene"]["controller"]


@pytest.mark.parametrize(
    ("controller", "device", "said"),
    [
        (SENSING, HOST, "controller.velocity: must not be sensor unless the driver is virtual"),
        (SENSING, REPLAYED, "controller.velocity: must not be sensor unless the driver is virtual"),
        (READING, REPLAYED, "controller.detections: must be 1 where recordings are played back"),
        ({**READING, "detections": 65}, HOST, "controller.detections: must be at most 64 unless the driver is virtual"),
    ],
)
def test_what_only_the_virtual_device_reads_is_refused_by_others(
    controller: dict[str, Any], device: dict[str, Any], said: str
) -> None:
    source = Source("spec.yaml")
    told = {"controller": controller, "device": device}
    source.value = {"kind": "hw-run", "name": "small", "model": {"inertia": 2e-6}, **told}
    if controller["kind"] == "impulse_damping":
        del source.value["model"]
    with pytest.raises(SpecError) as error:
        validate(source)
    (fault,) = error.value.faults
    assert f"{fault.key}: {fault.message}".startswith(said)
    source.value = {"kind": "hw-run", "name": "small", "remedies": {"plain wall": {}, "other": {"change": told}}}
    del source.value["remedies"]["other"]["change"]["device"]
    source.value["device"] = device
    with pytest.raises(SpecError) as error:
        validate(source)
    assert any(said.partition(": ")[2] in one.message for one in error.value.faults)


@pytest.mark.parametrize("detections", [4, 64])
def test_a_target_takes_readings_within_an_interval(detections: int) -> None:
    source = Source("spec.yaml")
    told = {"controller": {**READING, "detections": detections}, "device": HOST}
    source.value = {"kind": "hw-run", "name": "small", **told}
    validate(source)


MOVED = ("motor", "coil", "current_loop", "supply", "eddy_brake")


@pytest.mark.parametrize("part", MOVED)
def test_a_virtual_knob_takes_the_motors_of_the_table(part: str) -> None:
    source = Source("spec.yaml")
    source.value = {"kind": "hw-run", "name": "small", **CHANGES[part]["scene"]}
    assert VERDICTS[part, "device"] != REFUSED
    assert validate(source)


@pytest.mark.parametrize("part", [part for part in PARTS if VERDICTS[part, "device"] == REFUSED])
def test_a_campaign_on_a_knob_has_a_reason_for_what_it_lacks(part: str) -> None:
    assert (part, "device") in WHY


@pytest.mark.parametrize("part", OVER_ANGLE)
def test_a_campaign_on_a_knob_takes_what_the_table_says(part: str) -> None:
    source = Source("spec.yaml")
    source.value = {"kind": "hw-run", "name": "small", part: CHANGES[part]["scene"][part]}
    assert VERDICTS[part, "device"] != REFUSED
    assert getattr(validate(source).effects, part) is not None


@pytest.mark.parametrize("part", CHANGES)
def test_growth_refuses_what_the_table_says(part: str) -> None:
    """Of a scene without a hand, which is the bouncing ball, and with the part."""
    ball = {"scene": {"hand": CHANGES[part].get("scene", {}).get("hand")}}
    values = merged(merged(deepcopy(BASE), CHANGES[part]), ball if part not in ("hand",) else {})
    source = Source("spec.yaml")
    source.value = {**values, "starts": KINDS["phases"], "growth": {"duration": 0.01}}
    source.value["scene"].setdefault("knob", {}).pop("damping", None) if part == "handless" else None
    try:
        plan = validate(source)
    except SpecError:
        plain = {**source.value}
        plain.pop("growth")
        source.value = plain
        found = validate(source)
        assert isinstance(found, SweepPlan)
        assert not takes("bounces", parts_of(found.scene))
        return
    assert isinstance(plan, SweepPlan)
    assert takes("bounces", parts_of(plan.scene))


@pytest.mark.parametrize(
    ("part", "starts", "said"),
    [
        ("lag", "one", []),
        ("bare", "phases", []),
        (
            "bare",
            "ranges",
            ["some starts will be followed, not all: sets of states are not followed with a continuous sensor"],
        ),
        ("kalman", "phases", []),
        ("speed_sensor", "phases", []),
    ],
)
def test_what_will_not_be_proven_is_told(part: str, starts: str, said: list[str]) -> None:
    plan = planned(part, starts=KINDS[starts])
    assert isinstance(plan, SweepPlan)
    assert not_proven(plan) == said


@pytest.mark.parametrize(("part", "what"), [("cogging", "cogging torque")])
def test_what_hinders_sets_with_a_controller_is_told(part: str, what: str) -> None:
    source = Source("spec.yaml")
    source.value = {**merged(deepcopy(BASE), merged(CHANGES[part], CHANGES["controller"])), "starts": KINDS["one"]}
    plan = validate(source)
    assert isinstance(plan, SweepPlan)
    start = "some phases of the start will be followed, not all"
    assert not_proven(plan)[0] == f"{start}: sets of states are not followed with a controller beside {what}"


def test_friction_with_a_finger_is_told_as_what_hinders() -> None:
    for starts, expected in (
        ("one", []),
        (
            "ranges",
            [
                "some starts will be followed, not all: sets of states are not followed with Coulomb friction "
                "and a finger apart from the knob"
            ],
        ),
    ):
        plan = planned("finger", starts=KINDS[starts])
        assert isinstance(plan, SweepPlan)
        rubbed = plan._replace(scene=plan.scene._replace(knob=plan.scene.knob._replace(coulomb_torque=1e-5)))
        assert not_proven(rubbed) == expected


def test_every_column_has_a_title_of_its_own() -> None:
    assert len({row.title for row in COLUMNS.values()}) == len(COLUMNS)


def test_stored_page_is_current() -> None:
    assert (ROOT / "docs" / "reference" / "capabilities.md").read_text() == page(), "make schemas"


def test_a_velocity_sensor_beside_friction_is_labelled() -> None:
    source = Source("spec.yaml")
    source.value = merged(merged(deepcopy(BASE), CHANGES["friction"]), CHANGES["speed_sensor"])
    source.value["starts"] = KINDS["phases"]
    plan = validate(source)
    assert isinstance(plan, SweepPlan)
    what = "Coulomb friction with a controller that reads a velocity sensor"
    assert not_proven(plan) == [f"what is found may stay unproven: the scene has {what}"]
    assert SweepStage(plan, jobs=1).run().cells.to_pylist()[0]["certified_fraction"] == 0.0
