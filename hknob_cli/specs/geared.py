"""What a gear comes to for knob, motor and encoder, all as seen from the knob.

A rigid gear leaves one body, J + n^2 Jm. With compliance there are two, and a spring between them: the motor, which the
encoder sees and the actuator turns, takes the place of the knob, the mesh that of a fingerpad, and knob and hand that
of a finger. The user's push acts on the latter.
"""

from typing import Any

from hknob_cli.specs.gear import Gear
from hknob_cli.specs.parts import Finger, Fingerpad, Hand, Knob, Scene


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
