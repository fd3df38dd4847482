"""The computations that claims name: each takes the evidence and the claim's arguments, and gives a number.

A computation returns a float (a flag counts as 1 or 0), or None where the quantity does not exist, and raises
`MissingError` where the evidence lacks what it needs. Its docstring says what it computes, and in which unit.
"""

import pkgutil
from collections.abc import Callable
from importlib import import_module
from typing import Any

from hknob_cli.results.evidence import Evidence

Check = Callable[..., float | bool | None]

CHECKS: dict[str, Check] = {}


def check(function: Check) -> Check:
    """Register a computation under its name."""
    CHECKS[function.__name__] = function
    return function


def compute(name: str, evidence: Evidence, arguments: dict[str, Any]) -> float | None:
    """Value of a computation. Raises `MissingError`, and `TypeError` for arguments it does not take."""
    value = CHECKS[name](evidence, **arguments)
    return None if value is None else float(value)


# Each module beside this one registers its own.
for _module in pkgutil.iter_modules(__path__):
    import_module(f"{__name__}.{_module.name}")
