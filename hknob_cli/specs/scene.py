"""The scene: what exists between hand, knob, encoder, wall and actuator. What is not listed does not exist.

Source of the parts: Hasser, sections 6.3-6.4 (Fig. 27, Table 7). SI units throughout.
"""

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from hknob_cli.specs.controller import ControllerSpec
from hknob_cli.specs.hand import HandSpec
from hknob_cli.specs.part import Part as Part
from hknob_cli.specs.parts import Actuator, Bias, Encoder, Knob, Scene, Wall


def _sensor(value: Any) -> Any:
    """Which form of encoder this is; picks the model that validates it."""
    return "none" if isinstance(value, str) else "encoder"


class SceneSpec(Part):
    """Knob and wall, and whatever else is listed."""

    knob: Knob
    wall: Wall
    hand: HandSpec | None = None
    bias: Bias | None = None
    encoder: Annotated[
        Annotated[Encoder, Tag("encoder")] | Annotated[Literal["none"], Tag("none")],
        Discriminator(_sensor),
        Field(default_factory=Encoder, description="none: a continuous sensor"),
    ]
    actuator: Actuator | None = None
    controller: ControllerSpec | None = None
    sampling: Annotated[
        Literal["zero_order_hold", "continuous"],
        Field(description="how the controller acts in time; continuous: without a sample clock, at once"),
    ] = "zero_order_hold"

    def plain(self) -> Scene:
        """The scene as plain values."""
        return Scene(
            knob=self.knob,
            wall=self.wall,
            hand=self.hand.plain() if self.hand else None,
            bias=self.bias,
            encoder=None if isinstance(self.encoder, str) else self.encoder,
            actuator=self.actuator,
            sampled=self.sampling == "zero_order_hold",
            controller=self.controller.plain() if self.controller else None,
        )
