"""The ensemble of one cell: trials that differ in where the first sample falls, side by side.

Lanes of trials advance together, branch-free, through the transient; then each is followed to its proof and counted
under the orbit it reaches. Nothing is stored per sample, nor per trial beyond one block of lanes.
"""

from typing import Any, NamedTuple

from hknob_cli.engine.certificate import DIFFERENT, certify
from hknob_cli.engine.follow import CYCLE_CONTINUUM, CYCLE_ON_EDGE, CYCLE_PROVEN, follow, same_line
from hknob_cli.engine.loop import copy_line, drive_of, interval, level_of, push
from hknob_cli.engine.propagator import hold_coefficients

# Numbers of an orbit, in a row of the table.
FATE, PERIOD, X, V, MARGIN, EDGE, CLOSURE, BOUND, TRIALS, SAMPLES = range(10)
ROW = 10


class TrialRoom(NamedTuple):
    """Work space for one block of lanes, and the orbits found so far: lists or arrays.

    ``x``, ``v``: a lane each; ``line``: its delay line; ``ring``: that of the trial that is followed; ``table``: rows
    of `ROW` numbers; ``lines``: the delay line of each orbit.
    """

    x: Any
    v: Any
    line: Any
    ring: Any
    table: Any
    lines: Any


def advance(x, v, line, head, delay, steps, loop):
    """Advance all lanes by ``steps`` samples in place; the new head of the delay line.

    ``x`` and ``v`` have one entry a lane; ``line`` holds ``delay`` rows of queued levels, one entry a lane, flat.
    """
    lanes = len(x)
    sense, offset, kappa, gamma, beta = loop.sense, loop.offset, loop.kappa, loop.gamma, loop.beta
    s1, g1, f1, s2, g2, f2 = loop.s1, loop.g1, loop.f1, loop.s2, loop.g2, loop.f2
    if delay == 0:
        for _ in range(steps):
            for j in range(lanes):
                at, speed = x[j], v[j]
                level = level_of(at, sense)
                wall = -kappa * (level + offset) - gamma if level < 0.0 else -gamma
                y = wall - beta * at
                x[j] = at + (s2 * speed + g2 * y)
                v[j] = f2 * speed + s2 * y
        return head
    split = loop.split > 0.0
    for _ in range(steps):
        now = head * lanes
        following = ((head + 1) % delay) * lanes
        for j in range(lanes):
            at, speed = x[j], v[j]
            older = line[now + j]
            line[now + j] = level_of(at, sense)
            newer = line[following + j]
            if split:
                y = (-kappa * (older + offset) - gamma if older < 0.0 else -gamma) - beta * at
                at, speed = at + (s1 * speed + g1 * y), f1 * speed + s1 * y
            y = (-kappa * (newer + offset) - gamma if newer < 0.0 else -gamma) - beta * at
            x[j] = at + (s2 * speed + g2 * y)
            v[j] = f2 * speed + s2 * y
        head = (head + 1) % delay
    return head


def near(a, b):
    """Whether two states of an orbit are the same up to rounding; distinct orbits are many orders further apart."""
    return abs(a - b) <= 1e-9 * (1.0 + abs(a))


def deepest(x, v, ring, head, n, loop):
    """Turn an orbit to its deepest sample, where every trial that reaches it can recognise it.

    Returns ``(x, v, head, period)``; the period is shorter than ``n`` where the orbit was found over several turns.
    ``ring`` is left as it stands at that sample.
    """
    delay = len(ring)
    line = copy_line(ring)
    at = head
    x0, v0 = x, v
    bx, bv, bhead = x, v, head
    best = copy_line(ring)
    period = n
    for i in range(n):
        if i > 0 and n % i == 0 and near(x0, x) and near(v0, v) and same_line(line, at, ring, head):
            period = i
            break
        if x < bx:
            bx, bv, bhead = x, v, at
            best = copy_line(line)
        older, newer = push(level_of(x, loop.sense), line, at, loop)
        x, v = interval(x, v, older, newer, loop)
        if delay > 0:
            at = (at + 1) % delay
    for j in range(delay):
        ring[j] = best[j]
    return bx, bv, bhead, period


def find(fate, n, x, v, table, found):
    """Row of the table that holds this orbit, or ``found`` when it is new; fates without an orbit share one row."""
    for row in range(found):
        base = row * ROW
        if table[base + FATE] != fate or table[base + PERIOD] != n:
            continue
        if n == 0:
            return row
        if near(x, table[base + X]) and near(v, table[base + V]):
            return row
    return found


def first_sample(angle, velocity, phases, loop):
    """State at the first sample of the first of ``phases`` trials, 1/(2 phases) of a period after the start."""
    s, g, f = hold_coefficients(loop.alpha, loop.beta, 0.5 / phases)
    y = drive_of(0.0, loop) - loop.beta * angle
    return angle + (s * velocity + g * y), f * velocity + s * y


def ensemble(at, phases, start, stop, budget, rows, room, loop):
    """Run trials ``start`` to ``stop`` of a cell and count them by the orbit they reach.

    Trial i is first sampled (i + 1/2)/phases of a period after its start, torque zero until then.

    Args:
        at: Position (counts) and velocity (counts per sample) there of trial ``start``.
        phases: Trials of the cell.
        start: Trial to begin with.
        stop: Trial before which to end.
        budget: How long a trial is followed.
        rows: Of the table that are filled already.
        room: `TrialRoom`, or what has fields of these names.
        loop: The cell's numbers.

    Returns ``(rows, overflow, samples, at)``: ``overflow`` counts the trials that found the table full, and ``at`` is
    the state of trial ``stop``.
    """
    x, v, line, ring, table = room.x, room.v, room.line, room.ring, room.table
    ax, av = at
    delay, width, capacity = len(ring), len(x), len(table) // ROW
    free = drive_of(0.0, loop)
    s, g, f = hold_coefficients(loop.alpha, loop.beta, 1.0 / phases)
    overflow, samples = 0, 0
    for first in range(start, stop, width):
        lanes = min(width, stop - first)
        for j in range(width):
            x[j], v[j] = ax, av
            if j < lanes:
                y = free - loop.beta * ax
                ax, av = ax + (s * av + g * y), f * av + s * y
        for j in range(width * delay):
            line[j] = 0.0
        head = advance(x, v, line, 0, delay, budget.skip, loop)
        for j in range(lanes):
            for k in range(delay):
                ring[k] = line[k * width + j]
            fate, n, ox, ov, at, used = follow(
                x[j], v[j], ring, head, budget.samples - budget.skip, budget.limit, loop, budget.final
            )
            samples += used + budget.skip
            turns = n
            cycle = fate == CYCLE_PROVEN or fate == CYCLE_ON_EDGE or fate == CYCLE_CONTINUUM
            if cycle:
                ox, ov, at, n = deepest(ox, ov, ring, at, n, loop)
            row = find(fate, n, ox, ov, table, rows)
            margin, edge, closure, bound = 0.0, 0.0, 0.0, 0.0
            if cycle and row == rows:
                status, px, pv, margin, edge, closure, bound = certify(ox, ov, ring, at, n, loop)
                if status == DIFFERENT and n < turns:
                    # The shorter turn was near, not equal: it is an orbit of all its turns.
                    n = turns
                    row = find(fate, n, ox, ov, table, rows)
                    _, px, pv, margin, edge, closure, bound = certify(ox, ov, ring, at, n, loop)
                if fate == CYCLE_PROVEN:
                    ox, ov = px, pv
            if row == capacity:
                overflow += 1
                continue
            base = row * ROW
            if row == rows:
                rows += 1
                table[base + FATE], table[base + PERIOD] = fate, n
                table[base + X], table[base + V] = ox, ov
                table[base + MARGIN], table[base + EDGE] = margin, edge
                table[base + CLOSURE], table[base + BOUND] = closure, bound
                table[base + TRIALS], table[base + SAMPLES] = 0.0, 0.0
                for k in range(delay):
                    room.lines[row * delay + k] = ring[(at + k) % delay]
            table[base + TRIALS] += 1.0
            table[base + SAMPLES] += used + budget.skip
    return rows, overflow, samples, (ax, av)
