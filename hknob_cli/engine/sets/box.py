"""Every start in a box: polygons followed until each lies inside what a proven orbit captures."""

from math import sqrt

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.follow import CYCLE_PROVEN, REST_PROVEN, follow
from hknob_cli.engine.follow import GREW as GREW_FATE
from hknob_cli.engine.loop import level_of
from hknob_cli.engine.sets.ball import (
    CAPTURED,
    FIRST_REST_TEST,
    GREW,
    MEETS_EDGE,
    STEPS_DEEPER,
    Centre,
    Scope,
    Trial,
    add_end,
    follow_ball,
    step_through,
)
from hknob_cli.engine.sets.polygon import (
    COUNT,
    ERROR,
    LEVEL,
    POLYGON,
    SAMPLE,
    WEIGHT,
    V,
    X,
    blur,
    corner_radius,
    forget,
    keep,
    move_corners,
    part,
    put,
    put_box,
)

SMALL = 0.4  # part of a lattice cell's width: a polygon of that radius may be merged with others
# Below this width, in counts, polygons are merged only where the wall steps deeper: there motions along one orbit meet
# in few places, whereas elsewhere they lie all along it. Wider ones are cut again before they come there.
SECTION = 0.01
ENDED, UNPROVEN, PARTED, KEPT = range(4)  # what becomes of a polygon


def seek(x, v, scope, ring, known, loop):
    """What the trial from one state ends in, entered where it is new: ``(row, samples)``, row -1 if not proven."""
    start, patience = Trial(x, v, 0.0, 0.0, 0, FIRST_REST_TEST, 0), min(scope.patience, scope.budget)
    event, row, trial, used = follow_ball(start, 0.0, ring, patience, scope.limit, False, known, loop)
    if event == CAPTURED:
        return row, used
    if event == GREW:
        return add_end(GREW_FATE, 0, trial.x, trial.v, ring, trial.head, known, loop), used
    left = scope.budget - used
    fate, period, x, v, head, steps = follow(trial.x, trial.v, ring, trial.head, left, scope.limit, loop, True)
    if period == 0 and fate != GREW_FATE:
        return -1, used + steps
    row = add_end(fate, period, x, v, ring, head, known, loop)
    return (row if fate == CYCLE_PROVEN or fate == REST_PROVEN or fate == GREW_FATE else -1), used + steps


def sample_box(starts, first, stop, scope, ring, ends, known, loop):
    """Count where the trials from single states end; ``(samples, unproven)``.

    ``starts``: x, v of each, flat, of which those from ``first`` to ``stop`` are followed; ``ends`` takes their rows.
    """
    taken, unproven = 0, 0
    for k in range(first, stop):
        row, used = seek(starts[2 * k], starts[2 * k + 1], scope, ring, known, loop)
        taken += used
        ends[k] = row
        if row < 0:
            unproven += 1
        else:
            known.table[10 * row + 8] += 1.0
    return taken, unproven


def fill_box(low_x, high_x, low_v, high_v, room, loop):
    """Let the box be the only polygon that waits."""
    x, v = 0.5 * (low_x + high_x), 0.5 * (low_v + high_v)
    room.stack[X], room.stack[V] = x, v
    weight = 1.0 / sqrt(loop.beta)  # of velocities in the norm
    room.stack[ERROR] = 4.0 * EPSILON * (abs(low_x) + abs(high_x) + weight * (abs(low_v) + abs(high_v)))
    room.stack[LEVEL], room.stack[SAMPLE], room.stack[WEIGHT], room.stack[COUNT] = 0.0, 0.0, 1.0, 4.0
    put_box(room.stack, 7, low_x - x, high_x - x, low_v - v, high_v - v)
    forget(room)


def fill_polygon(corners, count, room, loop):
    """Let the convex polygon with these corners be the only polygon that waits."""
    size_x, size_v = 0.0, 0.0
    for k in range(count):
        size_x, size_v = max(size_x, abs(corners[2 * k])), max(size_v, abs(corners[2 * k + 1]))
    error = 8.0 * EPSILON * (size_x + size_v / sqrt(loop.beta))
    put(room.stack, 0, Centre(0.0, 0.0, error, 0.0, 0.0, 1.0), corners, count)
    forget(room)


def follow_polygon(room, waiting, width, scope, known, loop):
    """Follow the last polygon that waits until it ends, is parted or kept; ``(waiting, fate, samples)``."""
    own, corners, ring = room.own, room.corners, room.ring
    patience, budget, limit = scope
    waiting -= 1
    for k in range(POLYGON):
        own[k] = room.stack[waiting * POLYGON + k]
    trial, n = Trial(own[X], own[V], own[ERROR], own[LEVEL], 0, FIRST_REST_TEST, 0), int(own[SAMPLE])
    count, weight, blurred = int(own[COUNT]), own[WEIGHT], blur(loop)
    first = corner_radius(own, 7, count, loop)
    radius = first * (1.0 + blurred)
    # Samples in no known attractor count through all cuts: what is cut again and again would else never be asked.
    age, since, wait, taken = 0, n % patience, patience, 0
    between = max(8, patience // 16)  # samples after which the radius is computed again
    small = radius + trial.error < SMALL * width
    while True:
        some = min(between, wait - since, budget - n)
        event, row, trial, used = follow_ball(trial, radius, ring, some, limit, small, known, loop)
        n += used
        age += used
        since += used
        taken += used
        if event == CAPTURED:
            return waiting, ENDED, taken
        if event == GREW or n >= budget:  # that what has grown so far never comes back is not proven
            return waiting, UNPROVEN, taken
        move_corners(own, 7, count, age, corners, 0, loop)
        radius = corner_radius(corners, 0, count, loop) + blurred * first
        small = radius + trial.error < SMALL * width
        x, v = trial.x, trial.v
        # What cutting and telling corners from another middle may round away.
        reach = trial.error + blurred * first + 8.0 * EPSILON * (abs(x) + abs(v) / sqrt(loop.beta))
        centre = Centre(x, v, reach, trial.level, float(n), weight)
        if small and (event == STEPS_DEEPER or width > SECTION):
            if keep(room, centre, corners, count, width, loop):
                return waiting, KEPT, taken
            small = False
        if event == MEETS_EDGE:
            least, most = corners[0], corners[0]
            for k in range(1, count):
                least, most = min(least, corners[2 * k]), max(most, corners[2 * k])
            low, high = level_of(x + least - reach, loop.sense), level_of(x + most + reach, loop.sense)
            if low < high:
                parted = part(room, waiting, centre, corners, count, low, high, loop)
                if parted < 0:
                    return waiting, UNPROVEN, taken
                return parted, PARTED, taken + parted - waiting  # a part costs as much as a sample
            run, next_test = (trial.run + 1, trial.next_test) if trial.level == low else (0, FIRST_REST_TEST)
            x, v, error, head = step_through(x, v, trial.error, low, ring, trial.head, loop)
            trial = Trial(x, v, error, low, run, next_test, head)
            n += 1
            age += 1
            since += 1
            taken += 1
        elif since >= wait:
            # Long in no known attractor: its centre's own is found, and entered.
            since, wait = 0, 2 * wait
            row, steps = seek(x, v, Scope(0, budget - n, limit), ring, known, loop)
            taken += steps
            if row < 0:
                return waiting, UNPROVEN, taken


def follow_generation(room, waiting, width, samples, scope, known, loop):
    """Follow polygons until none waits or ``samples`` are taken: ``(waiting, polygons, undecided, samples)``.

    ``undecided``: measure of starts, as a part of the box or a bound on it, that reach a polygon without a proven end.
    """
    ended, undecided, taken = 0, 0.0, 0
    while waiting > 0 and taken < samples:
        weight = room.stack[(waiting - 1) * POLYGON + WEIGHT]
        waiting, fate, steps = follow_polygon(room, waiting, width, scope, known, loop)
        taken += steps
        if fate == UNPROVEN:
            undecided += weight
        if fate != PARTED:
            ended += 1
    return waiting, ended, undecided, taken


def seek_some(room, waiting, some, scope, known, loop):
    """Find what the centres of ``some`` of the polygons that wait end in, evenly spread; the samples taken."""
    taken = 0
    for k in range(min(some, waiting)):
        base = POLYGON * (k * waiting // min(some, waiting))
        _, used = seek(room.stack[base + X], room.stack[base + V], scope, room.ring, known, loop)
        taken += used
    return taken
