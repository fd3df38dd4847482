"""All clock phases of one start: an arc of states, cut where a sample of it meets a count edge.

The state at the first sample, after phi of a period of free flight, is a curve over the phase phi. While all of an arc
acts alike, its states n samples later differ from its middle's as free motions do: by D(n + phi) - D(n + middle), where
D(t) is the free motion about its rest point at the time t after the start. So an arc needs no points: one trial, its
middle, is followed, and the rest is known in closed form.
"""

from math import sqrt

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.follow import CYCLE_PROVEN, REST_PROVEN, follow
from hknob_cli.engine.loop import drive_of, level_of
from hknob_cli.engine.sets.arc_cut import arc_speed, cut, free_motion
from hknob_cli.engine.sets.ball import (
    CAPTURED,
    FIRST_REST_TEST,
    GREW,
    MEETS_EDGE,
    OUT_OF_SAMPLES,
    follow_ball,
    step_through,
)
from hknob_cli.engine.sets.centre import Trial
from hknob_cli.engine.sets.known import add_end

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


def position_error(angle, velocity, loop):
    """Bound on the rounding of a free motion from a start, at any time, in the norm of `certificate.distance`."""
    rest = drive_of(0.0, loop) / loop.beta
    scale = abs(angle - rest) + abs(velocity) / sqrt(loop.beta)
    return 64.0 * EPSILON * (1.0 + sqrt(loop.beta) / loop.alpha) * (scale + abs(rest))


def begin_arcs(angle, velocity, delay, patience, room, loop):
    """Make ready to follow every clock phase of one start, as `follow_arcs` has it: one arc, which waits.

    ``patience``: samples in no known attractor, after which the middle of an arc looks for one of its own.
    """
    stack = room.stack
    rest, slack = drive_of(0.0, loop) / loop.beta, position_error(angle, velocity, loop)
    x, v = free_motion(0.5, angle - rest, velocity, loop)
    stack[0], stack[1], stack[2], stack[3], stack[4] = 0.0, 1.0, 0.0, x + rest, v
    stack[5], stack[6], stack[7], stack[8] = slack, 0.0, 0.0, FIRST_REST_TEST
    stack[9], stack[10], stack[11] = 0.5 * arc_speed(angle - rest, velocity, loop), 0.0, 0.0
    for k in range(delay):
        room.rings[k] = 0.0
    for k in range(PROGRESS):
        room.progress[k] = 0.0
    room.progress[WAITING] = room.progress[SHORTEST] = room.progress[WHOLE] = 1.0
    room.progress[PATIENCE] = patience


def follow_arcs(angle, velocity, delay, budget, limit, most, final, room, known, loop):
    """Follow the arcs of one start that wait, until none is left or ``most`` samples are taken.

    Where samples end a call, the next one goes on; what comes out does not depend on how often. Shares go into the
    table of ``known``, all else into ``room.progress``.

    Args:
        angle: Of the start, counts.
        velocity: Of the start, counts per sample. The torque is zero until the first sample.
        delay: Commands under way.
        budget: Samples that a motion may take.
        limit: Position past which a motion has diverged.
        most: Samples after which this call ends. A search for an orbit under way then is finished first.
        final: Whether a motion gets no more samples than its budget, as in `follow`.
        room: `sets.room.ArcRoom`, made ready by `begin_arcs`.
        known: `sets.room.Known`, to be filled.
        loop: The cell, with damping and hand stiffness.

    Returns the samples that this call took.
    """
    stack, rings, ring, spare, cuts = room.stack, room.rings, room.ring, room.spare, room.cuts
    rest = drive_of(0.0, loop) / loop.beta
    dx0, dv0 = angle - rest, velocity
    slack = position_error(angle, velocity, loop)
    progress = room.progress
    waiting, ended, patience = int(progress[WAITING]), int(progress[DONE]), int(progress[PATIENCE])
    undecided, shortest, covered = progress[UNDECIDED], progress[SHORTEST], progress[COVERED]
    taken = 0
    most_waiting = len(stack) // ARC
    while waiting > 0 and taken < most:
        waiting -= 1
        at = waiting * ARC
        low, high, n, x, v = stack[at], stack[at + 1], int(stack[at + 2]), stack[at + 3], stack[at + 4]
        error, level, run, next_test = stack[at + 5], stack[at + 6], int(stack[at + 7]), int(stack[at + 8])
        radius, since, wait = stack[at + 9], int(stack[at + 10]), int(stack[at + 11])
        for k in range(delay):
            ring[k] = rings[waiting * delay + k]
        head = 0
        if wait == 0:
            wait = patience
        fate = OPEN
        while fate == OPEN:
            samples = max(0, min(wait - since, budget - n, most - taken))
            trial = Trial(x, v, error, level, run, next_test, head)
            event, row, trial, used = follow_ball(trial, radius, ring, samples, limit, False, known, loop)
            x, v, error, level, run, next_test, head = trial
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
            dx, dv = free_motion(float(n), dx0, dv0, loop)
            low_x, low_v = free_motion(low, dx, dv, loop)
            speed = arc_speed(low_x, low_v, loop)  # which never grows, either
            radius = 0.5 * (high - low) * speed
            if event != MEETS_EDGE:
                # Long in no known attractor: its middle's own is found, and entered.
                since, wait = 0, 2 * wait
                for k in range(delay):
                    spare[k] = ring[k]
                end, period, ox, ov, head_of, steps = follow(x, v, spare, head, budget - n, limit, loop, final)
                taken += steps
                rows = int(known.counts[0])
                row = add_end(end, period, ox, ov, spare, head_of, known, loop)
                if row < 0 or (end != CYCLE_PROVEN and end != REST_PROVEN):
                    fate = UNPROVEN
                    if steps >= budget - n:
                        progress[SPENT] += high - low
                    if row >= 0:
                        known.table[row * 10 + 8] += high - low
                elif row < rows:
                    patience = min(2 * patience, budget)  # it was on its way to a known one
                continue
            reach = radius + error
            if level_of(x - reach, loop.sense) == level_of(x + reach, loop.sense):
                continue  # it has shrunk enough
            # The ball meets an edge: the arc itself is looked at.
            middle = 0.5 * (low + high)
            mid_x, mid_v = free_motion(middle, dx, dv, loop)
            parts = cut(low, high, low_x, low_v, speed, x - mid_x, error + slack, dx, dv, cuts, loop)
            if parts < 0 or waiting + parts > most_waiting:
                fate, waiting, progress[WHOLE] = PARTED, 0, 0.0
            elif parts == 1:
                run, next_test = (run + 1, next_test) if level == cuts[0] else (0, FIRST_REST_TEST)
                level = cuts[0]
                x, v, error, head = step_through(x, v, error, level, ring, head, loop)
                n += 1
                since += 1
                taken += 1
            else:
                for part in range(parts):
                    q, first, last = cuts[3 * part], cuts[3 * part + 1], cuts[3 * part + 2]
                    for k in range(delay):
                        spare[k] = ring[k]
                    cx, cv = free_motion(0.5 * (first + last), dx, dv, loop)
                    cx, cv, grown, to = step_through(
                        x + (cx - mid_x), v + (cv - mid_v), error + slack, q, spare, head, loop
                    )
                    at = waiting * ARC
                    stack[at], stack[at + 1], stack[at + 2], stack[at + 3] = first, last, float(n + 1), cx
                    stack[at + 4], stack[at + 5], stack[at + 6] = cv, grown, q
                    stack[at + 7], stack[at + 8] = 0.0, FIRST_REST_TEST
                    stack[at + 9], stack[at + 10], stack[at + 11] = 0.5 * (last - first) * speed, 0.0, 0.0
                    for k in range(delay):
                        rings[waiting * delay + k] = spare[(to + k) % delay]
                    waiting += 1
                    taken += 1
                fate = PARTED
        if fate == INTERRUPTED:
            at = waiting * ARC
            stack[at + 2], stack[at + 3], stack[at + 4], stack[at + 5] = float(n), x, v, error
            stack[at + 6], stack[at + 7], stack[at + 8], stack[at + 9] = level, float(run), float(next_test), radius
            stack[at + 10], stack[at + 11] = float(since), float(wait)
            for k in range(delay):
                rings[waiting * delay + k] = ring[(head + k) % delay]
            waiting += 1
        if fate == UNPROVEN:
            undecided += high - low
            row = -1
        if fate == ENDED or fate == UNPROVEN:
            if 3 * ended + 3 <= len(room.ended):
                room.ended[3 * ended], room.ended[3 * ended + 1], room.ended[3 * ended + 2] = low, high, row
            ended += 1
            covered += high - low
            shortest = min(shortest, high - low)
            if ended >= MOST_ARCS or covered > MOST_COVERED:
                waiting, progress[WHOLE] = 0, 0.0
    progress[WAITING], progress[DONE], progress[PATIENCE] = float(waiting), float(ended), float(patience)
    progress[UNDECIDED], progress[SHORTEST], progress[COVERED] = undecided, shortest, covered
    progress[TAKEN] += taken
    return taken
