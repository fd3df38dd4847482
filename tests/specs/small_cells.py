"""A small cell with each part of a scene, by which the table of what goes with what is tried."""

from copy import deepcopy
from typing import Any

from hknob_cli.errors import SpecError
from hknob_cli.specs.bench import merged
from hknob_cli.specs.capabilities import (
    EXACT,
    PROVEN,
    REFUSED,
    STARTS,
    VERDICTS,
    engine_of,
    parts_of,
    verdict_of,
)
from hknob_cli.specs.capability_reasons import SETS
from hknob_cli.specs.cells import cells_of
from hknob_cli.specs.load import validate
from hknob_cli.specs.plan import Plan, SweepPlan, scene_at
from hknob_cli.specs.source import Source
from hknob_cli.stages.sweep.run import SweepStage

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
    "mesh": {"scene": {"gear": {"ratio": 5.0, "motor_inertia": 1e-8, "stiffness": 20.0, "mesh_damping": 1e-3}}},
    "play": {"scene": {"gear": {"ratio": 2.5, "motor_inertia": 1e-8, "stiffness": 20.0, "backlash": 0.002}}},
    "cogging": {"scene": {"cogging": {"torque": 3e-4, "per_revolution": 84, "centre": 0.03}}},
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


# What sets are followed with.
BESIDE = ("friction", "virtual_damping", "delay", "torque_step", "lag", "detents")
MORE_STATES = ("finger", "coil", "mesh", "hysteresis", "backlash")  # than angle and speed, or another count


def check_sweep(part: str, starts: str) -> None:
    """A sweep of the base with a part is refused, proven, or neither, as the table says."""
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
