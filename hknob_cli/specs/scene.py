"""The scene of a spec. Its parts are those of `specs.parts`; here is what a spec writes in another way.

That is a hand from a table or file, an encoder that is ``none``, and how the controller is sampled.
"""

from typing import Annotated, Any, Literal, Self

from pydantic import Discriminator, Field, ModelWrapValidatorHandler, PrivateAttr, Tag, model_validator

from hknob_cli.specs.hand import HandSpec
from hknob_cli.specs.over_angle import OVER_ANGLE
from hknob_cli.specs.part import Part as Part
from hknob_cli.specs.part import model_with_fields
from hknob_cli.specs.parts import Encoder, Scene


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
