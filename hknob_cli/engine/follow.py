"""Following one trial until its fate is proven: the repeating level sequence, rest, or growth.

Memory is constant: a checkpoint is kept at a sample where the wall steps deeper, and moved on after 1, 2, 4, ...
such samples (Brent's cycle finding). When the trial comes back to it, the samples in between are a candidate period,
and `certificate.certify` decides.
"""

from hknob_cli.engine.certificate import (
    NEUTRAL,
    NOT_CAPTURED,
    ON_EDGE,
    PROVEN,
    certify,
    distance,
)
from hknob_cli.engine.loop import copy_line, interval, level_of, push
from hknob_cli.engine.rest import AT_REST, LEAVES, MOVING, RINGS, settles

FIRST_TOLERANCE = 0.03  # counts between a return and its checkpoint that are worth an attempt at a proof
FIRST_REST_TEST = 8  # samples in one level before rest is thought of

CYCLE_PROVEN = 0
CYCLE_ON_EDGE = 1
CYCLE_CONTINUUM = 2
REST_PROVEN = 3
REST_EDGE = 4
GREW = 5
LEFT = 6
UNSETTLED = 7
UNDAMPED = 8


def same_line(ring, head, other, start):
    """Whether two delay lines hold the same levels in the same order."""
    n = len(ring)
    for j in range(n):
        if ring[(head + j) % n] != other[(start + j) % n]:
            return False
    return True


def constant_line(ring, level):
    """Whether every queued level is ``level``."""
    for j in range(len(ring)):
        if ring[j] != level:
            return False
    return True


def look_at_rest(x, v, level, ring, loop):
    """What becomes of a trial whose level goes on: ``(fate, rest)``; `UNSETTLED` if nothing is known."""
    kind, rest, _, _ = settles(x, v, level, loop)
    if kind == MOVING or not constant_line(ring, level):
        return UNSETTLED, rest
    if kind == AT_REST:
        return REST_PROVEN, rest
    if kind == LEAVES:
        return LEFT, rest
    return (UNDAMPED if kind == RINGS else REST_EDGE), rest


def tolerance_after(status, gap, margin, away):
    """How near a trial must come back for the next proof, after one from a ``gap`` has failed.

    ``away``: how far it is from the orbit that was tried. Both shrink together: the next waits until the trial is
    within the margin.
    """
    return gap * min(1.0, 0.9 * margin / away) if status == NOT_CAPTURED else 0.5 * gap


def unsettled(damped):
    """Fate of a trial that has come to nothing: it may yet, where something damps it."""
    return UNSETTLED if damped else UNDAMPED


def follow(x, v, ring, head, budget, limit, loop, final=True):
    """Follow a trial for at most ``budget`` samples.

    ``limit`` is the position in counts past which it has diverged. Returns ``(fate, n, x*, v*, head, samples)``; the
    delay line ``ring`` is left as it stands at the orbit's state. ``final``: whether the trial gets no more samples
    than these, so that a last look at how it stands is worth it.
    """
    damped = loop.alpha > 0.0
    delay = len(ring)
    have, events, next_checkpoint, since = False, 0, 1, 0
    cx, cv, chead, tolerance = x, v, head, FIRST_TOLERANCE
    cring = copy_line(ring)
    edge_n, edge_x, edge_v, edge_head = 0, x, v, head
    edge_ring = copy_line(ring)
    resting_on_edge = False
    level = level_of(x, loop.sense)
    run, next_test = 0, FIRST_REST_TEST
    for i in range(budget):
        if not -limit < x < limit:
            return GREW, 0, x, v, head, i
        before = level
        level = level_of(x, loop.sense)
        if level == before:
            run += 1
            if run >= next_test:
                next_test = 2 * run
                fate, rest = look_at_rest(x, v, level, ring, loop)
                if fate == REST_PROVEN:
                    return fate, 1, rest, 0.0, head, i
                if fate == LEFT or fate == UNDAMPED:
                    return fate, 0, x, v, head, i
                resting_on_edge = resting_on_edge or fate == REST_EDGE
        else:
            run, next_test = 0, FIRST_REST_TEST
            resting_on_edge = False
        if level < before and damped:
            if have:
                gap = distance(x - cx, v - cv, loop)
                if gap < tolerance and same_line(ring, head, cring, chead):
                    status, ox, ov, margin, _, _, _ = certify(x, v, ring, head, since, loop)
                    if status == PROVEN:
                        return CYCLE_PROVEN, since, ox, ov, head, i
                    if status == NEUTRAL:
                        return CYCLE_CONTINUUM, since, ox, ov, head, i
                    if status == ON_EDGE:
                        edge_n, edge_x, edge_v, edge_head = since, ox, ov, head
                        edge_ring = copy_line(ring)
                    tolerance = tolerance_after(status, gap, margin, distance(x - ox, v - ov, loop))
            events += 1
            if events == next_checkpoint:
                next_checkpoint = 2 * events
                have, since = True, 0
                cx, cv, chead, tolerance = x, v, head, FIRST_TOLERANCE
                cring = copy_line(ring)
        since += 1
        older, newer = push(level, ring, head, loop)
        x, v = interval(x, v, older, newer, loop)
        if delay > 0:
            head = (head + 1) % delay
    if not final:  # what has repeated without proof may yet be left, or proven
        return unsettled(damped), 0, x, v, head, budget
    if edge_n > 0:
        for j in range(delay):
            ring[j] = edge_ring[j]
        return CYCLE_ON_EDGE, edge_n, edge_x, edge_v, edge_head, budget
    if resting_on_edge:
        _, rest, _, _ = settles(x, v, level, loop)
        return REST_EDGE, 1, rest, 0.0, head, budget
    # The tests grow rare: without one more, the share at rest could fall when the limit is raised.
    level = level_of(x, loop.sense)
    fate, rest = look_at_rest(x, v, level, ring, loop)
    if fate == REST_PROVEN:
        return REST_PROVEN, 1, rest, 0.0, head, budget
    return unsettled(damped), 0, x, v, head, budget
