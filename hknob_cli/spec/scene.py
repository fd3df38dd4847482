"""The scene: what exists between hand, knob, encoder, wall and actuator. What is not listed does not exist.

Source of the parts: Hasser, sections 6.3-6.4 (Fig. 27, Table 7). SI units throughout.
"""

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag, model_validator
from pydantic_core import PydanticCustomError

from hknob_cli.spec import plan
from hknob_cli.spec.grip import Grip
from hknob_cli.spec.quantity import AddedInertia, Damping, Inertia, Seconds, Stiffness, Torque


class Part(BaseModel):
    """A piece of a spec: immutable, no unknown keys."""

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)


_GIVEN_BY_TABLE = ("inertia", "damping", "stiffness", "finger", "fingerpad")


def _sensor(value: Any) -> Any:
    """Which form of encoder this is; picks the model that validates it."""
    return "none" if isinstance(value, str) else "encoder"


class KnobSpec(Part):
    """The device: what turns, felt without any control."""

    inertia: Annotated[Inertia, Field(description="moment of inertia of knob and motor")]
    damping: Annotated[Damping, Field(description="viscous damping of the device")] = 0.0
    coulomb_torque: Annotated[Torque, Field(description="Coulomb friction level, with stick")] = 0.0


class FingerSpec(Part):
    """The finger: a body of its own, sprung and damped to ground (J1, B1, K1 of Hasser, Fig. 13)."""

    inertia: Annotated[Inertia, Field(description="moment of inertia of the fingers about the knob's axis")]
    damping: Annotated[Damping, Field(description="damping of the fingers, to ground")] = 0.0
    stiffness: Annotated[Stiffness, Field(description="stiffness of the fingers, to ground")] = 0.0


class FingerpadSpec(Part):
    """The fingerpad: spring and damper between finger and knob (B2, K2 of Hasser, Fig. 13)."""

    damping: Annotated[Damping, Field(description="damping of the fingerpads")] = 0.0
    stiffness: Annotated[Stiffness, Field(description="stiffness of the fingerpads")] = 0.0


class HandSpec(Part):
    """The hand on the knob; its neutral angle is 0.

    Second order, moving with the knob, by ``inertia``, ``damping`` and ``stiffness``, or by ``table`` and ``grip_n``
    as measured; or fourth order, by ``finger`` and ``fingerpad``.
    """

    model_config = ConfigDict(
        json_schema_extra={
            "dependentRequired": {"table": ["grip_n"], "grip_n": ["table"]},
            "dependentSchemas": {"table": {"properties": dict.fromkeys(_GIVEN_BY_TABLE, False)}},
        },
    )

    inertia: Annotated[AddedInertia, Field(description="moment of inertia the grasp adds")] = 0.0
    damping: Annotated[Damping, Field(description="damping of the grasp")] = 0.0
    stiffness: Annotated[Stiffness, Field(description="stiffness of the grasp")] = 0.0
    finger: FingerSpec | None = None
    fingerpad: FingerpadSpec | None = None
    table: Annotated[
        Literal[1, 2, 3, 4, 5] | None,
        Field(
            description="Hasser's hand models, without the apparatus: 1 simple and 2 key pinch of a 17.8 mm knob;"
            " 3 simple, 4 key pinch and 5 three fingers of a 29.9 mm knob"
        ),
    ] = None
    grip_n: Annotated[Grip | None, Field(description="row of the table: its grip force")] = None

    @model_validator(mode="after")
    def _one_order(self) -> "HandSpec":
        if (self.table is None) != (self.grip_n is None):
            raise PydanticCustomError("two_keys", "must have both 'table' and 'grip_n', or neither")
        if (self.finger is None) != (self.fingerpad is None):
            raise PydanticCustomError("two_parts", "must have both 'finger' and 'fingerpad', or neither")
        if self.finger and (self.inertia or self.damping or self.stiffness):
            raise PydanticCustomError(
                "two_hands", "must have 'finger' and 'fingerpad', or inertia, damping and stiffness, not both"
            )
        return self

    def plain(self) -> plan.Hand:
        """The hand as plain values."""
        if self.table is not None and self.grip_n is not None:
            from hknob_cli.printed.hands import grasps

            by_grip = {grasp.grip_n: plan.Hand(*grasp[1:]) for grasp in grasps(self.table)}
            return by_grip[self.grip_n]._replace(by_grip=tuple(by_grip.items()))
        return plan.Hand(
            inertia=self.inertia,
            damping=self.damping,
            stiffness=self.stiffness,
            finger=plan.Finger(**dict(self.finger)) if self.finger else None,
            fingerpad=plan.Fingerpad(**dict(self.fingerpad)) if self.fingerpad else None,
        )


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
    elif isinstance(model, HandSpec) and model.table is not None and getattr(model.plain(), key) != absent:
        places.append(("scene", part, "table"))
    if any(value != absent for value in axes.get(path, [])):
        places.append(("grid", path))
    return places


def contradictions(scene: SceneSpec, axes: plan.Axes) -> list[tuple[tuple[str, ...], str]]:
    """What in a scene, with its grid, excludes something else: places in the spec, and what is wrong there."""
    found: list[tuple[tuple[str, ...], str]] = []
    if scene.bias and scene.bias.half_quantum and scene.encoder == "none":
        found.append((("scene", "bias", "half_quantum"), "must be absent where encoder is none: it has no count"))
    if scene.hand and scene.hand.finger:
        for key in ("inertia", "damping", "stiffness"):
            if f"hand.{key}" in axes:
                found.append((("grid", f"hand.{key}"), "must be absent where the hand has a finger"))
    found += _hand_of_table(scene, axes)
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


def _hand_of_table(scene: SceneSpec, axes: plan.Axes) -> list[tuple[tuple[str, ...], str]]:
    """What contradicts a hand that is a row of a printed table: other keys, and a knob too light for it."""
    found: list[tuple[tuple[str, ...], str]] = []
    if scene.hand is None or scene.hand.table is None or scene.hand.grip_n is None:
        if plan.GRIP in axes:
            found.append((("grid", plan.GRIP), "must be absent where the hand has no table"))
        return found
    for key in _GIVEN_BY_TABLE:
        if key in scene.hand.model_fields_set and getattr(scene.hand, key) is not None:
            found.append((("scene", "hand", key), "must be absent where the hand has a table, which gives it"))
    knob = min(axes.get("knob.inertia", [scene.knob.inertia]))
    place = ("grid", plan.GRIP) if plan.GRIP in axes else ("scene", "hand", "grip_n")
    hand = scene.hand.plain()
    for grip in axes.get(plan.GRIP, [scene.hand.grip_n]):
        added = plan.gripped(hand, grip).inertia
        if "hand.inertia" not in axes and knob + added <= 0.0:
            less = f"table {scene.hand.table} has {-added:g} kg*m^2 less than its apparatus without a hand"
            found.append((place, f"must leave an inertia above 0: at {grip:g} N, {less}, and the knob has {knob:g}"))
    return found
