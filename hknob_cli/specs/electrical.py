"""What a motor, an eddy brake and a gear come to for the knob: damping, lag, a torque limit, or a coil that remembers.

A voltage V = u R/Kt drives the torque u through the lag L/R, and the back voltage adds the torque of the same winding
when it is shorted: the winding's equation is linear.
"""

from math import pi
from typing import Any

from hknob_cli.specs.geared import ungeared
from hknob_cli.specs.motor import Coil
from hknob_cli.specs.parts import Actuator, Scene


def reduced(scene: Scene) -> Scene:
    """The scene without motor, eddy brake and gear, with what they do in their place; of arrays of numbers, too."""
    if scene.eddy_brake:
        damping = scene.knob.damping + scene.eddy_brake.damping
        scene = scene._replace(knob=scene.knob._replace(damping=damping), eddy_brake=None)
    scene = ungeared(scene)
    if scene.motor is None:
        return scene
    damping, coil, motor = scene.knob.damping, scene.coil, scene.motor
    actuator = scene.actuator
    if motor.bandwidth is not None:
        actuator = (actuator or Actuator())._replace(time_constant=1.0 / (2.0 * pi * motor.bandwidth))
    if motor.supply_voltage is not None:
        most = motor.torque_constant * motor.supply_voltage / motor.resistance
        actuator = (actuator or Actuator())._replace(torque_limit=most)
    if motor.winding != "current":
        brake = motor.torque_constant * motor.torque_constant / motor.resistance
        late = motor.inductance / motor.resistance
        if _is_there(late):  # not where it is below the least number above 0
            coil = Coil(brake, late)
            if motor.winding == "voltage":
                actuator = (actuator or Actuator())._replace(time_constant=coil.time_constant)
        else:
            damping = damping + brake
    return scene._replace(
        knob=scene.knob._replace(damping=damping),
        actuator=actuator,
        coil=coil,
        motor=None,
    )


def _is_there(value: Any) -> bool:
    """Whether a number, or any of an array, is not 0."""
    return bool((value != 0.0).any()) if hasattr(value, "any") else value != 0.0
