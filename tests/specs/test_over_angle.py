"""Specs with a torque over the angle: what is read, and faults with their place."""

from copy import deepcopy
from math import pi
from pathlib import Path
from typing import Any

import pytest

from hknob_cli.errors import SpecError
from hknob_cli.specs.bench import merged
from hknob_cli.specs.load import validate
from hknob_cli.specs.plan import COUNTS, DeadZone, Detents, EndStops, Profile, SweepPlan
from hknob_cli.specs.source import Source, parse

BASE: dict[str, Any] = {
    "kind": "sweep",
    "name": "small",
    "scene": {"knob": {"inertia": 1.9e-6}, "hand": {"inertia": 3e-7, "damping": 3.45e-4, "stiffness": 0.04}},
    "grid": {"sample_rate_hz": [1000.0], COUNTS: [256]},
}


def planned(scene: dict[str, Any], **grid: Any) -> SweepPlan:
    source = Source("spec.yaml")
    source.value = merged(deepcopy(BASE), {"scene": scene, "grid": grid})
    plan = validate(source)
    assert isinstance(plan, SweepPlan)
    return plan


def faults(scene: dict[str, Any], **grid: Any) -> list[str]:
    with pytest.raises(SpecError) as raised:
        planned(scene, **grid)
    return [f"{fault.key}: {fault.message}" for fault in raised.value.faults]


def test_all_parts_are_read_and_units_converted() -> None:
    scene = planned(
        {
            "profile": {"points": [["-1 rad", "8 mN*m"], [0, 0], [1.0, -0.008]], "interpolation": "stepped"},
            "detents": {
                "spacing": 0.2,
                "torque": "6 mN*m",
                "shape": "triangle",
                "range": [-1, "57.29577951308232 deg"],
            },
            "end_stops": {"low": -1, "stiffness": 0.5},
            "dead_zone": {"width": 0.1, "stiffness": 0.2, "torque": 0.01},
        }
    ).scene
    assert scene.profile == Profile(((-1.0, 0.008), (0.0, 0.0), (1.0, -0.008)), "stepped")
    assert scene.detents == Detents(0.006, spacing=0.2, shape="triangle", range=(-1.0, pytest.approx(1.0)))
    assert scene.end_stops == EndStops(0.5, low=-1.0)
    assert scene.dead_zone == DeadZone(0.1, 0.2, torque=0.01)
    assert scene.wall.stiffness == 0.0


def test_a_scene_has_a_wall_or_another_torque() -> None:
    assert faults({}) == ["scene.wall: missing, and required"]
    assert planned({"wall": {"stiffness": 0.27}}).scene.detents is None


WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "not a function": (
        {"profile": {"points": [[0.1, 0.0], [0.1, 0.1]]}},
        "scene.profile: points: angles must increase, got 0.1 after 0.1 (point 2)",
    ),
    "not a function at the third point": (
        {"profile": {"points": [[0.1, 0.0], [0.2, 0.1], [0.15, 0.1]]}},
        "scene.profile: points: angles must increase, got 0.15 after 0.2 (point 3)",
    ),
    "empty": ({"profile": {"points": []}}, "scene.profile: points: must have at least one [angle, torque], got none"),
    "does not close": (
        {"profile": {"points": [[0, 0.1], [6.283185307179586, 0.2]], "periodic": True}},
        "scene.profile: points: the last torque must be the first, 0.1, where it is periodic, got 0.2",
    ),
    "does not go round": (
        {"profile": {"points": [[0, 0.1], [0.5, 0.1]], "periodic": True}},
        "scene.profile: points: where it is periodic, the angles must span a whole part of a revolution, 2 pi / n, "
        "or whole revolutions, got 0.5 rad",
    ),
    "does not go round in numbers that there are": (
        {"profile": {"points": [[0, 0.1], [1e-300, 0.1]], "periodic": True}},
        "scene.profile: points: where it is periodic, the angles must span a whole part of a revolution, 2 pi / n, "
        "or whole revolutions, got 1e-300 rad",
    ),
    "spacing below all numbers": (
        {"detents": {"spacing": 5e-324, "torque": 0.008}},
        "scene.detents: spacing must be a whole part of a revolution, 2 pi / n, where there is no range, got "
        "4.94065645841e-324: write per_revolution, or a range",
    ),
    "finer than a count": (
        {"detents": {"per_revolution": 129, "torque": 0.008}},
        "scene.detents.per_revolution: must be at most 128, one for every 2 of 256 counts, got 129",
    ),
    "spacing finer than a count": (
        {"detents": {"spacing": 0.04, "torque": 0.008, "range": [-1, 1]}},
        "scene.detents.spacing: must be at least 0.0490874 rad, 2 of 256 counts, got 0.04",
    ),
    "number and spacing": (
        {"detents": {"per_revolution": 12, "spacing": 0.1, "torque": 0.008}},
        "scene.detents: must have exactly one of 'per_revolution' and 'spacing'",
    ),
    "spacing does not go round": (
        {"detents": {"spacing": 0.1, "torque": 0.008}},
        "scene.detents: spacing must be a whole part of a revolution, 2 pi / n, where there is no range, got 0.1: "
        "write per_revolution, or a range",
    ),
    "one point that is to go round": (
        {"profile": {"points": [[0, 0.1]], "periodic": True}},
        "scene.profile: points: the last torque must be the first, 0.1, where it is periodic, got 0.1",
    ),
    "range of no width": (
        {"detents": {"per_revolution": 12, "torque": 0.008, "range": [1, 1]}},
        "scene.detents: range: the first angle must be below the second, got 1 and 1",
    ),
    "range": (
        {"detents": {"per_revolution": 12, "torque": 0.008, "range": [1, -1]}},
        "scene.detents: range: the first angle must be below the second, got 1 and -1",
    ),
    "zone of a sine": (
        {"detents": {"per_revolution": 12, "torque": 0.008, "dead_zone": 0.01}},
        "scene.detents: dead_zone must be absent where shape is sine: it is of shape spring",
    ),
    "zone as wide as a detent": (
        {"detents": {"per_revolution": 12, "torque": 0.008, "shape": "spring", "dead_zone": 0.53}},
        "scene.detents: dead_zone must be below the spacing, 0.523599 rad, got 0.53",
    ),
    "stops in the wrong order": (
        {"end_stops": {"low": 1, "high": -1, "stiffness": 1}},
        "scene.end_stops: low must be below high, got 1 and -1",
    ),
    "no stop": ({"end_stops": {"stiffness": 1}}, "scene.end_stops: must have one of 'low' and 'high', or both"),
    "half a quantum of no wall": (
        {"end_stops": {"low": -1, "stiffness": 1}, "bias": {"half_quantum": True}},
        "scene.bias.half_quantum: must be absent without a wall: it is half the step of its torque",
    ),
    "without a clock": (
        {"end_stops": {"low": -1, "stiffness": 1}, "sampling": "continuous"},
        "scene.end_stops: must be absent where sampling is continuous: its events are those of a wall",
    ),
    "controller of the wall without a wall": (
        {"detents": {"per_revolution": 12, "torque": 1}, "controller": {"kind": "half_sample"}},
        "scene.wall.stiffness: must be > 0 where kind is half_sample: it acts on the wall's torque",
    ),
    "damping inside no wall": (
        {
            "detents": {"per_revolution": 12, "torque": 1},
            "controller": {"kind": "velocity_damping", "damping": 1e-5},
        },
        "scene.controller: must have everywhere: true without a wall: else it damps inside the wall",
    ),
    "filtered angle of no wall": (
        {
            "detents": {"per_revolution": 12, "torque": 1},
            "controller": {
                "kind": "velocity_damping",
                "damping": 1e-5,
                "everywhere": True,
                "low_pass": 0.005,
                "angle": "filtered",
            },
        },
        "scene.controller.angle: must be counted without a wall: the wall's spring is what acts at the filtered angle",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_faults(name: str) -> None:
    scene, fault = WRONG[name]
    grid = {COUNTS: None} if scene.get("encoder") == "none" else {}
    grid |= {"sample_rate_hz": None} if "sampling" in scene else {}
    found = faults(scene, **grid)
    assert fault in found, found


@pytest.mark.parametrize(
    ("axis", "values", "fault"),
    [
        ("end_stops.low", [-0.1, 0.6], "must be below high all over the grid, got 0.6 and 0.5"),
        ("detents.spacing", [0.6, 0.7], "must be absent where per_revolution is given"),
        ("detents.dead_zone", [0.1, 0.6], "must be below the spacing of the detents, 0.523599 rad, got 0.6"),
    ],
)
def test_faults_of_a_grid_stand_at_its_axis(axis: str, values: list[float], fault: str) -> None:
    scene = {
        "detents": {"per_revolution": 12, "torque": 0.008, "shape": "spring"},
        "end_stops": {"low": -0.5, "high": 0.5, "stiffness": 1.0},
    }
    (found,) = faults(scene, **{axis: values})
    assert found.startswith(f'grid["{axis}"]: ')
    assert fault in found


def test_a_fault_has_line_and_column(tmp_path: Path) -> None:
    text = """\
kind: sweep
name: small
scene:
  knob: {inertia: 1.9e-6}
  profile:
    points: [[0, 0.001], [-1, 0.002]]
grid: {sample_rate_hz: 1000, counts_per_rev: 256}
"""
    with pytest.raises(SpecError) as raised:
        validate(parse(text, "spec.yaml"))
    (fault,) = raised.value.faults
    assert str(fault) == "spec.yaml:6:5: scene.profile: points: angles must increase, got -1 after 0 (point 2)"


TWO_COUNTS = 4.0 * pi / 256.0


@pytest.mark.parametrize(
    ("detents", "grid", "said"),
    [
        (
            {"dead_zone": 0.2},
            {"detents.spacing": [0.1, 0.5]},
            "dead_zone: must be below the spacing of the detents, 0.1",
        ),
        ({"range": None}, {"detents.spacing": [0.1 * pi, 4.0 * pi]}, "must be a whole part of a revolution, 2 pi / n"),
        (
            {"dead_zone": 0.2},
            {"detents.spacing": [0.2, 0.5]},
            "must be below the spacing of the detents, 0.2 rad",
        ),
        ({}, {"detents.spacing": [0.02, 0.5]}, "must be at least 0.0490874 rad, 2 of 256 counts, got 0.02"),
        ({"range": None}, {"detents.spacing": [0.1 * pi, 0.3]}, "must be a whole part of a revolution, 2 pi / n"),
        (
            {"spacing": None, "range": None, "per_revolution": 129},
            {COUNTS: [256, 1024]},
            "must be at most 128, one for every 2 of 256 counts, got 129",
        ),
        ({"spacing": None, "range": None, "per_revolution": 128}, {}, ""),
        ({"spacing": TWO_COUNTS * (1.0 - 1e-9)}, {}, ""),  # a billionth too fine is a rounding
        ({"spacing": TWO_COUNTS * (1.0 - 2e-9)}, {}, "must be at least 0.0490874 rad, 2 of 256 counts, got 0.0490874"),
    ],
)
def test_spacings_of_detents(detents: dict[str, Any], grid: dict[str, Any], said: str) -> None:
    scene = {"detents": {"torque": 0.008, "shape": "spring", "spacing": 0.1 * pi, "range": [-1, 1], **detents}}
    if not said:
        assert planned(scene, **grid).scene.detents is not None
        return
    (found,) = faults(scene, **grid)
    assert said in found


def test_the_finest_detents_of_a_continuous_sensor() -> None:
    """There are no counts, and none are named."""
    detents = {"torque": 0.008, "range": [-1, 1]}
    finest = 4.0 * pi / 1e12
    assert planned({"encoder": "none", "detents": {**detents, "spacing": finest}}, **{COUNTS: None}).scene.detents
    assert faults({"encoder": "none", "detents": {**detents, "spacing": 0.9 * finest}}, **{COUNTS: None}) == [
        "scene.detents.spacing: must be at least 1.25664e-11 rad, got 1.13097e-11"
    ]


def test_a_periodic_profile_goes_round_from_anywhere() -> None:
    for first in (-1.0, 0.0, 1.0):
        points = [[first, 0.0], [first + 1.0, 0.1], [first + 2.0 * pi, 0.0]]
        assert planned({"profile": {"points": points, "periodic": True}}).scene.profile is not None
