"""Specs with a motor or an eddy brake: what is read, what it comes to, and faults with their place."""

from copy import deepcopy
from math import pi
from typing import Any

import pytest

from hknob_cli.errors import SpecError
from hknob_cli.report.derived_numbers import derived_numbers, passivity
from hknob_cli.report.scene_words import scene_sentences
from hknob_cli.specs.bench import merged
from hknob_cli.specs.load import validate
from hknob_cli.specs.motor import Coil
from hknob_cli.specs.plan import COUNTS, RATE, Scene, SweepPlan, scene_at
from hknob_cli.specs.source import Source

KT, R, L = 0.0234, 2.32, 2.38e-4
MOTOR = {"torque_constant": KT, "resistance": R, "winding": "shorted"}
BRAKE = {"flux_density": 0.3, "conductivity": 5.8e7, "thickness": 1e-3, "area": 1e-4, "radius": 0.02, "share": 0.5}
BASE: dict[str, Any] = {
    "kind": "sweep",
    "name": "small",
    "scene": {
        "knob": {"inertia": 1.9e-6, "damping": 1e-5},
        "hand": {"inertia": 3e-7, "damping": 3.45e-4, "stiffness": 0.04},
        "wall": {"stiffness": 0.27},
        "bias": {"torque": 0.001},
    },
    "grid": {RATE: [1000.0], COUNTS: [256]},
}


def planned(scene: dict[str, Any], **grid: Any) -> SweepPlan:
    source = Source("spec.yaml")
    source.value = merged(deepcopy(BASE), {"scene": scene, "grid": grid})
    plan = validate(source)
    assert isinstance(plan, SweepPlan)
    return plan


def first(scene: dict[str, Any]) -> Scene:
    """The scene of the only cell."""
    return scene_at(planned(scene).scene, {RATE: 1000.0, COUNTS: 256})


def faults(scene: dict[str, Any], **grid: Any) -> list[str]:
    with pytest.raises(SpecError) as raised:
        planned(scene, **grid)
    return [f"{fault.key}: {fault.message}" for fault in raised.value.faults]


def test_units_are_converted() -> None:
    motor = planned({"motor": {**MOTOR, "torque_constant": "23.4 mN*m/A", "inductance": "0.238 mH"}}).scene.motor
    assert motor is not None
    assert (motor.torque_constant, motor.inductance) == (pytest.approx(KT), pytest.approx(L))


def test_a_shorted_winding_without_inductance_is_damping() -> None:
    made = first({"motor": MOTOR})
    assert made.knob.damping == pytest.approx(1e-5 + KT**2 / R)
    assert made.motor is made.coil is made.actuator is None


def test_with_inductance_it_is_a_coil() -> None:
    made = first({"motor": {**MOTOR, "inductance": L}})
    assert made.knob.damping == 1e-5
    assert made.coil == Coil(pytest.approx(KT**2 / R), pytest.approx(L / R))
    assert made.actuator is None


@pytest.mark.parametrize("winding", ["shorted", "voltage"])
def test_an_inductance_that_no_number_can_tell_is_none(winding: str) -> None:
    """L/R rounds to 0, by which nothing is divided."""
    made = first({"motor": {"torque_constant": KT, "resistance": 1e12, "winding": winding, "inductance": 1e-320}})
    assert made.knob.damping == 1e-5 + KT**2 / 1e12
    assert made.coil is made.actuator is None


def test_a_voltage_lags_as_the_winding_does() -> None:
    made = first({"motor": {**MOTOR, "winding": "voltage", "inductance": L, "supply_voltage": 2.0}})
    assert made.actuator is not None
    assert made.actuator.time_constant == pytest.approx(L / R)
    assert made.actuator.torque_limit == pytest.approx(KT * 2.0 / R)
    assert made.coil == Coil(pytest.approx(KT**2 / R), pytest.approx(L / R))


def test_a_current_loop_is_a_lag_and_does_not_damp() -> None:
    made = first({"motor": {**MOTOR, "winding": "current", "bandwidth": "1 kHz"}, "actuator": {"delay_samples": 1}})
    assert made.actuator is not None
    assert made.actuator.time_constant == pytest.approx(1.0 / (2.0 * pi * 1000.0))
    assert made.actuator.delay_samples == 1.0
    assert (made.knob.damping, made.coil) == (1e-5, None)


def test_an_eddy_brake_is_damping() -> None:
    made = first({"eddy_brake": BRAKE})
    assert made.knob.damping == pytest.approx(1e-5 + 0.5 * 5.8e7 * 1e-3 * 1e-4 * 0.3**2 * 0.02**2)
    assert made.eddy_brake is None


def test_what_a_cell_comes_to_is_reduced_once() -> None:
    made = first({"motor": {**MOTOR, "inductance": L}, "eddy_brake": BRAKE})
    assert scene_at(made, {}) == made


@pytest.mark.parametrize(
    ("motor", "fault"),
    [
        ({**MOTOR, "resistance": 0}, "scene.motor.resistance: must be > 0, got 0"),
        ({**MOTOR, "torque_constant": -0.02}, "scene.motor.torque_constant: must be > 0, got -0.02"),
        ({**MOTOR, "inductance": -1e-3}, "scene.motor.inductance: must be >= 0, got -0.001"),
        ({"resistance": R, "winding": "shorted"}, "scene.motor.torque_constant: missing, and required"),
        ({"torque_constant": KT, "resistance": R}, "scene.motor.winding: missing, and required"),
        (
            {**MOTOR, "bandwidth": 100.0},
            "scene.motor: bandwidth: must be absent where winding is shorted: it is of a current loop",
        ),
        (
            {**MOTOR, "supply_voltage": 5.0},
            "scene.motor: supply_voltage: must be absent where winding is shorted: no amplifier drives it",
        ),
        (
            {**MOTOR, "winding": "current", "inductance": L},
            "scene.motor: inductance: must be absent where winding is current: the amplifier overcomes it; give its "
            "bandwidth",
        ),
    ],
)
def test_a_motor_that_cannot_be(motor: dict[str, Any], fault: str) -> None:
    assert faults({"motor": motor}) == [fault]


def test_a_limit_that_falls_with_the_speed_is_refused_with_its_number() -> None:
    (found,) = faults({"motor": {**MOTOR, "winding": "current", "supply_voltage": 5.0}})
    assert "would fall with the speed by Kt²/R = 0.000236 N*m for each rad/s" in found


def test_one_lag_and_one_limit() -> None:
    driven = {**MOTOR, "winding": "voltage", "inductance": L, "supply_voltage": 2.0}
    assert faults({"motor": driven, "actuator": {"time_constant": 1e-4, "torque_limit": 0.01}}) == [
        "scene.actuator.time_constant: must be absent beside motor.inductance: L/R of the winding is the lag",
        "scene.actuator.torque_limit: must be absent beside motor.supply_voltage: Kt V/R is the limit",
    ]
    shorted = {**MOTOR, "inductance": L}
    assert planned({"motor": shorted, "actuator": {"time_constant": 1e-4, "torque_limit": 0.01}})


def test_an_axis_that_the_winding_does_not_have() -> None:
    assert faults({"motor": MOTOR}, **{"motor.bandwidth": [100.0]}) == [
        'grid["motor.bandwidth"]: must be absent where winding is shorted'
    ]


def test_the_words_and_numbers_tell_it() -> None:
    scene = planned({"motor": {**MOTOR, "inductance": L}}).scene
    axes: Any = {RATE: [1000.0], COUNTS: [256]}
    numbers = {one.name: one.least for one in derived_numbers(scene, axes)}
    assert numbers["damping by the motor"] == pytest.approx(KT**2 / R)
    assert numbers["damping by the motor, by need"] == pytest.approx(KT**2 / R / (0.27 * 1e-3 / 2.0))
    assert numbers["damping by the motor, by hand"] == pytest.approx(KT**2 / R / 3.45e-4)
    assert numbers["corner of the winding"] == pytest.approx(R / (2.0 * pi * L))
    assert "Motor: a shorted winding beside the one that is driven, Kt 0.0234 N*m/A, R 2.32 ohm, L 0.000238 H." in (
        scene_sentences(scene, axes)
    )
    assert any("fades above R/(2 pi L)" in line for line in passivity(scene, axes))
    without = planned({"motor": MOTOR}).scene
    assert passivity(without, axes)[0] == "Is the knob's own damping more than passivity needs? Yes."
