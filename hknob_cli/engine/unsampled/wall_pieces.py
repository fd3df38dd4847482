"""The wall without a sample clock: pieces of the angle, in each of which the motion is linear.

With an encoder the torque is a staircase: piece 0 is all that lies outside the wall, piece n = 1, 2, ... the n-th count
inside it, between the edges 1 - n and -n. With a continuous sensor there are two pieces, and piece 1 has the stiffness
of the wall. Angle ``x`` is measured from the wall's edge, in counts where there are any; time in a unit of the scene's.

The torque never falls with depth, so that the potential energy is convex: rest points form one interval, which is known
before anything moves (`rest_range`).
"""

from typing import NamedTuple


class Unsampled(NamedTuple):
    """Plant, wall and encoder, dimensionless; every field is a float. J x'' + ... is divided by J."""

    alpha: float  # damping
    beta: float  # hand stiffness
    kappa: float  # wall stiffness; 0: there is no wall
    gamma: float  # constant push into the wall
    phi: float  # Coulomb friction
    offset: float  # the angle that an encoder level reports, less the level, in counts: 0 <= offset < 1
    counted: float  # 1 with an encoder, 0 with a continuous sensor


def piece_drive(n, loop):
    """Acceleration in piece ``n`` by bias and encoder wall: what does not depend on the angle, without friction."""
    if n > 0.0 and loop.counted > 0.0:
        return loop.kappa * (n - loop.offset) - loop.gamma
    return -loop.gamma


def piece_stiffness(n, loop):
    """Stiffness in piece ``n``: of the hand, and of the wall where the sensor is continuous."""
    if n > 0.0 and loop.counted == 0.0:
        return loop.beta + loop.kappa
    return loop.beta


def upper_end(n):
    """Upper end of piece ``n``; infinite outside the wall."""
    return 1.0 - n if n > 0.0 else float("inf")


def lower_end(n, loop):
    """Lower end of piece ``n``; infinite where nothing changes further in."""
    if loop.kappa == 0.0 or (n > 0.0 and loop.counted == 0.0):
        return -float("inf")
    return 0.0 - n


def wall_potential(x, loop):
    """Energy stored in the wall at ``x``: the area under its torque, which is exact at count edges."""
    depth = -x
    if depth <= 0.0:
        return 0.0
    if loop.counted == 0.0:
        return 0.5 * loop.kappa * depth * depth
    whole = depth // 1.0
    return loop.kappa * (whole * (0.5 * (whole + 1.0) - loop.offset) + (whole + 1.0 - loop.offset) * (depth - whole))


def potential(x, loop):
    """Potential energy at ``x`` of bias, hand and wall; 0 at the wall's edge."""
    return (loop.gamma + 0.5 * loop.beta * x) * x + wall_potential(x, loop)


def highest_rest(loop):
    """Highest position at which the knob can rest: pushed up by no less than minus the friction, below it at least."""
    inf = float("inf")
    n = 0.0
    if loop.phi < loop.gamma and loop.kappa > 0.0:
        n = 1.0
        if loop.counted > 0.0:
            deep = (loop.gamma - loop.phi + loop.kappa * loop.offset) / (loop.kappa + loop.beta)
            n = max(-(-deep // 1.0), 1.0)
    pull, stiffness = piece_drive(n, loop) + loop.phi, piece_stiffness(n, loop)
    low, high = lower_end(n, loop), upper_end(n)
    if stiffness > 0.0:
        return min(max(pull / stiffness, low), high)
    return high if pull >= 0.0 else -inf


def lowest_rest(loop):
    """Lowest position at which the knob can rest: pushed up by no more than the friction, above it at least."""
    inf = float("inf")
    n = 0.0
    if loop.kappa > 0.0 and loop.counted > 0.0:
        deep = (loop.gamma + loop.phi + loop.kappa * loop.offset + loop.beta) / (loop.kappa + loop.beta)
        n = max(deep // 1.0, 0.0)
    elif loop.kappa > 0.0 and -loop.gamma - loop.phi < 0.0:
        n = 1.0
    pull, stiffness = piece_drive(n, loop) - loop.phi, piece_stiffness(n, loop)
    low, high = lower_end(n, loop), upper_end(n)
    if stiffness > 0.0:
        return min(max(pull / stiffness, low), high)
    return low if pull <= 0.0 else inf


def rest_range(loop):
    """Lowest and highest position at which the knob can rest; the first above the second where there is none.

    Rest on an edge is meant in Filippov's sense: the torques on its two sides, friction added, push towards it or hold.
    """
    return lowest_rest(loop), highest_rest(loop)
