"""The parts of a scene in plain words, and what ``hknob explain`` says of a spec."""

from collections.abc import Iterator
from itertools import product
from math import pi
from typing import Any, NamedTuple

from hknob_cli.report.derived_numbers import Number
from hknob_cli.report.table import folded, short
from hknob_cli.specs.plan import COUNTS, GRIP, PERSON, RATE, Axes, Hand, Scene, placed, value_at
from hknob_cli.specs.quantity import unit_at
from hknob_cli.specs.squeeze import DECIDING, grip_of, left_out

# What is written after numbers that have no unit.
_PURE = {
    "actuator.delay_samples": "samples",
    "encoder.offset_counts": "counts",
    "encoder.hysteresis_counts": "counts",
    "clock.jitter": "of it",
    "cogging.per_revolution": "places of rest in a turn",
    "squeeze.margin": "times",
}
_GRASP = ("inertia", "damping", "stiffness")
_WINDINGS = {
    "shorted": "a shorted winding beside the one that is driven",
    "voltage": "a winding driven by a voltage",
    "current": "a winding driven by a current",
}
_ROUNDING = {"floor": "down", "nearest": "to the nearest count", "ceil": "up", "truncate": "towards 0"}


def range_of(values: list[float | int]) -> str:
    """One value, or the smallest and the largest."""
    return " to ".join(dict.fromkeys(short(value) for value in (min(values), max(values))))


def scene_sentences(scene: Scene, axes: Axes) -> list[str]:
    """The parts that a scene has; varied numbers with their range over the grid."""
    return [*_Words(scene, axes).sentences()]


class _Words:
    """The sentences of one scene over one grid."""

    def __init__(self, scene: Scene, axes: Axes) -> None:
        self.scene, self.axes = scene, axes
        self._told: set[str] = set()

    def sentences(self) -> Iterator[str]:
        scene = self.scene
        rubs = "" if self._value("knob.coulomb_torque") else ", no friction"
        knob = self._forms("knob", inertia="inertia {}", damping="damping {}", coulomb_torque="Coulomb friction {}")
        yield f"Knob: {knob}{rubs}."
        yield self._hand()
        if wall := self._value("wall.stiffness"):
            more = self._forms("wall", damping="virtual damping {}")
            yield f"Wall: a spring below the angle 0, {wall}{f'; {more}' if more else ''}."
        yield from self._over_angle()
        yield self._push()
        yield self._sensor()
        yield from self._clock()
        yield from self._motor()
        if scene.controller:
            numbers = [f"{key} {self._plain(f'controller.{key}', value)}" for key, value in _keys(scene.controller)]
            yield f"Controller: {', '.join([scene.controller.kind, *numbers])}."

    def _value(self, path: str) -> str:
        """A number of the scene with its unit, or its range; empty where it is 0 or absent everywhere."""
        self._told.add(path)
        value = value_at(self.scene, path)
        values = self.axes.get(path, [] if value is None else [value])
        if not values or not any(values):
            return ""
        varied = f" ({len(values)} values)" if len(values) > 1 else ""
        unit = _PURE.get(path) or unit_at(Scene, path)
        return f"{range_of(values)}{' ' if unit else ''}{unit}{varied}"

    def _forms(self, part: str, **forms: str) -> str:
        """What is said of the numbers of a part, each in the form for its key; of others, which come last, by the key.

        Those are said that have not been, and have another value than their default.
        """
        said = [form.format(text) for key, form in forms.items() if (text := self._value(f"{part}.{key}"))]
        there = getattr(self.scene, part)
        for key, value in there._asdict().items() if there else ():
            path = f"{part}.{key}"
            differs = path in self.axes or (isinstance(value, float) and value != there._field_defaults.get(key))
            if differs and path not in self._told and (text := self._value(path)):
                said.append(f"{key.replace('_', ' ')} {text}")
        return ", ".join(said)

    def _plain(self, path: str, value: Any) -> str:
        if path in self.axes:
            return range_of(self.axes[path])
        return short(value) if isinstance(value, float) else str(value)

    def _hand(self) -> str:
        hand = self.scene.hand
        if hand is None:
            return "Hand: none; nothing holds the knob."
        if hand.by_person:
            people = len(self.axes.get(PERSON, hand.by_person))
            return f"Hands: {people} of them: {_of_all(hand.by_person)}."
        if self.scene.squeeze:
            friction, margin = self._value("squeeze.friction"), self._value("squeeze.margin")
            scenes = self._squeezes()
            asked, most = range_of(sorted(map(grip_of, scenes))), max(map(left_out, scenes))
            said = f"Hand: measured, at the grip that the push asks for, {asked} N"
            said = f"{said}: {margin} what holds at a friction of {friction}."
            what = " and ".join(self._left_out()).capitalize()
            return f"{said} {what}, left out of it, may change it by up to {short(most)} N." if most else said
        if hand.by_grip and GRIP in self.axes:
            grips = self.axes[GRIP]
            return f"Hand: measured, at a grip of {range_of(grips)} N ({len(grips)} values)."
        if hand.finger:
            finger = self._parts("hand.finger", _GRASP)
            pad = self._parts("hand.fingerpad", ("damping", "stiffness"))
            said = f"Hand: a finger of {finger}; between it and the knob a fingerpad of {pad}"
            return f"{said}. The numbers below take finger and knob as one body."
        numbers = self._parts("hand", _GRASP)
        return f"Hand: {numbers}, turning with the knob." if numbers else "Hand: without inertia, damping or stiffness."

    def _squeezes(self) -> list[Scene]:
        """The scene at the ends of the axes that its grip depends on, and of what is left out of the grip."""
        deciding = (*DECIDING, GRIP, "knob.coulomb_torque", "cogging.torque")
        ends = {name: {min(values), max(values)} for name, values in self.axes.items() if name.startswith(deciding)}
        return [placed(self.scene, dict(zip(ends, values, strict=True))) for values in product(*ends.values())]

    def _left_out(self) -> Iterator[str]:
        """What of the scene the grip at rest leaves out."""
        if self._value("knob.coulomb_torque") or self._value("gear.motor_coulomb_torque"):
            yield "friction of the bearings"
        if self._value("cogging.torque"):
            yield "cogging"

    def _parts(self, path: str, keys: tuple[str, ...]) -> str:
        found = {key: self._value(f"{path}.{key}") for key in keys}
        return ", ".join(f"{key} {text}" for key, text in found.items() if text)

    def _push(self) -> str:
        bias = self.scene.bias
        if bias and bias.half_quantum:
            return "Push: half of the torque step of one count, into the wall."
        push = self._value("bias.torque")
        return (
            f"Push: {push} into the wall."
            if push
            else "Push: none; only the spring of the hand, if any, turns it back."
        )

    def _sensor(self) -> str:
        if self.scene.encoder is None:
            return "Sensor: continuous, without counts."
        encoder = self.scene.encoder
        counts = self.axes.get(COUNTS, [])
        said = f"Encoder: {range_of(counts)} counts per revolution" if counts else "Encoder"
        more = self._forms(
            "encoder",
            offset_counts="edges {} off",
            hysteresis_counts="hysteresis of {}",
            backlash="behind a slack of {}",
        )
        return f"{said}, read {_ROUNDING[encoder.rounding]}{f', {more}' if more else ''}."

    def _clock(self) -> Iterator[str]:
        rates = self.axes.get(RATE, [])
        if not self.scene.sampled:
            yield "Clock: none; the torque follows at once."
        elif rates:
            share = self._value("clock.jitter")
            drawn = f", each interval shorter or longer by up to {share}" if share else ""
            yield f"Clock: {range_of(rates)} Hz{drawn}; the torque is held from sample to sample."
        if found := self._forms(
            "actuator",
            delay_samples="delay of {}",
            time_constant="lag of {}",
            torque_limit="torque up to {}",
            dead_band="no torque below {}",
            torque_step="torque in steps of {}",
        ):
            yield f"Actuator: {found}."

    def _motor(self) -> Iterator[str]:
        if motor := self.scene.motor:
            found = self._forms(
                "motor",
                torque_constant="Kt {}",
                resistance="R {}",
                inductance="L {}",
                bandwidth="a bandwidth of {}",
                supply_voltage="at most {}",
            )
            yield f"Motor: {_WINDINGS[motor.winding]}, {found}."
        if torque := self._value("cogging.torque"):
            places = self._value("cogging.per_revolution")
            centre = self._value("cogging.centre")
            at = f", one of them at {centre}" if centre else ""
            yield f"Cogging: up to {torque} toward {places} of the motor{at}; a triangle wave."
        if self.scene.gear:
            yield f"Gear: {self._gear()}; encoder and actuator are on the motor's shaft."
        if self.scene.eddy_brake:
            yield f"Eddy brake: {self._value('eddy_brake.flux_density')} through a disc that turns with the knob."

    def _gear(self) -> str:
        """What the gear has; ratio first."""
        return self._forms(
            "gear",
            ratio="the motor turns {} times as far as the knob",
            motor_inertia="inertia of the motor {}",
            motor_damping="damping {}",
            motor_coulomb_torque="friction {}",
            stiffness="a mesh of stiffness {} at the knob",
            mesh_damping="with a damping of {}",
            backlash="teeth with a backlash of {} at the knob",
        )

    def _over_angle(self) -> Iterator[str]:
        scene = self.scene
        if scene.profile:
            ends = [1e3 * angle for angle, _ in scene.profile.points]
            torques = [torque for _, torque in scene.profile.points]
            again = ", again and again" if scene.profile.periodic else ""
            yield (
                f"Profile: {len(torques)} points from {short(ends[0])} to {short(ends[-1])} mrad{again}, torques of "
                f"{range_of(torques)} N*m, {scene.profile.interpolation}."
            )
        if detents := scene.detents:
            spacing = detents.spacing or 2.0 * pi / (detents.per_revolution or 1)
            torque = self._value("detents.torque") or "0 N*m"
            yield f"Detents: every {short(1e3 * spacing)} mrad, {torque} at most, of shape {detents.shape}."
        if stops := scene.end_stops:
            ends_of = {"below": stops.low, "above": stops.high}
            where = " and ".join(f"{side} {short(1e3 * at)} mrad" for side, at in ends_of.items() if at is not None)
            yield f"End stops: a spring of {self._value('end_stops.stiffness')} {where}."
        if zone := scene.dead_zone:
            yield (
                f"Dead zone: {short(1e3 * zone.width)} mrad wide about {short(1e3 * zone.centre)} mrad; a spring of "
                f"{self._value('dead_zone.stiffness')} outside of it."
            )


def _of_all(hands: tuple[Hand, ...]) -> str:
    """Ranges of the numbers of many hands."""
    found = {key: [getattr(one, key) for one in hands] for key in _GRASP}
    return ", ".join(f"{key} {range_of(values)} {unit_at(Hand, key)}" for key, values in found.items() if any(values))


def _keys(controller: Any) -> Iterator[tuple[str, Any]]:
    from hknob_cli.specs.controller import KINDS

    yield from ((key, getattr(controller, key)) for key in KINDS[controller.kind].keys)


class Explained(NamedTuple):
    """What a spec describes: its ``kind``, ``name``, and the ``answer`` in a sentence.

    ``sections``: sentences by title; ``numbers``: what follows from a scene; ``next``: the command to run then.
    """

    kind: str
    name: str
    answer: str
    sections: dict[str, list[str]]
    numbers: list[Number]
    next: str


def as_data(found: Explained) -> dict[str, Any]:
    """The same as plain data, numbers in SI units."""
    numbers = [
        {"name": one.name, "unit": one.unit, "least": one.least, "largest": one.largest, "means": one.means}
        for one in found.numbers
    ]
    sections = {title.replace(" ", "_"): lines for title, lines in found.sections.items()}
    return {"kind": found.kind, "name": found.name, "answer": found.answer, **sections, "numbers": numbers}


def explained_text(found: Explained) -> str:
    """The same for the terminal."""
    lines = [found.answer]
    for title, said in found.sections.items():
        if said:
            lines += ["", f"{title[0].upper()}{title[1:]}:", *(f"  {line}" for line in said)]
    if found.numbers:
        lines += ["", "What follows:", *(f"  {one.name}: {one.text} ({one.means})" for one in found.numbers)]
    return folded("\n".join([*lines, "", f"next: {found.next}"]))
