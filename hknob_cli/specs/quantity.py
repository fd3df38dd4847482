"""Numbers with units: SI floats, or strings such as ``1 kHz`` and ``19.8 g*cm^2``, converted and dimension-checked.

pint is loaded only when a string with a unit is met.
"""

import re
from functools import cache
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import PydanticCustomError, core_schema

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
    import pint

    names = match["unit"].translate(_SPELLINGS)
    try:
        quantity = _registry().Quantity(float(match["number"]), names)
        value = float(quantity.to("dimensionless" if unit == "1" else unit).magnitude)
        angle, wanted = _angle_power(names), _angle_power(unit)
    except pint.UndefinedUnitError as error:
        unknown = ", ".join(error.unit_names)
        raise ValueError(f"has an unknown unit '{unknown}'; a number in {unit}, or a unit of its kind") from None
    except pint.DimensionalityError as error:
        raise ValueError(f"is in {error.units1}, which is not a kind of {unit}") from None
    except Exception:  # pint parses with Python's tokenizer, and lets out whatever that raises
        raise ValueError(f"is not a number with a unit; for example 1.5 {unit}") from None
    # To pint an angle is a pure number; to a knob 1 rad/s is not 1 Hz. A torque per angle may leave the angle out.
    if angle != wanted and not (angle == 0 and "N" in unit):
        raise ValueError(f"is in {quantity.units}, which is not a kind of {unit}")
    return value


def _angle_power(names: str) -> float:
    """Power of the radian in a unit."""
    return float(dict(_registry().Quantity(1.0, names).to_root_units().unit_items()).get("radian", 0))


class Unit:
    """Annotation of a float field: the SI unit of its number, and the kind of unit a string may have."""

    def __init__(self, name: str) -> None:
        self.name = name

    def convert(self, value: Any) -> Any:
        """SI number for a string with a unit; anything else unchanged."""
        if not isinstance(value, str):
            return value
        try:
            return to_si(value, self.name)
        except ValueError as error:
            raise PydanticCustomError("unit", "{reason}", {"reason": str(error)}) from None

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> core_schema.CoreSchema:
        return core_schema.no_info_before_validator_function(self.convert, handler(source))

    def __get_pydantic_json_schema__(
        self, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        number = handler(schema)
        text = {"type": "string", "pattern": r"^\s*[-+]?[0-9.]", "description": f"number with a unit, as {self.name}"}
        return {"anyOf": [number, text], "x-unit": self.name}


def _whole(value: Any) -> Any:
    """A float that is a whole number as one: YAML reads ``1e7`` as a float; anything else unchanged."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


MayBeFloat = BeforeValidator(_whole)  # annotation of a strict whole number that a large one of is written as 1e7


class NotSweepable:
    """Annotation of a number that no grid varies."""


def _number(unit: str, **bounds: Any) -> Any:
    return Annotated[float, Field(strict=True, allow_inf_nan=False, **bounds), Unit(unit)]


Inertia = _number("kg*m^2", gt=0, le=1e6)
AddedInertia = _number("kg*m^2", ge=0, le=1e6)
Damping = _number("N*m*s/rad", ge=0, le=1e9)
SignedDamping = _number("N*m*s/rad", ge=-1e9, le=1e9)
Stiffness = _number("N*m/rad", ge=0, le=1e12)
Torque = _number("N*m", ge=0, le=1e9)
SignedTorque = _number("N*m", ge=-1e9, le=1e9)
Angle = _number("rad", ge=-1e6, le=1e6)
PositiveAngle = _number("rad", gt=0, le=1e6)
Velocity = _number("rad/s", ge=-1e9, le=1e9)
Seconds = _number("s", ge=0, le=1e6)
PositiveSeconds = _number("s", gt=0, le=1e6)
KnobRadius = _number("m", gt=0, le=1.0)
SoundGain = _number("Pa*s/rad", gt=0, le=1e9)
SampleRate = _number("Hz", ge=1e-3, le=1e9)
