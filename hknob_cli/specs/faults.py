"""From a validator's errors to faults with their places in the file."""

from collections.abc import Callable
from typing import Any

from pydantic import BaseModel, ValidationError

from hknob_cli.errors import MOST_FAULTS, Fault
from hknob_cli.specs.messages import keys_of, message
from hknob_cli.specs.scene_paths import items_of, part_of
from hknob_cli.specs.source import Path_, Source

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
