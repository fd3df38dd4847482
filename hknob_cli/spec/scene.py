"""The scene: what exists between hand, knob, encoder, wall and actuator. What is not listed does not exist.

Source of the parts: Hasser, sections 6.3-6.4 (Fig. 27, Table 7). SI units throughout.
"""

from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

from hknob_cli.spec import plan
from hknob_cli.spec.quantity import AddedInertia, Damping, Inertia, Seconds, Stiffness, Torque


class Part(BaseModel):
    """A piece of a spec: immutable, no unknown keys."""

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)


def _sampled(value: Any) -> Any:
    if value == "none":
        raise PydanticCustomError("absent", "must be a mapping: a continuous sensor is not in this version")
    return value


class KnobSpec(Part):
    """The device: what turns, felt without any control."""

    inertia: Annotated[Inertia, Field(description="moment of inertia of knob and motor")]
    damping: Annotated[Damping, Field(description="viscous damping of the device")] = 0.0
    coulomb_torque: Annotated[Torque, Field(description="Coulomb friction level; predict only")] = 0.0


class HandSpec(Part):
    """The hand on the knob, second order, to ground; its neutral angle is 0."""

    inertia: Annotated[AddedInertia, Field(description="moment of inertia the grasp adds")] = 0.0
    damping: Annotated[Damping, Field(description="damping of the grasp")] = 0.0
    stiffness: Annotated[Stiffness, Field(description="stiffness of the grasp")] = 0.0


class WallSpec(Part):
    """The virtual wall: a spring for measured angles below 0, nothing above."""

    stiffness: Annotated[Stiffness, Field(description="virtual stiffness")]
    damping: Annotated[Damping, Field(description="on the differenced measured angle; predict only")] = 0.0


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
    time_constant: Annotated[Seconds, Field(description="first-order lag; 0 in this version")] = 0.0
    torque_limit: Annotated[Torque | None, Field(description="saturation; null in this version")] = None
    torque_step: Annotated[Torque, Field(description="D/A step; 0 in this version")] = 0.0


class SceneSpec(Part):
    """Knob and wall, and whatever else is listed."""

    knob: KnobSpec
    wall: WallSpec
    hand: HandSpec | None = None
    bias: BiasSpec | None = None
    encoder: Annotated[EncoderSpec, BeforeValidator(_sampled), Field(default_factory=EncoderSpec)]
    actuator: ActuatorSpec | None = None
    sampling: Annotated[Literal["zero_order_hold"], Field(description="how the controller acts in time")] = (
        "zero_order_hold"
    )

    def plain(self) -> plan.Scene:
        """The scene as plain values."""
        return plan.Scene(
            knob=plan.Knob(**dict(self.knob)),
            wall=plan.Wall(**dict(self.wall)),
            hand=plan.Hand(**dict(self.hand)) if self.hand else None,
            bias=plan.Bias(**dict(self.bias)) if self.bias else None,
            encoder=plan.Encoder(**dict(self.encoder)),
            actuator=plan.Actuator(**dict(self.actuator)) if self.actuator else None,
        )
