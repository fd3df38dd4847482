"""One trial without a sample clock, to its end, and what is met on the way there.

With damping or friction every motion settles: the potential is convex. Where only one position can be a rest point, it
is known before the motion is, and a trial that chatters over a count edge need not be followed through its infinitely
many, ever smaller crossings. Without either, every motion is periodic or leaves; some bounces are followed to measure
how well its energy is kept.

The swing from one turning point to the next never grows. The remaining motion spans no more than a threshold from
the moment at which it is that far from the turning point ahead, for the first time within the first swing whose
successor is no longer than the threshold.
"""

from typing import NamedTuple

from hknob_cli.engine.unsampled.edge_time import EDGE, ENDS, TURN
from hknob_cli.engine.unsampled.state_machine import heading, move_on, place, set_off, time_to
from hknob_cli.engine.unsampled.wall_pieces import potential

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
