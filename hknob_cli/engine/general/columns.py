"""Columns of derivatives: how the state, the delay line and the last reading depend on where a motion began.

A column has ``width`` entries: state, delay line, last reading. After ``width`` columns, ``cols`` holds the derivatives
of the older command of an interval in each column, and then those of the newer. Beside the columns there are marks of
what the motion of a period comes near to.
"""

from typing import Any, NamedTuple

from hknob_cli.engine.general.body import ENTRY, HALVES, HALVES_HELD, HELD, RATES
from hknob_cli.engine.general.controller import slopes

# Marks of a period. The least: distance of a torque from the friction level where that decides, velocity at the end of
# a hold, torque of teeth that press, room to a corner of cogging (below 0 where one is passed).
LEVEL, SPEED, PRESSED, CORNER_ROOM = range(4)
# Beside cogging: the least room to a corner where the motion stands or turns round; of corners that are passed the sum
# of 1 / speed, and the least speed; a bound on accelerations all along; the time on slopes that do not hold.
TURN_ROOM, SLOWNESS, SLOWEST, FASTEST, LOOSE = range(4, 9)
# What the derivative makes at a sample, at most, of a size of 1 at the start (`corners`).
SWOLLEN = 9
# And with friction, of turns: the sum of 1 / deceleration, the least of it, and of it times what is left of a hold in
# which friction holds the knob from there on. Of a hold that begins with a speed of 0 the latter is of the level.
TURNING, LEAST_TURN, STUCK_FOR = range(10, 13)
# And with more states, of releases within a hold: the sum of 1 / rate of the torque, the least of that, and of it times
# the shorter of the pieces beside it. `LEVEL` and `SPEED` are then of all times but those near ends of pieces.
RELEASING, LEAST_RELEASE, RELEASED_FOR = range(13, 16)
MARKS = 16


class Columns(NamedTuple):
    """Columns that move together under one command.

    ``values``: list or array of the columns, ``width`` apart, and of the derivatives of commands; ``command``: where
    those of this command begin; ``number``: of columns.
    """

    values: Any
    command: int
    number: int
    width: int


def begin_marks(marks):
    """Set the marks to what they are before a period."""
    for i in range(MARKS):
        marks[i] = float("inf")
    for sum_or_most in (SLOWNESS, FASTEST, LOOSE, SWOLLEN, TURNING, RELEASING):
        marks[sum_or_most] = 0.0


def begin_columns(space, count):
    """The derivatives of the state by itself, ``count`` columns."""
    for c in range(count):
        for i in range(space.width):
            space.cols[c * space.width + i] = 1.0 if i == c else 0.0


def feed(shown, before, delay, head, wall, cols, count, width):
    """Derivatives of the commands of this interval, by a continuous sensor and through the delay, in every column."""
    now, last = slopes(shown, before, wall)
    older, newer = width * width, width * width + width
    line = width - 1 - delay
    for c in range(count):
        at = c * width
        slope = 0.0
        if count == width:
            slope = now * cols[at] + last * cols[at + width - 1]
            cols[at + width - 1] = cols[at]
        cols[older + c] = slope
        cols[newer + c] = slope
        if delay > 0:
            cols[older + c] = cols[at + line + head] if count == width else 0.0
            if count == width:
                cols[at + line + head] = slope
                cols[newer + c] = cols[at + line + (head + 1) % delay]


def spread_two(columns, sgf, body):
    """Move the columns by coefficients (s, g, f) of second order."""
    s, g, f = sgf
    cols = columns.values
    for c in range(columns.number):
        at = c * columns.width
        y = cols[columns.command + c] - body.beta * cols[at]
        x = cols[at] + (s * cols[at + 1] + g * y)
        cols[at + 1] = f * cols[at + 1] + s * y
        cols[at] = x


def spread_by(columns, span, rates, halves, pulled, body, pad):
    """Move the columns over ``span`` by the matrices that begin at ``rates`` and ``halves``; overwrites ``pad``.

    ``pulled``: whether the command acts on what moves.
    """
    n, cols = body.order, columns.values
    rates *= n * n
    h = 1.0
    half = 0
    while span > 0.0:
        if span >= h:
            span -= h
            base = (halves + half) * n * n
            for c in range(columns.number):
                at = c * columns.width
                for i in range(n):
                    total = 0.0
                    if pulled and body.lag == 0.0:
                        total = body.vectors[ENTRY * n + i] * cols[columns.command + c]
                    for j in range(n):
                        total += body.matrices[rates + i * n + j] * cols[at + j]
                    pad[i] = total
                if body.lag > 0.0:
                    pad[n - 1] += body.lag * cols[columns.command + c]
                for i in range(n):
                    total = 0.0
                    for j in range(n):
                        total += body.matrices[base + i * n + j] * pad[j]
                    cols[at + i] += total
        h *= 0.5
        half += 1


def spread_many(columns, span, mode, body, pad):
    """Move the columns over ``span`` in one mode, by its binary digits; overwrites ``pad``."""
    rates, halves = (HELD, HALVES_HELD) if mode == 0 else (RATES, HALVES)
    pulled = mode != 0 or body.play > 0.0
    spread_by(columns, span, rates, halves, pulled, body, pad)


def turn_round(columns, jump, body):
    """The columns at a zero of the velocity: its rate there changes by ``jump``, relatively (saltation matrix)."""
    n, cols, width = body.order, columns.values, columns.width
    for c in range(columns.number):
        speed = cols[c * width + 1] * jump
        for i in range(n):
            cols[c * width + i] += body.vectors[ENTRY * n + i] * speed
