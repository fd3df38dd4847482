"""Loops, arcs and polygons that the tests of sets share."""

import numpy as np
from hypothesis import strategies as st

from hknob_cli.engine.loop import Loop, make_loop
from hknob_cli.engine.sets.room import Known, make_known


def zeros(count: int) -> list[float]:
    """Work space of the interpreter."""
    return [0.0] * count


def knob(sense: float = 1.0, offset: float = 0.0, split: float = 0.0) -> Loop:
    """Hasser's knob at 464 Hz and 1024 counts."""
    return make_loop(0.338, 0.0844, 0.5696, 0.344, sense, offset, split)


def known(delay: int = 0) -> Known:
    """Room for attractors."""
    return make_known(zeros, delay)


def expm(matrix: np.ndarray) -> np.ndarray:
    """Matrix exponential, by SciPy."""
    from scipy.linalg import expm as exponential

    return exponential(matrix)


def free_response(loop: Loop, t: float) -> np.ndarray:
    """Transition matrix of the free plant over ``t`` samples."""
    return expm(np.array([[0.0, 1.0], [-loop.beta, -loop.alpha]]) * t)


numbers = st.floats(allow_nan=False, allow_infinity=False)
loops = st.builds(
    lambda alpha, beta, kappa, gamma, sense: make_loop(alpha, beta, kappa, gamma, sense, 0.0, 0.0),
    alpha=st.floats(1e-3, 3.0),
    beta=st.floats(1e-5, 20.0),
    kappa=st.floats(1e-4, 20.0),
    gamma=st.floats(0.0, 5.0),
    sense=st.sampled_from([1.0, -1.0]),
)
