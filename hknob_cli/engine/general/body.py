"""The body that the torque moves: knob and hand, with or without a finger of its own, lag and Coulomb friction.

State ``z``, in counts and sample periods: (x, v) of the knob; with a finger also (d, w), angle and speed of the knob
*relative* to it (Hasser, eq. 1; a stiff fingerpad leaves no difference of large numbers); with a shorted winding that
has inductance also y, the turn that it remembers, y' = v - R/L y, which it answers as a spring of Kt^2/L; with lag also
the torque that acts, as an acceleration of the knob. ``order`` counts them: 2 to 6. Between events, the motion being
linear,

    z' = A z + c + p u,   z(t) = z + D(t) (A z + c + p u),   D(t) = integral of exp(A s) over [0, t],

and ``u`` is the acceleration by torques that are constant. While friction holds the knob, the rest moves by another A.

The energy of the difference of two motions never grows while they get the same commands: springs and masses keep it,
dampers take it, and friction, a monotone function of speed, takes it, too (Brezis 1973, ch. 3).
"""

from math import inf, sqrt
from typing import Any, NamedTuple


class Body(NamedTuple):
    """Numbers of a body; ``matrices`` and ``vectors`` are flat, and lists or arrays."""

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
    coil: float  # stiffness of a shorted winding, Kt^2/L T^2 / J; 0 without one
    coil_rate: float  # sample periods over its time constant, R/L T
    lag: float  # sample periods over time constant; 0 without lag
    shift: float  # neutral angle of the hand is at x = -shift
    push: float  # bias, into the wall
    drive: float  # constant acceleration of the knob by bias and neutral angle
    reach: float  # position for unit root of energy: distance <= reach * norm; inf where nothing holds the knob
    damped: bool
    s1: float  # of second order: the plant over the part of an interval under the older command
    g1: float
    f1: float
    s2: float  # and over the rest
    g2: float
    f2: float
    terms: int  # of second order: of the power series of S / t and G / t^2; 0 where they converge slowly
    matrices: Any  # RATES, HELD, FIRST, SECOND, HALVES..., HALVES_HELD..., (order * order) each
    vectors: Any  # CONSTANT, CONSTANT_HELD, ENTRY, (order) each; then both series, (terms) each
    play: float  # between the teeth of a gear; 0 where they cannot part
    halt: Any  # (1); above 0 where the search is to be given up, what is under way without a result
    cogs: Any = None  # a torque of the true angle, as `cogging` has it: list or array


HALVINGS = 53  # D down to the last bit of a sample period
RATES, HELD = 0, 1  # A, sliding and held by friction; or with teeth that press and teeth apart
FIRST, SECOND = 2, 3  # D over the part of an interval under the older command, and over the rest
HALVES, HALVES_HELD = 4, 4 + HALVINGS  # D(1), D(1/2), D(1/4), ...; not of second order
ADDED = 4 + 2 * HALVINGS  # D over the pieces of an interval under a law, without friction; not of second order
STUCK = ADDED  # with play and friction: A of a motor that is held, teeth pressing and apart, then D as `HALVES` of both
STUCK_HALVES = STUCK + 2
CONSTANT, CONSTANT_HELD, ENTRY = 0, 1, 2  # c, sliding and held; p
CONSTANT_STUCK = 3  # with play and friction: c of a motor that is held


def copy_to(target, source):
    """Copy a state, or what is remembered."""
    for j in range(len(source)):
        target[j] = source[j]


def rate_of(z, u, mode, body, out):
    """Rate of the state under the command ``u``; ``mode``: +1 and -1 sliding, 0 held, 2 without friction."""
    n = body.order
    extra = 0.0
    if mode == 1 or mode == -1:
        extra = -mode * body.friction
    if body.lag == 0.0:
        extra += u
    matrix = (HELD if mode == 0 else RATES) * n * n
    for i in range(n):
        if mode == 0:
            total = body.vectors[CONSTANT_HELD * n + i]
        else:
            total = body.vectors[CONSTANT * n + i] + body.vectors[ENTRY * n + i] * extra
        for j in range(n):
            total += body.matrices[matrix + i * n + j] * z[j]
        out[i] = total
    if body.lag > 0.0:
        out[n - 1] += body.lag * u


def coil_at(body):
    """Where a state has the turn that a shorted winding remembers."""
    return 4 if body.ratio > 0.0 else 2


def acceleration(z, u, body):
    """Acceleration of the knob without friction."""
    n = body.order
    total = body.drive
    for j in range(n):
        total += body.matrices[n + j] * z[j]
    return total if body.lag > 0.0 else total + u


def norm_at(dz, at, body):
    """`norm` of the difference of states that begins at ``dz[at]``."""
    if body.ratio > 0.0:
        finger, tip = dz[at + 1] - dz[at + 3], dz[at] - dz[at + 2]
        square = dz[at + 1] * dz[at + 1] + body.pad_stiffness * dz[at + 2] * dz[at + 2]
        square += (finger * finger + body.finger_stiffness * tip * tip) / body.ratio
    else:
        square = dz[at + 1] * dz[at + 1] + body.beta * dz[at] * dz[at]
    if body.coil > 0.0:
        turn = dz[at + coil_at(body)]
        square += body.coil * turn * turn
    late = abs(dz[at + body.order - 1]) / body.lag if body.lag > 0.0 else 0.0
    return sqrt(square) + late


def norm(dz, body):
    """Root of the energy of a difference of states, as speed of the knob; lag counted by what it can still add."""
    return norm_at(dz, 0, body)


def turn_finger(dz, body):
    """Turn round a finger's numbers: of all differences whose numbers are at most ``dz``, it then has most energy.

    The numbers are at least 0 before. The energy is convex, and largest where knob and finger go opposite ways. Twice,
    ``dz`` is as it was.
    """
    if body.ratio > 0.0:
        dz[2] = -dz[2]
        dz[3] = -dz[3]


def stiffness(body):
    """Bound on the acceleration of the knob by springs and dampers, by `norm`."""
    if body.ratio > 0.0:
        own = body.alpha + body.pad_damping * (1.0 + sqrt(body.ratio)) + sqrt(body.pad_stiffness)
    else:
        own = body.alpha + sqrt(body.beta)
    return own + sqrt(body.coil) if body.coil > 0.0 else own


def distance(dz, body):
    """Bound on how far apart in position two motions get under the same commands, from their difference now."""
    if body.order == 2 and body.beta == 0.0 and body.friction == 0.0:
        if body.alpha == 0.0:
            return inf
        return abs(dz[0]) + abs(dz[1]) / body.alpha
    return body.reach * norm(dz, body)
