"""Which parts a scene has, by the names of the table of `specs.capabilities`."""

from hknob_cli.specs.controller import MODELLED, Controller
from hknob_cli.specs.electrical import reduced
from hknob_cli.specs.over_angle import OVER_ANGLE
from hknob_cli.specs.plan import Actuator, Encoder, Fingerpad, Hand, Scene


def parts_of(scene: Scene) -> frozenset[str]:
    """Which of `capabilities.PARTS` a scene has, and what it amounts to."""
    written, scene = scene, reduced(scene)
    knob, wall, hand, actuator = scene.knob, scene.wall, scene.hand or Hand(), scene.actuator or Actuator()
    encoder, finger = scene.encoder or Encoder(), hand.finger
    pad = hand.fingerpad or Fingerpad()
    over_angle = {name: getattr(scene, name) is not None for name in OVER_ANGLE}
    against = wall.stiffness > 0.0 or any(over_angle.values())
    pushed = scene.bias is not None and bool(scene.bias.torque or scene.bias.half_quantum) and against
    damping = knob.damping + (pad.damping + finger.damping if finger else hand.damping)
    soft = pad.stiffness == 0.0 or finger.stiffness == 0.0 if finger else hand.stiffness == 0.0
    found = {
        "bias": scene.bias is not None,
        "hand": scene.hand is not None,
        "grip": bool(hand.by_grip),
        "people": bool(hand.by_person),
        "knob_damping": knob.damping != 0.0,
        "friction": knob.coulomb_torque != 0.0,
        "hand_damping": hand.damping != 0.0,
        "hand_stiffness": hand.stiffness != 0.0,
        "finger": finger is not None,
        "virtual_damping": wall.damping != 0.0,
        "delay": actuator.delay_samples != 0.0,
        "lag": actuator.time_constant != 0.0,
        "torque_limit": actuator.torque_limit is not None,
        "torque_step": actuator.torque_step != 0.0,
        "dead_band": actuator.dead_band != 0.0,
        "rounding": encoder.rounding != "floor",
        "offset": encoder.offset_counts != 0.0,
        "hysteresis": encoder.hysteresis_counts != 0.0,
        "backlash": encoder.backlash != 0.0,
        "bare": scene.encoder is None,
        "jitter": scene.clock is not None and scene.clock.jitter != 0.0,
        "unsampled": not scene.sampled,
        **(_of_controller(scene.controller) if scene.controller else {}),
        **over_angle,
        "motor": written.motor is not None,
        "coil": scene.coil is not None,
        "current_loop": written.motor is not None and written.motor.bandwidth is not None,
        "supply": written.motor is not None and written.motor.supply_voltage is not None,
        "eddy_brake": written.eddy_brake is not None,
        "gear": written.gear is not None,
        "mesh": scene.behind,
        "play": scene.play != 0.0,
        "cogging": scene.cogging is not None and scene.cogging.torque != 0.0,
        "squeeze": written.squeeze is not None,
        "undamped": damping == 0.0 and scene.coil is None and knob.coulomb_torque == 0.0,
        "unheld": soft,
        "unpushed": not pushed,
        "handless": scene.hand is None,
    }
    return frozenset(part for part, there in found.items() if there)


def _of_controller(controller: Controller) -> dict[str, bool]:
    return {
        "controller": True,
        "speed_sensor": controller.velocity == "sensor",
        "estimated_speed": controller.estimates,
        "kalman": controller.estimate == "kalman",
        "several_readings": controller.detections > 1,
        "pulses": controller.steps > 1 or (controller.kind == "impulse_damping" and controller.pulse < 1.0),
        "knob_model": controller.kind in MODELLED,
        "by_counts": bool(controller.counted[0]),
    }
