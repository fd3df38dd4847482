"""One trial without a sample clock, to its end, and what is met on the way there.

With damping or friction every motion settles: the potential is convex. Where only one position can be a rest point, it
is known before the motion is, and a trial that chatters over a count edge need not be followed through its infinitely
many, ever smaller crossings. Without either, every motion is periodic or leaves; some bounces are followed to measure
how well its energy is kept.

The swing from one turning point to the next never grows. The remaining motion spans no more than a threshold from
the moment at which it is that far from the turning point ahead, for the first time within the first swing whose
successor is no longer than the threshold.
"""

from hknob_cli.engine.unsampled.edge_time import EDGE, ENDS, TURN
from hknob_cli.engine.unsampled.state_machine import heading, move_on, place, time_to
from hknob_cli.engine.unsampled.wall_pieces import potential

CAME_TO_REST = 0
BOUNCES_ON = 1
GOES_AWAY = 2
OUT_OF_EVENTS = 3

PART_OF_BOUNCE = 0.01  # of the first bounce: the span that counts as settled where there are no counts
FINAL = 1e-6  # of the threshold: the swing at which chatter under damping and friction is no longer followed


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
    # The two turning points before this one, the start counting as one: position, and state at the older.
    older, recent = x, x
    old_t, old_n, old_edge, old_u, old_v = 0.0, n, edge, u, v
    new_t, new_n, new_edge, new_u, new_v = 0.0, n, edge, u, v
    turns = 0
    if v != 0.0:
        way = 1.0 if v > 0.0 else -1.0
    else:
        n, way = heading(n, edge, u, loop)
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
            if before == 0.0 and contact == inf:
                contact = time
            elif before == 1.0 and way > 0.0:
                bounces += 1
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
        swing, previous = abs(here - recent), abs(recent - older)
        path += swing
        if came > 0.0:
            top = here
        else:
            bottom = here
        if threshold == 0.0 and way == 0.0:
            threshold = PART_OF_BOUNCE * abs(here - x)
        elif threshold == 0.0 and came > 0.0 and turns > 0 and contact < inf:
            threshold = PART_OF_BOUNCE * swing
        if settled == inf and not free and (threshold > 0.0 or way == 0.0):
            if turns > 0 and swing <= threshold:
                settled = 0.0
                if previous > threshold:
                    goal = recent + (threshold if older > recent else -threshold)
                    settled = old_t + time_to(old_n, old_edge, old_u, old_v, goal, loop)
            elif way == 0.0:
                settled = 0.0
                if swing > threshold:
                    goal = here + (threshold if recent > here else -threshold)
                    settled = new_t + time_to(new_n, new_edge, new_u, new_v, goal, loop)
        if way == 0.0:
            fate = CAME_TO_REST
            break
        if single and settled < inf and (loop.alpha == 0.0 or loop.phi == 0.0 or swing <= FINAL * threshold):
            fate = CAME_TO_REST
            break
        if free and came > 0.0:
            drift = max(drift, abs(potential(here, loop) - reference))
            peaks += 1
            if peaks > max_peaks:
                fate = BOUNCES_ON
                break
        older, recent = recent, here
        old_t, old_n, old_edge, old_u, old_v = new_t, new_n, new_edge, new_u, new_v
        new_t, new_n, new_edge, new_u, new_v = time, n, edge, u, v
        turns += 1
    if fate == OUT_OF_EVENTS and peaks > 1:
        fate = BOUNCES_ON
    return fate, edge + u, events, bounces, contact, settled, path, top, bottom, drift
