"""One trial without a sample clock, to its end, what is met on the way there, and its events as rows.

With damping or friction every motion settles: the potential is convex. Where only one position can be a rest point, it
is known before the motion is, and a trial that chatters over a count edge need not be followed through its infinitely
many, ever smaller crossings. Without either, every motion is periodic or leaves; some bounces are followed to measure
how well its energy is kept.

The swing from one turning point to the next never grows. The remaining motion spans no more than a threshold from
the moment at which it is that far from the turning point ahead, for the first time within the first swing whose
successor is no longer than the threshold.

An undamped motion comes back the way it went, in the same time: the swing from its top to its bottom is half of its
period. From the events of a trial, one row each, the exact state at any time follows.
"""

from math import ceil, sqrt
from typing import NamedTuple

from hknob_cli.engine.propagator import hold_coefficients
from hknob_cli.engine.unsampled.state_machine import (
    EDGE,
    ENDS,
    TURN,
    acceleration,
    heading,
    move_on,
    piece_stiffness,
    place,
    potential,
    set_off,
    time_to,
)

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


CAME_TO_REST = 0
BOUNCES_ON = 1
GOES_AWAY = 2
OUT_OF_EVENTS = 3

PART_OF_BOUNCE = 0.01  # of the first bounce: the span that counts as settled where there are no counts
FINAL = 1e-6  # of the threshold: the swing at which chatter under damping and friction is no longer followed


class TurningPoint(NamedTuple):
    """A turning point of a trial, or its start: position, time and state (`state_machine`)."""

    x: float
    time: float
    n: float
    edge: float
    u: float
    v: float


def time_ahead(point, goal, loop):
    """Time at which a motion that goes on from a turning point is at ``goal``."""
    return point.time + time_to(point.n, point.edge, point.u, point.v, goal, loop)


def part_of_bounce(x, swing, here, came, way, later, contact):
    """Span that counts as settled where there are no counts; 0 as long as there was no bounce.

    ``x``: where the trial began; ``later``: whether it has turned before.
    """
    if way == 0.0:
        return PART_OF_BOUNCE * abs(here - x)
    if came > 0.0 and later and contact < float("inf"):
        return PART_OF_BOUNCE * swing
    return 0.0


def time_of_settling(here, way, threshold, later, older, recent, loop):
    """Time from which on a motion spans no more than ``threshold``; infinite as long as it spans more.

    It turns ``here``, or rests (``way`` 0), after the turning points ``older`` and ``recent``.
    """
    if not (threshold > 0.0 or way == 0.0):
        return float("inf")
    swing = abs(here - recent.x)
    if later and swing <= threshold:
        if abs(recent.x - older.x) > threshold:
            return time_ahead(older, recent.x + (threshold if older.x > recent.x else -threshold), loop)
        return 0.0
    if way == 0.0:
        if swing > threshold:
            return time_ahead(recent, here + (threshold if recent.x > here else -threshold), loop)
        return 0.0
    return float("inf")


def chatters(single, settled, swing, threshold, loop):
    """Whether a motion has settled over the one rest there is, and need not be followed further."""
    if not single or settled == float("inf"):
        return False
    return loop.alpha == 0.0 or loop.phi == 0.0 or swing <= FINAL * threshold


def pass_edge(n, way, time, contact, bounces):
    """Time of the first contact, and count of bounces, once an edge of piece ``n`` is passed."""
    if n == 0.0 and contact == float("inf"):
        return time, bounces
    if n == 1.0 and way > 0.0:
        return contact, bounces + 1
    return contact, bounces


def settle_motion(x, v, threshold, single, max_events, max_peaks, loop):
    """Follow a trial from (``x``, ``v``) to rest, or for ``max_peaks`` bounces if nothing damps it.

    ``threshold``: span of the motion that counts as settled; 0 for `PART_OF_BOUNCE`. ``single``: whether there is
    one rest point only. Returns ``(fate, x_end, events, bounces, contact, settled, path, top, bottom, drift)``:
    position reached (at rest: where, unless the rest point is single and chattered over), count of events and of
    times the knob left the wall, times of the first contact and of settling (infinite: never), length of the way
    that friction acted on, last maximum and minimum, and the largest distance of the energy at a maximum from that at
    the start.
    """
    inf = float("inf")
    free = loop.alpha == 0.0 and loop.phi == 0.0
    n, edge, u = place(x, v, loop)
    time, path = 0.0, 0.0
    events, bounces, peaks = 0, 0, 0
    settled, drift, reference = inf, 0.0, 0.5 * v * v + potential(x, loop)
    top, bottom = inf, -inf
    # The two turning points before this one, the start counting as one.
    older = TurningPoint(x, 0.0, n, edge, u, v)
    recent = older
    turns = 0
    n, way = set_off(n, edge, u, v, loop)
    contact = 0.0 if n > 0.0 else inf
    if way == 0.0:
        return CAME_TO_REST, x, 0, 0, contact, 0.0, 0.0, x, x, 0.0
    fate = OUT_OF_EVENTS
    while events < max_events:
        before = n
        kind, n, edge, u, v, t = move_on(n, edge, u, v, way, inf, loop)
        if kind == EDGE or kind == TURN:
            events += 1
            time += t
        if kind == EDGE:
            contact, bounces = pass_edge(before, way, time, contact, bounces)
            if v != 0.0:
                continue
        elif kind != TURN and kind != ENDS:
            fate = GOES_AWAY
            break
        # A turning point, or the end.
        here = edge + u
        came = way
        if kind == ENDS:
            way = 0.0
        else:
            n, way = heading(n, edge, u, loop)
            if way == came:
                continue  # passed an edge with no speed left and goes on: no turning point
        swing = abs(here - recent.x)
        path += swing
        if came > 0.0:
            top = here
        else:
            bottom = here
        if threshold == 0.0:
            threshold = part_of_bounce(x, swing, here, came, way, turns > 0, contact)
        if settled == inf and not free:
            settled = time_of_settling(here, way, threshold, turns > 0, older, recent, loop)
        if way == 0.0 or chatters(single, settled, swing, threshold, loop):
            fate = CAME_TO_REST
            break
        if free and came > 0.0:
            drift = max(drift, abs(potential(here, loop) - reference))
            peaks += 1
            if peaks > max_peaks:
                fate = BOUNCES_ON
                break
        older, recent = recent, TurningPoint(here, time, n, edge, u, v)
        turns += 1
    if fate == OUT_OF_EVENTS and peaks > 1:
        fate = BOUNCES_ON
    return fate, edge + u, events, bounces, contact, settled, path, top, bottom, drift


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
