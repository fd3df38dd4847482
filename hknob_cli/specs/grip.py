"""A grip force: of the printed hand models one that Tables 1-5 have a row for, of a file one that it has."""

from math import isclose
from typing import Annotated, Any

from pydantic import ValidationInfo
from pydantic_core import PydanticCustomError

from hknob_cli.specs.quantity import Quantity

Grip = Annotated[float, Quantity("N")]


def printed_grips() -> list[float]:
    """Grip forces (N) of Tables 1-5, which are the same in each."""
    from hknob_cli.printed.tables import grasps

    return [grasp.grip_n for grasp in grasps(1)]


def same_grip(one: float, other: float) -> bool:
    """Whether two grip forces (N) are the same except for rounding, of units as of the person who wrote them."""
    return isclose(one, other, rel_tol=1e-9)


def unprinted(grip_n: float) -> str | None:
    """What is wrong with a grip force (N) of a printed hand; None if Tables 1-5 have a row for it."""
    grips = printed_grips()
    if any(same_grip(grip_n, grip) for grip in grips):
        return None
    allowed = ", ".join(f"{grip:g}" for grip in grips)
    return f"must be a grip force of Tables 1-5, {allowed}"


def printed_beside_table(value: float | None, info: ValidationInfo) -> float | None:
    """Validator of a grip force: beside a ``table`` it is one of its rows."""
    wrong = unprinted(value) if value is not None and info.data.get("table") is not None else None
    if wrong:
        raise PydanticCustomError("grip", "{reason}", {"reason": wrong})
    return value


def printed_grip_schema() -> dict[str, Any]:
    """JSON Schema of a grip force beside a table."""
    return {"anyOf": [{"enum": printed_grips()}, {"type": "string"}]}
