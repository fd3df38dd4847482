"""The events of a trial without a sample clock, one row each: from them the exact state at any time follows."""

from hknob_cli.engine.unsampled.edge_time import EDGE, TURN
from hknob_cli.engine.unsampled.state_machine import acceleration, heading, move_on


def is_chatter(edge, v, height, loop):
    """Whether a knob that passes ``edge`` at ``v`` gets no further than ``height`` on either side of it."""
    above = 0.0 - edge
    falls = -acceleration(above, edge, 0.0, loop)
    rises = acceleration(above + 1.0, edge, 0.0, loop)
    return v * v <= 2.0 * height * min(falls, rises)


def record_motion(t, n, edge, u, v, way, until, single, rest, height, loop, rows, filled, capacity):
    """Write the state after each event up to the time ``until`` into ``rows``, from the row ``filled`` on.

    The state is that of `state_machine`, at the time ``t``; ``rows`` holds t, n, edge, u, v, way, flat. Where ``rest``
    is the only rest point (``single``) and a count edge, chatter over it that gets no further than ``height`` is
    rest. Returns ``(filled, done)``: not done where ``rows`` is full.
    """
    while filled < capacity:
        kind, n, edge, u, v, dt = move_on(n, edge, u, v, way, float("inf"), loop)
        if (kind != EDGE and kind != TURN) or t + dt > until:
            return filled, True
        t += dt
        if single and kind == EDGE and edge == rest and loop.counted > 0.0 and is_chatter(edge, v, height, loop):
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
