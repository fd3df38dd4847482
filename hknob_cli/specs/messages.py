"""Faults of a spec in the user's words: what is wrong, the value given, what is allowed."""

import difflib
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from hknob_cli.errors import printable

if TYPE_CHECKING:
    from pydantic import BaseModel

_BOUNDS = {
    "greater_than": (">", "gt"),
    "greater_than_equal": (">=", "ge"),
    "less_than": ("<", "lt"),
    "less_than_equal": ("<=", "le"),
}
_KINDS = {
    "float_type": "a number",
    "int_type": "a whole number",
    "string_type": "text",
    "bool_type": "true or false",
    "list_type": "a list",
    "tuple_type": "a list",
    "dict_type": "a mapping of keys to values",
    "model_type": "a mapping of keys to values",
    "model_attributes_type": "a mapping of keys to values",
    "float_parsing": "a number",
    "int_parsing": "a whole number",
    "bool_parsing": "true or false",
    "finite_number": "a finite number",
    "int_from_float": "a whole number",
}


def shown(value: Any) -> str:
    """A value as it appears in a message; long ones are cut."""
    if isinstance(value, str):
        text = f"'{value}'"
    elif value is None or isinstance(value, bool):
        text = {None: "null", True: "true", False: "false"}[value]
    else:
        text = str(value)
    if isinstance(value, dict):
        text = "a mapping"
    if isinstance(value, list):
        text = f"a list of {len(value)}"
    text = printable(text)
    return text if len(text) <= 60 else text[:57] + "..."


def nearest(key: str, allowed: list[str]) -> str:
    """Hint for an unknown key: the nearest valid one, and all of them."""
    if not allowed:
        return "unknown key"
    close = closest(key, allowed)
    hint = f"did you mean '{close}'? " if close else ""
    return f"unknown key; {hint}allowed: {', '.join(allowed)}"


# What people call a key, and the keys that may be meant.
_ALSO_CALLED = {
    "friction": ("coulomb_torque",),
    "mass": ("inertia",),
    "spring": ("stiffness",),
    "damper": ("damping",),
    "delay": ("delay_samples",),
    "lag": ("time_constant",),
    "push": ("bias",),
    "rate": ("sample_rate_hz",),
    "cpr": ("counts_per_rev",),
    "resolution": ("counts_per_rev",),
}


def closest(name: str, names: list[str]) -> str | None:
    """The one of ``names`` that is another word for ``name``, or else is spelled most like it; None if none is."""
    if meant := [one for one in _ALSO_CALLED.get(name, ()) if one in names]:
        return meant[0]
    close = difflib.get_close_matches(name, names, n=1, cutoff=0.5)
    return close[0] if close else None


def unknown(what: str, name: str, names: Sequence[str]) -> str:
    """That nothing of this sort is called so: the nearest name, and all of them."""
    close = closest(name, list(names))
    hint = f"did you mean '{close}'? " if close else ""
    return f"unknown {what} {shown(name)}; {hint}allowed: {', '.join(names)}"


def message(error: Any, allowed: list[str] | tuple[str, ...]) -> str:
    """Message for one pydantic error; ``allowed`` are the keys valid beside an unknown one."""
    kind, context, value = error["type"], error.get("ctx", {}), error.get("input")
    if kind == "extra_forbidden":
        return nearest(str(error["loc"][-1]), list(allowed))
    if kind == "missing":
        return "missing, and required"
    if kind in _BOUNDS:
        sign, key = _BOUNDS[kind]
        bound = context[key]
        return f"must be {sign} {bound:g}, got {shown(value)}"
    if kind == "literal_error":
        return f"must be {context['expected']}, got {shown(value)}"
    if kind == "value_error":
        return str(context["error"])
    if kind == "unit":
        return f"{shown(value)} {context['reason']}"
    if kind in _KINDS:
        return f"must be {_KINDS[kind]}, got {shown(value)}"
    if kind in {"too_short", "too_long"}:
        side = "at least" if kind == "too_short" else "at most"
        bound = context.get("min_length", context.get("max_length"))
        return f"must have {side} {bound} item{'s' if bound != 1 else ''}, got {shown(value)}"
    if kind.startswith("string_"):
        return f"{error['msg'].replace('String should', 'must')}, got {shown(value)}"
    if isinstance(value, dict) or hasattr(type(value), "model_fields"):
        return str(error["msg"])
    return f"{error['msg']}, got {shown(value)}"


def keys_of(model: "type[BaseModel] | None") -> list[str]:
    """Keys a part of a spec may have."""
    return [info.alias or name for name, info in model.model_fields.items()] if model else []
