"""The grid: axes of values, or points that fill their ranges.

An axis is a list of values, ``{log: [first, last, count]}`` or ``{lin: [first, last, count]}``; a single value is an
axis of one. Beside sample rate and counts, any number of the scene is an axis by its dotted path. A continuous sensor
needs no counts, a continuous controller no sample rate. With a design, whose points take the place of all combinations,
an axis is a range, ``{log: [first, last]}`` or ``{lin: [first, last]}``, a list, or a value.
"""

import math
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag, TypeAdapter, ValidationError, model_validator
from pydantic_core import PydanticCustomError

from hknob_cli.specs.cells import log_between
from hknob_cli.specs.part import Part
from hknob_cli.specs.plan import COUNTS, GRIP, RATE
from hknob_cli.specs.quantity import MayBeFloat, SampleRate
from hknob_cli.specs.scene_paths import annotated, scalar_field, scalar_paths
from hknob_cli.specs.unit_points import HALTON, LATIN, MOST_POINTS, RANDOM, SOBOL, Points

_METHODS = (SOBOL, HALTON, LATIN, RANDOM)


_Sobol = Annotated[int, Field(strict=True, ge=1, le=MOST_POINTS[SOBOL]), MayBeFloat]
_Latin = Annotated[int, Field(strict=True, ge=1, le=MOST_POINTS[LATIN]), MayBeFloat]
_Many = Annotated[int, Field(strict=True, ge=1, le=MOST_POINTS[RANDOM]), MayBeFloat]


def _one_method(schema: dict[str, Any]) -> None:
    """Say in the JSON Schema that there is one method."""
    schema["oneOf"] = [{"required": [method]} for method in _METHODS]


class PointsSpec(Part):
    """Points that fill the ranges of the axes: how many, by exactly one method (scipy.stats.qmc; random: numpy)."""

    model_config = ConfigDict(json_schema_extra=_one_method)

    sobol: Annotated[
        _Sobol | None, Field(description="points of a scrambled Sobol sequence; a power of two is best")
    ] = None
    halton: Annotated[_Many | None, Field(description="points of a scrambled Halton sequence")] = None
    latin_hypercube: Annotated[_Latin | None, Field(description="points of a Latin hypercube")] = None
    random: Annotated[_Many | None, Field(description="points drawn independently")] = None
    seed: Annotated[int, Field(strict=True, ge=0, le=2**32 - 1, description="the same points by it")] = 1

    @model_validator(mode="after")
    def _one(self) -> "PointsSpec":
        given = [name for name in _METHODS if getattr(self, name) is not None]
        if len(given) != 1:
            text = f"must have exactly one of {', '.join(_METHODS)}, got {' and '.join(given) or 'none'}"
            raise PydanticCustomError("one_of", "{text}", {"text": text})
        return self

    def plain(self, scales: dict[str, str]) -> Points:
        """The design as plain values; ``scales``: log or lin of each axis that is a range."""
        method = next(name for name in _METHODS if getattr(self, name) is not None)
        return Points(method, int(getattr(self, method)), self.seed, scales)


MAX_CELLS = 1_000_000

_STRICT = Field(strict=True)
Value = Annotated[int, _STRICT] | Annotated[float, _STRICT] | Annotated[str, _STRICT]
Listed = Annotated[list[Value], Field(min_length=1, max_length=MAX_CELLS)]
Counts = Annotated[int, Field(strict=True, ge=1, le=2**31)]


class LogAxis(Part):
    """Values evenly spaced on a log scale."""

    log: Annotated[tuple[Value, Value, Annotated[int, Field(strict=True, ge=1, le=MAX_CELLS)]], Field()]


class LinAxis(Part):
    """Values evenly spaced."""

    lin: Annotated[tuple[Value, Value, Annotated[int, Field(strict=True, ge=1, le=MAX_CELLS)]], Field()]


class LogRange(Part):
    """A range of a design, its points evenly spread on a log scale."""

    log: tuple[Value, Value]


class LinRange(Part):
    """A range of a design, its points evenly spread."""

    lin: tuple[Value, Value]


def _form(value: Any) -> str:
    """Which form of axis this is; picks the model that validates it."""
    if isinstance(value, dict):
        return "lin axis" if "lin" in value and "log" not in value else "log axis"
    if isinstance(value, LogAxis | LinAxis):
        return "log axis" if isinstance(value, LogAxis) else "lin axis"
    return "list axis" if isinstance(value, list) else "one value"


AxisSpec = Annotated[
    Annotated[Listed, Tag("list axis")]
    | Annotated[LogAxis, Tag("log axis")]
    | Annotated[LinAxis, Tag("lin axis")]
    | Annotated[Value, Tag("one value")],
    Discriminator(_form),
]


def _form_or_range(value: Any) -> str:
    """As `_form`, with the ranges of a design."""
    if isinstance(value, LogRange | LinRange):
        return "log range" if isinstance(value, LogRange) else "lin range"
    form = _form(value)
    if form in ("log axis", "lin axis") and isinstance(value, dict):
        inner = value.get(form[:3])
        return f"{form[:3]} range" if isinstance(inner, list | tuple) and len(inner) <= 2 else form
    return form


GridAxis = Annotated[
    Annotated[Listed, Tag("list axis")]
    | Annotated[LogAxis, Tag("log axis")]
    | Annotated[LinAxis, Tag("lin axis")]
    | Annotated[LogRange, Tag("log range")]
    | Annotated[LinRange, Tag("lin range")]
    | Annotated[Value, Tag("one value")],
    Discriminator(_form_or_range),
]


class AxisError(ValueError):
    """A value of an axis is not allowed; ``steps`` leads to it below the axis."""

    def __init__(self, steps: tuple[str | int, ...], message: str) -> None:
        super().__init__(message)
        self.steps = steps


def _spread(axis: LogAxis | LinAxis, adapter: TypeAdapter[float]) -> list[float]:
    """Values of a log or lin axis, its end points exact."""
    name = "log" if isinstance(axis, LogAxis) else "lin"
    first_raw, last_raw, count = axis.log if isinstance(axis, LogAxis) else axis.lin
    first, last = (_checked(raw, adapter, (name, i)) for i, raw in enumerate((first_raw, last_raw)))
    if count == 1:
        if first != last:
            raise AxisError((name, 2), f"must be >= 2 between {first:g} and {last:g}, got 1")
        return [first]
    if name == "log" and not (first > 0 and last > 0):
        raise AxisError((name, 0 if first <= 0 else 1), "must be > 0 on a log axis, got 0")
    steps = [i / (count - 1) for i in range(count)]
    if name == "log":
        inner = log_between(first, last, steps[1:-1])
    else:
        inner = [first + (last - first) * step for step in steps[1:-1]]
    return [first, *(_snapped(value) for value in inner), last]


def _snapped(value: float) -> float:
    """The 12-digit number that ``value`` misses by rounding only, as 1000.0000000000001 does; else the value."""
    short = float(f"{value:.12g}")
    return short if abs(short - value) <= 4.0 * math.ulp(value) else value


def _checked(raw: Value, adapter: TypeAdapter[Any], steps: tuple[str | int, ...]) -> Any:
    from hknob_cli.specs.messages import message

    try:
        return adapter.validate_python(raw)
    except ValidationError as error:
        raise AxisError(steps, message(error.errors()[0], ())) from None


def length(axis: GridAxis) -> int:
    """How many values an axis has, told without making them."""
    if isinstance(axis, LogAxis | LinAxis):
        return (axis.log if isinstance(axis, LogAxis) else axis.lin)[2]
    return len(axis) if isinstance(axis, list) else 1


def axis_values(name: str, axis: GridAxis) -> list[float | int]:
    """Values of one axis in SI units. Raises `AxisError`."""
    if isinstance(axis, LogRange | LinRange):
        form = "log" if isinstance(axis, LogRange) else "lin"
        text = f"missing, and required: {{{form}: [first, last, count]}}; a range without it needs a design in the grid"
        raise AxisError((form, 2), text)
    if name == COUNTS:
        wide: TypeAdapter[Any] = TypeAdapter(Annotated[float, Field(strict=True, ge=1, le=2**31)])
        exact: TypeAdapter[Any] = TypeAdapter(Counts)
        if isinstance(axis, LogAxis | LinAxis):
            values: list[Any] = [round(value) for value in _spread(axis, wide)]
        else:
            listed = axis if isinstance(axis, list) else [axis]
            values = [_checked(raw, exact, (i,) if isinstance(axis, list) else ()) for i, raw in enumerate(listed)]
    else:
        info = scalar_field(name)
        kind = SampleRate if name == RATE else annotated(info)
        return list(levels(axis, kind))
    _unrepeated(values, axis)
    return values


def point_values(name: str, axis: GridAxis) -> tuple[list[float | int], str | None]:
    """Values of an axis of a design, or the ends of its range and their scale, log or lin. Raises `AxisError`."""
    if isinstance(axis, LogAxis | LinAxis):
        form, count = ("log", axis.log[2]) if isinstance(axis, LogAxis) else ("lin", axis.lin[2])
        text = f"must be absent where the grid has a design: {{{form}: [first, last]}}, a list, or a value; got {count}"
        raise AxisError((form, 2), text)
    if not isinstance(axis, LogRange | LinRange):
        return axis_values(name, axis), None
    form, both = ("log", axis.log) if isinstance(axis, LogRange) else ("lin", axis.lin)
    if name == GRIP:
        raise AxisError((form,), "must be a list of grip forces: hands were measured at these, not between")
    ends = axis_values(name, LogAxis(log=(*both, 2)) if form == "log" else LinAxis(lin=(*both, 2)))
    return ends, form


def levels(axis: AxisSpec, kind: Any) -> tuple[float, ...]:
    """Values of an axis, of the scene or not, each of a ``kind`` as pydantic validates it. Raises `AxisError`."""
    adapter: TypeAdapter[Any] = TypeAdapter(kind)
    if isinstance(axis, LogAxis | LinAxis):
        values = _spread(axis, adapter)
    else:
        listed = axis if isinstance(axis, list) else [axis]
        values = [float(_checked(raw, adapter, (i,) if isinstance(axis, list) else ())) for i, raw in enumerate(listed)]
    _unrepeated(values, axis)
    return tuple(values)


def _unrepeated(values: list[Any], axis: AxisSpec) -> None:
    seen: set[float | int] = set()
    for i, value in enumerate(values):
        if value in seen:
            raise AxisError((i,) if isinstance(axis, list) else (), f"must not repeat a value, got {value:g} twice")
        seen.add(value)


def _name_axes(schema: dict[str, Any]) -> None:
    """Say in the JSON Schema which axes there are."""
    axis = schema.pop("additionalProperties", {})
    schema["properties"].update(dict.fromkeys(scalar_paths(), axis))
    schema["additionalProperties"] = False
    forms = ("log", "lin")
    schema["if"] = {"required": ["design"], "properties": {"design": {"type": "object"}}}
    schema["then"] = {"patternProperties": {"": {"properties": {form: {"maxItems": 2} for form in forms}}}}
    schema["else"] = {"patternProperties": {"": {"properties": {form: {"minItems": 3} for form in forms}}}}


class Grid(BaseModel):
    """Axes by name. Cells follow in the order of the axes, the last one fastest; or they are the points of a design."""

    model_config = ConfigDict(frozen=True, extra="allow", defer_build=True, json_schema_extra=_name_axes)
    __pydantic_extra__: dict[str, GridAxis]

    design: Annotated[
        PointsSpec | None, Field(description="points that fill the ranges of the axes, in place of every combination")
    ] = None
    sample_rate_hz: Annotated[
        GridAxis | None, Field(description="sample rate, Hz; not needed where sampling is continuous")
    ] = None
    counts_per_rev: Annotated[
        GridAxis | None, Field(description="encoder counts per revolution; not needed where encoder is none")
    ] = None

    def axes(self) -> dict[str, GridAxis]:
        """Axes as written: sample rate and counts first, then the others in the order written."""
        names = [RATE, COUNTS, *(self.__pydantic_extra__ or {})]
        return {name: axis for name in names if (axis := getattr(self, name)) is not None}
