"""The grid: axes of values.

An axis is a list of values, ``{log: [first, last, count]}`` or ``{lin: [first, last, count]}``; a single value is an
axis of one. Beside sample rate and counts, any number of the scene is an axis by its dotted path. A continuous sensor
needs no counts, a continuous controller no sample rate.
"""

import math
from typing import Annotated, Any, get_args, get_origin

from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag, TypeAdapter, ValidationError
from pydantic.fields import FieldInfo

from hknob_cli.spec.plan import COUNTS, RATE
from hknob_cli.spec.quantity import Fixed, SampleRate, Unit
from hknob_cli.spec.scene import Part, SceneSpec

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


def scalar_field(path: str) -> FieldInfo | None:
    """The scene's number at a dotted path, ``wall.stiffness``; None if there is none."""
    model: type[BaseModel] = SceneSpec
    *parents, last = path.split(".")
    for part in parents:
        info = model.model_fields.get(part)
        inner = model_of(info) if info else None
        if inner is None:
            return None
        model = inner
    found = model.model_fields.get(last)
    return None if found is None or model_of(found) or not _is_number(found) else found


def scalar_paths() -> list[str]:
    """Every dotted path that may be an axis."""
    paths = []
    for part, info in SceneSpec.model_fields.items():
        model = model_of(info)
        if model:
            paths += [f"{part}.{name}" for name in _numbers(model)]
    return paths


def _numbers(model: type[BaseModel]) -> list[str]:
    """Paths of the numbers in a part of the scene."""
    paths = []
    for name, info in model.model_fields.items():
        inner = model_of(info)
        if inner:
            paths += [f"{name}.{path}" for path in _numbers(inner)]
        elif _is_number(info):
            paths.append(name)
    return paths


def _arms(info: FieldInfo) -> tuple[Any, ...]:
    annotation = info.annotation
    return getattr(annotation, "__args__", None) or (annotation,)


def model_of(info: FieldInfo) -> type[BaseModel] | None:
    """The model of a field that holds a part of a spec; None if it holds a value."""
    for arm in _arms(info):
        plain = get_args(arm)[0] if get_origin(arm) is Annotated else arm
        if isinstance(plain, type) and issubclass(plain, BaseModel):
            return plain
    return None


def items_of(info: FieldInfo) -> type[BaseModel] | None:
    """The model of the items of a field that is a list or a mapping of parts; None if it is not."""
    for arm in (info.annotation, *_arms(info)):
        plain = get_args(arm)[0] if get_origin(arm) is Annotated else arm
        if get_origin(plain) in (list, dict):
            for item in (item for part in get_args(plain)[-1:] for item in (part, *get_args(part))):
                if isinstance(item, type) and issubclass(item, BaseModel):
                    return item
    return None


def _is_number(info: FieldInfo) -> bool:
    if any(isinstance(item, Fixed) for item in info.metadata):
        return False
    arms = _arms(info)
    return float in arms or any(getattr(arm, "__origin__", None) is float for arm in arms)


def axis_unit(name: str) -> str:
    """SI unit of a grid axis, as the scene declares it; "1" for a pure number."""
    if name == RATE:
        return "Hz"
    info = scalar_field(name)
    units = [item.name for item in _metadata(info) if isinstance(item, Unit)] if info else []
    return units[0] if units else "1"


def _metadata(info: FieldInfo) -> list[Any]:
    """Metadata of a field and of the arms of its union."""
    return [*info.metadata, *(item for arm in _arms(info) for item in getattr(arm, "__metadata__", ()))]


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
        inner = [first * (last / first) ** step for step in steps[1:-1]]
    else:
        inner = [first + (last - first) * step for step in steps[1:-1]]
    return [first, *(_snapped(value) for value in inner), last]


def _snapped(value: float) -> float:
    """The 12-digit number that ``value`` misses by rounding only, as 1000.0000000000001 does; else the value."""
    short = float(f"{value:.12g}")
    return short if abs(short - value) <= 4.0 * math.ulp(value) else value


def _checked(raw: Value, adapter: TypeAdapter[Any], steps: tuple[str | int, ...]) -> Any:
    from hknob_cli.spec.messages import message

    try:
        return adapter.validate_python(raw)
    except ValidationError as error:
        raise AxisError(steps, message(error.errors()[0], ())) from None


def axis_values(name: str, axis: AxisSpec) -> list[float | int]:
    """Values of one axis in SI units. Raises `AxisError`."""
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
        kind = SampleRate if name == RATE else _annotated(info)
        return list(levels(axis, kind))
    _unrepeated(values, axis)
    return values


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


def _annotated(info: FieldInfo | None) -> Any:
    assert info is not None
    annotation: Any = info.annotation
    for item in info.metadata:
        annotation = Annotated[annotation, item]
    return annotation


def _name_axes(schema: dict[str, Any]) -> None:
    """Say in the JSON Schema which axes there are."""
    axis = schema.pop("additionalProperties", {})
    schema["properties"].update(dict.fromkeys(scalar_paths(), axis))
    schema["additionalProperties"] = False


class Grid(BaseModel):
    """Axes by name. Cells follow in the order of the axes, the last one fastest."""

    model_config = ConfigDict(frozen=True, extra="allow", defer_build=True, json_schema_extra=_name_axes)
    __pydantic_extra__: dict[str, AxisSpec]

    sample_rate_hz: Annotated[
        AxisSpec | None, Field(description="sample rate, Hz; not needed where sampling is continuous")
    ] = None
    counts_per_rev: Annotated[
        AxisSpec | None, Field(description="encoder counts per revolution; not needed where encoder is none")
    ] = None

    def axes(self) -> dict[str, AxisSpec]:
        """Axes as written: sample rate and counts first, then the others in the order written."""
        names = [RATE, COUNTS, *(self.__pydantic_extra__ or {})]
        return {name: axis for name in names if (axis := getattr(self, name)) is not None}
