"""Rows by what is asked of their columns: a value as printed, one of several, or bounds."""

from collections.abc import Callable
from typing import Any

from hknob_cli.errors import UsageError

Where = dict[str, Any]

SAME = 5e-3  # texts round: 2154 Hz is 2154.43
_BOUNDS: dict[str, Callable[[float, float], bool]] = {
    "at_least": lambda value, bound: value >= bound * (1.0 - 1e-9),
    "at_most": lambda value, bound: value <= bound * (1.0 + 1e-9),
    "above": lambda value, bound: value > bound * (1.0 + 1e-9),
    "below": lambda value, bound: value < bound * (1.0 - 1e-9),
}


def matching(rows: list[dict[str, Any]], asked: Where) -> list[dict[str, Any]]:
    """Those of the rows that have what is asked. Raises `UsageError` for an unknown bound."""
    return [row for row in rows if all(_is(row[name], value) for name, value in asked.items())]


def _is(value: Any, asked: Any) -> bool:
    if isinstance(asked, list):
        return any(_is(value, one) for one in asked)
    if isinstance(asked, dict):
        if unknown := sorted(set(asked) - set(_BOUNDS)):
            raise UsageError(f"where: unknown {', '.join(unknown)}; there are {', '.join(_BOUNDS)}")
        return value is not None and all(_BOUNDS[name](value, bound) for name, bound in asked.items())
    if isinstance(asked, str | bool) or value is None:
        return bool(value == asked)
    return bool(abs(value - asked) <= SAME * abs(asked))
