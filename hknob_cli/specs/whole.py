"""One of a few whole numbers, written as one: 1.0 and true are equal to 1 in Python, and would be taken for it."""

from typing import Any

from pydantic import BeforeValidator
from pydantic_core import PydanticKnownError


def _as_written(value: Any) -> Any:
    if isinstance(value, bool | float):
        raise PydanticKnownError("int_type")
    return value


WHOLE = BeforeValidator(_as_written)
