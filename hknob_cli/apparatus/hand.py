"""The hand on the knob as a mechanism, of second order or with a finger apart, and its exact motion under torques.

Between events z' = A z + c, so z(t) = z0 + D(t) (A z0 + c) with D(t) the integral of exp(A s) over [0, t]. D at all
samples is one table per mechanism; a stretch without events is then one product. With Coulomb friction the motion
slides one way (another c) until the velocity vanishes, and then turns round or is held (another A) until the other
torques exceed the friction level. The engine's `advance_span` does the same sample by sample, for loops that need
the angle.

A velocity that crosses zero and comes back between two samples is not seen: it stays below |jerk| dt² / 8.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from hknob_cli.errors import ComputationError

FINGER_INERTIA = 3e-7  # kg m^2, "a generous estimate", section 4.4.1
FINGER_TO_PAD = 10.0  # K1 / K2 = B1 / B2, ibid.


class SecondOrder(NamedTuple):
    """J θ'' + B θ' + K θ = T: inertia (kg·m²) of hand and apparatus together, damping (N·m·s/rad), stiffness (N·m/rad).

    The inertia is one number because the firm grips of Tables 1-5 have less of it than the apparatus alone.
    """

    inertia: float
    damping: float
    stiffness: float


class FourthOrder(NamedTuple):
    """The knob (inertia, kg·m²), by a fingerpad (damping, stiffness) on a finger that is held to ground.

    Source: equation 1; the knob is the network's J2, the finger its J1, B1, K1, the fingerpad its B2, K2.
    """

    inertia: float
    finger_inertia: float
    finger_damping: float
    finger_stiffness: float
    pad_damping: float
    pad_stiffness: float


Hand = SecondOrder | FourthOrder


def split(hand: SecondOrder, *, knob_kg_m2: float, finger_kg_m2: float = FINGER_INERTIA) -> FourthOrder:
    """Finger and fingerpad in series that have the hand's damping and stiffness; its inertia does not enter.

    Source: section 4.4.1, K_T = K1 K2 / (K1 + K2) and B_T alike, with K1 = 10 K2 and B1 = 10 B2.
    """
    pad = (1.0 + FINGER_TO_PAD) / FINGER_TO_PAD
    return FourthOrder(
        inertia=knob_kg_m2,
        finger_inertia=finger_kg_m2,
        finger_damping=FINGER_TO_PAD * pad * hand.damping,
        finger_stiffness=FINGER_TO_PAD * pad * hand.stiffness,
        pad_damping=pad * hand.damping,
        pad_stiffness=pad * hand.stiffness,
    )


def static_stiffness(hand: Hand) -> float:
    """Stiffness (N·m/rad) that holds the knob against a constant torque."""
    if isinstance(hand, SecondOrder):
        return hand.stiffness
    total = hand.finger_stiffness + hand.pad_stiffness
    return hand.finger_stiffness * hand.pad_stiffness / total if total > 0.0 else 0.0


Array = np.ndarray[Any, np.dtype[np.float64]]

MOST_EVENTS = 10_000
SLIDING, HELD = 0, 1


class Mechanism(NamedTuple):
    """Knob, hand and amplifier; the state is (θ, ω) of the knob, (θ, ω) of the finger if any, the torque if it lags.

    Angles in rad from the neutral angle, rad/s, N·m. ``rates``: A while sliding and while held, shape (2, n, n);
    ``entry``: rate of the state by a unit of commanded torque, (n,); ``inertia`` (kg·m²) of the knob; ``coulomb``
    (N·m).
    """

    rates: Array
    entry: Array
    inertia: float
    coulomb: float
    stiffness: float

    def rest(self, torque: float) -> Array:
        """State in which the hand is displaced statically by a torque (N·m); neutral without stiffness."""
        state = np.zeros(len(self.entry))
        if torque != 0.0 and self.stiffness > 0.0:
            state[0] = torque / self.stiffness
            if len(state) > 3:
                state[2] = state[0] * self.rates[0, 3, 0] / -self.rates[0, 3, 2]
        return state


def mechanism(hand: Hand, *, coulomb: float = 0.0, lag_s: float = 0.0) -> Mechanism:
    """The mechanism of a hand on a knob with Coulomb friction (N·m), its torque behind the command by a lag (s)."""
    inertia, stiffness = hand.inertia, static_stiffness(hand)
    if isinstance(hand, SecondOrder):
        body = np.array([[0.0, 1.0], [-hand.stiffness / inertia, -hand.damping / inertia]])
    else:
        k1, b1, k2, b2 = hand.finger_stiffness, hand.finger_damping, hand.pad_stiffness, hand.pad_damping
        body = np.array(
            [
                [0.0, 1.0, 0.0, 0.0],
                np.array([-k2, -b2, k2, b2]) / inertia,
                [0.0, 0.0, 0.0, 1.0],
                np.array([k2, b2, -(k1 + k2), -(b1 + b2)]) / hand.finger_inertia,
            ]
        )
    order = len(body) + (lag_s > 0.0)
    rates, entry = np.zeros((2, order, order)), np.zeros(order)
    rates[SLIDING, : len(body), : len(body)] = body
    if lag_s > 0.0:
        rates[SLIDING, 1, -1] = 1.0 / inertia
        rates[SLIDING, -1, -1] = -1.0 / lag_s
        entry[-1] = 1.0 / lag_s
    else:
        entry[1] = 1.0 / inertia
    rates[HELD] = rates[SLIDING]
    rates[HELD, :2] = 0.0
    return Mechanism(rates, entry, inertia, coulomb, stiffness)


def follow(body: Mechanism, start: Array, stretches: Sequence[tuple[float, int]], interval_s: float) -> Array:
    """States at every sample, (samples + 1, n), from ``start`` on, under ``stretches`` of (torque in N·m, samples).

    Raises `ComputationError` if the motion has no end of events.
    """
    longest = max(count for _, count in stretches)
    used = (SLIDING,) if body.coulomb == 0.0 else (SLIDING, HELD)
    tables = [increments(body.rates[one], interval_s, longest) for one in used]
    states = [start[None, :]]
    for torque, count in stretches:
        if body.coulomb == 0.0:
            z = states[-1][-1]
            states.append(z + tables[SLIDING][1 : count + 1] @ (body.rates[SLIDING] @ z + body.entry * torque))
        else:
            states += _rub(body, states[-1][-1], torque, count, interval_s, tables)
    return np.concatenate(states)


def _rub(body: Mechanism, z: Array, torque: float, count: int, interval_s: float, tables: list[Array]) -> list[Array]:
    """States at the samples of one stretch with friction, in pieces."""
    level = body.coulomb / body.inertia
    pull, push = body.rates[SLIDING, 1], body.entry[1] * torque
    pieces: list[Array] = []
    mode = _way(z, float(pull @ z) + push, level)
    done, into = 0, 0.0  # samples passed, and time since the last of them
    for _ in range(MOST_EVENTS):
        table, a = tables[HELD if mode == 0 else SLIDING], body.rates[HELD if mode == 0 else SLIDING]
        c = body.entry * torque
        if mode == 0:
            c[1] = 0.0
        else:
            c[1] -= mode * level
        # From here to the next sample, then by the table.
        skip = 1 if into == 0.0 else 0
        first = z if skip else z + increment(a, interval_s - into) @ (a @ z + c)
        ahead = first + table[skip : count - done + skip] @ (a @ first + c)
        over = np.abs(ahead @ pull + push) > level if mode == 0 else mode * ahead[:, 1] < 0.0
        if not over.any():
            pieces.append(ahead)
            return pieces
        ends = int(over.argmax())
        if ends > 0:
            pieces.append(ahead[:ends])
            done, into, z = done + ends, 0.0, ahead[ends - 1]
        if mode == 0:
            way = 1 if ahead[ends] @ pull + push > 0.0 else -1
            g, offset = -way * pull, level - way * push
        else:
            way = 0
            g, offset = np.eye(len(z))[1] * mode, 0.0
        t, z = _crossing(a, z, c, g, offset, interval_s - into)
        into += t
        if mode != 0:
            z[1] = 0.0
            way = _way(z, float(pull @ z) + push, level)
        mode = way
        if into >= interval_s:  # at the very sample
            pieces.append(z[None, :])
            done, into = done + 1, 0.0
        if done == count:
            return pieces
    raise ComputationError(f"the knob turns round or sticks more than {MOST_EVENTS} times under one torque")


def _way(z: Array, pull: float, level: float) -> int:
    """Which way the knob slides, 1 or -1; 0 if friction holds it."""
    if z[1] != 0.0:
        return 1 if z[1] > 0.0 else -1
    return 0 if abs(pull) <= level else 1 if pull > 0.0 else -1


def _crossing(a: Array, z: Array, c: Array, g: Array, offset: float, width: float) -> tuple[float, Array]:
    """When g·z + offset, negative after ``width``, vanishes, and the state then: Newton's method inside a bracket."""
    rate = a @ z + c
    low, high, t = 0.0, width, 0.5 * width
    if float(g @ z) + offset <= 0.0:
        # A zero at the start, which is not the one that is meant: begin where the value is positive.
        while t > 1e-12 * width and float(g @ (z + increment(a, t) @ rate)) + offset <= 0.0:
            high, t = t, 0.5 * t
        low, t = t, 0.5 * (t + high)
    state = z
    for _ in range(100):
        d = increment(a, t)
        state = z + d @ rate
        value = float(g @ state) + offset
        low, high = (low, t) if value < 0.0 else (t, high)
        slope = float(g @ (a @ state + c))
        step = -value / slope if slope != 0.0 else np.inf
        inside = low <= t + step <= high
        then = t + step if inside else 0.5 * (low + high)
        if abs(then - t) <= 1e-13 * width:
            break
        t = then
    return t, state


def increment(a: Array, t: float) -> Array:
    """D(t), shape (n, n): the integral of exp(A s) over [0, t]."""
    return _exponential(a, t)[0]


def increments(a: Array, t: float, count: int) -> Array:
    """D(0), D(t), D(2 t), ... D(count t), shape (count + 1, n, n): D(s + t) = D(s) + exp(A s) D(t)."""
    table = np.zeros((count + 1, *a.shape))
    table[1:2], forward = _exponential(a, t)
    known = 1
    while known < count:
        more = min(known, count - known)
        table[known + 1 : known + more + 1] = table[known] + forward @ table[1 : more + 1]
        known += more
        forward = forward @ forward
    return table


def _exponential(a: Array, t: float) -> tuple[Array, Array]:
    """D(t) and exp(A t), by the series of a short time and doubling.

    The exponential is squared on its own: I + A D would lose the fast modes of a stiff fingerpad to rounding.
    """
    one = np.eye(len(a))
    size = float(np.abs(a).sum(axis=1).max()) * t
    doublings = max(0, int(np.ceil(np.log2(size))) + 1) if size > 0.5 else 0
    short = t / 2.0**doublings
    at = a * short
    term = total = one
    for k in range(2, 20):
        term = term @ at / k
        total = total + term
    d, e = total * short, one + at @ total
    for _ in range(doublings):
        d, e = d + e @ d, e @ e
    return d, e
