"""Teeth with play: the motion from flank to flank, exact; teeth press, they never pull.

The mesh's angle d is counted from the flank on which the wall holds the push; the other flank is at -play. With o, the
overlap of teeth on a flank, they carry max(0, k o + c o') where o > 0, and nothing else: a tooth whose spring and
damper would pull is left, and relaxes. The torque is that of the state alone, so that it needs no memory. It jumps, by
c o', where teeth meet; where they part it is 0 on both sides. So there are three linear modes, and their ends are zeros
of o, or of the torque (`teeth_ends`).

With friction the motor slides, one way or the other, or is held: each flank has three modes. What ends one is a zero of
the motor's speed, or of what friction lacks to hold it, beside those of the teeth. Cogging of the motor has two linear
modes of each in which it moves, and a corner of its torque is one more end; ``slope`` is its number.
"""

from hknob_cli.engine.general.body import (
    CONSTANT,
    CONSTANT_STUCK,
    ENTRY,
    HALVES,
    HALVES_HELD,
    HALVINGS,
    HELD,
    RATES,
    STUCK,
    STUCK_HALVES,
)
from hknob_cli.engine.general.cogging import (
    TOOTHED_HALVES,
    has_cogs,
    is_stable,
    slope_pull,
)
from hknob_cli.engine.general.slide_two import way

APART = 2  # modes of a piece that is written down, by the sign of the speed: 1 on the wall's flank, 2 on none,
BACK = 3  # and 3 on the other; with a motor that friction holds 0,
STUCK_APART, STUCK_BACK = 4, 5  # and these
ON_STABLE, ON_UNSTABLE = 7, 10  # what is added to one of a motor that moves on a slope of cogging
SPRUNG = 4  # end of a mode, beside `TURNED`, that of the motor's way, and corners of cogging: of what teeth did


def overlap(d, side, body):
    """How far teeth overlap on a flank, +1 the wall's and -1 the other; below 0 they do not touch."""
    return d if side > 0 else -(d + body.play)


def pressing(z, at, side, body):
    """Torque of the mesh on a flank if teeth touch there, as an acceleration of the motor, out of the gap."""
    return body.pad_stiffness * overlap(z[at + 2], side, body) + side * body.pad_damping * z[at + 3]


def touches(z, at, side, body):
    """Whether teeth press on a flank: they overlap, and spring and damper do not pull."""
    return overlap(z[at + 2], side, body) > 0.0 and pressing(z, at, side, body) > 0.0


def flank(z, body):
    """Flank on which teeth press: +1 the wall's, -1 the other, 0 none."""
    if touches(z, 0, 1, body):
        return 1
    return -1 if touches(z, 0, -1, body) else 0


def teeth_rate(z, u, side, toward, body, out, slope=0.0):
    """Rate of the state under the command ``u``, on a flank or on none.

    ``toward``: sign of the motor's speed, against which friction acts; 0 where there is none, or where it holds.
    """
    n = body.order
    if toward == 0 and body.friction > 0.0:
        matrix = (STUCK + (1 if side == 0 else 0)) * n * n
        for i in range(n):
            total = body.vectors[CONSTANT_STUCK * n + i]
            for j in range(n):
                total += body.matrices[matrix + i * n + j] * z[j]
            out[i] = total
        if side < 0:
            out[3] -= body.ratio * body.pad_stiffness * body.play
        if body.lag > 0.0:
            out[n - 1] += body.lag * u
        return
    matrix = (HELD if side == 0 else RATES) * n * n
    command = (0.0 if body.lag > 0.0 else u) - toward * body.friction
    if has_cogs(body.cogs):
        command += slope_pull(body.cogs, z[0], slope)
    for i in range(n):
        total = body.vectors[CONSTANT * n + i] + body.vectors[ENTRY * n + i] * command
        for j in range(n):
            total += body.matrices[matrix + i * n + j] * z[j]
        out[i] = total
    if side < 0:
        away = body.pad_stiffness * body.play
        out[1] -= away
        out[3] -= (1.0 + body.ratio) * away
    if body.lag > 0.0:
        out[n - 1] += body.lag * u


def teeth_pull(z, at, u, side, body, slope=0.0):
    """Acceleration of the motor without friction, on a flank or on none."""
    n = body.order
    matrix = (HELD if side == 0 else RATES) * n * n
    total = body.vectors[CONSTANT * n + 1]
    if has_cogs(body.cogs):
        total += slope_pull(body.cogs, z[at], slope)
    if body.lag == 0.0:
        total += u
    for j in range(n):
        total += body.matrices[matrix + n + j] * z[at + j]
    if side < 0:
        total -= body.pad_stiffness * body.play
    return total


def direction(z, u, side, body, slope=0.0):
    """Sign of the motor's speed from here on; 0 where friction holds it."""
    pull = teeth_pull(z, 0, u, side, body, slope)
    if body.friction > 0.0:
        return way(z[1], pull, body.friction)
    return 1 if z[1] > 0.0 or (z[1] == 0.0 and pull > 0.0) else -1


def halves_of(side, toward, slope, body):
    """Where `Body.matrices` has D, as `HALVES`, of a mode."""
    if toward == 0 and body.friction > 0.0:
        return STUCK_HALVES + (HALVINGS if side == 0 else 0)
    if has_cogs(body.cogs):
        return TOOTHED_HALVES + ((0 if side != 0 else 2) + (0 if is_stable(slope) else 1)) * HALVINGS
    return HALVES_HELD if side == 0 else HALVES
