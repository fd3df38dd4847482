"""Following a ball of states sample by sample, until an edge may part it or a known attractor has captured it.

A proven orbit keeps its levels under any disturbance below its margin, and the free plant never grows in the norm of
`certificate.distance`. So a ball of states around a motion ends in the orbit when, at a sample that both share, the
distance of the two, the ball's radius and all roundings together stay below the margin.

All states of the ball act alike while it meets no count edge, and then it only moves and shrinks: its centre is a trial
like any other, and its radius, in the norm in which the free plant never grows, is an upper bound.
"""

from math import sqrt
from typing import NamedTuple

from hknob_cli.engine.certificate import DIFFERENT, certify, distance, step_error
from hknob_cli.engine.ensemble import deepest, find
from hknob_cli.engine.follow import CYCLE_CONTINUUM, CYCLE_ON_EDGE, CYCLE_PROVEN, REST_PROVEN, constant_line
from hknob_cli.engine.loop import copy_line, drive_of, interval, level_of, lower_edge, push, upper_edge
from hknob_cli.engine.rest import AT_REST, settles


class Scope(NamedTuple):
    """How far motions are followed.

    ``patience``: samples in no known attractor, after which one is looked for; ``budget``: samples of a motion;
    ``limit``: position past which it has diverged.
    """

    patience: int
    budget: int
    limit: float


class Start(NamedTuple):
    """Where the motions of all clock phases begin, at a torque of zero until the first sample.

    ``x``: position, counts; ``v``: velocity, counts per sample; ``delay``: commands under way.
    """

    x: float
    v: float
    delay: int


class Trial(NamedTuple):
    """The centre of a ball, which is a trial, and how long all states of the ball have acted alike.

    Attributes:
        x: Position, counts.
        v: Velocity, counts per sample.
        error: Bound on its rounding error, in the norm of `certificate.distance`.
        level: That acted at the sample before.
        run: Samples that it has acted.
        next_test: Samples after which rest is tried.
        head: Where the oldest of the commands under way is.
    """

    x: float
    v: float
    error: float
    level: float
    run: int
    next_test: int
    head: int


class Centre(NamedTuple):
    """The state that a polygon is told from, and what all of its states share.

    Attributes:
        x: Position, counts.
        v: Velocity, counts per sample.
        error: Bound on its rounding error, in the norm of `certificate.distance`.
        level: As which all states of the polygon act, or acted last.
        sample: Samples taken so far.
        weight: Measure of the starts that are in the polygon.
    """

    x: float
    v: float
    error: float
    level: float
    sample: float
    weight: float


POINTS_OF_ORBIT = 64  # samples of an orbit, where the wall steps deeper, at which balls are compared with it


def same_ring(ring, head, lines, base):
    """Whether a delay line, from ``head`` on, holds what ``lines`` holds from ``base`` on."""
    n = len(ring)
    for k in range(n):
        if ring[(head + k) % n] != lines[base + k]:
            return False
    return True


def count_below(x, known):
    """How many samples of known orbits lie below ``x``; they are in order."""
    low, high = 0, int(known.counts[1])
    while low < high:
        middle = (low + high) // 2
        if known.points[3 * middle + 1] < x:
            low = middle + 1
        else:
            high = middle
    return low


def captor(x, v, reach, ring, head, known, loop):
    """Row of the proven orbit that captures every state within ``reach`` of ``(x, v)``; -1 if none is known to.

    To be asked at a sample where the wall steps deeper. ``reach`` is in the norm of `distance`, roundings included.
    """
    delay = len(ring)
    points, margins = known.points, known.margins
    if not reach < known.counts[2]:
        return -1
    far = known.counts[2] - reach
    for j in range(count_below(x - far, known), int(known.counts[1])):
        base = 3 * j
        if points[base + 1] > x + far:
            return -1
        if not abs(x - points[base + 1]) + reach < margins[j]:
            continue
        near = distance(x - points[base + 1], v - points[base + 2], loop) + reach < margins[j]
        if near and same_ring(ring, head, known.point_lines, j * delay):
            return int(points[base])
    return -1


def add_point(row, x, v, line, at, known):
    """Enter a sample of an orbit, in the order of positions."""
    delay, points, lines = len(line), known.points, known.point_lines
    place = count_below(x, known)
    for j in range(int(known.counts[1]), place, -1):
        for k in range(3):
            points[3 * j + k] = points[3 * j + k - 3]
        for k in range(delay):
            lines[j * delay + k] = lines[(j - 1) * delay + k]
        known.margins[j] = known.margins[j - 1]
    points[3 * place], points[3 * place + 1], points[3 * place + 2] = row, x, v
    known.margins[place] = known.table[10 * row + 4] - known.table[10 * row + 7]
    known.counts[2] = max(known.counts[2], known.margins[place])
    for k in range(delay):
        lines[place * delay + k] = line[(at + k) % delay]
    known.counts[1] += 1.0


def add_points(row, x, v, ring, head, n, known, loop):
    """Enter the samples of an orbit at which the wall steps deeper, as far as there is room."""
    delay = len(ring)
    line = copy_line(ring)
    at, before, entered = head, 1.0, 0
    for i in range(2 * n):
        level = level_of(x, loop.sense)
        room = 3 * int(known.counts[1]) + 3 <= len(known.points)
        if i >= n and level < before and entered < POINTS_OF_ORBIT and room:
            add_point(row, x, v, line, at, known)
            entered += 1
        before = level
        older, newer = push(level, line, at, loop)
        x, v = interval(x, v, older, newer, loop)
        if delay > 0:
            at = (at + 1) % delay


def add_end(fate, n, x, v, ring, head, known, loop):
    """Row of an end that `follow` gave, entered where it is new; -1 where the table is full.

    Of a proven cycle the samples where the wall steps deeper are entered, too, for `captor`.
    """
    delay = len(ring)
    table, rows = known.table, int(known.counts[0])
    cycle = fate == CYCLE_PROVEN or fate == CYCLE_ON_EDGE or fate == CYCLE_CONTINUUM
    turns = n
    if cycle:
        x, v, head, n = deepest(x, v, ring, head, n, loop)
    row = find(fate, n, x, v, table, rows)
    if row < rows:
        return row
    if row * 10 + 10 > len(table):
        return -1
    margin, edge, closure, bound = 0.0, 0.0, 0.0, 0.0
    if cycle:
        status, px, pv, margin, edge, closure, bound = certify(x, v, ring, head, n, loop)
        if status == DIFFERENT:
            n = turns
            row = find(fate, n, x, v, table, rows)
            if row < rows:
                return row
            status, px, pv, margin, edge, closure, bound = certify(x, v, ring, head, n, loop)
        if fate == CYCLE_PROVEN:
            x, v = px, pv
    base = row * 10
    table[base], table[base + 1], table[base + 2], table[base + 3] = fate, n, x, v
    table[base + 4], table[base + 5], table[base + 6], table[base + 7] = margin, edge, closure, bound
    table[base + 8], table[base + 9] = 0.0, 0.0
    for k in range(delay):
        known.lines[row * delay + k] = ring[(head + k) % delay]
    known.counts[0] = row + 1
    if fate == CYCLE_PROVEN:
        add_points(row, x, v, ring, head, n, known, loop)
    return row


def resting(x, v, reach, level, ring, head, known, loop):
    """Row of the rest point inside one level where every state within ``reach`` of ``(x, v)`` ends; -1 if none.

    The level must go on acting: that of this sample, and of all that is under way.
    """
    if not constant_line(ring, level):
        return -1
    fate, rest, margin, bound = settles(x, v, level, loop)
    if fate != AT_REST or not distance(x - rest, v, loop) + reach + bound < margin:
        return -1
    return add_end(REST_PROVEN, 1, rest, 0.0, ring, head, known, loop)


MEETS_EDGE = 0  # the ball may lie on both sides of an edge that changes the torque: look at what it bounds
CAPTURED = 1
GREW = 2
OUT_OF_SAMPLES = 3
STEPS_DEEPER = 4

FIRST_REST_TEST = 8


def follow_ball(trial, radius, ring, samples, limit, small, known, loop):
    """Follow the ball around a trial for at most ``samples`` samples.

    Args:
        trial: Its centre, `Trial`.
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
