"""Loops, arcs and polygons that the tests of sets share."""

from typing import Any

import numpy as np
from hypothesis import strategies as st

from hknob_cli.engine.loop import Loop, make_loop
from hknob_cli.engine.sets import arc
from hknob_cli.engine.sets.ball import Start
from hknob_cli.engine.sets.room import ArcRoom, Known, make_known


def zeros(count: int) -> list[float]:
    """Work space of the interpreter."""
    return [0.0] * count


def knob(sense: float = 1.0, offset: float = 0.0, split: float = 0.0) -> Loop:
    """Hasser's knob at 464 Hz and 1024 counts."""
    return make_loop(0.338, 0.0844, 0.5696, 0.344, sense, offset, split)


def known(delay: int = 0) -> Known:
    """Room for attractors."""
    return make_known(zeros, delay)


def follow_all(
    angle: float,
    velocity: float,
    delay: int,
    budget: int,
    patience: int,
    limit: float,
    room: ArcRoom,
    ends: Known,
    loop: Loop,
    *,
    most: int = 10**9,
    functions: Any = None,
) -> tuple[int, int, float, float, float, bool]:
    """Follow every clock phase to its end, at most ``most`` samples at a time.

    Returns samples, arcs, undecided phases, the shortest arc, the length of all, and whether there was room.
    """
    begin, follow = arc.begin_arcs, arc.follow_arcs
    if functions:
        begin, follow = functions["sets.begin_arcs"], functions["sets.follow_arcs"]
    start = Start(angle, velocity, delay)
    begin(start, patience, room, loop)
    while room.progress[arc.WAITING] > 0.0:
        follow(start, budget, limit, most, True, room, ends, loop)
    told = room.progress
    return (
        int(told[arc.TAKEN]),
        int(told[arc.DONE]),
        told[arc.UNDECIDED],
        told[arc.SHORTEST],
        told[arc.COVERED],
        told[arc.WHOLE] > 0.0,
    )


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
    gamma=st.one_of(st.just(0.0), st.floats(1e-12, 5.0)),
    sense=st.sampled_from([1.0, -1.0]),
)
