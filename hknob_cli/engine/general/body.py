"""The body that the torque moves: knob and hand, with or without a finger of its own, lag and Coulomb friction.

State ``z``, in counts and sample periods: (x, v) of the knob; with a finger also (d, w), angle and speed of the knob
*relative* to it (Hasser, eq. 1; a stiff fingerpad leaves no difference of large numbers); with lag also the torque that
acts, as an acceleration of the knob. ``order`` counts them: 2 to 5. Between events the motion is linear,

    z' = A z + c + p u,   z(t) = z + D(t) (A z + c + p u),   D(t) = integral of exp(A s) over [0, t],

and ``u`` is the acceleration by torques that are constant. While friction holds the knob, the rest moves by another A.

The energy of the difference of two motions never grows while they get the same commands: springs and masses keep it,
dampers take it, and friction, a monotone function of speed, takes it, too (Brezis 1973, ch. 3).
"""

from math import sqrt
from typing import Any, NamedTuple


class Body(NamedTuple):
    """Numbers of a body; matrices are flat, row by row, and lists or arrays."""

    order: int
    friction: float  # Coulomb level, Tc T^2 / (J quantum)
    alpha: float  # damping of knob (and, of second order, hand), b T / J
    beta: float  # stiffness of a second-order hand, k T^2 / J
    spacing: float  # of second order: time between zeros of the velocity; inf without ringing
    pad_damping: float  # fingerpad
    pad_stiffness: float
    ratio: float  # knob inertia over finger inertia; 0 without a finger
    finger_damping: float  # finger to ground, per finger inertia
    finger_stiffness: float
    lag: float  # sample periods over time constant; 0 without lag
    shift: float  # neutral angle of the hand is at x = -shift
    push: float  # bias, into the wall
    reach: float  # position for unit root of energy: distance <= reach * norm; inf where nothing holds the knob
    damped: bool
    s1: float  # of second order: the plant over the part of an interval under the older command
    g1: float
    f1: float
    s2: float  # and over the rest
    g2: float
    f2: float
    rates: Any  # A, sliding
    held: Any  # A, held by friction
    constant: Any  # c, sliding
    constant_held: Any
    entry: Any  # p
    first: Any  # D over the part of an interval under the older command
    second: Any  # D over the rest
    halves: Any  # D(1), D(1/2), D(1/4), ..., sliding; empty for second order
    halves_held: Any


HALVINGS = 53  # D down to the last bit of a sample period


def rate_of(z, u, mode, body, out):
    """Rate of the state under the command ``u``; ``mode``: +1 and -1 sliding, 0 held, 2 without friction."""
    n = body.order
    extra = 0.0
    if mode == 1 or mode == -1:
        extra = -mode * body.friction
    if body.lag == 0.0:
        extra += u
    for i in range(n):
        total = body.constant_held[i] if mode == 0 else body.constant[i] + body.entry[i] * extra
        for j in range(n):
            total += (body.held[i * n + j] if mode == 0 else body.rates[i * n + j]) * z[j]
        out[i] = total
    if body.lag > 0.0:
        out[n - 1] += body.lag * u


def acceleration(z, u, body):
    """Acceleration of the knob without friction."""
    n = body.order
    total = body.constant[1]
    for j in range(n):
        total += body.rates[n + j] * z[j]
    return total if body.lag > 0.0 else total + u


def norm(dz, body):
    """Root of the energy of a difference of states, as speed of the knob; lag counted by what it can still add."""
    if body.ratio > 0.0:
        finger, tip = dz[1] - dz[3], dz[0] - dz[2]
        square = dz[1] * dz[1] + body.pad_stiffness * dz[2] * dz[2]
        square += (finger * finger + body.finger_stiffness * tip * tip) / body.ratio
    else:
        square = dz[1] * dz[1] + body.beta * dz[0] * dz[0]
    late = abs(dz[body.order - 1]) / body.lag if body.lag > 0.0 else 0.0
    return sqrt(square) + late


def distance(dz, body):
    """Bound on how far apart in position two motions get under the same commands, from their difference now."""
    if body.order == 2 and body.beta == 0.0 and body.friction == 0.0:
        return abs(dz[0]) + abs(dz[1]) / body.alpha
    return body.reach * norm(dz, body)
