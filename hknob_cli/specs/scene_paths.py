"""Where in a spec something stands: its numbers by dotted paths, which may be axes, and faults with their places.

Paths are those of the scene, ``wall.stiffness``, each with its unit. Faults are made of a validator's errors.
"""

import difflib
from collections.abc import Callable, Iterator, Sequence
from typing import Annotated, Any, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from hknob_cli.errors import MOST_FAULTS, Fault
from hknob_cli.specs.messages import keys_of, message
from hknob_cli.specs.part import model_of
from hknob_cli.specs.plan import RATE
from hknob_cli.specs.quantity import NotSweepable, Quantity
from hknob_cli.specs.scene import SceneSpec
from hknob_cli.specs.source import Path_, Source


def scalar_field(path: str) -> FieldInfo | None:
    """The scene's number at a dotted path, ``wall.stiffness``; None if there is none."""
    model: type[BaseModel] = SceneSpec
    *parents, last = path.split(".")
    for part in parents:
        info = model.model_fields.get(part)
        inner = part_of(info) if info else None
        if inner is None:
            return None
        model = inner
    found = model.model_fields.get(last)
    return found if found is not None and _is_number(found) else None


def scalar_paths() -> list[str]:
    """Every dotted path that may be an axis."""
    paths = []
    for part, info in SceneSpec.model_fields.items():
        model = part_of(info)
        if model:
            paths += [f"{part}.{name}" for name in _numbers(model)]
    return paths


def _numbers(model: type[BaseModel]) -> list[str]:
    """Paths of the numbers in a part of the scene."""
    paths = []
    for name, info in model.model_fields.items():
        inner = part_of(info)
        if inner:
            paths += [f"{name}.{path}" for path in _numbers(inner)]
        elif _is_number(info):
            paths.append(name)
    return paths


def _arms(info: FieldInfo) -> tuple[Any, ...]:
    annotation = info.annotation
    return getattr(annotation, "__args__", None) or (annotation,)


def part_of(info: FieldInfo) -> type[BaseModel] | None:
    """The model of a field that holds a part of a spec; None if it holds a value."""
    for arm in _arms(info):
        model = model_of(get_args(arm)[0] if get_origin(arm) is Annotated else arm)
        if model is not None:
            return model
    return None


def items_of(info: FieldInfo) -> type[BaseModel] | None:
    """The model of the items of a field that is a list or a mapping of parts; None if it is not."""
    for arm in (info.annotation, *_arms(info)):
        plain = get_args(arm)[0] if get_origin(arm) is Annotated else arm
        if get_origin(plain) in (list, dict):
            return _first_model(get_args(plain)[-1])
    return None


def _first_model(kind: Any) -> type[BaseModel] | None:
    """The first model in a type, however it is annotated."""
    model = model_of(kind)
    if model is not None:
        return model
    return next((found for arm in get_args(kind) if (found := _first_model(arm)) is not None), None)


def _is_number(info: FieldInfo) -> bool:
    if any(isinstance(item, NotSweepable) for item in info.metadata):
        return False
    arms = _arms(info)
    return float in arms or any(getattr(arm, "__origin__", None) is float for arm in arms)


def axis_unit(name: str) -> str:
    """SI unit of a grid axis, as the scene declares it; "1" for a pure number."""
    if name == RATE:
        return "Hz"
    info = scalar_field(name)
    units = [item.unit for item in _metadata(info) if isinstance(item, Quantity)] if info else []
    return units[0] if units else "1"


def _metadata(info: FieldInfo) -> list[Any]:
    """Metadata of a field and of the arms of its union."""
    return [*info.metadata, *(item for arm in _arms(info) for item in getattr(arm, "__metadata__", ()))]


def annotated(info: FieldInfo | None) -> Any:
    """Type of a field with all that bounds its values."""
    assert info is not None
    annotation: Any = info.annotation
    for item in info.metadata:
        annotation = Annotated[annotation, item]
    return annotation


_DEEPEST = 5
_MOST = 3  # suggestions


def unknown_path(model: type[BaseModel], path: str, stages: Sequence[str] = ()) -> str | None:
    """What is wrong with a dotted path whose first key a spec does not have; None if it has that key.

    ``stages``: of a pipeline, whose specs have keys of their own.
    """
    keys = keys_of(model)
    first = path.split(".")[0]
    if first in keys:
        return None
    if stages:
        meant = [f"stages.{stages[0]}.set.{path}"]
    else:
        everything = list(_paths(model))
        meant = [one for one in everything if one.endswith(f".{path}")] or _spelled_like(path, everything)
    hint = f"did you mean {' or '.join(repr(one) for one in meant[:_MOST])}? " if meant else ""
    return f"unknown key; {hint}allowed: {', '.join(keys)}"


def _spelled_like(path: str, everything: list[str]) -> list[str]:
    """The path whose end of as many keys is spelled most like this one."""
    count = path.count(".") + 1
    ends = {".".join(one.split(".")[-count:]): one for one in reversed(everything)}
    return [ends[close] for close in difflib.get_close_matches(path, list(ends), n=1)]


def _paths(model: type[BaseModel], depth: int = 0) -> Iterator[str]:
    """Every key of a spec, by dotted path."""
    for name, info in model.model_fields.items():
        key = info.alias or name
        yield key
        inner = part_of(info)
        if inner is not None and depth < _DEEPEST:
            yield from (f"{key}.{path}" for path in _paths(inner, depth + 1))


Place = Callable[[Path_], Path_]


def faults_of(
    source: Source,
    model: type[BaseModel],
    error: ValidationError,
    *,
    values: Any = None,
    place: Place = lambda path: path,
) -> list[Fault]:
    """Faults of what a model does not take; of more than are said of a spec, the others without hints, which take time.

    ``values`` is what was validated, if not the whole of ``source``; ``place`` says where in the file a path in it is.
    """
    return [
        _fault_at(source, model if i < MOST_FAULTS else None, one, values=values, place=place)
        for i, one in enumerate(error.errors(include_url=False))
    ]


def _fault_at(source: Source, model: type[BaseModel] | None, error: Any, *, values: Any, place: Place) -> Fault:
    """Fault for one pydantic error: its location without the tags of unions, its message in the user's words.

    Without a ``model`` nothing is said of the keys that are allowed.
    """
    path: list[str | int] = []
    value: Any = source.value if values is None else values
    last = len(error["loc"]) - 1
    for i, part in enumerate(error["loc"]):
        if isinstance(value, dict) and (part in value or (error["type"] == "missing" and i == last)):
            path.append(part)
            value = value.get(part)
        elif isinstance(value, list) and isinstance(part, int):
            path.append(part)
            value = value[part] if part < len(value) else None
        # anything else is a union's tag, which the user never wrote
    allowed = keys_of(_model_at(model, tuple(path[:-1])))
    return source.fault(place(tuple(path)), message(error, allowed), at_key=error["type"] == "extra_forbidden")


def _model_at(model: type[BaseModel] | None, path: Path_) -> type[BaseModel] | None:
    """The model whose keys stand at ``path``; None if a value does."""
    current = model
    inside: type[BaseModel] | None = None  # of the items of a list or mapping that the path has just entered
    for part in path:
        if inside is not None:
            current, inside = inside, None
            continue
        info = current.model_fields.get(str(part)) if current else None
        current, inside = (part_of(info), items_of(info)) if info else (None, None)
    return current
