"""Following a ball of states sample by sample, until an edge may part it or an attractor has captured it.

All states of the ball act alike while it meets no count edge, and then it only moves and shrinks: its centre is a trial
like any other, and its radius, in the norm in which the free plant never grows, is an upper bound.
"""

from math import sqrt

from hknob_cli.engine.certificate import step_error
from hknob_cli.engine.loop import drive_of, interval, level_of, lower_edge, push, upper_edge
from hknob_cli.engine.sets.centre import Trial
from hknob_cli.engine.sets.known import captor, resting

MEETS_EDGE = 0  # the ball may lie on both sides of an edge that changes the torque: look at what it bounds
CAPTURED = 1
GREW = 2
OUT_OF_SAMPLES = 3
STEPS_DEEPER = 4

FIRST_REST_TEST = 8


def follow_ball(trial, radius, ring, samples, limit, small, known, loop):
    """Follow the ball around a trial for at most ``samples`` samples.

    Args:
        trial: Its centre, `centre.Trial`.
        radius: Bound on the distance of its states from the centre, in the norm of `certificate.distance`.
        ring: The delay line; changed in place.
        samples: That may pass.
        limit: Position past which motions have diverged.
        small: Whether to return where the wall steps deeper.
        known: The attractors, `sets.room.Known`.
        loop: The cell.

    Returns ``(event, row, trial, used)``; ``row`` of the attractor where captured.
    """
    x, v, error, level, run, next_test, head = trial
    delay = len(ring)
    weight = 1.0 / sqrt(loop.beta)
    older, newer = 0.0, drive_of(level, loop)
    low, high = lower_edge(level, loop.sense), upper_edge(level, loop.sense)
    for i in range(samples):
        reach = radius + error
        before = level
        if not low < x - reach or not x + reach < high:  # else the level is the one before, which costs less to see
            level = level_of(x, loop.sense)
            if level_of(x - reach, loop.sense) != level or level_of(x + reach, loop.sense) != level:
                return MEETS_EDGE, -1, Trial(x, v, error, before, run, next_test, head), i
            low, high = lower_edge(level, loop.sense), upper_edge(level, loop.sense)
        if not -limit < x < limit:
            return GREW, -1, Trial(x, v, error, level, run, next_test, head), i
        if level < before:
            row = captor(x, v, reach, ring, head, known, loop)
            if row >= 0:
                return CAPTURED, row, Trial(x, v, error, level, run, next_test, head), i
            if small and i > 0:
                return STEPS_DEEPER, -1, Trial(x, v, error, before, run, next_test, head), i
        if level == before:
            run += 1
            if run >= next_test:
                next_test = 2 * run
                row = resting(x, v, reach, level, ring, head, known, loop)
                if row >= 0:
                    return CAPTURED, row, Trial(x, v, error, level, run, next_test, head), i
        else:
            run, next_test = 0, FIRST_REST_TEST
        if delay > 0:
            older, newer = push(level, ring, head, loop)
        elif level != before:  # else it need not be waited for
            newer = drive_of(level, loop)
        error += step_error(x, v, older, newer, weight, loop)
        x, v = interval(x, v, older, newer, loop)
        if delay > 0:
            head = (head + 1) % delay
    return OUT_OF_SAMPLES, -1, Trial(x, v, error, level, run, next_test, head), samples


def step_through(x, v, error, level, ring, head, loop):
    """One sample more of a set that acts as ``level``: ``(x, v, error, head)``."""
    older, newer = push(level, ring, head, loop)
    error += step_error(x, v, older, newer, 1.0 / sqrt(loop.beta), loop)
    x, v = interval(x, v, older, newer, loop)
    if len(ring) > 0:
        head = (head + 1) % len(ring)
    return x, v, error, head
