"""What in a scene, with its grid, excludes a gear, and what a gear excludes."""

from collections.abc import Iterator

from hknob_cli.specs.controller import MODELLED
from hknob_cli.specs.over_angle import OVER_ANGLE
from hknob_cli.specs.part import Place
from hknob_cli.specs.plan import Axes
from hknob_cli.specs.scene import SceneSpec


def gear_contradictions(scene: SceneSpec, axes: Axes) -> Iterator[tuple[Place, str]]:
    """Places in the spec, and what is wrong there."""
    gear = scene.gear
    if gear is None:
        return
    for name in OVER_ANGLE:
        if getattr(scene, name) and scene.encoder != "none":
            text = "must be absent where 'gear' is given: a turn of the knob need not be a whole number of counts"
            yield ("scene", name), text
    if gear.stiffness is None and "gear.stiffness" not in axes:
        for key in ("mesh_damping", "backlash"):
            if f"gear.{key}" in axes:
                yield ("grid", f"gear.{key}"), "must be absent where the gear has no stiffness"
        return
    where = "where the gear has a stiffness"
    if min(axes.get("gear.motor_inertia", [gear.motor_inertia])) == 0.0:
        varied = "gear.motor_inertia" in axes
        yield (
            ("grid", "gear.motor_inertia") if varied else ("scene", "gear"),
            f"must have a motor_inertia > 0 {where}: the motor turns by itself",
        )
    if any(axes.get("knob.coulomb_torque", [scene.knob.coulomb_torque])):
        path = ("grid", "knob.coulomb_torque") if "knob.coulomb_torque" in axes else ("scene", "knob", "coulomb_torque")
        yield path, f"must be 0 {where}: friction is followed on the motor's side alone; give gear.motor_coulomb_torque"
    if scene.controller and scene.controller.kind in MODELLED:
        yield (
            ("scene", "controller", "kind"),
            f"must be one without a model of knob and hand {where}: that is of one body",
        )
    if scene.hand and scene.hand.finger:
        yield (
            ("scene", "hand", "finger"),
            f"must be absent {where}: motor and knob are the two bodies that are followed",
        )
