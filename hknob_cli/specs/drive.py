"""What a motor, an eddy brake and a gear come to for the knob: damping, lag, a torque limit, or a coil that remembers.

A rigid gear leaves one body, J + n^2 Jm. With compliance there are two, and a spring between them: the motor, which the
encoder sees and the actuator turns, takes the place of the knob, the mesh that of a fingerpad, and knob and hand that
of a finger. The user's push acts on the latter.

A voltage V = u R/Kt drives the torque u through the lag L/R, and the back voltage adds the torque of the same winding
when it is shorted: the winding's equation is linear.
"""

from math import pi
from typing import Any, NamedTuple

from hknob_cli.specs.motor import Coil, EddyBrake, Motor
from hknob_cli.specs.parts import Actuator, Finger, Fingerpad, Gear, Hand, Knob, Scene, Wall
from hknob_cli.specs.quantity import Place


def ungeared(scene: Scene) -> Scene:
    """The scene without its gear, with what it does in its place; of arrays of numbers, too."""
    if scene.gear is None:
        return scene
    gear, knob, actuator, motor, cogging = scene.gear, scene.knob, scene.actuator, scene.motor, scene.cogging
    n = gear.ratio
    if actuator:
        limit = actuator.torque_limit
        actuator = actuator._replace(
            torque_limit=None if limit is None else n * limit,
            torque_step=n * actuator.torque_step,
            dead_band=n * actuator.dead_band,
        )
    if motor:
        motor = motor._replace(torque_constant=n * motor.torque_constant)
    if cogging:
        # Seen from the knob, places of rest in a turn need not be a whole number.
        often: Any = n * cogging.per_revolution
        cogging = cogging._replace(torque=n * cogging.torque, per_revolution=often, centre=cogging.centre / n)
    scene = scene._replace(gear=None, turns=n, actuator=actuator, motor=motor, cogging=cogging)
    if gear.stiffness is None:
        return scene._replace(
            knob=Knob(
                inertia=knob.inertia + n * n * gear.motor_inertia,
                damping=knob.damping + n * n * gear.motor_damping,
                coulomb_torque=knob.coulomb_torque + n * gear.motor_coulomb_torque,
            )
        )
    return _in_two(scene, gear)


def _in_two(scene: Scene, gear: Gear) -> Scene:
    """The motor in the place of the knob, and behind the mesh knob and hand as one body."""
    n, knob, hand = gear.ratio, scene.knob, scene.hand or Hand()
    return scene._replace(
        knob=Knob(
            inertia=n * n * gear.motor_inertia,
            damping=n * n * gear.motor_damping,
            coulomb_torque=n * gear.motor_coulomb_torque,
        ),
        hand=hand._replace(
            inertia=0.0,
            damping=0.0,
            stiffness=0.0,
            finger=Finger(knob.inertia + hand.inertia, knob.damping + hand.damping, hand.stiffness),
            fingerpad=Fingerpad(gear.mesh_damping, gear.stiffness or 0.0),
        ),
        behind=True,
        play=gear.backlash,
    )


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


BESIDE_SUPPLY = "must be absent beside motor.supply_voltage: Kt V/R is the limit"  # of actuator.torque_limit


class Driven(NamedTuple):
    """The knob with their damping, a winding that remembers, and lag (s) and torque limit (N·m) of the amplifier."""

    knob: Knob
    coil: Coil | None
    lag_s: float
    limit_nm: float | None


def driven_of(knob: Any, motor: Motor | None, eddy_brake: EddyBrake | None) -> Driven:
    """What they come to; ``knob`` has the fields of a scene's."""
    found = reduced(Scene(knob=Knob(*knob), wall=Wall(0.0), motor=motor, eddy_brake=eddy_brake))
    actuator = found.actuator or Actuator()
    return Driven(found.knob, found.coil, actuator.time_constant, actuator.torque_limit)


def driven_faults(spec: Any, knob: Any, *, virtual: bool) -> list[tuple[Place, str]]:
    """What of the motor of a campaign's ``spec`` is not followed there, and what it excludes.

    ``virtual``: whether the device is the virtual one; else it is a target whose knob is simulated.
    """
    if spec.motor is None:
        return []
    found: list[tuple[Place, str]] = []
    driven = driven_of(knob, spec.motor, None)
    lag = "inductance" if driven.coil else "bandwidth"
    if driven.coil and not virtual:
        text = "must be 0 with a target: the knob that its firmware simulates has no winding that remembers"
        found.append((("motor", "inductance"), text))
    elif driven.lag_s and not virtual:
        text = "must be absent with a target: the amplifier that its firmware simulates has no lag"
        found.append((("motor", "bandwidth"), text))
    if driven.lag_s and spec.nuisances is not None and spec.nuisances.amplifier:
        found.append((("nuisances", "amplifier"), f"must be absent beside motor.{lag}, which is the lag"))
    if driven.limit_nm is not None and spec.actuator is not None and spec.actuator.torque_limit is not None:
        found.append((("actuator", "torque_limit"), BESIDE_SUPPLY))
    return found


def limited(actuator: Any, limit_nm: float | None) -> Any:
    """An actuator, None for none, with the limit of a motor; its own, which a remedy has given it, if that is less."""
    if limit_nm is None:
        return actuator
    made = actuator or Actuator()
    own = made.torque_limit
    return made._replace(torque_limit=limit_nm if own is None else min(own, limit_nm))
