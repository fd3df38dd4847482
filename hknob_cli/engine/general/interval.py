"""One sample interval of the general loop: sense, command, and move under what is commanded."""

from typing import Any, NamedTuple

from hknob_cli.engine.general.controller import command, read, slopes
from hknob_cli.engine.general.glide import glide, rub


class Space(NamedTuple):
    """Work space, as lists or arrays; ``width`` entries a column of derivatives: state, delay line, last reading."""

    width: int
    rate: Any  # (order)
    work: Any  # (order)
    columns: Any  # (width * width)
    du: Any  # (width)
    matrix: Any  # (width * 2 width)
    power: Any  # (width * width)
    total: Any  # (width * width)
    spare: Any  # (width * width)
    residual: Any  # (width)
    away: Any  # (width)
    state: Any  # (order), a motion beside the trial
    orbit: Any  # (order), the periodic one
    line: Any  # (delay)
    orbit_line: Any  # (delay)
    marks: Any  # (2)
    none: Any  # empty


def move(z, older, newer, body, wall, space, count, marks):
    """Move ``z``, and ``count`` columns of derivatives, over an interval under two commands."""
    width = space.width
    if body.friction == 0.0 and count == 0 and len(marks) == 0:
        if wall.split > 0.0:
            glide(z, older, wall.split, 0, body, space.rate, space.work)
        glide(z, newer, 1.0 - wall.split, 1, body, space.rate, space.work)
        return
    delay = width - body.order - 1
    if wall.split > 0.0:
        rub(
            z,
            older,
            wall.split,
            body.s1,
            body.g1,
            body.f1,
            body,
            space.rate,
            space.work,
            space.columns,
            space.du,
            count,
            width,
            marks,
        )
        if delay > 0:
            for c in range(count):
                space.du[c] = space.away[c]
    rub(
        z,
        newer,
        1.0 - wall.split,
        body.s2,
        body.g2,
        body.f2,
        body,
        space.rate,
        space.work,
        space.columns,
        space.du,
        count,
        width,
        marks,
    )


def feed(shown, before, head, body, wall, space, count):
    """Derivatives of the commands of this interval, column by column, by a continuous sensor; through the delay line."""
    now, last = slopes(shown, before, wall)
    n, width = body.order, space.width
    delay = width - n - 1
    for c in range(count):
        at = c * width
        space.du[c] = 0.0
        if delay < 0:
            continue
        slope = now * space.columns[at] + last * space.columns[at + width - 1]
        space.columns[at + width - 1] = space.columns[at]
        if delay == 0:
            space.du[c] = slope
        else:
            space.du[c] = space.columns[at + n + head]
            space.columns[at + n + head] = slope
            space.away[c] = space.columns[at + n + (head + 1) % delay]
            if wall.split == 0.0:
                space.du[c] = space.away[c]


def advance(z, before, ring, head, body, wall, space, count, marks):
    """One interval from a sample to the next: ``(reading, head)``; ``ring`` holds the commands under way."""
    shown = read(z[0], wall)
    u = command(shown, before, wall)
    older = u
    delay = len(ring)
    if count > 0:
        feed(shown, before, head, body, wall, space, count)
    if delay > 0:
        older = ring[head]
        ring[head] = u
        head = (head + 1) % delay
        u = ring[head]
    move(z, older, u, body, wall, space, count, marks)
    return shown, head
