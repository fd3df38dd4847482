"""The scene of a spec, where it is written in another way than used, and its faults that no part shows by itself.

Its parts are those of `specs.parts`. Written in another way are a hand from a table or file, an encoder that is
``none``, and how the controller is sampled. Faults are of a scene with its grid: of a motor, a gear, a grip that
follows the push, a controller's velocity, and a torque over the angle; what a part excludes, and what excludes it.
`refusals` has those that follow from the table of `capabilities`.
"""

from collections.abc import Iterator
from math import pi
from typing import Annotated, Any, Literal, Self

from pydantic import Discriminator, Field, ModelWrapValidatorHandler, PrivateAttr, Tag, model_validator

from hknob_cli.specs.controller import MODELLED, Controller
from hknob_cli.specs.drive import BESIDE_SUPPLY
from hknob_cli.specs.hand import HandSpec
from hknob_cli.specs.over_angle import OVER_ANGLE, Detents, EndStops, ways_round
from hknob_cli.specs.part import Part as Part
from hknob_cli.specs.part import Place, model_with_fields
from hknob_cli.specs.parts import Encoder, Scene, Squeeze
from hknob_cli.specs.plan import COUNTS, RATE, Axes


def _sensor(value: Any) -> Any:
    """Which form of encoder this is; picks the model that validates it."""
    return "none" if isinstance(value, str) else "encoder"


def _wall_or_another(schema: dict[str, Any]) -> None:
    """Say in the JSON Schema that a scene has a wall, or another torque over the angle."""
    schema["required"].remove("wall")
    schema["anyOf"] = [{"required": [name]} for name in ("wall", *OVER_ANGLE)]


_Listed = model_with_fields(
    Scene, "Listed", but=("sampled", "coil", "turns", "behind", "play"), json_schema_extra=_wall_or_another
)


class SceneSpec(_Listed):  # type: ignore[misc, valid-type]
    """Knob and wall, and whatever else is listed."""

    hand: HandSpec | None = None
    encoder: Annotated[
        Annotated[Encoder, Tag("encoder")] | Annotated[Literal["none"], Tag("none")],
        Discriminator(_sensor),
        Field(default_factory=Encoder, description="none: a continuous sensor"),
    ]
    sampling: Annotated[
        Literal["zero_order_hold", "continuous"],
        Field(description="how the controller acts in time; continuous: without a sample clock, at once"),
    ] = "zero_order_hold"

    _given: frozenset[str] = PrivateAttr(default=frozenset())

    @model_validator(mode="wrap")
    @classmethod
    def _keep_given(cls, value: Any, read: ModelWrapValidatorHandler[Self]) -> Self:
        if isinstance(value, dict) and "wall" not in value and any(value.get(name) for name in OVER_ANGLE):
            value = {**value, "wall": {"stiffness": 0.0}}
        made = read(value)
        made._given = frozenset(value["controller"]) if made.controller else frozenset()
        return made

    @property
    def given(self) -> frozenset[str]:
        """Keys of the controller that are listed, if only at their defaults."""
        return self._given

    def plain(self) -> Scene:
        """The scene as plain values."""
        parts: dict[str, Any] = {key: getattr(self, key, Scene._field_defaults.get(key)) for key in Scene._fields}
        parts["hand"] = self.hand.plain() if self.hand else None
        parts["encoder"] = None if isinstance(self.encoder, str) else self.encoder
        parts["sampled"] = self.sampling == "zero_order_hold"
        return Scene(**parts)


def motor_contradictions(scene: SceneSpec, axes: Axes) -> Iterator[tuple[Place, str]]:
    """Places in the spec, and what is wrong there."""
    motor = scene.motor
    if motor is None:
        return

    def asked(path: str, absent: float | None) -> bool:
        part, key = path.split(".")
        model = getattr(scene, part)
        return path in axes or (model is not None and getattr(model, key) != absent)

    inductive = motor.winding == "voltage" and asked("motor.inductance", 0.0)
    lag = "motor.inductance" if inductive else "motor.bandwidth" if asked("motor.bandwidth", None) else ""
    if lag and asked("actuator.time_constant", 0.0):
        what = "L/R of the winding" if inductive else "the current loop"
        yield ("scene", "actuator", "time_constant"), f"must be absent beside {lag}: {what} is the lag"
    if asked("motor.supply_voltage", None) and asked("actuator.torque_limit", None):
        yield ("scene", "actuator", "torque_limit"), BESIDE_SUPPLY
    for key, windings in (
        ("inductance", ("shorted", "voltage")),
        ("bandwidth", ("current",)),
        ("supply_voltage", ("voltage",)),
    ):
        if f"motor.{key}" in axes and motor.winding not in windings:
            yield ("grid", f"motor.{key}"), f"must be absent where winding is {motor.winding}"


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


DIFFERENCED = ("differenced", "sensor")  # what every kind with a velocity has
# Numbers of velocity_damping, the velocities that they are of, and what these are called in a fault.
VELOCITIES_OF = {
    "window": (("differenced", "adaptive"), "the differenced velocity"),
    "low_pass": (("differenced", "timed", "adaptive"), "the differenced velocity"),
    "time_out": (("timed",), "velocity: timed"),
    "detections": (("timed",), "velocity: timed"),
    "bandwidth": (("tracking",), "velocity: tracking"),
    "acceleration": (("kalman",), "velocity: kalman"),
}


def velocity_contradictions(spec: Controller, given: frozenset[str], axes: Axes) -> list[tuple[Place, str]]:
    """Faults of a controller with a velocity: their places in the spec, and what is wrong; ``given``: its keys."""
    where = f"where velocity is {spec.velocity}"
    if spec.kind != "velocity_damping":
        if spec.velocity in DIFFERENCED:
            return []
        return [(("scene", "controller", "velocity"), f"must be differenced or sensor where kind is {spec.kind}")]
    found: list[tuple[Place, str]] = []

    def values(key: str) -> list[float]:
        return list(axes.get(f"controller.{key}", [getattr(spec, key)]))

    def place(key: str) -> Place:
        return ("grid", f"controller.{key}") if f"controller.{key}" in axes else ("scene", "controller", key)

    for key, (velocities, name) in VELOCITIES_OF.items():
        there = key in given or f"controller.{key}" in axes
        if there and spec.velocity not in velocities:
            found.append((place(key), f"must be absent {where}: it is of {name}"))
    if spec.velocity == "adaptive" and min(values("window")) < 2:
        at = place("window") if "window" in given or "controller.window" in axes else ("scene", "controller")
        found.append((at, f"must have a window of 2 samples or more {where}: one has one line only"))
    if spec.velocity == "kalman" and "acceleration" not in given and "controller.acceleration" not in axes:
        found.append((("scene", "controller"), f"must have an acceleration {where}"))
    if spec.velocity == "tracking":
        if "bandwidth" not in given and "controller.bandwidth" not in axes:
            found.append((("scene", "controller"), f"must have a bandwidth {where}"))
        elif RATE in axes and not 2.0 * max(values("bandwidth")) < min(axes[RATE]):
            slowest = min(axes[RATE])
            found.append(
                (
                    place("bandwidth"),
                    f"must be < {slowest / 2.0:g} rad/s at {slowest:g} Hz, got {max(values('bandwidth')):g}: "
                    "the filter is stable where it is less than half the sample rate",
                )
            )
    if spec.angle == "filtered" and spec.velocity not in ("tracking", "kalman") and max(values("low_pass")) == 0.0:
        message = "must be counted where nothing filters: give a low_pass, or velocity: tracking or kalman"
        found.append((("scene", "controller", "angle"), message))
    return found


LEAST_COUNTS = 2  # of a detent: one, and all its counts are alike


def over_angle_contradictions(scene: SceneSpec, axes: Axes) -> list[tuple[Place, str]]:
    """Places in the spec, and what is wrong there."""
    there = [name for name in OVER_ANGLE if getattr(scene, name)]
    if not there:
        return []
    found: list[tuple[Place, str]] = []
    if scene.bias and scene.bias.half_quantum and max(axes.get("wall.stiffness", [scene.wall.stiffness])) == 0.0:
        found.append(
            (("scene", "bias", "half_quantum"), "must be absent without a wall: it is half the step of its torque")
        )
    if scene.detents:
        found += _of_detents(scene.detents, axes)
    if scene.end_stops:
        found += _of_stops(scene.end_stops, axes)
    return found


def _place(axes: Axes, part: str, key: str) -> Place:
    """Where a number stands: in the grid, or in the scene."""
    return ("grid", f"{part}.{key}") if f"{part}.{key}" in axes else ("scene", part, key)


def _of_detents(part: Detents, axes: Axes) -> Iterator[tuple[Place, str]]:
    """Detents finer than counts, a spacing that does not go round, or a zone as wide as a detent."""
    counts = min(axes.get(COUNTS, [10**12]))
    if part.per_revolution and part.per_revolution * LEAST_COUNTS > counts:
        yield (
            ("scene", "detents", "per_revolution"),
            f"must be at most {int(counts) // LEAST_COUNTS}, one for every {LEAST_COUNTS} of {int(counts)} counts, got "
            f"{part.per_revolution}",
        )
    if part.per_revolution:
        spacings = [2.0 * pi / part.per_revolution]
    else:
        spacings = [float(value) for value in axes.get("detents.spacing", [part.spacing or 1.0])]
    place = _place(axes, "detents", "spacing")
    least = LEAST_COUNTS * 2.0 * pi / counts
    if not part.per_revolution and min(spacings) < least * (1.0 - 1e-9):
        said = f", {LEAST_COUNTS} of {int(counts)} counts" if COUNTS in axes else ""
        yield place, f"must be at least {least:.6g} rad{said}, got {min(spacings):g}"
    if part.range is None:
        for value in spacings:
            ways = ways_round(value)
            if ways is None or ways[1] != 1:
                yield (
                    place,
                    f"must be a whole part of a revolution, 2 pi / n, where there is no range, got {value:.12g}",
                )
    zone = max(axes.get("detents.dead_zone", [part.dead_zone]))
    if not zone < min(spacings):
        yield (
            _place(axes, "detents", "dead_zone"),
            f"must be below the spacing of the detents, {min(spacings):g} rad, got {zone:g}",
        )
    if part.shape != "spring" and "detents.dead_zone" in axes:
        yield ("grid", "detents.dead_zone"), f"must be absent where shape is {part.shape}: it is of shape spring"
    if part.per_revolution and "detents.spacing" in axes:
        yield ("grid", "detents.spacing"), "must be absent where per_revolution is given"


def _of_stops(part: EndStops, axes: Axes) -> Iterator[tuple[Place, str]]:
    """Stops that are in the wrong order somewhere in the grid."""
    lows = [value for value in axes.get("end_stops.low", [part.low]) if value is not None]
    highs = [value for value in axes.get("end_stops.high", [part.high]) if value is not None]
    if lows and highs and not max(lows) < min(highs):
        key = "low" if "end_stops.low" in axes else "high"
        yield (
            _place(axes, "end_stops", key),
            f"low must be below high all over the grid, got {max(lows):g} and {min(highs):g}",
        )
