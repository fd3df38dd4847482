"""Every start in a box: convex polygons of states, cut where a sample of them meets a count edge.

While all of a polygon acts alike, its corners differ from its centre, n samples later, by Phi^n times what they differed
at the start. So one trial, the centre, is followed, and corners are computed where they matter.
"""

from math import sqrt

from hknob_cli.engine.certificate import EPSILON, distance
from hknob_cli.engine.follow import CYCLE_PROVEN, GREW as GROWN, REST_PROVEN, follow
from hknob_cli.engine.loop import level_of, lower_edge, upper_edge
from hknob_cli.engine.propagator import hold_coefficients
from hknob_cli.engine.sets.ball import CAPTURED, FIRST_REST_TEST, GREW, MEETS_EDGE, STEPS_DEEPER, follow_ball, step_through
from hknob_cli.engine.sets.known import add_end

CORNERS = 12  # that a polygon may have
X, V, ERROR, LEVEL, SAMPLE, WEIGHT, COUNT = range(7)  # numbers of a polygon; then its corners, relative to x and v
POLYGON = 7 + 2 * CORNERS
OPEN, ENDED, UNPROVEN, PARTED, KEPT = range(5)  # what becomes of a polygon
SMALL = 0.4  # part of a lattice cell that is small enough to be merged with others in it
ENTRY = 5  # numbers of a lattice cell: members, and their least and largest x and v


def corner_radius(corners, base, count, loop):
    """Largest distance of a polygon's corners from its centre, and so of all its states."""
    radius = 0.0
    for k in range(count):
        radius = max(radius, distance(corners[base + 2 * k], corners[base + 2 * k + 1], loop))
    return radius


def move_corners(given, base, count, samples, out, loop):
    """Corners after ``samples`` samples of acting alike, from those at ``given[base:]``, to ``out``."""
    s, g, f = hold_coefficients(loop.alpha, loop.beta, float(samples))
    for k in range(count):
        dx, dv = given[base + 2 * k], given[base + 2 * k + 1]
        out[2 * k] = dx + (s * dv - loop.beta * g * dx)
        out[2 * k + 1] = f * dv - loop.beta * s * dx


def clip(corners, count, low, high, out):
    """The part of a convex polygon with ``low <= x <= high``, to ``out``; its number of corners, -1 for too many."""
    kept = 0
    for side in range(2):
        source = corners if side == 0 else out
        total = count if side == 0 else kept
        limit = low if side == 0 else high
        sign = 1.0 if side == 0 else -1.0
        scratch = out[2 * CORNERS + 4 :] if side == 1 else out
        if side == 1:
            for k in range(2 * total):
                scratch[k] = out[k]
            source = scratch
        kept = 0
        for k in range(total):
            ax, av = source[2 * k], source[2 * k + 1]
            j = (k + 1) % total
            bx, bv = source[2 * j], source[2 * j + 1]
            inside, following = sign * (ax - limit) >= 0.0, sign * (bx - limit) >= 0.0
            if inside:
                out[2 * kept], out[2 * kept + 1] = ax, av
                kept += 1
            if inside != following:
                part = (limit - ax) / (bx - ax)
                out[2 * kept], out[2 * kept + 1] = limit, av + part * (bv - av)
                kept += 1
        if kept == 0:
            return 0
    return kept


def put_box(out, at, low_x, high_x, low_v, high_v):
    """The corners of a rectangle."""
    out[at], out[at + 1] = low_x, low_v
    out[at + 2], out[at + 3] = high_x, low_v
    out[at + 4], out[at + 5] = high_x, high_v
    out[at + 6], out[at + 7] = low_x, high_v


def put(piece, base, x, v, error, level, sample, weight, corners, count):
    """Enter a polygon; one with too many corners as the rectangle around it."""
    least_x, most_x, least_v, most_v = corners[0], corners[0], corners[1], corners[1]
    for k in range(1, count):
        least_x, most_x = min(least_x, corners[2 * k]), max(most_x, corners[2 * k])
        least_v, most_v = min(least_v, corners[2 * k + 1]), max(most_v, corners[2 * k + 1])
    cx, cv = 0.5 * (least_x + most_x), 0.5 * (least_v + most_v)
    piece[base + X], piece[base + V], piece[base + ERROR] = x + cx, v + cv, error
    piece[base + LEVEL], piece[base + SAMPLE], piece[base + WEIGHT] = level, sample, weight
    at = base + 7
    if count > CORNERS:
        put_box(piece, at, least_x - cx, most_x - cx, least_v - cv, most_v - cv)
        piece[base + COUNT] = 4.0
        return
    for k in range(count):
        piece[at + 2 * k], piece[at + 2 * k + 1] = corners[2 * k] - cx, corners[2 * k + 1] - cv
    piece[base + COUNT] = count


def slot(i, j, keys, used):
    """Place of a lattice cell in a table with open addressing: where it is, or where it may be entered."""
    size = len(used)
    at = ((int(i) * 73856093) ^ (int(j) * 19349663)) % size
    while used[at] and (keys[2 * at] != i or keys[2 * at + 1] != j):
        at = (at + 1) % size
    return at


def keep_small(room, x, v, error, level, sample, weight, corners, count, lattice, loop):
    """Enter a small polygon into the lattice; whether there was room. ``room.many`` counts the cells in use."""
    scale = 1.0 / sqrt(loop.beta)
    i, j = x / lattice // 1.0, v * scale / lattice // 1.0
    at = slot(i, j, room.keys, room.used)
    low_x, high_x, low_v, high_v = corners[0], corners[0], corners[1], corners[1]
    for k in range(1, count):
        low_x, high_x = min(low_x, corners[2 * k]), max(high_x, corners[2 * k])
        low_v, high_v = min(low_v, corners[2 * k + 1]), max(high_v, corners[2 * k + 1])
    slack_v = error * sqrt(loop.beta)
    base = ENTRY * at
    if not room.used[at]:
        if 2 * room.many[0] >= len(room.used):
            return False
        room.many[0] += 1
        room.used[at] = True
        room.keys[2 * at], room.keys[2 * at + 1] = i, j
        room.cells[base] = 1.0
        put(room.singles, POLYGON * at, x, v, error, level, sample, weight, corners, count)
        room.cells[base + 1], room.cells[base + 2] = x + low_x - error, x + high_x + error
        room.cells[base + 3], room.cells[base + 4] = v + low_v - slack_v, v + high_v + slack_v
        return True
    room.cells[base] += 1.0
    room.singles[POLYGON * at + WEIGHT] += weight
    room.cells[base + 1] = min(room.cells[base + 1], x + low_x - error)
    room.cells[base + 2] = max(room.cells[base + 2], x + high_x + error)
    room.cells[base + 3] = min(room.cells[base + 3], v + low_v - slack_v)
    room.cells[base + 4] = max(room.cells[base + 4], v + high_v + slack_v)
    return True


def follow_polygon(room, waiting, lattice, budget, patience, limit, known, loop):
    """Follow the last polygon that waits until it ends, is parted or small; ``(waiting, fate, samples, looks)``."""
    stack, ring, corners, parts = room.stack, room.ring, room.corners, room.parts
    waiting -= 1
    base = waiting * POLYGON
    for k in range(POLYGON):
        room.own[k] = stack[base + k]
    own = room.own
    x, v, error, level, n = own[X], own[V], own[ERROR], own[LEVEL], int(own[SAMPLE])
    count, weight, age = int(own[COUNT]), own[WEIGHT], 0
    radius = corner_radius(own, 7, count, loop)
    head, since, wait, taken, looks = 0, 0, patience, 0, 0
    run, next_test = 0, FIRST_REST_TEST
    chunk = max(8, patience // 16)
    small = radius + error < SMALL * lattice
    while True:
        event, row, x, v, error, level, run, next_test, head, used = follow_ball(
            x, v, radius, error, level, run, next_test, ring, head, min(chunk, min(wait - since, budget - n)), limit,
            small, known, loop,
        )
        n += used
        age += used
        since += used
        taken += used
        if event == CAPTURED:
            known.table[row * 10 + 8] += weight
            return waiting, ENDED, taken, looks
        if event == GREW:
            row = add_end(GROWN, 0, x, v, ring, head, known, loop)
            known.table[row * 10 + 8] += weight
            return waiting, ENDED, taken, looks
        if n >= budget:
            return waiting, UNPROVEN, taken, looks
        move_corners(own, 7, count, age, corners, loop)
        looks += 1
        radius = corner_radius(corners, 0, count, loop) * (1.0 + 64.0 * EPSILON) + 64.0 * EPSILON * radius
        small = radius + error < SMALL * lattice
        if small and (event == STEPS_DEEPER or lattice > room.coarse[0]) and keep_small(
            room, x, v, error, level, float(n), weight, corners, count, lattice, loop
        ):
            return waiting, KEPT, taken, looks
        if event != MEETS_EDGE:
            if since < wait:
                continue
            since, wait = 0, 2 * wait
            end, period, ox, ov, head_of, steps = follow(x, v, room.spare, head, budget - n, limit, loop)
            taken += steps
            row = add_end(end, period, ox, ov, room.spare, head_of, known, loop)
            if row < 0 or (end != CYCLE_PROVEN and end != REST_PROVEN):
                return waiting, UNPROVEN, taken, looks
            continue
        least, most = corners[0], corners[0]
        for k in range(1, count):
            least, most = min(least, corners[2 * k]), max(most, corners[2 * k])
        reach = error + 64.0 * EPSILON * (abs(x) + radius)
        q, top = level_of(x + least - reach, loop.sense), level_of(x + most + reach, loop.sense)
        if q == top:
            run, next_test = (run + 1, next_test) if level == q else (0, FIRST_REST_TEST)
            level = q
            x, v, error, head = step_through(x, v, error, level, ring, head, loop)
            n += 1
            age += 1
            since += 1
            taken += 1
            continue
        if waiting + int(top - q) + 1 > len(stack) // POLYGON:
            return waiting, UNPROVEN, taken, looks
        while q <= top:
            low, high = lower_edge(q, loop.sense) - reach - x, upper_edge(q, loop.sense) + reach - x
            kept = clip(corners, count, low, high, parts)
            if kept > 0:
                put(stack, waiting * POLYGON, x, v, error, q, float(n), weight, parts, kept)
                at = waiting * POLYGON
                # One sample on, as level q; the corners follow.
                cx, cv, grown, _ = step_through(stack[at + X], stack[at + V], stack[at + ERROR], q, ring, head, loop)
                stack[at + X], stack[at + V], stack[at + ERROR] = cx, cv, grown
                stack[at + SAMPLE] = float(n + 1)
                many = int(stack[at + COUNT])
                for k in range(2 * many):
                    parts[k] = stack[at + 7 + k]
                move_corners(parts, 0, many, 1, room.moved, loop)
                for k in range(2 * many):
                    stack[at + 7 + k] = room.moved[k]
                waiting += 1
                taken += 1
            q += 1.0
        return waiting, PARTED, taken, looks


def seek(x, v, ring, budget, limit, known, loop):
    """Find what one state ends in, and enter it if it is new; the samples taken."""
    event, _, x, v, _, _, _, _, head, used = follow_ball(
        x, v, 0.0, 0.0, 0.0, 0, FIRST_REST_TEST, ring, 0, budget, limit, False, known, loop
    )
    return used


def follow_generation(room, waiting, lattice, budget, patience, limit, samples, known, loop):
    """Follow all polygons that wait, or until ``samples`` are taken: ``(waiting, ended, undecided, taken, looks)``."""
    ended, undecided, taken, looks = 0, 0.0, 0, 0
    while waiting > 0 and taken < samples:
        weight = room.stack[(waiting - 1) * POLYGON + WEIGHT]
        waiting, fate, steps, seen = follow_polygon(room, waiting, lattice, budget, patience, limit, known, loop)
        taken += steps
        looks += seen
        if fate == UNPROVEN:
            undecided += weight
        if fate != PARTED:
            ended += 1
    return waiting, ended, undecided, taken, looks


def next_generation(room, first, waiting, most):
    """Take lattice cells from ``first`` on back to the stack, merged; ``(first, waiting)``, at most ``most`` of them."""
    moved = 0
    at = first
    while at < len(room.used) and moved < most:
        if room.used[at]:
            base, to = POLYGON * at, waiting * POLYGON
            if room.cells[ENTRY * at] == 1.0:
                for k in range(POLYGON):
                    room.stack[to + k] = room.singles[base + k]
            else:
                entry = ENTRY * at
                low_x, high_x = room.cells[entry + 1], room.cells[entry + 2]
                low_v, high_v = room.cells[entry + 3], room.cells[entry + 4]
                x, v = 0.5 * (low_x + high_x), 0.5 * (low_v + high_v)
                room.stack[to + X], room.stack[to + V], room.stack[to + ERROR] = x, v, 4.0 * EPSILON * (abs(x) + abs(v))
                room.stack[to + LEVEL], room.stack[to + SAMPLE] = 0.0, 0.0
                room.stack[to + WEIGHT], room.stack[to + COUNT] = room.singles[base + WEIGHT], 4.0
                put_box(room.stack, to + 7, low_x - x, high_x - x, low_v - v, high_v - v)
            room.used[at] = False
            room.many[0] -= 1
            waiting += 1
            moved += 1
        at += 1
    return at, waiting
