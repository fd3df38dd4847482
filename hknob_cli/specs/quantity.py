"""What a value of a spec is held to: bounds, units, whole numbers. Declared beside the value, checked by pydantic.

Nothing here loads pydantic before a spec is read, so that the classes that are declared with it stay light.
"""

from collections.abc import Callable, Iterator
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Any

if TYPE_CHECKING:
    from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
    from pydantic_core import CoreSchema


class Bounds:
    """Annotation of a value: its bounds, by the keywords of pydantic's ``Field``."""

    __is_annotated_types_grouped_metadata__ = True  # pydantic takes what `__iter__` gives in place of this

    def __init__(self, **bounds: Any) -> None:
        self.bounds = bounds

    def __iter__(self) -> Iterator[Any]:
        return iter(self._metadata)

    @cached_property
    def _metadata(self) -> list[Any]:
        from pydantic import Field

        made: list[Any] = Field(**self.bounds).metadata
        return made


class Unit:
    """Annotation of a float field: the SI unit of its number, and the kind of unit a string may have."""

    def __init__(self, name: str) -> None:
        self.name = name

    def convert(self, value: Any) -> Any:
        """SI number for a string with a unit; anything else unchanged."""
        if not isinstance(value, str):
            return value
        from pydantic_core import PydanticCustomError

        from hknob_cli.specs.units import to_si

        try:
            return to_si(value, self.name)
        except ValueError as error:
            raise PydanticCustomError("unit", "{reason}", {"reason": str(error)}) from None

    def __get_pydantic_core_schema__(self, source: Any, handler: "GetCoreSchemaHandler") -> "CoreSchema":
        from pydantic_core import core_schema

        return core_schema.no_info_before_validator_function(self.convert, handler(source))

    def __get_pydantic_json_schema__(self, schema: "CoreSchema", handler: "GetJsonSchemaHandler") -> dict[str, Any]:
        number = handler(schema)
        text = {"type": "string", "pattern": r"^\s*[-+]?[0-9.]", "description": f"number with a unit, as {self.name}"}
        return {"anyOf": [number, text], "x-unit": self.name}


class _Before:
    """Annotation of a value that a function sees before it is checked."""

    def __init__(self, convert: Callable[[Any], Any]) -> None:
        self.convert = convert

    def __get_pydantic_core_schema__(self, source: Any, handler: "GetCoreSchemaHandler") -> "CoreSchema":
        from pydantic_core import core_schema

        return core_schema.no_info_before_validator_function(self.convert, handler(source))


def _whole(value: Any) -> Any:
    """A float that is a whole number as one: YAML reads ``1e7`` as a float; anything else unchanged."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


def _as_written(value: Any) -> Any:
    """The value, unless it is a float, or true or false, which to Python are equal to whole numbers."""
    if isinstance(value, bool | float):
        from pydantic_core import PydanticKnownError

        raise PydanticKnownError("int_type")
    return value


MayBeFloat = _Before(_whole)  # annotation of a strict whole number that a large one of is written as 1e7
WHOLE = _Before(_as_written)  # annotation of one of a few whole numbers, written as one


class NotSweepable:
    """Annotation of a number that no grid varies."""


class Quantity(Bounds):
    """Annotation of a float field: its SI unit, and bounds. A string may have another unit of its kind."""

    def __init__(self, unit: str, **bounds: Any) -> None:
        super().__init__(strict=True, allow_inf_nan=False, **bounds)
        self.unit = unit

    def __iter__(self) -> Iterator[Any]:
        yield from super().__iter__()
        yield Unit(self.unit)


Inertia = Annotated[float, Quantity("kg*m^2", gt=0, le=1e6)]
AddedInertia = Annotated[float, Quantity("kg*m^2", ge=0, le=1e6)]
Damping = Annotated[float, Quantity("N*m*s/rad", ge=0, le=1e9)]
SignedDamping = Annotated[float, Quantity("N*m*s/rad", ge=-1e9, le=1e9)]
Stiffness = Annotated[float, Quantity("N*m/rad", ge=0, le=1e12)]
Torque = Annotated[float, Quantity("N*m", ge=0, le=1e9)]
SignedTorque = Annotated[float, Quantity("N*m", ge=-1e9, le=1e9)]
Angle = Annotated[float, Quantity("rad", ge=-1e6, le=1e6)]
Width = Annotated[float, Quantity("rad", ge=0, le=1e6)]
PositiveAngle = Annotated[float, Quantity("rad", gt=0, le=1e6)]
Velocity = Annotated[float, Quantity("rad/s", ge=-1e9, le=1e9)]
Seconds = Annotated[float, Quantity("s", ge=0, le=1e6)]
PositiveSeconds = Annotated[float, Quantity("s", gt=0, le=1e6)]
KnobRadius = Annotated[float, Quantity("m", gt=0, le=1.0)]
SoundGain = Annotated[float, Quantity("Pa*s/rad", gt=0, le=1e9)]
PositiveHertz = Annotated[float, Quantity("Hz", gt=0, le=1e9)]
SampleRate = Annotated[float, Quantity("Hz", ge=1e-3, le=1e9)]

# Of a trial on a knob: within what a target takes (docs/reference/wire.md), or a person can do.
Force = Annotated[float, Quantity("N", gt=0, le=100)]
ForceNoise = Annotated[float, Quantity("N", ge=0, le=10)]
WallStiffness = Annotated[float, Quantity("N*m/rad", ge=0, le=1000)]
WallDamping = Annotated[float, Quantity("N*m*s/rad", ge=0, le=1000)]
TorqueLimit = Annotated[float, Quantity("N*m", gt=0, le=10)]
Bandwidth = Annotated[float, Quantity("rad/s", gt=0, le=1e7)]
Acceleration = Annotated[float, Quantity("rad/s^2", gt=0, le=1e9)]
SpeedLimit = Annotated[float, Quantity("rad/s", gt=0, le=1e4)]
Watchdog = Annotated[float, Quantity("s", ge=0.001, le=0.05)]
Minutes = Annotated[float, Quantity("s", gt=0, le=900)]
SomeSeconds = Annotated[float, Quantity("s", ge=0, le=60)]
AngleNoise = Annotated[float, Quantity("rad", ge=0, le=0.1)]
TimeNoise = Annotated[float, Quantity("s", ge=0, le=0.1)]
Share = Annotated[float, Bounds(strict=True, ge=0, le=0.5)]
