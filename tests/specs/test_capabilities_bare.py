"""Tests of `specs.capabilities`: what goes with a continuous sensor, and what needs the counts of an encoder."""

from copy import deepcopy
from typing import Any, get_args, get_type_hints

import pytest

from hknob_cli.errors import SpecError
from hknob_cli.specs.bench import merged
from hknob_cli.specs.capabilities import (
    EXACT,
    EXCEPTIONS,
    PROVEN,
    REFUSED,
    STARTS,
    engine_of,
    parts_of,
    verdict_of,
)
from hknob_cli.specs.cells import cells_of
from hknob_cli.specs.controller import BY_COUNTS, Controller
from hknob_cli.specs.controller import KINDS as CONTROLLERS
from hknob_cli.specs.load import validate
from hknob_cli.specs.plan import SweepPlan, scene_at
from hknob_cli.specs.remarks import not_proven
from hknob_cli.specs.source import Source
from hknob_cli.stages.sweep.run import SweepStage
from tests.specs.small_cells import BASE, CHANGES, KINDS, planned


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


@pytest.mark.one_in(5)
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
