"""What a spec of a campaign on a knob describes, in words."""

from typing import Any

from hknob_cli.report.scene_words import scene_sentences
from hknob_cli.report.table import short
from hknob_cli.specs.campaign import VIRTUAL
from hknob_cli.specs.plan import Axes, Bias, Knob, Scene, Wall
from hknob_cli.specs.pulses import THRESHOLD, PulsePlan
from hknob_cli.stages.work import counted

# Sentences about what the program does to a knob, whose own parts only a simulation knows.
_DONE = tuple(
    f"{part}:"
    for part in ("Wall", "Encoder", "Clock", "Actuator", "Controller", "Profile", "Detents", "End stops", "Dead zone")
)


def explained_campaign(plan: Any) -> tuple[str, dict[str, list[str]], Scene | None, Axes]:
    """The answer, sentences by title, and the scene and axes from which numbers follow."""
    if isinstance(plan, PulsePlan):
        return *explained_pulses(plan), None, {}
    trials = plan.repeats * len(plan.tries)
    for values in plan.axes.values():
        trials *= len(values)
    device = plan.device
    simulated = device.driver == "virtual" or bool(device.target)
    where = device.target or device.url or ", ".join(map(str, plan.recordings)) or "computed here"
    scene = _scene(plan, simulated)
    course, limits = plan.course, plan.limits
    about = {
        "parts": _parts(plan, scene, simulated),
        "device": [f"{device.driver}: {where}."],
        "trials": [
            f"Each records {short(course.buzz[0])} to {short(course.buzz[1])} s of buzz, and ends after "
            f"{short(course.longest)} s in any case.",
            f"Order: {'shuffled' if plan.shuffled else 'as listed'}, seed {plan.seed}.",
        ],
        **({"remedies": [_tried(one, plan.reference) for one in plan.tries]} if plan.has_remedies else {}),
        **({"compared": [f"With what was computed of them in {plan.against}."]} if plan.against else {}),
        "limits": [f"Torque up to {short(limits.torque)} N*m, speed up to {short(limits.speed)} rad/s."],
        "not proven": ["Trials are measured, not proven."],
        "ignored": [] if simulated else ["The keys knob and person: they describe a simulated device."],
    }
    asked = "on a simulated knob" if simulated else "on a knob" if device.driver == "serial" else "played back"
    under = f" under {counted(len(plan.tries), 'remedy', 'remedies')}" if plan.has_remedies else ""
    answer = f"{counted(trials, 'trial')} {asked} {'measure' if trials > 1 else 'measures'} whether it buzzes{under}."
    return answer, about, scene if simulated else scene._replace(knob=Knob(inertia=0.0)), plan.axes


def _scene(plan: Any, simulated: bool) -> Scene:
    """The scene of the first trial."""
    first = plan.first
    scene = Scene(
        knob=Knob(*plan.knob),
        wall=Wall(*first.wall),
        bias=Bias(torque=plan.person.push) if simulated else None,
        controller=first.controller,
        actuator=first.actuator,
    )
    scene = scene._replace(encoder=first.encoder or scene.encoder, motor=plan.motor, eddy_brake=plan.eddy_brake)
    return scene._replace(**plan.effects._asdict()) if plan.effects else scene


def _parts(plan: Any, scene: Scene, simulated: bool) -> list[str]:
    """Sentences of the scene, and of who holds a simulated knob; of a real one of what the program does to it."""
    lines = scene_sentences(scene, plan.axes)
    if not simulated:
        return [line for line in lines if line.startswith(_DONE)]
    wanders = [name.replace("_", " ") for name in ("wandering_push", "grip_wander") if getattr(plan.person, name)]
    person = f"Person: simulated, {'with ' + ' and '.join(wanders) if wanders else 'who pushes steadily'}."
    return [*(line for line in lines if not line.startswith("Hand:")), person]


def explained_pulses(plan: PulsePlan) -> tuple[str, dict[str, list[str]]]:
    """The answer, and sentences by title, of pulses that a grip fires."""
    pulses, who = plan.pulses, plan.pulses.person
    grips = ", ".join(map(short, plan.grips))
    if pulses.trigger == THRESHOLD:
        fires = "The pulse fires as the grip reaches its target."
    else:
        fires = (
            f"The pulse fires after the grip was within {pulses.band:.0%} of its target for {short(pulses.dwell)} s."
        )
    as_high = "as given for each grip" if plan.torques else "as moves the printed mean hand by 0.09 rad"
    person = (
        f"person {who.person}, drawn from table {who.table}" if who.person else f"the mean hand of table {who.table}"
    )
    device = plan.device
    simulated = device.driver == VIRTUAL or bool(device.target)
    where = device.target or device.url or "computed here"
    about = {
        "parts": [
            f"Person: simulated, {person}, whose hand follows the grip at which the pulse comes."
            if simulated
            else "Person: whoever holds the knob."
        ],
        "device": [f"{device.driver}: {where}, a loop of {short(pulses.sample_rate)} Hz."],
        "trials": [
            f"Grips of {grips} N; each {counted(pulses.trials, 'time')} in {counted(plan.repeats, 'block')}.",
            f"{fires} It lasts {short(1e3 * pulses.width)} ms; its torque is {as_high}.",
            f"Order: {'shuffled' if plan.shuffled else 'the lightest grip first'}, seed {plan.seed}.",
        ],
        "limits": [f"Torque up to {short(plan.limits.torque)} N*m, speed up to {short(plan.limits.speed)} rad/s."],
        "not proven": ["Trials are recorded, not proven; hknob sysid identifies the hand from them, with error bars."],
    }
    count = len(plan.grips) * pulses.trials * plan.repeats
    asked = "a simulated knob" if simulated else "a knob"
    return f"{counted(count, 'trial')} on {asked}: a grip fires a torque pulse, for hknob sysid.", about


def _tried(one: Any, reference: str) -> str:
    from hknob_cli.hardware.trial_wall import converters_of, words_of

    acts = one.controller.words if one.controller else "no controller"
    told = converters_of(one.encoder, one.actuator)
    acts += f", {words_of(told)}" if told else ""
    damping = f", damping {short(one.wall.damping)} N*m*s/rad" if one.wall.damping else ""
    needs = f"; needs {one.needs}" if one.needs else ""
    name = f"{one.name}{' (the reference)' if one.name == reference else ''}"
    return f"{name}: a wall of {short(one.wall.stiffness)} N*m/rad{damping}, {acts}{needs}."
