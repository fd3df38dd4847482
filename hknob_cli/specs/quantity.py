"""What a value of a spec is held to: bounds, units, whole numbers; and parts that are declared by such values.

Declared beside the value, checked by pydantic. Nothing here loads pydantic before a spec is read, so that the classes
that are declared with it stay light: the rest of the program uses a part as a named tuple, whose annotations say what
is read, in which bounds. Where specs are read, pydantic takes a model in its place that `specs.part` makes of it.

Text with a unit, such as ``1 kHz`` and ``19.8 g*cm^2``, becomes an SI number, converted and dimension-checked. pint is
loaded only when a string with a unit is met.
"""

import re
from collections.abc import Callable, Iterator
from functools import cache, cached_property
from typing import TYPE_CHECKING, Annotated, Any, TypeVar, get_args, get_origin, get_type_hints

if TYPE_CHECKING:
    from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
    from pydantic_core import CoreSchema

MAX_LENGTH = 60
_SPELLINGS = str.maketrans({"·": "*", "²": "^2", "³": "^3"})


# A number, then unit names with powers below 100, joined by * / ( ) or blanks: pint would evaluate any arithmetic, and
# a power of a power of a power for ever.
_TEXT = re.compile(
    r"\s*(?P<number>[-+]?(?:\d++\.?\d*+|\.\d++)(?:[eE][-+]?\d++)?)"
    r"(?P<unit>(?:\s++|[A-Za-zµμΩ°]++|(?:\^|\*\*)\s*+-?\d{1,2}(?!\d|\s*(?:\^|\*\*|[²³]))"
    r"|[²³](?!\s*(?:\^|\*\*|[²³]))|[*/·()])*+)"
)
_POWER = re.compile(r"squared|cubed|square|cubic|sq|\^|\*\*|[²³]")
_POWER_WORD = re.compile(r"squared|cubed|square|cubic|sq")


@cache
def _registry() -> Any:
    import pint

    registry: Any = pint.UnitRegistry()
    registry.define("newton_meter = newton * meter = Nm")
    return registry


def to_si(text: str, unit: str) -> float:
    """Convert ``text``, a number with a unit, to ``unit``. Raises `ValueError` with the reason."""
    match = _TEXT.fullmatch(text) if len(text) <= MAX_LENGTH else None
    if match is None or (_POWER_WORD.search(match["unit"]) and len(_POWER.findall(match["unit"])) > 1):
        raise ValueError(f"is not a number with a unit; for example 1.5 {unit}")
    if not match["unit"].strip():
        raise ValueError(f"is text; write the number without quotes, or with a unit, as in 1.5 {unit}")
    factor = _factor(match["unit"].translate(_SPELLINGS), unit)
    if isinstance(factor, str):
        raise ValueError(factor)
    return float(match["number"]) * factor


@cache
def _factor(names: str, unit: str) -> float | str:
    """By what a number in one unit is multiplied; why it cannot be. Each unit is parsed once, which is slow."""
    import pint

    registry = _registry()
    wanted = "dimensionless" if unit == "1" else unit
    try:
        units = registry.Quantity(1.0, names).units
        factor = float(registry.convert(1.0, units, wanted))
        angle, wanted_angle = _angle_power(names), _angle_power(unit)
    except pint.UndefinedUnitError as error:
        unknown = ", ".join(error.unit_names)
        return f"has an unknown unit '{unknown}'; a number in {unit}, or a unit of its kind"
    except pint.DimensionalityError as error:
        return f"is in {error.units1}, which is not a kind of {unit}"
    except Exception:  # pint parses with Python's tokenizer, and lets out whatever that raises
        return f"is not a number with a unit; for example 1.5 {unit}"
    # To pint an angle is a pure number; to a knob 1 rad/s is not 1 Hz. A torque per angle may leave the angle out.
    if angle != wanted_angle and not (angle == 0 and "N" in unit):
        return f"is in {units}, which is not a kind of {unit}"
    return factor


def _angle_power(names: str) -> float:
    """Power of the radian in a unit."""
    return float(dict(_registry().Quantity(1.0, names).to_root_units().unit_items()).get("radian", 0))


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


T = TypeVar("T")
Place = tuple[str | int, ...]  # of a value in a spec


def declared(schema: Any = None, *, unread: tuple[str, ...] = ()) -> Callable[[type[T]], type[T]]:
    """Let pydantic read a named tuple from a mapping of its keys, and from nothing else.

    A field is annotated with its type, what it is held to (`specs.quantity`) and a text that describes it. A method
    ``wrong``, if there is one, says what is wrong with the values together; empty if nothing is. ``schema``: what the
    JSON Schema has besides, or a function that adds to it. ``unread``: fields that are no keys of a spec.
    """

    def mark(kind: type[T]) -> type[T]:
        kind.json_schema_extra, kind.unread = schema, unread  # type: ignore[attr-defined]
        kind.__get_pydantic_core_schema__ = classmethod(_validator)  # type: ignore[attr-defined]
        return kind

    return mark


def is_declared(kind: Any) -> bool:
    """Whether a type is a part that is declared so."""
    return isinstance(kind, type) and hasattr(kind, "json_schema_extra") and hasattr(kind, "_fields")


@cache
def unit_at(kind: Any, path: str) -> str:
    """SI unit of the number at a dotted path of a named tuple, as its annotation says; empty if that has none."""
    first, _, rest = path.partition(".")
    hint = get_type_hints(kind, include_extras=True)[first]
    if rest:
        return next(unit_at(arm, rest) for arm in _arms(hint) if hasattr(arm, "_fields"))
    noted = [note for one in (hint, *_arms(hint)) for note in getattr(one, "__metadata__", ())]
    return next((note.unit for note in noted if hasattr(note, "unit")), "")


def _arms(hint: Any) -> tuple[Any, ...]:
    """What a type is one of; itself, if that is all."""
    bare = get_args(hint)[0] if get_origin(hint) is Annotated else hint
    return get_args(bare) or (bare,)


def _validator(kind: Any, _: Any, handler: Any) -> Any:
    from hknob_cli.specs.part import validator_of

    return validator_of(kind, handler)
