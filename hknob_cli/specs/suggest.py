"""What a ``key.path`` on the command line was meant to be, where a spec has no such key: the paths that end like it."""

import difflib
from collections.abc import Iterator, Sequence

from pydantic import BaseModel

from hknob_cli.specs.messages import keys_of
from hknob_cli.specs.scene_paths import part_of

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
