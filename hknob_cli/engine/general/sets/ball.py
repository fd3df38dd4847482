"""Following a ball of states sample by sample, until an edge may part it or an attractor has captured it.

As `engine.sets.ball`, in the general loop: while all states of the ball act alike its centre is a trial like any other,
and its radius, in `body.norm`, is an upper bound.
"""

from hknob_cli.engine.general.controller import command
from hknob_cli.engine.general.interval import hold
from hknob_cli.engine.general.laws.step import advance_two, decide, move_piece
from hknob_cli.engine.general.sets.cell import Centre
from hknob_cli.engine.general.sets.known import captor, resting
from hknob_cli.engine.general.sets.memory import step_error, watched
from hknob_cli.engine.general.sets.readings import remembered, steps_deeper
from hknob_cli.engine.general.sets.turns import (
    ball_reach,
    count_of,
    half_of,
    is_simple,
    keep_count,
    level_at,
    peek,
)

MEETS_EDGE = 0  # the ball may lie on both sides of an edge that changes the command: look at what it bounds
CAPTURED = 1
GREW = 2
OUT_OF_SAMPLES = 3
STEPS_DEEPER = 4

FIRST_REST_TEST = 8


def step_through(centre, count, cell, pad):
    """One sample more of a set that acts as its level: its centre then, moved in place.

    ``count``: that it has before the next sample, with hysteresis of the encoder.
    """
    drift, body, wall, law = cell.drift, cell.body, cell.wall, cell.known.law
    z, ring, level, head = centre.z, centre.ring, centre.level, centre.head
    before, error = remembered(level, wall), centre.error
    if law is None:
        u = command(level, centre.before, wall)
        older = u
        for j in range(len(ring)):
            older = max(abs(older), abs(ring[j]))
        error += step_error(z, u, older, drift, body)
        head = hold(z, u, ring, head, body, wall, pad)
    else:
        before = 0.0
        decide(level, 0.0, ring, wall, law)
        largest = 0.0
        for j in range(law.line, len(ring)):
            largest = max(largest, abs(ring[j]))
        error += step_error(z, largest, largest, drift, body)
        if body.order == 2:
            advance_two(z, ring, body, wall, law)
        else:
            for piece in range(law.pieces):
                move_piece(z, ring, piece, body, law, pad)
    before = keep_count(cell.known.turns, law, count, before, ring)
    return Centre(z, before, ring, head, error, level, centre.sample + 1.0, centre.weight)


def follow_ball(centre, radius, run, next_test, samples, limit, small, cell):
    """Follow the ball around a centre for at most ``samples`` samples.

    Args:
        centre: `cell.Centre`; its level is the reading that acted at the sample before.
        radius: Bound on the distance of its states from the centre, in `body.norm`.
        run: Samples that the level has acted.
        next_test: Samples after which rest is tried.
        samples: That may pass.
        limit: Position past which motions have diverged.
        small: Whether to return where the wall steps deeper.
        cell: `cell.Cell`.

    Returns ``(event, row, centre, run, next_test)``; ``row`` of the attractor where captured.
    """
    drift, known, body, wall = cell.drift, cell.known, cell.body, cell.wall
    z, ring = centre.z, centre.ring
    before, head, error, level = centre.before, centre.head, centre.error, centre.level
    pad, watch = known.space.pad, watched(known.law, wall)
    two, delay = body.order == 2 and is_simple(known.turns, known.law), len(ring)
    half = half_of(known.turns, False, watch)
    always, by_command, by_x, by_v = drift.once[0], drift.once[1], drift.once[2], drift.once[3]
    x, v = z[0], z[1]  # of second order the state is in these two alone, until it is asked for
    event, row, taken = OUT_OF_SAMPLES, -1, samples
    for i in range(samples):
        reach = ball_reach(known.turns, radius, error, body)
        last = level
        shown = count_of(known.turns, known.law, before, ring)
        level = level_at(known.turns, x, shown, half, drift.bottom, watch)
        if (
            level_at(known.turns, x - reach, shown, half, drift.bottom, watch) != level
            or level_at(known.turns, x + reach, shown, half, drift.bottom, watch) != level
        ):
            event, level, taken = MEETS_EDGE, last, i
            break
        if not -limit < x < limit:
            event, taken = GREW, i
            break
        if steps_deeper(level, last, watch):
            z[0], z[1] = x, v
            row = captor(z, before, ring, head, radius + error, known, body, wall)
            if row >= 0:
                event, taken = CAPTURED, i
                break
            if small and i > 0:
                event, level, taken = STEPS_DEEPER, last, i
                break
        if level == last:
            run += 1
            if run >= next_test:
                next_test = 2 * run
                z[0], z[1] = x, v
                row = resting(z, before, ring, radius + error, level, known, body, wall)
                if row >= 0:
                    event, taken = CAPTURED, i
                    break
        else:
            run, next_test = 0, FIRST_REST_TEST
        if not two:
            acts = Centre(z, before, ring, head, error, level, centre.sample, centre.weight)
            known_count, count = peek(acts, radius + error, cell)
            if not known_count:
                event, level, taken = MEETS_EDGE, last, i
                break
            moved = step_through(acts, count, cell, pad)
            before, head, error = moved.before, moved.head, moved.error
            x, v = z[0], z[1]
            continue
        u = command(level, before, wall)
        before = remembered(level, wall)
        older = u
        if delay > 0:
            older = ring[head]
            ring[head] = u
            head = head + 1 if head + 1 < delay else 0
            u = ring[head]
        error += always + by_command * max(abs(u), abs(older)) + by_x * abs(x) + by_v * abs(v)
        if wall.split > 0.0:
            y = older + body.drive - body.beta * x
            x, v = x + (body.s1 * v + body.g1 * y), body.f1 * v + body.s1 * y
        y = u + body.drive - body.beta * x
        x, v = x + (body.s2 * v + body.g2 * y), body.f2 * v + body.s2 * y
    z[0], z[1] = x, v
    end = Centre(z, before, ring, head, error, level, centre.sample + taken, centre.weight)
    return event, row, end, run, next_test
