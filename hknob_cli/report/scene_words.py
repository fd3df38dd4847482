"""The parts of a scene in plain words: a sentence each, with SI values and units, and what varies over the grid."""

from collections.abc import Iterator
from itertools import product
from math import pi
from typing import Any

from hknob_cli.report.table import short
from hknob_cli.specs.plan import COUNTS, GRIP, PERSON, RATE, Axes, Hand, Scene, placed
from hknob_cli.specs.squeeze import DECIDING, grip_of, left_out

_UNITS = {"inertia": "kg*m^2", "damping": "N*m*s/rad", "stiffness": "N*m/rad"}
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

    def sentences(self) -> Iterator[str]:
        scene = self.scene
        friction = self._value("knob.coulomb_torque", "N*m")
        knob = [
            f"inertia {self._value('knob.inertia', 'kg*m^2')}",
            f"damping {self._value('knob.damping', 'N*m*s/rad')}",
        ]
        knob.append(f"Coulomb friction {friction}" if friction else "no friction")
        yield f"Knob: {', '.join(part for part in knob if not part.endswith(' '))}."
        yield self._hand()
        if wall := self._value("wall.stiffness", "N*m/rad"):
            damping = self._value("wall.damping", "N*m*s/rad")
            yield f"Wall: a spring below the angle 0, {wall}{f'; virtual damping {damping}' if damping else ''}."
        yield from self._over_angle()
        yield self._push()
        yield self._sensor()
        yield from self._clock()
        yield from self._motor()
        if scene.controller:
            numbers = [f"{key} {self._plain(f'controller.{key}', value)}" for key, value in _keys(scene.controller)]
            yield f"Controller: {', '.join([scene.controller.kind, *numbers])}."

    def _value(self, path: str, unit: str) -> str:
        """A number of the scene with its unit, or its range; empty where it is 0 or absent everywhere."""
        value: Any = self.scene
        for step in path.split("."):
            value = getattr(value, step, None)
        values = self.axes.get(path, [] if value is None else [value])
        if not values or not any(values):
            return ""
        varied = f" ({len(values)} values)" if len(values) > 1 else ""
        return f"{range_of(values)} {unit}{varied}"

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
            friction, margin = self._value("squeeze.friction", ""), self._value("squeeze.margin", "times")
            scenes = self._squeezes()
            asked, most = range_of(sorted(map(grip_of, scenes))), max(map(left_out, scenes))
            said = f"Hand: measured, at the grip that the push asks for, {asked} N"
            said = f"{said}: {margin} what holds at a friction of {friction.strip()}."
            what = " and ".join(self._left_out()).capitalize()
            return f"{said} {what}, left out of it, may change it by up to {short(most)} N." if most else said
        if hand.by_grip and GRIP in self.axes:
            grips = self.axes[GRIP]
            return f"Hand: measured, at a grip of {range_of(grips)} N ({len(grips)} values)."
        if hand.finger:
            finger = self._parts("hand.finger", tuple(_UNITS))
            pad = self._parts("hand.fingerpad", ("damping", "stiffness"))
            said = f"Hand: a finger of {finger}; between it and the knob a fingerpad of {pad}"
            return f"{said}. The numbers below take finger and knob as one body."
        numbers = self._parts("hand", tuple(_UNITS))
        return f"Hand: {numbers}, turning with the knob." if numbers else "Hand: without inertia, damping or stiffness."

    def _squeezes(self) -> list[Scene]:
        """The scene at the ends of the axes that its grip depends on, and of what is left out of the grip."""
        deciding = (*DECIDING, GRIP, "knob.coulomb_torque", "cogging.torque")
        ends = {name: {min(values), max(values)} for name, values in self.axes.items() if name.startswith(deciding)}
        return [placed(self.scene, dict(zip(ends, values, strict=True))) for values in product(*ends.values())]

    def _left_out(self) -> Iterator[str]:
        """What of the scene the grip at rest leaves out."""
        if self._value("knob.coulomb_torque", "") or self._value("gear.motor_coulomb_torque", ""):
            yield "friction of the bearings"
        if self._value("cogging.torque", ""):
            yield "cogging"

    def _parts(self, path: str, keys: tuple[str, ...]) -> str:
        found = {key: self._value(f"{path}.{key}", _UNITS[key]) for key in keys}
        return ", ".join(f"{key} {text}" for key, text in found.items() if text)

    def _push(self) -> str:
        bias = self.scene.bias
        if bias and bias.half_quantum:
            return "Push: half of the torque step of one count, into the wall."
        push = self._value("bias.torque", "N*m")
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
        offset = self._value("encoder.offset_counts", "counts")
        parts = [said, f"read {_ROUNDING[encoder.rounding]}"]
        parts += [f"edges {offset} off"] if offset else []
        if hysteresis := self._value("encoder.hysteresis_counts", "counts"):
            parts.append(f"hysteresis of {hysteresis}")
        if slack := self._value("encoder.backlash", "rad"):
            parts.append(f"behind a slack of {slack}")
        return f"{', '.join(parts)}."

    def _clock(self) -> Iterator[str]:
        rates = self.axes.get(RATE, [])
        if not self.scene.sampled:
            yield "Clock: none; the torque follows at once."
        elif rates:
            share = self._value("clock.jitter", "of it")
            drawn = f", each interval shorter or longer by up to {share}" if share else ""
            yield f"Clock: {range_of(rates)} Hz{drawn}; the torque is held from sample to sample."
        named = {
            "delay of {}": ("actuator.delay_samples", "samples"),
            "lag of {}": ("actuator.time_constant", "s"),
            "torque up to {}": ("actuator.torque_limit", "N*m"),
            "no torque below {}": ("actuator.dead_band", "N*m"),
            "torque in steps of {}": ("actuator.torque_step", "N*m"),
        }
        found = [form.format(text) for form, (path, unit) in named.items() if (text := self._value(path, unit))]
        if found:
            yield f"Actuator: {', '.join(found)}."

    def _motor(self) -> Iterator[str]:
        if motor := self.scene.motor:
            named = {
                "Kt {}": ("torque_constant", "N*m/A"),
                "R {}": ("resistance", "ohm"),
                "L {}": ("inductance", "H"),
                "a bandwidth of {}": ("bandwidth", "Hz"),
                "at most {}": ("supply_voltage", "V"),
            }
            found = [
                form.format(text) for form, (key, unit) in named.items() if (text := self._value(f"motor.{key}", unit))
            ]
            yield f"Motor: {_WINDINGS[motor.winding]}, {', '.join(found)}."
        if torque := self._value("cogging.torque", "N*m"):
            places = self._value("cogging.per_revolution", "places of rest in a turn")
            centre = self._value("cogging.centre", "rad")
            at = f", one of them at {centre}" if centre else ""
            yield f"Cogging: up to {torque} toward {places} of the motor{at}; a triangle wave."
        if self.scene.gear:
            yield f"Gear: {self._gear()}; encoder and actuator are on the motor's shaft."
        if self.scene.eddy_brake:
            yield f"Eddy brake: {self._value('eddy_brake.flux_density', 'T')} through a disc that turns with the knob."

    def _gear(self) -> str:
        """What the gear has; ratio first."""
        named = {
            "the motor turns {} times as far as the knob": ("ratio", ""),
            "inertia of the motor {}": ("motor_inertia", "kg*m^2"),
            "damping {}": ("motor_damping", "N*m*s/rad"),
            "friction {}": ("motor_coulomb_torque", "N*m"),
            "a mesh of stiffness {} at the knob": ("stiffness", "N*m/rad"),
            "with a damping of {}": ("mesh_damping", "N*m*s/rad"),
            "teeth with a backlash of {} at the knob": ("backlash", "rad"),
        }
        found = [
            form.format(text.strip())
            for form, (key, unit) in named.items()
            if (text := self._value(f"gear.{key}", unit))
        ]
        return ", ".join(found)

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
            torque = self._value("detents.torque", "N*m") or "0 N*m"
            yield f"Detents: every {short(1e3 * spacing)} mrad, {torque} at most, of shape {detents.shape}."
        if stops := scene.end_stops:
            ends_of = {"below": stops.low, "above": stops.high}
            where = " and ".join(f"{side} {short(1e3 * at)} mrad" for side, at in ends_of.items() if at is not None)
            yield f"End stops: a spring of {self._value('end_stops.stiffness', 'N*m/rad')} {where}."
        if zone := scene.dead_zone:
            yield (
                f"Dead zone: {short(1e3 * zone.width)} mrad wide about {short(1e3 * zone.centre)} mrad; a spring of "
                f"{self._value('dead_zone.stiffness', 'N*m/rad')} outside of it."
            )


def _of_all(hands: tuple[Hand, ...]) -> str:
    """Ranges of the numbers of many hands."""
    found = {key: [getattr(one, key) for one in hands] for key in _UNITS}
    return ", ".join(f"{key} {range_of(values)} {_UNITS[key]}" for key, values in found.items() if any(values))


def _keys(controller: Any) -> Iterator[tuple[str, Any]]:
    from hknob_cli.specs.controller import KINDS

    yield from ((key, getattr(controller, key)) for key in KINDS[controller.kind].keys)
