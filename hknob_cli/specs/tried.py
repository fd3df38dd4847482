"""The remedies that a campaign on a knob tries: what each changes of wall, controller and converters, checked.

A change is a JSON merge patch (RFC 7396) of the campaign's spec: mappings are merged, null removes a key, anything else
replaces. It may name what a device is told, which is the wall, its controller, its encoder and its actuator.
"""

from typing import Annotated, Any

from pydantic import Field, ValidationError

from hknob_cli.errors import Fault
from hknob_cli.specs.bench import merged
from hknob_cli.specs.campaign import Tried, Wall
from hknob_cli.specs.controller import Controller
from hknob_cli.specs.part import Part, Place
from hknob_cli.specs.parts import Actuator, Encoder
from hknob_cli.specs.plan import Axes
from hknob_cli.specs.refusals import NEEDS_A_WALL, controller_faults, device_refusals
from hknob_cli.specs.remedies import RemedySpec
from hknob_cli.specs.scene_paths import faults_of
from hknob_cli.specs.source import Path_, Source

ACTING = ("wall", "controller", "encoder", "actuator")  # keys of the spec that a remedy may change
BESIDE = ("reference", "against", "hand")  # keys that go with remedies alone


class TriedSpec(RemedySpec):
    """One remedy of a campaign: what it changes of what a device is told, and what it asks for."""

    change: Annotated[
        dict[str, Any],
        Field(description="merge patch of wall, controller, encoder and actuator; null removes a key"),
    ] = {}  # noqa: RUF012


class ActingSpec(Part):
    """What a device is told of the wall."""

    wall: Annotated[Wall, Field(default_factory=Wall)]
    controller: Controller | None = None
    encoder: Encoder | None = None
    actuator: Actuator | None = None


def acting_faults(acting: Any, given: frozenset[str], axes: Axes, *, driver: str) -> list[tuple[Place, str]]:
    """What is wrong with what a device is told, and what of it none runs; ``acting`` has the keys of `ActingSpec`.

    ``given``: the keys of the controller that are listed; ``driver``: the device's.
    """
    found = controller_faults(acting.controller, given, axes) if acting.controller else []
    found = found or device_refusals(acting, driver=driver)
    found = [(place[1:], text) for place, text in found]  # a campaign has no scene around it
    if acting.actuator is not None and acting.actuator.torque_limit == 0.0:
        found.append((("actuator", "torque_limit"), "must be > 0 on a device"))
    if acting.controller is not None and acting.wall.stiffness == 0.0:
        found.append((("wall", "stiffness"), NEEDS_A_WALL))
    return found


def tries_of(
    source: Source, remedies: dict[str, TriedSpec], reference: str, axes: Axes, *, driver: str
) -> tuple[tuple[Tried, ...], list[Fault]]:
    """What each remedy of a campaign, whose own wall and controller are valid, puts on the knob; or what is wrong."""
    tries, faults = [], []
    for name, remedy in remedies.items():
        found = _tried(source, name, remedy, axes, driver=driver)
        if isinstance(found, list):
            faults += found
        else:
            about = (name, remedy.needs, remedy.source)
            tries.append(Tried(found.wall, found.controller, *about, found.encoder, found.actuator))
    if reference not in remedies:
        names = ", ".join(remedies)
        faults.append(source.fault(("reference",), f"must be one of remedies ({names}), got {reference!r}"))
    return tuple(tries), faults


def _tried(source: Source, name: str, remedy: TriedSpec, axes: Axes, *, driver: str) -> ActingSpec | list[Fault]:
    """What a device is told under a remedy; or its faults, where its change was written."""
    stem: Path_ = ("remedies", name, "change")
    odd = [key for key in remedy.change if key not in ACTING]
    if odd:
        text = "must not be changed by a remedy on a knob: a device is told wall, controller, encoder and actuator"
        return [source.fault((*stem, key), text, at_key=True) for key in odd]
    values = merged({key: source.value[key] for key in ACTING if source.value.get(key) is not None}, remedy.change)

    def place(path: Path_) -> Path_:
        return (*stem, *path)

    try:
        acting = ActingSpec.model_validate(values)
    except ValidationError as error:
        return faults_of(source, ActingSpec, error, values=values, place=place)
    found = acting_faults(acting, frozenset(values.get("controller") or ()), axes, driver=driver)
    return [source.fault(place(path), text) for path, text in found] or acting
