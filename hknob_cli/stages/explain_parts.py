"""What ``hknob explain`` says of grids and starts, and of a campaign on a knob, in plain words."""

from typing import Any

from hknob_cli.report.scene_words import range_of, scene_sentences
from hknob_cli.report.table import labels, short
from hknob_cli.specs.campaign import VIRTUAL
from hknob_cli.specs.cells import cells_of
from hknob_cli.specs.plan import COUNTS, GRIP, PERSON, RATE, Axes, Bias, Knob, Scene, Starts, Wall
from hknob_cli.specs.pulses import THRESHOLD, PulsePlan
from hknob_cli.specs.remarks import follows_all
from hknob_cli.stages.work import counted

_AXES = {RATE: "sample rates", COUNTS: "encoder resolutions", PERSON: "hands", GRIP: "grips"}


def size(plan: Any) -> str:
    """What the grid is, as the beginning of a sentence."""
    many = {name: len(values) for name, values in plan.axes.items() if len(values) > 1}
    if plan.points:
        return f"A design of {counted(plan.points.number, 'point')} ({plan.points.method})"
    if not many:
        return "One cell"
    *first, last = (_AXES.get(name, f"values of {name}") for name in many)
    of = f"{', '.join(first)} and {last}" if first else last
    return f"A {' x '.join(map(str, many.values()))} grid of {of}" if first else f"A grid of {many.popitem()[1]} {of}"


def who(scene: Scene) -> str:
    """Who has the knob, as the subject of a sentence."""
    if not scene.hand:
        return "a knob"
    return "a knob, held by one of several hands," if scene.hand.by_person else "a knob, held by a hand,"


def grid_lines(plan: Any) -> list[str]:
    """How many cells, and the values of each axis: the first and the last of many."""
    lines = [f"{counted(len(cells_of(plan)), 'cell')}."]
    for name, values in plan.axes.items():
        unit = plan.units.get(name, "")
        unit = f" {unit}" if unit and unit != "1" and name not in (COUNTS, PERSON) else ""
        if plan.points and name in plan.points.scales:
            lines.append(f"{name}: between {range_of(values)}{unit}, {plan.points.scales[name]} scale.")
        elif len(values) > 6:
            lines.append(f"{name}: {len(values)} values from {short(values[0])} to {short(values[-1])}{unit}.")
        else:
            lines.append(f"{name}: {', '.join(labels(values))}{unit}.")
    return lines


def starts_lines(starts: Starts, scene: Scene) -> list[str]:
    """Which starts are followed, and what would be complete."""
    every = follows_all(scene, starts)
    if starts.anywhere:
        return ["Every state at a sample, however far. Results say in which cells the list of cycles is complete."]
    if starts.span:
        low, high = labels([1e3 * angle for angle in starts.span[:2]])
        slowest, fastest = labels(list(starts.span[2:]))
        where = f"from {low} to {high} mrad and {slowest} to {fastest} rad/s at a sample."
        if not every:
            return [f"Some states {where} Others may end elsewhere."]
        return [f"Every state {where} Results say in which cells the list of cycles is proven to be complete."]
    where = f"{short(1e3 * starts.angle)} mrad{', inside the wall' if starts.angle < 0.0 else ''}"
    start = f"One start: {where}, {f'at {short(starts.velocity)} rad/s' if starts.velocity else 'at rest'}"
    if not scene.sampled:
        return [f"{start}. Other starts may end elsewhere."]
    if starts.sampled or not every:
        phases = f"at {counted(starts.phases, 'phase')} of the sample clock"
        return [f"{start}, {phases}. Other phases and starts may end elsewhere."]
    return [
        f"{start}, at every phase of the sample clock. Results say in which cells this is proven to be complete. Other "
        "starts may end elsewhere."
    ]


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
