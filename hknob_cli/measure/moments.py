"""Integrals over one hold as matrices, for many pieces of motion at once; what they are: `engine.orbit.forms`."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hknob_cli.engine.orbit import forms

Array = NDArray[np.float64]


class Forms(NamedTuple):
    """Integrals over one hold of z = (x, v, drive): ``mean`` (3,) of x; ``square`` and ``speed`` (3, 3) of x², v²."""

    mean: Array
    square: Array
    speed: Array


def hold_forms(alpha: float, beta: float, duration: float) -> Forms:
    """Forms over a hold of length ``duration``."""
    numbers = forms.hold_forms(alpha, beta, duration)
    return Forms(np.array(numbers[:3]), _matrix(numbers[3:9]), _matrix(numbers[9:]))


def _matrix(form: tuple[float, ...]) -> Array:
    xx, xv, xu, vv, vu, uu = form
    return np.array([[xx, xv, xu], [xv, vv, vu], [xu, vu, uu]])
