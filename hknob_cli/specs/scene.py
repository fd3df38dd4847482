"""The scene: what exists between hand, knob, encoder, wall and actuator. What is not listed does not exist.

Source of the parts: Hasser, sections 6.3-6.4 (Fig. 27, Table 7). SI units throughout.
"""

from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Discriminator, Field, Tag, model_validator
from pydantic_core import PydanticCustomError

from hknob_cli.specs import plan
from hknob_cli.specs.controller import ControllerSpec, controller_contradictions
from hknob_cli.specs.hand import HandSpec, hand_contradictions
from hknob_cli.specs.part import Part as Part
from hknob_cli.specs.part import Place
from hknob_cli.specs.quantity import Damping, Inertia, Seconds, Stiffness, Torque


def _sensor(value: Any) -> Any:
    """Which form of encoder this is; picks the model that validates it."""
    return "none" if isinstance(value, str) else "encoder"


class KnobSpec(Part):
    """The device: what turns, felt without any control."""

    inertia: Annotated[Inertia, Field(description="moment of inertia of knob and motor")]
    damping: Annotated[Damping, Field(description="viscous damping of the device")] = 0.0
    coulomb_torque: Annotated[Torque, Field(description="Coulomb friction level, with stick")] = 0.0


class WallSpec(Part):
    """The virtual wall: a spring for measured angles below 0, nothing above."""

    stiffness: Annotated[Stiffness, Field(description="virtual stiffness")]
    damping: Annotated[Damping, Field(description="virtual, on the differenced measured angle")] = 0.0


class BiasSpec(Part):
    """The user's constant push into the wall: a torque, or half the torque step of one count."""

    model_config = ConfigDict(
        json_schema_extra={"oneOf": [{"required": ["torque"]}, {"required": ["half_quantum"]}]},
    )

    torque: Annotated[Torque | None, Field(description="constant torque into the wall")] = None
    half_quantum: Annotated[
        Literal[True] | None, Field(description="true: half of wall stiffness times one count (Hasser, sec. 7.2)")
    ] = None

    @model_validator(mode="after")
    def _one_of(self) -> "BiasSpec":
        if (self.torque is None) == (self.half_quantum is None):
            raise PydanticCustomError("one_of", "must have exactly one of 'torque' and 'half_quantum'")
        return self


class EncoderSpec(Part):
    """The angle sensor: reports the edge of a count that ``rounding`` picks."""

    rounding: Annotated[
        Literal["floor", "nearest", "ceil", "truncate"],
        Field(description="which count a position is read as; floor is Hasser's"),
    ] = "floor"
    offset_counts: Annotated[
        float,
        Field(
            strict=True,
            ge=0,
            lt=1,
            allow_inf_nan=False,
            description="encoder edges lie this part of a count above the wall's edge and its multiples",
        ),
    ] = 0.0


class ActuatorSpec(Part):
    """From command to torque."""

    delay_samples: Annotated[
        float,
        Field(strict=True, ge=0, le=1000, allow_inf_nan=False, description="transport delay in sample periods"),
    ] = 0.0
    time_constant: Annotated[Seconds, Field(description="of the lag from command to torque, first order")] = 0.0
    torque_limit: Annotated[Torque | None, Field(description="saturation of the torque; null: none")] = None
    torque_step: Annotated[
        Torque, Field(description="D/A step, to whole multiples of which a command is rounded; 0: none")
    ] = 0.0


class SceneSpec(Part):
    """Knob and wall, and whatever else is listed."""

    knob: KnobSpec
    wall: WallSpec
    hand: HandSpec | None = None
    bias: BiasSpec | None = None
    encoder: Annotated[
        Annotated[EncoderSpec, Tag("encoder")] | Annotated[Literal["none"], Tag("none")],
        Discriminator(_sensor),
        Field(default_factory=EncoderSpec, description="none: a continuous sensor"),
    ]
    actuator: ActuatorSpec | None = None
    controller: ControllerSpec | None = None
    sampling: Annotated[
        Literal["zero_order_hold", "continuous"],
        Field(description="how the controller acts in time; continuous: without a sample clock, at once"),
    ] = "zero_order_hold"

    def plain(self) -> plan.Scene:
        """The scene as plain values."""
        return plan.Scene(
            knob=plan.Knob(**dict(self.knob)),
            wall=plan.Wall(**dict(self.wall)),
            hand=self.hand.plain() if self.hand else None,
            bias=plan.Bias(**dict(self.bias)) if self.bias else None,
            encoder=plan.Encoder(**dict(self.encoder)) if isinstance(self.encoder, EncoderSpec) else None,
            actuator=plan.Actuator(**dict(self.actuator)) if self.actuator else None,
            sampled=self.sampling == "zero_order_hold",
            controller=self.controller.plain() if self.controller else None,
        )


def given(scene: SceneSpec, axes: plan.Axes, path: str) -> list[tuple[str, ...]]:
    """Places in the spec where the value at ``path``, a part and a key, is other than if it were not listed."""
    part, key = path.split(".")
    model = getattr(scene, part)
    places: list[tuple[str, ...]] = []
    if model is None or model == "none":
        return places
    absent = type(model).model_fields[key].default
    if getattr(model, key) != absent:
        places.append(("scene", part, key))
    elif isinstance(model, HandSpec) and model.measured and getattr(model.plain(), key) != absent:
        places.append(("scene", part, model.measured))
    if any(value != absent for value in axes.get(path, [])):
        places.append(("grid", path))
    return places


def contradictions(scene: SceneSpec, axes: plan.Axes) -> list[tuple[Place, str]]:
    """What in a scene, with its grid, excludes something else: places in the spec, and what is wrong there."""
    found: list[tuple[Place, str]] = []
    if scene.bias and scene.bias.half_quantum and scene.encoder == "none":
        found.append((("scene", "bias", "half_quantum"), "must be absent where encoder is none: it has no count"))
    if scene.hand and scene.hand.finger:
        for key in ("inertia", "damping", "stiffness"):
            if f"hand.{key}" in axes:
                found.append((("grid", f"hand.{key}"), "must be absent where the hand has a finger"))
    found += hand_contradictions(scene.hand, scene.knob.inertia, axes)
    if scene.controller:
        found += controller_contradictions(scene.controller, axes)
        found += _beside_controller(scene, axes)
    if scene.sampling == "continuous":
        needs_clock = {
            ("wall", "damping"): "virtual damping needs samples to difference",
            ("actuator", "delay_samples"): "a delay in samples needs a sample clock",
            ("actuator", "time_constant"): "actuator lag is not in a continuous controller",
            ("actuator", "torque_step"): "a torque step is not in a continuous controller",
            ("actuator", "torque_limit"): "a torque limit is not in a continuous controller",
        }
        for path, why in needs_clock.items():
            for place in given(scene, axes, ".".join(path)):
                found.append((place, f"must be absent where sampling is continuous: {why}"))
        if scene.hand and scene.hand.finger:
            found.append((("scene", "hand", "finger"), "must be absent where sampling is continuous"))
    return found


def _beside_controller(scene: SceneSpec, axes: plan.Axes) -> list[tuple[Place, str]]:
    """Parts of a scene that no controller has been built for."""
    found: list[tuple[Place, str]] = []
    for path in (
        "knob.coulomb_torque",
        "wall.damping",
        "hand.finger",
        "actuator.delay_samples",
        "actuator.time_constant",
        "actuator.torque_step",
    ):
        found += [(place, "must be absent where a controller is given") for place in given(scene, axes, path)]
    if scene.encoder == "none":
        found.append((("scene", "encoder"), "must be absent where a controller is given: it reads counts"))
    if scene.sampling == "continuous":
        found.append((("scene", "sampling"), "must be absent where a controller is given: it has a sample clock"))
    if min(axes.get("wall.stiffness", [scene.wall.stiffness])) == 0.0:
        found.append((("scene", "wall", "stiffness"), "must be > 0 where a controller is given"))
    return found
