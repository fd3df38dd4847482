"""The sampled loop in numbers: everything the recursion needs, without dimensions.

Angle ``x`` is in encoder counts from the encoder edge that bounds level 0, time in sample periods. The wall acts on
the *level* of the encoder, a whole number that is 0 outside the wall and -1, -2, ... inside.
"""

from typing import NamedTuple

from hknob_cli.engine.propagator import hold_coefficients


def floor(value):
    """Largest whole number not above a finite ``value``, as a float."""
    return value // 1.0


class Loop(NamedTuple):
    """One cell's plant, wall, encoder and delay, dimensionless; every field is a float."""

    alpha: float  # damping, b T / J
    beta: float  # hand stiffness, k T^2 / J
    kappa: float  # wall stiffness, K T^2 / J
    gamma: float  # constant push into the wall, per count
    sense: float  # +1: a level holds its lower edge (floor); -1: its upper edge (ceil)
    offset: float  # the angle an encoder level reports, less the level, in counts: 0 <= offset < 1
    split: float  # part of an interval that still runs under the older command; 0 without a fractional delay
    s1: float  # the plant over ``split``
    g1: float
    f1: float
    s2: float  # the plant over the rest of the interval
    g2: float
    f2: float


def make_loop(alpha, beta, kappa, gamma, sense, offset, split):
    """The loop with these numbers, and the plant over the two parts of an interval."""
    s1, g1, f1 = hold_coefficients(alpha, beta, split)
    s2, g2, f2 = hold_coefficients(alpha, beta, 1.0 - split)
    return Loop(alpha, beta, kappa, gamma, sense, offset, split, s1, g1, f1, s2, g2, f2)


def level_of(x, sense):
    """Encoder level at ``x``: 0 outside the wall, negative inside."""
    q = floor(x) if sense > 0.0 else -floor(-x)  # a choice costs less than two products, each waiting for the last
    return q if q < 0.0 else 0.0


def drive_of(level, loop):
    """Acceleration by wall and bias while ``level`` is the one acted on: the virtual wall, -K times measured angle."""
    if level < 0.0:
        return -loop.kappa * (level + loop.offset) - loop.gamma
    return -loop.gamma


def upper_edge(level, sense):
    """Upper end of the positions that act like ``level``; infinite for level 0, where the wall is off."""
    if level == 0.0:
        return float("inf")
    return level + 1.0 if sense > 0.0 else level


def lower_edge(level, sense):
    """Lower end of the positions that act like ``level``."""
    return level if sense > 0.0 else level - 1.0


def copy_line(ring):
    """A copy of a delay line; an empty one itself: to make room for nothing takes longer than to follow a sample."""
    return ring.copy() if len(ring) > 0 else ring


def push(level, ring, head, loop):
    """Queue ``level`` in the delay line; the two drives of this interval, older first.

    ``ring`` holds the levels commanded at earlier samples, oldest at ``head``; empty without a delay, where the
    first drive is not used.
    """
    if len(ring) == 0:
        return 0.0, drive_of(level, loop)
    older = drive_of(ring[head], loop)
    ring[head] = level
    return older, drive_of(ring[(head + 1) % len(ring)], loop)


def interval(x, v, older, newer, loop):
    """State one sample later: ``split`` periods under the drive ``older``, the rest under ``newer``."""
    if loop.split > 0.0:
        y = older - loop.beta * x
        x, v = x + (loop.s1 * v + loop.g1 * y), loop.f1 * v + loop.s1 * y
    y = newer - loop.beta * x
    return x + (loop.s2 * v + loop.g2 * y), loop.f2 * v + loop.s2 * y
