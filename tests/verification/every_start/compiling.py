"""Whether the functions that do the work are compiled: only if HKNOB_TESTS_COMPILED is set before they are imported.

A few thousand samples are done by the interpreter sooner than a compiler is.
"""

import os
from collections.abc import Callable
from typing import TypeVar

Function = TypeVar("Function", bound=Callable)


def compiled(function: Function) -> Function:
    """The function, compiled by numba or as it is."""
    if not os.environ.get("HKNOB_TESTS_COMPILED"):
        return function
    from numba import njit

    return njit(function)
