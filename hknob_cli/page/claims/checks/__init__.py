"""The computations that claims name: each takes the evidence and the claim's arguments, and gives a number.

A computation returns a float (a flag counts as 1 or 0), or None where the quantity does not exist, and raises
`MissingError` where the evidence lacks what it needs. Its docstring says what it computes, and in which unit.
"""

from collections.abc import Callable
from functools import cache
from importlib import import_module
from inspect import Parameter, signature
from pkgutil import iter_modules
from typing import Any

from hknob_cli.errors import MISSHAPEN, UsageError
from hknob_cli.results.result_set import ResultSet
from hknob_cli.specs.messages import nearest, shown

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


def argument_fault(function: Callable[..., Any], given: dict[str, Any], *, before: int) -> str | None:
    """What is wrong with keyword arguments, whatever their values; None if nothing is.

    The first ``before`` parameters are not the user's.
    """
    names = list(signature(function).parameters.values())[before:]
    allowed = [one.name for one in names]
    for name in given:
        if name not in allowed:
            return nearest(name, allowed).replace("unknown key", f"unknown argument {shown(name)}")
    lacking = [one.name for one in names if one.default is Parameter.empty and one.name not in given]
    return f"needs {', '.join(lacking)}" if lacking else None


def check_fault(name: str, given: dict[str, Any]) -> str | None:
    """What is wrong with a computation's name or arguments; None if nothing is."""
    if name not in known():
        return nearest(name, sorted(known())).replace("unknown key", f"unknown check {shown(name)}")
    wrong = argument_fault(known()[name], given, before=1)
    return f"{name}: {wrong}" if wrong else None


def compute(name: str, evidence: ResultSet, arguments: dict[str, Any]) -> float | None:
    """Value of a computation. Raises `MissingError`, and `UsageError` for arguments that it cannot use."""
    try:
        value = known()[name](evidence, **arguments)
        return None if value is None else float(value)
    except MISSHAPEN as error:
        raise UsageError(f"{name} cannot use {arguments}: {error}") from error
