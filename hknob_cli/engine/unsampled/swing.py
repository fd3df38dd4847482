"""One undamped swing, from its top to its bottom: duration, and integrals of the angle and of its square.

An undamped motion comes back the way it went, in the same time: the swing is half of its period.
"""

from math import ceil, sqrt

from hknob_cli.engine.propagator import hold_coefficients
from hknob_cli.engine.unsampled.edge_time import EDGE
from hknob_cli.engine.unsampled.state_machine import acceleration, heading, move_on, place
from hknob_cli.engine.unsampled.wall_pieces import piece_stiffness

# Gauss-Legendre, 10 nodes: the positive ones and their weights (Abramowitz & Stegun, table 25.4).
NODES = (0.14887433898163122, 0.4333953941292472, 0.6794095682990244, 0.8650633666889845, 0.9739065285171717)
WEIGHTS = (0.2955242247147528, 0.2692667193099965, 0.219086362515982, 0.1494513491505804, 0.06667134430868814)


def swing_moments(top, reference, loop):
    """Integrals over the swing down from rest at ``top``: ``(duration, bottom, of x - reference, of its square)``.

    Each piece is cut into parts of at most one radian of the plant's ringing, where ten nodes are exact to rounding.
    """
    n, edge, u = place(top, 0.0, loop)
    n, way = heading(n, edge, u, loop)
    v, total, first, second = 0.0, 0.0, 0.0, 0.0
    going = way < 0.0
    while going:
        stiffness = piece_stiffness(n, loop)
        y = acceleration(n, edge + u, way, loop)
        start, speed = (edge - reference) + u, v
        kind, n, edge, u, v, t = move_on(n, edge, u, v, way, float("inf"), loop)
        parts = max(1.0, float(ceil(sqrt(stiffness) * t)))
        h = 0.5 * t / parts
        for part in range(int(parts)):
            for i in range(5):
                for sign in (-1.0, 1.0):
                    at = h * (2.0 * part + 1.0 + sign * NODES[i])
                    s, g, _ = hold_coefficients(loop.alpha, stiffness, at)
                    x = start + (s * speed + g * y)
                    first += h * WEIGHTS[i] * x
                    second += h * WEIGHTS[i] * x * x
        total += t
        going = kind == EDGE  # without a speed, too: it then turns at once
    return total, edge + u, first, second
