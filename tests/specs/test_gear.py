"""A gear: a rigid one against the knob written by hand, to the last bit; and its faults."""

from copy import deepcopy
from typing import Any

import pytest

from hknob_cli.errors import SpecError
from hknob_cli.specs.bench import merged
from hknob_cli.specs.drive import ungeared
from hknob_cli.specs.load import validate
from hknob_cli.specs.motor import Cogging
from hknob_cli.specs.parts import Gear
from hknob_cli.specs.plan import (
    COUNTS,
    RATE,
    Actuator,
    Finger,
    Fingerpad,
    Hand,
    Knob,
    Plan,
    Scene,
    SweepPlan,
    Wall,
    knob_counts,
    scene_at,
)
from hknob_cli.specs.source import Source
from hknob_cli.stages.dfa.run import DfaStage
from hknob_cli.stages.predict.work import predict
from hknob_cli.stages.sweep.record import record_sweep
from hknob_cli.stages.sweep.run import SweepStage

N, MOTOR = 8.0, {"motor_inertia": 1e-8, "motor_damping": 2.5e-7}  # a power of 2: ratio times counts has no rounding
BASE: dict[str, Any] = {
    "kind": "sweep",
    "name": "small",
    "scene": {
        "knob": {"inertia": 1.9e-6, "damping": 1e-5},
        "hand": {"inertia": 3.0e-7, "damping": 3.45e-4, "stiffness": 0.04},
        "wall": {"stiffness": 0.27},
        "bias": {"torque": 0.001},
    },
    "grid": {RATE: [1000.0], COUNTS: [32]},
    "starts": {"angle": 0.02, "phases": 4},
}
GEARED = {"scene": {"gear": {"ratio": N, **MOTOR}}}
BY_HAND = {
    "scene": {"knob": {"inertia": 1.9e-6 + N * N * 1e-8, "damping": 1e-5 + N * N * 2.5e-7}},
    "grid": {COUNTS: [256]},
}
# What else there is, behind the gear and as the knob written by hand has it.
PAIRS: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "plain": ({}, {}),
    "every phase": ({"starts": {"phases": None}}, {"starts": {"phases": None}}),
    "ranges": (2 * ({"starts": {"angle": [-0.01, 0.01], "velocity": [-0.5, 0.5], "phases": None}},)),  # type: ignore[dict-item]
    "anywhere": (2 * ({"starts": "anywhere"},)),  # type: ignore[dict-item]
    "friction of the motor": (
        {"scene": {"gear": {"motor_coulomb_torque": 1e-5}}},
        {"scene": {"knob": {"coulomb_torque": N * 1e-5}}},
    ),
    "torques of the motor": (
        {"scene": {"actuator": {"torque_limit": 0.0005, "torque_step": 1e-5, "delay_samples": 0.5}}},
        {"scene": {"actuator": {"torque_limit": N * 0.0005, "torque_step": N * 1e-5, "delay_samples": 0.5}}},
    ),
    "a winding": (
        {"scene": {"motor": {"torque_constant": 0.003, "resistance": 2.32, "winding": "shorted"}}},
        {"scene": {"motor": {"torque_constant": N * 0.003, "resistance": 2.32, "winding": "shorted"}}},
    ),
    "a push of half a count": (2 * ({"scene": {"bias": {"torque": None, "half_quantum": True}}},)),  # type: ignore[dict-item]
    "a controller": (2 * ({"scene": {"controller": {"kind": "bounded_lag"}}},)),  # type: ignore[dict-item]
    "what is felt": (2 * ({"perceive": {"knob_radius": 0.0089, "extrapolate": True}},)),  # type: ignore[dict-item]
}


def planned(*changes: dict[str, Any]) -> Plan:
    source = Source("spec.yaml")
    values = deepcopy(BASE)
    for change in changes:
        values = {**merged(values, change), **({"starts": change["starts"]} if "starts" in change else {})}
    if isinstance(values.get("starts"), dict):
        values["starts"] = {"angle": 0.02, **{k: v for k, v in values["starts"].items() if v is not None}}
    source.value = {key: value for key, value in values.items() if value is not None}
    return validate(source)


def rows(plan: Plan, table: str = "orbits") -> list[dict[str, Any]]:
    assert isinstance(plan, SweepPlan)
    found = getattr(SweepStage(plan, jobs=1).run(), table).to_pylist()
    return [{name: value for name, value in row.items() if name != COUNTS} for row in found]


@pytest.mark.one_in(3)
@pytest.mark.parametrize("pair", PAIRS)
def test_a_rigid_gear_is_a_heavier_knob_with_more_counts_to_the_last_bit(pair: str) -> None:
    geared, by_hand = PAIRS[pair]
    one, other = planned(GEARED, geared), planned(BY_HAND, by_hand)
    for table in ("orbits", "cells"):
        assert rows(one, table) == rows(other, table)
    assert rows(one)


def test_a_rigid_gear_is_recorded_to_the_last_bit() -> None:
    more = {"starts": {"phases": 1}, "record": {"duration": 0.02}}
    one, other = planned(GEARED, more), planned(BY_HAND, more)
    assert isinstance(one, SweepPlan)
    assert isinstance(other, SweepPlan)
    assert record_sweep(one).drop_columns([COUNTS]).equals(record_sweep(other).drop_columns([COUNTS]))


@pytest.mark.parametrize("kind", ["dfa", "predict"])
def test_laws_of_a_rigid_gear_are_those_of_the_knob_by_hand(kind: str) -> None:
    more = {"kind": kind, "starts": None, "scene": {"bias": {"torque": None, "half_quantum": True}}}
    found = []
    for change in (GEARED, BY_HAND):
        plan = planned(change, more)
        if kind == "dfa":
            tables = [DfaStage(plan).run().drop_columns([COUNTS])]  # type: ignore[arg-type, union-attr]
        else:
            tables = [table.drop_columns([COUNTS]) for table in predict(plan)]  # type: ignore[arg-type]
        found.append([table.to_pylist() for table in tables])
    assert found[0] == found[1]
    assert all(found[0])


def test_counts_of_the_knob_are_those_of_the_encoder_times_the_ratio() -> None:
    plan = planned(GEARED, {"scene": {"gear": {"ratio": 7.4}}, "grid": {COUNTS: [360]}})
    assert isinstance(plan, SweepPlan)
    cell: dict[str, float | int] = {RATE: 1000.0, COUNTS: 360}
    assert knob_counts(scene_at(plan.scene, cell), cell) == pytest.approx(2664.0, rel=1e-15)


def test_a_ratio_may_be_an_axis() -> None:
    grid = {"grid": {"gear.ratio": [4.0, 8.0]}}
    plan = planned(GEARED, grid)
    assert rows(plan)[-1].pop("gear.ratio") == 8.0
    last = [{name: value for name, value in row.items() if name != "gear.ratio"} for row in rows(plan)]
    assert last[-1] == rows(planned(GEARED))[-1]


def faults(*changes: dict[str, Any]) -> list[str]:
    with pytest.raises(SpecError) as raised:
        planned(*changes)
    return [f"{fault.key}: {fault.message}" for fault in raised.value.faults]


STIFF = {"scene": {"gear": {"ratio": N, "motor_inertia": 1e-8, "stiffness": 5.0}}}
PLAY = {"scene": {"gear": {**STIFF["scene"]["gear"], "backlash": 0.005}}}
FINGER = {
    "scene": {
        "hand": {
            "inertia": None,
            "damping": None,
            "stiffness": None,
            "finger": {"inertia": 3e-7, "damping": 3e-4, "stiffness": 0.5},
            "fingerpad": {"damping": 1e-3, "stiffness": 20.0},
        }
    }
}


def test_torque_over_the_angle_goes_behind_a_gear_without_counts() -> None:
    """A turn of the knob need not be a whole number of counts, which a continuous sensor does not have."""
    detents = {"scene": {"detents": {"per_revolution": 12, "torque": 0.002}}}
    bare = {"scene": {"encoder": "none"}, "grid": {COUNTS: None}}
    for gear in (GEARED, STIFF, PLAY):
        assert any("scene.detents: must be absent where 'gear' is given" in one for one in faults(gear, detents))
        assert planned(gear, detents, bare).scene.detents


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ((GEARED, {"scene": {"gear": {"ratio": 0.0}}}), "scene.gear.ratio: must be > 0, got 0.0"),
        ((GEARED, {"scene": {"gear": {"mesh_damping": 1e-3}}}), "mesh_damping: must be absent where the gear has no"),
        ((GEARED, {"scene": {"gear": {"backlash": 0.01}}}), "backlash: must be absent where the gear has no stiffness"),
        (
            (GEARED, {"grid": {"gear.backlash": [0.0, 0.01]}}),
            'grid["gear.backlash"]: must be absent where the gear has no',
        ),
        ((STIFF, {"scene": {"gear": {"backlash": -0.01}}}), "scene.gear.backlash: must be >= 0"),
        ((GEARED, {"scene": {"detents": {"per_revolution": 12, "torque": 0.002}}}), "scene.detents: must be absent"),
        ((GEARED, {"grid": {"gear.mesh_damping": [1e-3]}}), 'grid["gear.mesh_damping"]: must be absent where the gear'),
        ((STIFF, {"scene": {"gear": {"motor_inertia": 0.0}}}), "scene.gear: must have a motor_inertia > 0"),
        ((STIFF, {"scene": {"knob": {"coulomb_torque": 1e-5}}}), "scene.knob.coulomb_torque: must be 0 where"),
        ((STIFF, FINGER), "scene.hand.finger: must be absent where the gear has a stiffness"),
        (
            (STIFF, {"scene": {"controller": {"kind": "half_sample"}}}),
            "scene.controller.kind: must be one without a model",
        ),
        ((STIFF, {"kind": "predict", "starts": None}), "scene.gear.stiffness: must be absent"),
    ],
)
def test_what_does_not_go_with_a_gear_is_a_fault(changes: tuple[dict[str, Any], ...], said: str) -> None:
    assert any(said in one for one in faults(*changes)), faults(*changes)


def test_cogging_of_the_motor_as_the_knob_feels_it() -> None:
    """A turn of the knob is N turns of the motor."""
    scene = Scene(Knob(1.9e-6), Wall(0.27), cogging=Cogging(7, 1e-4, 0.8), gear=Gear(N, 1e-8))
    assert ungeared(scene).cogging == Cogging(N * 7, N * 1e-4, 0.8 / N)


def test_an_elastic_gear_is_a_motor_before_a_finger() -> None:
    """The motor in the place of the knob, the mesh in that of a pad, knob and hand in that of a finger."""
    gear = Gear(N, 1e-8, 2.5e-7, 1e-5, stiffness=10.0, mesh_damping=1e-3, backlash=0.01)
    scene = Scene(
        Knob(1.9e-6, 1e-5), Wall(0.27), hand=Hand(3e-7, 3.45e-4, 0.04), actuator=Actuator(1.0, 1e-4), gear=gear
    )
    made = ungeared(scene)
    assert made.knob == Knob(N * N * 1e-8, N * N * 2.5e-7, N * 1e-5)
    assert made.hand == Hand(finger=Finger(1.9e-6 + 3e-7, 1e-5 + 3.45e-4, 0.04), fingerpad=Fingerpad(1e-3, 10.0))
    assert made.actuator == Actuator(1.0, 1e-4)
    assert (made.behind, made.play, made.turns) == (True, 0.01, N)
