"""What in a scene, with its grid, excludes a motor's numbers: two sources of one lag or limit, and axes without use."""

from collections.abc import Iterator

from hknob_cli.specs.driven import BESIDE_SUPPLY
from hknob_cli.specs.part import Place
from hknob_cli.specs.plan import Axes
from hknob_cli.specs.scene import SceneSpec


def motor_contradictions(scene: SceneSpec, axes: Axes) -> Iterator[tuple[Place, str]]:
    """Places in the spec, and what is wrong there."""
    motor = scene.motor
    if motor is None:
        return

    def asked(path: str, absent: float | None) -> bool:
        part, key = path.split(".")
        model = getattr(scene, part)
        return path in axes or (model is not None and getattr(model, key) != absent)

    inductive = motor.winding == "voltage" and asked("motor.inductance", 0.0)
    lag = "motor.inductance" if inductive else "motor.bandwidth" if asked("motor.bandwidth", None) else ""
    if lag and asked("actuator.time_constant", 0.0):
        what = "L/R of the winding" if inductive else "the current loop"
        yield ("scene", "actuator", "time_constant"), f"must be absent beside {lag}: {what} is the lag"
    if asked("motor.supply_voltage", None) and asked("actuator.torque_limit", None):
        yield ("scene", "actuator", "torque_limit"), BESIDE_SUPPLY
    for key, windings in (
        ("inductance", ("shorted", "voltage")),
        ("bandwidth", ("current",)),
        ("supply_voltage", ("voltage",)),
    ):
        if f"motor.{key}" in axes and motor.winding not in windings:
            yield ("grid", f"motor.{key}"), f"must be absent where winding is {motor.winding}"
