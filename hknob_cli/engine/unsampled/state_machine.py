"""The motion without a sample clock, from event to event: count edges, turning points, stick, rest.

A state is ``(n, edge, u, v)``: the piece, a position ``edge + u`` told from a nearby edge so that the smallest
excursion keeps its digits, and the velocity. On an edge ``u`` is exactly 0. With it goes ``way``, the direction of
motion: +1, -1, or 0 at rest, for friction acts against it even where the velocity is momentarily zero.
"""

from hknob_cli.engine.unsampled.edge_time import EDGE, ENDS, TURN, damped_step, undamped_step
from hknob_cli.engine.unsampled.wall_pieces import lower_end, piece_drive, piece_stiffness, upper_end


def place(x, v, loop):
    """Piece, edge and distance from the edge of a position ``x`` at velocity ``v``: ``(n, edge, u)``."""
    if loop.kappa == 0.0 or x > 0.0 or (x == 0.0 and v >= 0.0):
        return 0.0, 0.0, x
    if loop.counted == 0.0:
        return 1.0, 0.0, x
    n = -(x // 1.0)
    if x == -n:
        return (n + 1.0 if v < 0.0 else n), 0.0 - n, 0.0
    edge = 1.0 - n if x + n > 0.5 else 0.0 - n
    return n, edge, x - edge


def acceleration(n, x, way, loop):
    """Acceleration at ``x`` in piece ``n`` while moving in the direction ``way``, except for the damping."""
    return piece_drive(n, loop) - way * loop.phi - piece_stiffness(n, loop) * x


def heading(n, edge, u, loop):
    """Where a knob without velocity goes: ``(n, way)``, ``way`` 0 if it rests.

    On an edge it rests unless the side above pushes up, or the side below pushes down, by more than the friction;
    never both, for the push grows with depth.
    """
    if u == 0.0 and loop.kappa > 0.0:
        above = 0.0 - edge
        if acceleration(above, edge, 1.0, loop) > 0.0:
            return above, 1.0
        if acceleration(above + 1.0, edge, -1.0, loop) < 0.0:
            return above + 1.0, -1.0
        return n, 0.0
    if acceleration(n, edge + u, 1.0, loop) > 0.0:
        return n, 1.0
    if acceleration(n, edge + u, -1.0, loop) < 0.0:
        return n, -1.0
    return n, 0.0


def set_off(n, edge, u, v, loop):
    """Where a knob goes, which moves or does not: ``(n, way)``."""
    if v == 0.0:
        return heading(n, edge, u, loop)
    return n, (1.0 if v > 0.0 else -1.0)


def move_on(n, edge, u, v, way, goal, loop):
    """The next event: ``(kind, n, edge, u, v, time)``, the state as it is just after it.

    ``goal``: a position at which to stop as well, or infinite. ``ENDS`` is a rest approached for ever; the state is
    then the rest.
    """
    stiffness = piece_stiffness(n, loop)
    y = acceleration(n, edge + u, way, loop)
    ahead = upper_end(n) if way > 0.0 else lower_end(n, loop)
    gap = (ahead - edge) - u
    stop = (goal - edge) - u
    early = 0.0 <= way * stop < way * gap
    if early:
        gap = stop
    if loop.alpha == 0.0:
        kind, move, v, t = undamped_step(v, y, way, gap, stiffness)
    else:
        kind, move, v, t = damped_step(v, y, way, gap, loop.alpha, stiffness)
    if kind == EDGE and not early:
        return kind, n - way, ahead, 0.0, v, t
    if (kind == TURN or kind == ENDS) and move == gap and not early:
        return kind, n, ahead, 0.0, v, t
    return kind, n, edge, u + move, v, t


def time_to(n, edge, u, v, goal, loop):
    """Time from a state to the position ``goal``, which is ahead, before the motion turns."""
    n, way = set_off(n, edge, u, v, loop)
    total = 0.0
    while way * (goal - (edge + u)) > 0.0:
        kind, n, edge, u, v, t = move_on(n, edge, u, v, way, goal, loop)
        total += t
        if kind != EDGE:
            break
    return total
