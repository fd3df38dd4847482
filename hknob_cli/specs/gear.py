"""A gear between knob and motor: encoder and actuator are on the motor's shaft, the hand is on the knob.

The motor turns ``ratio`` times as far as the knob. Seen from the knob its inertia and damping count ratio squared, its
torques ratio, and its encoder ratio times as many counts. Source: Hasser, section 10.5 (360 counts behind 7.4:1).
"""

from typing import Annotated, NamedTuple

from hknob_cli.specs.declared import declared
from hknob_cli.specs.quantity import AddedInertia, Bounds, Damping, Quantity, Torque, Width


@declared()
class Gear(NamedTuple):
    """A gear, rigid or with compliance; ``stiffness`` and ``mesh_damping`` are as the knob feels them."""

    ratio: Annotated[
        float, Bounds(strict=True, gt=0, le=1e4, allow_inf_nan=False), "turns of the motor for a turn of the knob"
    ]
    motor_inertia: Annotated[AddedInertia, "moment of inertia of the motor, at its shaft"] = 0.0
    motor_damping: Annotated[Damping, "viscous damping of the motor, at its shaft"] = 0.0
    motor_coulomb_torque: Annotated[Torque, "Coulomb friction level of the motor, at its shaft, with stick"] = 0.0
    stiffness: Annotated[
        float | None,
        Quantity("N*m/rad", gt=0, le=1e12),
        "of shafts and teeth, torque at the knob over its turn with the motor held; null: rigid",
    ] = None
    mesh_damping: Annotated[Damping, "of shafts and teeth, beside the stiffness, at the knob"] = 0.0
    backlash: Annotated[Width, "play of the teeth: angle by which the knob turns freely with the motor held"] = 0.0

    def wrong(self) -> str:
        """What does not go together; empty if all does."""
        if self.stiffness is None and self.mesh_damping:
            return "mesh_damping: must be absent where the gear has no stiffness: nothing yields, so nothing is damped"
        if self.stiffness is None and self.backlash:
            return "backlash: must be absent where the gear has no stiffness: rigid teeth that meet are not followed"
        return ""
