"""What in a scene, with its grid, excludes a grip that follows the push."""

from collections.abc import Iterator

from hknob_cli.specs.controller import MODELLED
from hknob_cli.specs.over_angle import OVER_ANGLE
from hknob_cli.specs.part import Place
from hknob_cli.specs.parts import Squeeze
from hknob_cli.specs.plan import Axes
from hknob_cli.specs.scene import SceneSpec


def squeeze_contradictions(scene: SceneSpec, axes: Axes) -> Iterator[tuple[Place, str]]:
    """Places in the spec, and what is wrong there."""
    squeeze, bias, hand = scene.squeeze, scene.bias, scene.hand
    if squeeze is None:
        return
    if hand is None or hand.table is None:
        yield ("scene", "squeeze"), "must be absent where the hand has no table: it is of one grip"
        return
    for key in ("inertia", "damping", "stiffness"):
        if f"hand.{key}" in axes:
            yield ("grid", f"hand.{key}"), "must be absent where 'squeeze' is given, from which it follows"
    if bias is not None and bias.half_quantum:
        yield ("scene", "bias", "half_quantum"), "must be absent where 'squeeze' is given: it asks for a torque"
        return
    for name in OVER_ANGLE:
        if getattr(scene, name):
            yield ("scene", name), "must be absent where 'squeeze' is given: the torque that it holds is that of a wall"
    if scene.controller and scene.controller.kind in MODELLED:
        text = "must be one without a model of knob and hand beside 'squeeze': its torque at rest is not the wall's"
        yield ("scene", "controller", "kind"), text
    push = max(axes.get("bias.torque", [bias.torque if bias and bias.torque else 0.0]))
    worst = Squeeze(
        min(axes.get("squeeze.friction", [squeeze.friction])),
        min(axes.get("squeeze.radius", [squeeze.radius])),
        max(axes.get("squeeze.margin", [squeeze.margin])),
    )
    asked, rows = push * worst.newtons_per_newton_meter, hand.plain().by_grip
    if asked > rows[-1][0]:
        text = f"must ask for at most {rows[-1][0]:g} N, the firmest grip of the table"
        yield ("scene", "squeeze"), f"{text}: a push of {push:g} N*m may ask for {asked:.4g} N"
    lightest = min(one.inertia for _, one in rows)
    knob = min(axes.get("knob.inertia", [scene.knob.inertia]))
    if knob + lightest <= 0.0:
        text = f"the table takes up to {-lightest:g} kg*m^2 from the {knob:g} of the knob"
        yield ("scene", "squeeze"), f"must leave an inertia above 0: {text}"
