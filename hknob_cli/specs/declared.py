"""A part of a spec, declared once: a named tuple whose annotations say what is read, and in which bounds.

The rest of the program uses the tuple, and loads no validation for it. Where specs are read, pydantic takes a model in
its place that `specs.part` makes of it.
"""

from collections.abc import Callable
from functools import cache
from typing import Annotated, Any, TypeVar, get_args, get_origin, get_type_hints

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
