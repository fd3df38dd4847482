"""The computations that claims name: each takes the evidence and the claim's arguments, and gives a number.

A computation returns a float (a flag counts as 1 or 0), or None where the quantity does not exist, and raises
`MissingError` where the evidence lacks what it needs. Its docstring says what it computes, and in which unit.
"""

from collections.abc import Callable
from functools import cache
from importlib import import_module
from pkgutil import iter_modules
from typing import Any

from hknob_cli.results.evidence import Evidence

Check = Callable[..., float | bool | None]

CHECKS: dict[str, Check] = {}


def check(function: Check) -> Check:
    """Register a computation under its name, which no other has."""
    assert function.__name__ not in CHECKS, function.__name__
    CHECKS[function.__name__] = function
    return function


@cache
def known() -> dict[str, Check]:
    """Every computation by name: those that the modules of this folder register."""
    for module in iter_modules(__path__, f"{__name__}."):
        import_module(module.name)
    return CHECKS


def compute(name: str, evidence: Evidence, arguments: dict[str, Any]) -> float | None:
    """Value of a computation. Raises `MissingError`, and `TypeError` for arguments it does not take."""
    value = known()[name](evidence, **arguments)
    return None if value is None else float(value)
