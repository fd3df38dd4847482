"""The events of a trial without a sample clock, one row each: from them the exact state at any time follows."""

from typing import NamedTuple

from hknob_cli.engine.unsampled.edge_time import EDGE, TURN
from hknob_cli.engine.unsampled.state_machine import acceleration, heading, move_on


class Ending(NamedTuple):
    """Where a motion ends: at the time ``until``, or at rest.

    Where ``rest`` is the only rest point (``single``) and a count edge, chatter over it that gets no further than
    ``height`` is rest.
    """

    until: float
    single: bool
    rest: float
    height: float


def is_chatter(edge, v, height, loop):
    """Whether a knob that passes ``edge`` at ``v`` gets no further than ``height`` on either side of it."""
    above = 0.0 - edge
    falls = -acceleration(above, edge, 0.0, loop)
    rises = acceleration(above + 1.0, edge, 0.0, loop)
    return v * v <= 2.0 * height * min(falls, rises)


def record_motion(state, ending, loop, rows, filled, capacity):
    """Write the state after each event into ``rows``, from the row ``filled`` on, up to the ``ending``.

    ``state``: the time t, then n, edge, u, v, way as `state_machine` has them; ``rows`` holds as many, flat. Returns
    ``(filled, done)``: not done where ``rows`` is full.
    """
    t, n, edge, u, v, way = state
    alone = ending.single and loop.counted > 0.0
    while filled < capacity:
        kind, n, edge, u, v, dt = move_on(n, edge, u, v, way, float("inf"), loop)
        if (kind != EDGE and kind != TURN) or t + dt > ending.until:
            return filled, True
        t += dt
        if alone and kind == EDGE and edge == ending.rest and is_chatter(edge, v, ending.height, loop):
            v = 0.0
        if v == 0.0:
            n, way = heading(n, edge, u, loop)
        base = 6 * filled
        rows[base], rows[base + 1], rows[base + 2] = t, n, edge
        rows[base + 3], rows[base + 4], rows[base + 5] = u, v, way
        filled += 1
        if way == 0.0:
            return filled, True
    return filled, False
