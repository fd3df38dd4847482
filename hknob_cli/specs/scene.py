"""The scene: what exists between hand, knob, encoder, wall and actuator. What is not listed does not exist.

Source of the parts: Hasser, sections 6.3-6.4 (Fig. 27, Table 7). SI units throughout.
"""

from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Discriminator, Field, Tag, model_validator
from pydantic_core import PydanticCustomError

from hknob_cli.specs import plan
from hknob_cli.specs.controller import ControllerSpec
from hknob_cli.specs.hand import HandSpec
from hknob_cli.specs.part import Part as Part
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
