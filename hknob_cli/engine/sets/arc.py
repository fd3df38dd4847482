"""All clock phases of one start: an arc of states, cut where a sample of it meets a count edge.

The state at the first sample, after phi of a period of free flight, is a curve over the phase phi. While all of an arc
acts alike, its states n samples later differ from its middle's as free motions do: by D(n + phi) - D(n + middle), where
D(t) is the free motion about its rest point at the time t after the start. So an arc needs no points: one trial, its
middle, is followed, and the rest is known in closed form.
"""

from math import sqrt
from typing import NamedTuple

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.follow import CYCLE_PROVEN, REST_PROVEN, follow
from hknob_cli.engine.loop import drive_of, level_of
from hknob_cli.engine.sets.arc_cut import Flight, arc_speed, cut, free_motion
from hknob_cli.engine.sets.ball import (
    CAPTURED,
    FIRST_REST_TEST,
    GREW,
    MEETS_EDGE,
    OUT_OF_SAMPLES,
    Trial,
    add_end,
    follow_ball,
    step_through,
)

# Numbers of an arc that waits: low and high phase, sample, x, v, error, level, run, next test, radius, samples in no
# known attractor, and those after which one is looked for (0: as many as for all).
ARC = 12
# Numbers of a cell that is followed: arcs that wait; samples taken; arcs that ended; the phases that did not end
# proven, and of them those that ran out of samples; the shortest arc; the length of all that ended, at last 1 and what
# they overlap by; whether there was room for all parts; and the patience of arcs.
PROGRESS = 9
WAITING, TAKEN, DONE, UNDECIDED, SPENT, SHORTEST, COVERED, WHOLE, PATIENCE = range(PROGRESS)
MOST_ARCS = 65_536  # of a cell; one with more is sampled
MOST_COVERED = 2.0  # arcs that overlap by more are all within rounding of an edge, and double for ever
OPEN, ENDED, UNPROVEN, PARTED, INTERRUPTED = range(5)  # what becomes of an arc


class Arc(NamedTuple):
    """An arc that is followed, beside the trial of its middle.

    Attributes:
        low: First phase.
        high: Last phase.
        sample: Samples taken so far.
        radius: Bound on the distance of its states from the middle.
        since: Samples in no known attractor.
        wait: Those after which one is looked for.
    """

    low: float
    high: float
    sample: int
    radius: float
    since: int
    wait: int


def position_error(angle, velocity, loop):
    """Bound on the rounding of a free motion from a start, at any time, in the norm of `certificate.distance`."""
    rest = drive_of(0.0, loop) / loop.beta
    scale = abs(angle - rest) + abs(velocity) / sqrt(loop.beta)
    return 64.0 * EPSILON * (1.0 + sqrt(loop.beta) / loop.alpha) * (scale + abs(rest))


def put_arc(at, arc, trial, ring, room):
    """Enter an arc as the one ``at`` of those that wait; ``ring``: what its middle has under way."""
    stack, base, delay = room.stack, at * ARC, len(ring)
    stack[base], stack[base + 1], stack[base + 2] = arc.low, arc.high, float(arc.sample)
    stack[base + 3], stack[base + 4], stack[base + 5], stack[base + 6] = trial.x, trial.v, trial.error, trial.level
    stack[base + 7], stack[base + 8] = float(trial.run), float(trial.next_test)
    stack[base + 9], stack[base + 10], stack[base + 11] = arc.radius, float(arc.since), float(arc.wait)
    for k in range(delay):
        room.rings[at * delay + k] = ring[(trial.head + k) % delay]


def take_arc(at, room):
    """The arc ``at`` of those that wait: ``(arc, trial)``; what its middle has under way goes to ``room.ring``."""
    stack, base, delay = room.stack, at * ARC, len(room.ring)
    for k in range(delay):
        room.ring[k] = room.rings[at * delay + k]
    run, next_test = int(stack[base + 7]), int(stack[base + 8])
    since, wait = int(stack[base + 10]), int(stack[base + 11])
    if wait == 0:
        wait = int(room.progress[PATIENCE])
    arc = Arc(stack[base], stack[base + 1], int(stack[base + 2]), stack[base + 9], since, wait)
    return arc, Trial(stack[base + 3], stack[base + 4], stack[base + 5], stack[base + 6], run, next_test, 0)


def begin_arcs(start, patience, room, loop):
    """Make ready to follow every clock phase of one start, as `follow_arcs` has it: one arc, which waits.

    ``patience``: samples in no known attractor, after which the middle of an arc looks for one of its own.
    """
    rest, slack = drive_of(0.0, loop) / loop.beta, position_error(start.x, start.v, loop)
    x, v = free_motion(0.5, start.x - rest, start.v, loop)
    for k in range(start.delay):
        room.ring[k] = 0.0
    radius = 0.5 * arc_speed(start.x - rest, start.v, loop)
    put_arc(0, Arc(0.0, 1.0, 0, radius, 0, 0), Trial(x + rest, v, slack, 0.0, 0, FIRST_REST_TEST, 0), room.ring, room)
    for k in range(PROGRESS):
        room.progress[k] = 0.0
    room.progress[WAITING] = room.progress[SHORTEST] = room.progress[WHOLE] = 1.0
    room.progress[PATIENCE] = patience


def seek_own(trial, share, left, limit, final, room, known, loop):
    """Find what the middle of an arc ends in, and enter it: ``(proven, seen, samples)``; whether it was known before.

    ``share``: the length of the arc; ``left``: samples that its motions may still take.
    """
    progress, ring, spare = room.progress, room.ring, room.spare
    for k in range(len(ring)):
        spare[k] = ring[k]
    end, period, x, v, head, steps = follow(trial.x, trial.v, spare, trial.head, left, limit, loop, final)
    rows = int(known.counts[0])
    row = add_end(end, period, x, v, spare, head, known, loop)
    proven = row >= 0 and (end == CYCLE_PROVEN or end == REST_PROVEN)
    if not proven:
        if steps >= left:
            progress[SPENT] += share
        if row >= 0:
            known.table[row * 10 + 8] += share
    return proven, row < rows, steps


def put_parts(parts, trial, sample, middle, slack, flight, room, loop):
    """Let the parts of an arc wait, each a sample on as its level, and with a middle of its own.

    ``middle``: state of the free motion where the trial is; ``slack``: bound on the rounding of any free motion.
    """
    ring, spare, cuts = room.ring, room.spare, room.cuts
    for part in range(parts):
        q, first, last = cuts[3 * part], cuts[3 * part + 1], cuts[3 * part + 2]
        for k in range(len(ring)):
            spare[k] = ring[k]
        x, v = free_motion(0.5 * (first + last), flight.dx, flight.dv, loop)
        x, v = trial.x + (x - middle[0]), trial.v + (v - middle[1])
        x, v, error, head = step_through(x, v, trial.error + slack, q, spare, trial.head, loop)
        arc = Arc(first, last, sample + 1, 0.5 * (last - first) * flight.speed, 0, 0)
        put_arc(int(room.progress[WAITING]), arc, Trial(x, v, error, q, 0, FIRST_REST_TEST, head), spare, room)
        room.progress[WAITING] += 1.0


def count_arc(low, high, row, room):
    """Count an arc that has ended, in the attractor ``row`` or, if that is -1, in none that is proven."""
    progress, ended = room.progress, int(room.progress[DONE])
    if row < 0:
        progress[UNDECIDED] += high - low
    if 3 * ended + 3 <= len(room.ended):
        room.ended[3 * ended], room.ended[3 * ended + 1], room.ended[3 * ended + 2] = low, high, row
    progress[DONE] += 1.0
    progress[COVERED] += high - low
    progress[SHORTEST] = min(progress[SHORTEST], high - low)
    if progress[DONE] >= MOST_ARCS or progress[COVERED] > MOST_COVERED:
        progress[WAITING] = progress[WHOLE] = 0.0


def follow_arc(start, budget, limit, most, final, room, known, loop):
    """Follow the last arc that waits until it ends, is parted, or has taken ``most`` samples; those that it took."""
    progress, ring, cuts = room.progress, room.ring, room.cuts
    rest, slack = drive_of(0.0, loop) / loop.beta, position_error(start.x, start.v, loop)
    progress[WAITING] -= 1.0
    arc, trial = take_arc(int(progress[WAITING]), room)
    low, high, n, radius, since, wait = arc
    fate, taken = OPEN, 0
    while fate == OPEN:
        samples = max(0, min(wait - since, budget - n, most - taken))
        event, row, trial, used = follow_ball(trial, radius, ring, samples, limit, False, known, loop)
        n += used
        since += used
        taken += used
        if event == CAPTURED:
            known.table[row * 10 + 8] += high - low
            fate = ENDED
            continue
        if event == GREW or n >= budget:
            fate = UNPROVEN
            if event != GREW:
                progress[SPENT] += high - low
            continue
        if event == OUT_OF_SAMPLES and since < wait:
            fate = INTERRUPTED
            continue
        dx, dv = free_motion(float(n), start.x - rest, start.v, loop)
        low_x, low_v = free_motion(low, dx, dv, loop)
        speed = arc_speed(low_x, low_v, loop)  # which never grows, either
        radius = 0.5 * (high - low) * speed
        if event != MEETS_EDGE:
            # Long in no known attractor: its middle's own is found, and entered.
            since, wait = 0, 2 * wait
            proven, seen, steps = seek_own(trial, high - low, budget - n, limit, final, room, known, loop)
            taken += steps
            if not proven:
                fate = UNPROVEN
            elif seen:
                progress[PATIENCE] = min(2.0 * progress[PATIENCE], budget)  # it was on its way to a known one
            continue
        reach = radius + trial.error
        if level_of(trial.x - reach, loop.sense) == level_of(trial.x + reach, loop.sense):
            continue  # it has shrunk enough
        # The ball meets an edge: the arc itself is looked at.
        middle = free_motion(0.5 * (low + high), dx, dv, loop)
        flight = Flight(dx, dv, trial.x - middle[0], speed)
        parts = cut(low, high, low_x, low_v, trial.error + slack, flight, cuts, loop)
        if parts < 0 or int(progress[WAITING]) + parts > len(room.stack) // ARC:
            fate, progress[WAITING], progress[WHOLE] = PARTED, 0.0, 0.0
        elif parts == 1:
            level = cuts[0]
            run, next_test = (trial.run + 1, trial.next_test) if trial.level == level else (0, FIRST_REST_TEST)
            x, v, error, head = step_through(trial.x, trial.v, trial.error, level, ring, trial.head, loop)
            trial = Trial(x, v, error, level, run, next_test, head)
            n += 1
            since += 1
            taken += 1
        else:
            put_parts(parts, trial, n, middle, slack, flight, room, loop)
            taken += parts
            fate = PARTED
    if fate == INTERRUPTED:
        put_arc(int(progress[WAITING]), Arc(low, high, n, radius, since, wait), trial, ring, room)
        progress[WAITING] += 1.0
    elif fate != PARTED:
        count_arc(low, high, row, room)
    return taken


def follow_arcs(start, budget, limit, most, final, room, known, loop):
    """Follow the arcs of one start that wait, until none is left or ``most`` samples are taken.

    Where samples end a call, the next one goes on; what comes out does not depend on how often. Shares go into the
    table of ``known``, all else into ``room.progress``.

    Args:
        start: `ball.Start`.
        budget: Samples that a motion may take.
        limit: Position past which a motion has diverged.
        most: Samples after which this call ends. A search for an orbit under way then is finished first.
        final: Whether a motion gets no more samples than its budget, as in `follow`.
        room: `sets.room.ArcRoom`, made ready by `begin_arcs`.
        known: `sets.room.Known`, to be filled.
        loop: The cell, with damping and hand stiffness.

    Returns the samples that this call took.
    """
    taken = 0
    while room.progress[WAITING] > 0.0 and taken < most:
        taken += follow_arc(start, budget, limit, most - taken, final, room, known, loop)
    room.progress[TAKEN] += taken
    return taken
