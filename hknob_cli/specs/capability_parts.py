"""Parts of a scene as the table of `specs.capabilities` has them: which are there, and which pairs are lower still."""

from collections.abc import Mapping
from typing import NamedTuple

from hknob_cli.specs.controller import MODELLED, Controller
from hknob_cli.specs.drive import reduced
from hknob_cli.specs.over_angle import OVER_ANGLE
from hknob_cli.specs.plan import Fingerpad, Hand, Scene


def parts_there(scene: Scene, keys: Mapping[str, str]) -> frozenset[str]:
    """Which parts a scene has, and what it amounts to; ``keys``: the dotted path of each part, empty without one.

    A part that is a key is there where that has another value than its default, or than 0 if it has none.
    """
    written, scene = scene, reduced(scene)
    told = {
        **_of_several(scene),
        **_of_drive(written, scene),
        **(_of_controller(scene.controller) if scene.controller else {}),
    }
    return frozenset(part for part, path in keys.items() if (told[part] if part in told else _is_given(scene, path)))


def _is_given(scene: Scene, path: str) -> bool:
    """Whether the key at a path has a value other than its default. False without a path."""
    if not path:
        return False
    above, _, key = path.rpartition(".")
    part = getattr(scene, above) if above else scene
    if part is None:
        return False
    return bool(getattr(part, key) != part._field_defaults.get(key, 0.0))


def _of_several(scene: Scene) -> dict[str, bool]:
    """What is no key of its own, or what several say together."""
    knob, hand, over_angle = scene.knob, scene.hand or Hand(), [getattr(scene, name) for name in OVER_ANGLE]
    finger, pad = hand.finger, hand.fingerpad or Fingerpad()
    against = scene.wall.stiffness > 0.0 or any(part is not None for part in over_angle)
    pushed = scene.bias is not None and bool(scene.bias.torque or scene.bias.half_quantum) and against
    damping = knob.damping + (pad.damping + finger.damping if finger else hand.damping)
    soft = pad.stiffness == 0.0 or finger.stiffness == 0.0 if finger else hand.stiffness == 0.0
    return {
        "bias": scene.bias is not None,
        "grip": bool(hand.by_grip),
        "people": bool(hand.by_person),
        "bare": scene.encoder is None,
        "unsampled": not scene.sampled,
        "undamped": damping == 0.0 and scene.coil is None and knob.coulomb_torque == 0.0,
        "unheld": soft,
        "unpushed": not pushed,
        "handless": scene.hand is None,
    }


def _of_drive(written: Scene, scene: Scene) -> dict[str, bool]:
    """What is reduced to other parts; ``written``: the scene before that."""
    motor = written.motor
    return {
        "motor": motor is not None,
        "coil": scene.coil is not None,
        "current_loop": motor is not None and motor.bandwidth is not None,
        "supply": motor is not None and motor.supply_voltage is not None,
        "eddy_brake": written.eddy_brake is not None,
        "gear": written.gear is not None,
        "mesh": scene.behind,
        "play": scene.play != 0.0,
        "squeeze": written.squeeze is not None,
    }


def _of_controller(controller: Controller) -> dict[str, bool]:
    return {
        "speed_sensor": controller.velocity == "sensor",
        "estimated_speed": controller.estimates,
        "several_readings": controller.detections > 1,
        "pulses": controller.steps > 1 or (controller.kind == "impulse_damping" and controller.pulse < 1.0),
        "knob_model": controller.kind in MODELLED,
        "by_counts": bool(controller.counted[0]),
    }


PROVEN, EXACT, ESTIMATED, REFUSED = "P", "E", "~", "-"
WORDS = {PROVEN: "exact and proven", EXACT: "exact", ESTIMATED: "estimated", REFUSED: "refused"}
LOWEST_FIRST = REFUSED + ESTIMATED + EXACT + PROVEN


class Lower(NamedTuple):
    """The verdict of a pair of parts in a column, and why.

    ``unless`` a scene has one of these parts, too.
    """

    verdict: str
    why: str
    unless: tuple[str, ...] = ()


# Pairs of parts whose verdict in a column is lower than that of each of them.
EXCEPTIONS = {
    **{
        (part, "virtual_damping", column): Lower(
            REFUSED,
            "the plain wall remembers one count there, not those of the last turning point and of the last sample: "
            "it is followed as a controller",
        )
        for part in ("hysteresis", "backlash")
        for column in ("general", "general_sets")
    },
    **{
        (part, other, "friction_sets"): Lower(
            REFUSED, "another engine follows such sets, or none", ("friction", *unless)
        )
        for part in ("hysteresis", "backlash")
        for other, *unless in (("controller", "several_readings"), ("virtual_damping",), ("lag",), ("current_loop",))
    },
    ("cogging", "bare", "general"): Lower(EXACT, "a cycle that passes a corner is proven by counts"),
    ("cogging", "speed_sensor", "laws"): Lower(EXACT, "the torque follows a motion that is not affine"),
    ("friction", "bare", "general"): Lower(EXACT, "the period map is not shown to contract"),
    ("friction", "speed_sensor", "laws"): Lower(EXACT, "the torque follows the motion, which is not affine"),
    **{
        (part, "speed_sensor", "laws"): Lower(EXACT, "how far motions part between samples is not bounded")
        for part in ("hysteresis", "backlash")
    },
    ("bare", "by_counts", "laws"): Lower(
        REFUSED, "there is no count to be worth so much, to change, or to be rounded to"
    ),
}
