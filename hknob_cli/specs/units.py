"""From text with a unit, such as ``1 kHz`` and ``19.8 g*cm^2``, to an SI number, converted and dimension-checked.

pint is loaded only when a string with a unit is met.
"""

import re
from functools import cache
from typing import Any

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
