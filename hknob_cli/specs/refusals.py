"""A scene with its grid: the values of its axes, or what in it excludes something else, as faults.

What excludes what is told by the one table of `specs.capabilities`; of two spellings of one thing only one may be
there.
"""

from collections.abc import Iterable, Sequence
from math import prod
from typing import Any, NamedTuple

from hknob_cli.errors import Fault
from hknob_cli.specs.campaign import REPLAY, SERIAL, VIRTUAL
from hknob_cli.specs.capabilities import (
    APART,
    AT,
    COLUMNS,
    PARTS,
    REFUSED,
    STARTS,
    VERDICTS,
    parts_of,
    reason,
)
from hknob_cli.specs.controller import KINDS, Controller
from hknob_cli.specs.grid import AxisError, Grid, axis_values, length, point_values
from hknob_cli.specs.hand import HandSpec, hand_contradictions
from hknob_cli.specs.messages import nearest
from hknob_cli.specs.over_angle import OVER_ANGLE
from hknob_cli.specs.part import Place, default_of
from hknob_cli.specs.plan import COUNTS, RATE, Axes, Encoder, Knob, Scene, Wall
from hknob_cli.specs.scene import (
    SceneSpec,
    gear_contradictions,
    motor_contradictions,
    over_angle_contradictions,
    squeeze_contradictions,
    velocity_contradictions,
)
from hknob_cli.specs.scene_paths import scalar_field, scalar_paths
from hknob_cli.specs.source import Source
from hknob_cli.specs.unit_points import Points

Faults = list[tuple[Place, str]]
_OF_A_DEVICE = ("encoder.", "actuator.")  # keys that a campaign's spec has as a scene has them, beside the controller's
_SAID_OF_STARTS = {"ranges": "where starts are a range", "anywhere": "where starts are anywhere"}
NEEDS_A_WALL = "must be > 0 where a controller is given"  # of wall.stiffness


def refusals(scene: SceneSpec, axes: Axes, columns: Sequence[str], *, people: bool = False, when: str = "") -> Faults:
    """Parts of a scene, or of its grid, that every one of ``columns`` refuses: places in the spec, and what is wrong.

    ``people``: whether the spec has a population, which brings the hands; ``when``: the end of the demand, by default
    that of the first column, whose reason is given.
    """
    column = columns[0]
    when = when or COLUMNS[column].when
    found: Faults = []
    for part, row in PARTS.items():
        if not all(VERDICTS[part, one] == REFUSED for one in columns):
            continue
        places = [place for place in _places(part, scene, axes, people=people) if not _within(place, found)]
        why = reason(part, column)
        if places and (part, column) in AT:
            verb = "must not be anywhere" if column == "anywhere" else "must be absent"
            found.append((AT[part, column], f"{verb} {row.when}: {why}"))
        else:
            found += [(place, f"{row.verb} {when}: {why}" if when else f"{row.verb}: {why}") for place in places]
    return found


def start_refusals(scene: SceneSpec, axes: Axes, starts: str, *, people: bool) -> Faults:
    """Parts of a scene for whose ``starts``, a key of `capabilities.STARTS`, there is no engine."""
    engines = [one for one in STARTS[starts] if one != "bounces"]
    return refusals(scene, axes, engines, people=people, when=_SAID_OF_STARTS.get(starts, ""))


def apart(asked: Iterable[str], starts: str) -> Faults:
    """Parts of a sweep that do not go with one another, or with its ``starts``."""
    there = {*asked, starts}
    found: Faults = []
    for one, others, when, why in APART:
        beside = [other for other in others if other in there]
        if one in there and beside:
            found.append(((one,), f"must be absent {when or _SAID_OF_STARTS[beside[0]]}: {why}"))
    return found


def _places(part: str, scene: SceneSpec, axes: Axes, *, people: bool) -> list[Place]:
    """Where a spec has a part; what a scene amounts to is at the scene."""
    over = [name for name in OVER_ANGLE if getattr(scene, name)]
    there = {
        "bare": scene.encoder == "none",
        "unsampled": scene.sampling == "continuous",
        "controller": scene.controller is not None,
        "people": people,
        "handless": not scene.hand and not people,
        "unpushed": not scene.bias or scene.bias.torque == 0.0 or not (over or scene.wall.stiffness > 0.0),
        **dict.fromkeys(OVER_ANGLE, False),
        **dict.fromkeys(over, True),
    }
    path = PARTS[part].path
    if part in there:
        return [("scene", path) if path else ("scene",)] if there[part] else []
    return [place for one in (path, *PARTS[part].also) if "." in one for place in given(scene, axes, one)]


def _within(place: Place, found: Faults) -> bool:
    """Whether a place lies inside one that is at fault as a whole."""
    return any(len(one) > 1 and place[: len(one)] == one for one, _ in found)


def given(scene: SceneSpec, axes: Axes, path: str) -> list[Place]:
    """Places in the spec where the value at ``path``, a part and a key, is other than if it were not listed."""
    part, key = path.split(".")
    model = getattr(scene, part)
    places: list[Place] = []
    if model is None or model == "none":
        return places
    absent = default_of(model, key)
    if getattr(model, key) != absent:
        places.append(("scene", part, key))
    elif isinstance(model, HandSpec) and model.measured and getattr(model.plain(), key) != absent:
        places.append(("scene", part, model.measured))
    if any(value != absent for value in axes.get(path, [])):
        places.append(("grid", path))
    return places


def contradictions(scene: SceneSpec, axes: Axes) -> Faults:
    """What in a scene, with its grid, excludes something else: places in the spec, and what is wrong there."""
    found: Faults = []
    if scene.bias and scene.bias.half_quantum and scene.encoder == "none":
        found.append((("scene", "bias", "half_quantum"), "must be absent where encoder is none, which has no counts"))
    found += _of_jitter(scene, axes)
    if scene.hand and scene.hand.finger:
        for key in ("inertia", "damping", "stiffness"):
            if f"hand.{key}" in axes:
                found.append((("grid", f"hand.{key}"), "must be absent where the hand has a finger"))
    found += hand_contradictions(scene.hand, scene.knob.inertia, axes)
    found += over_angle_contradictions(scene, axes)
    found += motor_contradictions(scene, axes)
    found += gear_contradictions(scene, axes)
    found += squeeze_contradictions(scene, axes)
    if scene.controller:
        found += controller_faults(scene.controller, scene.given, axes)
        found += refusals(scene, axes, ["laws"])
        key, why = scene.controller.counted
        if scene.encoder == "none" and key:
            value = getattr(scene.controller, key)
            found.append((("scene", "controller", key), f"must not be {value} where encoder is none: {why}"))
        found += _without_wall(scene, scene.controller, axes)
    elif scene.sampling == "continuous":
        found += refusals(scene, axes, ["unsampled"])
    return found


def _of_jitter(scene: SceneSpec, axes: Axes) -> Faults:
    """What does not go beside a sample clock that jitters."""
    if not (places := given(scene, axes, PARTS["jitter"].path)):
        return []
    delays = axes.get("actuator.delay_samples", [scene.actuator.delay_samples if scene.actuator else 0.0])
    if not any(delay % 1.0 for delay in delays):
        return []
    return [(places[0], "must be 0 beside a delay by a part of a sample: intervals are not of one length")]


def _without_wall(scene: SceneSpec, controller: Controller, axes: Axes) -> Faults:
    """What a controller lacks where there is no wall: only damping everywhere has something to act on."""
    if min(axes.get("wall.stiffness", [scene.wall.stiffness])) > 0.0:
        return []
    at: Place = ("scene", "wall", "stiffness")
    if not any(getattr(scene, name) for name in OVER_ANGLE):
        return [(at, NEEDS_A_WALL)]
    if controller.kind != "velocity_damping":
        return [(at, f"must be > 0 where kind is {controller.kind}: it acts on the wall's torque")]
    found: Faults = []
    if not controller.everywhere:
        message = "must have everywhere: true without a wall: else it damps inside the wall"
        found.append((("scene", "controller"), message))
    if controller.angle == "filtered":
        message = "must be counted without a wall: the wall's spring is what acts at the filtered angle"
        found.append((("scene", "controller", "angle"), message))
    return found


MOST_READINGS = 64  # of a target, in a sample interval


def device_refusals(acting: Any, *, driver: str) -> Faults:
    """What no device of a ``driver`` runs of a controller, encoder and actuator, which ``acting`` has."""
    found: Faults = []
    scene = Scene(knob=Knob(inertia=0.0), wall=Wall(stiffness=0.0))
    scene = scene._replace(controller=acting.controller, encoder=acting.encoder or Encoder(), actuator=acting.actuator)
    there = parts_of(scene)
    for part, (title, path, *_) in PARTS.items():
        if part in there and path.startswith(_OF_A_DEVICE) and VERDICTS[part, "device"] == REFUSED:
            text = f"must be one that a device can run: this is {title}, and {reason(part, 'device')}"
            found.append((("scene", *path.split(".")), text))
    if acting.controller is not None and not KINDS[acting.controller.kind].on_devices:
        text = f"must be one that a device can run: none has the law of {acting.controller.kind}"
        found.append((("scene", "controller", "kind"), text))
    if "speed_sensor" in there and driver != VIRTUAL:
        text = "must not be sensor unless the driver is virtual: no target has a sensor of the speed, and records none"
        found.append((("scene", "controller", "velocity"), text))
    if "several_readings" in there and driver == REPLAY:
        text = "must be 1 where recordings are played back: they have no readings within an interval"
        found.append((("scene", "controller", "detections"), text))
    if "several_readings" in there and driver == SERIAL and acting.controller.detections > MOST_READINGS:
        text = f"must be at most {MOST_READINGS} unless the driver is virtual: a target has room for no more readings"
        found.append((("scene", "controller", "detections"), text))
    return found


def controller_faults(spec: Controller, given: frozenset[str], axes: Axes) -> Faults:
    """Numbers of a controller, or of a grid, that its kind does not have or lacks; ``given``: the keys that are."""
    keys = KINDS[spec.kind].keys
    found: Faults = []
    allowed = ", ".join(keys)
    for key in given - {"kind", *keys}:
        found.append((("scene", "controller", key), f"must be absent where kind is {spec.kind}, which has {allowed}"))
    for name in axes:
        part, _, key = name.partition(".")
        if part == "controller" and key not in keys:
            found.append((("grid", name), f"must be absent where kind is {spec.kind}, which has {allowed}"))
    found += velocity_contradictions(spec, given, axes)
    values = axes.get("controller.damping", [spec.damping])
    if spec.kind == "velocity_damping" and "controller.damping" not in axes and "damping" not in given:
        found.append((("scene", "controller"), "must have damping where kind is velocity_damping"))
    if spec.kind == "passivity" and min(values) <= 0.0:
        place = ("grid", "controller.damping") if "controller.damping" in axes else ("scene", "controller")
        found.append((place, "must have a damping > 0 where kind is passivity: the most that it adds"))
    return sorted(found, key=lambda one: [str(step) for step in one[0]])


class Limit(NamedTuple):
    """How many cells a spec may span, and how to be allowed more, in words; empty: not at all."""

    cells: int
    how: str


class Resolved(NamedTuple):
    """Axes in SI numbers, of a design its points and the bounds of the axes, and what is wrong with them."""

    axes: Axes
    points: Points | None
    faults: list[Fault]


def resolve_axes(source: Source, grid: Grid, scene: SceneSpec | None, limit: Limit) -> Resolved:
    """Values of every axis; ``scene`` is None where it is itself at fault."""
    faults: list[Fault] = []
    axes: Axes = {}
    scales: dict[str, str] = {}
    written = grid.axes()
    count = prod(map(length, written.values()))  # before they are made, which may take more memory than there is
    if not grid.design and count > limit.cells:
        return Resolved({}, None, [source.fault(("grid",), too_many(count, limit), at_key=True)])
    for name, axis in written.items():
        if name not in (RATE, COUNTS):
            wrong = _axis_fault(name, scene)
            if wrong:
                faults.append(source.fault(("grid", name), wrong, at_key=True))
                continue
        try:
            if grid.design:
                axes[name], scale = point_values(name, axis)
                if scale:
                    scales[name] = scale
            else:
                axes[name] = axis_values(name, axis)
        except AxisError as error:
            faults.append(source.fault(("grid", name, *error.steps), str(error)))
    points = grid.design.plain(scales) if grid.design else None
    if points and points.number > limit.cells:
        faults.append(source.fault(("grid", "design", points.method), too_many(points.number, limit)))
    if points and not faults and all(len(values) == 1 for values in axes.values()):
        text = "must have an axis to vary: a range, {log: [first, last]} or {lin: [first, last]}, or a list"
        faults.append(source.fault(("grid", "design"), text))
    return Resolved(axes, points, faults)


def too_many(count: int, limit: Limit, beside: str = "") -> str:
    """What is wrong with so many cells."""
    return f"must span at most {limit.cells} cells{beside}, got {count}" + (f"; {limit.how}" if limit.how else "")


def _axis_fault(name: str, scene: SceneSpec | None) -> str | None:
    """Why a value of the scene cannot be an axis; None if it can."""
    if scalar_field(name) is None:
        return nearest(name, [RATE, COUNTS, "design", *scalar_paths()])
    if scene is None:
        return None
    part: Any = scene
    for step in name.split(".")[:-1]:
        part = getattr(part, step)
        if part is None or part == "none":
            return f"must vary a part of the scene, which has no '{step}'"
    if name == "bias.torque" and scene.bias and scene.bias.half_quantum:
        return "must not vary the torque of a half-quantum bias"
    return None
