"""Every clock at once: cells of states, and the cells that the next sample may come into, whenever it comes.

States of a second-order knob without friction, angle and speed, are covered by a grid of boxes, whose sides lie on the
count's edges, so that a box has one command. Over an interval between the shortest and the longest a box moves through
boxes that are bounded here, roundings included; these are its successors (cell mapping: Hsu 1987; outer covers of
attractors: Dellnitz & Hohmann 1997). A motion under any clock is a path through this graph. A path that goes on for
ever is, after as many steps as there are cells, in cells that a circle of the graph leads to; all others are trimmed.
A box from which every motion comes to rest, whatever the intervals, has no successors (`capture` is that of
`standstill.settles`).
"""

from math import sqrt
from typing import Any, NamedTuple

from hknob_cli.engine.general.controller import command, edge_gap, read
from hknob_cli.engine.loop import floor

CAPTURED, LEAVES = -1, -2  # in place of a number of boxes
LEVELS = 9  # an interval is cut into 1, 2, 4, ... 2**(LEVELS - 1) parts
HOLD = 32  # parts of a hold whose extremes are bounded
SLACK = 2.0**-32  # of the size of what is added up: far above all roundings
UNSEEN, THERE, RESTS = 0, 1, 2


class Cells(NamedTuple):
    """A grid of boxes: ``width`` counts by ``height`` counts a sample, ``columns`` by ``rows``, from ``left``, ``low``.

    ``left`` and ``low`` count boxes from 0. ``shortest``: interval, in the longest. ``whole``: whether the grid ends
    where nothing is known to stay. ``parts``: S, G and F in the middle of each part of the intervals that may be, by
    level, then of each part of a hold (3 each). ``boxes``: takes first and last column and row of successors (4 each).
    """

    width: float
    height: float
    left: int
    low: int
    columns: int
    rows: int
    shortest: float
    whole: bool
    parts: Any
    boxes: Any


class Joined(NamedTuple):
    """Cells that are joined where successors connect them, a tree for each motion, and ranges of positions.

    ``parent``: in its tree, and ``place``: in the queue, of each cell of the grid; ``lows`` and ``highs``: of each cell
    of the queue, and of a tree where its root is.
    """

    parent: Any
    place: Any
    lows: Any
    highs: Any


def rounded(x, fast, hard, u, body):
    """Far above what roundings add to a position or a speed within a hold, by the size of all terms."""
    return SLACK * (1.0 + abs(x) + fast + hard + abs(u) + abs(body.drive))


def rests(x, v, rx, rv, u, shown, body, wall):
    """Whether every motion from a box comes to rest under the command ``u``, whatever the intervals are."""
    rest = (u + body.drive) / body.beta
    gap = edge_gap(rest, shown, shown, wall)
    away, pace = abs(x - rest) + rx, abs(v) + rv
    far = body.reach * sqrt(pace * pace + body.beta * away * away)
    return far + SLACK * (1.0 + far + (abs(u) + abs(body.drive)) / body.beta) < gap


def centre_of(at, cells):
    """Position and speed in the middle of a cell."""
    column, row = at // cells.rows, at % cells.rows
    return (cells.left + column) * cells.width + 0.5 * cells.width, (
        cells.low + row
    ) * cells.height + 0.5 * cells.height


def successors(at, cells, body, wall):
    """Boxes that a box comes into within the next interval: how many, in ``cells.boxes``; or `CAPTURED`, `LEAVES`."""
    rx, rv = 0.5 * cells.width, 0.5 * cells.height
    x, v = centre_of(at, cells)
    shown = read(x, wall)
    u = command(shown, shown, wall)
    if rests(x, v, rx, rv, u, shown, body, wall):
        return CAPTURED
    y = u + body.drive - body.beta * x
    # Bounds on the speed, its rate, and the rate of that within a hold.
    fast = abs(v) + rv + abs(y) + body.beta * rx
    hard = abs(y) + body.beta * (rx + fast) + body.alpha * fast
    jerk = body.beta * fast + body.alpha * hard
    free, wide = 1.0 - cells.shortest, rounded(x, fast, hard, u, body)
    level, count = 0, 1
    while level < LEVELS - 1 and count < free * max(fast / cells.width, hard / cells.height):
        level, count = level + 1, 2 * count
    half = 0.5 * free / count
    for i in range(count):
        part = 3 * (count - 1 + i)
        s, g, f = cells.parts[part], cells.parts[part + 1], cells.parts[part + 2]
        at_x, at_v = x + s * v + g * y, f * v + s * y
        off_x = abs(1.0 - body.beta * g) * rx + abs(s) * rv
        off_v = abs(body.beta * s) * rx + abs(f) * rv
        pull = u + body.drive - body.beta * at_x - body.alpha * at_v
        off_x += half * (abs(at_v) + off_v + half * hard)
        off_v += half * (abs(pull) + body.beta * off_x + body.alpha * off_v + half * jerk)
        off_x += wide
        off_v += wide
        first, last = floor((at_x - off_x) / cells.width) - cells.left, floor((at_x + off_x) / cells.width) - cells.left
        under, over = floor((at_v - off_v) / cells.height) - cells.low, floor((at_v + off_v) / cells.height) - cells.low
        if cells.whole and (first < 0 or under < 0 or last >= cells.columns or over >= cells.rows):
            return LEAVES
        cells.boxes[4 * i] = max(int(first), 0)
        cells.boxes[4 * i + 1] = min(int(last), cells.columns - 1)
        cells.boxes[4 * i + 2] = max(int(under), 0)
        cells.boxes[4 * i + 3] = min(int(over), cells.rows - 1)
    return count


def reach_cells(state, queue, filled, most, cells, body, wall):
    """Find all cells that motions from the first ``filled`` of ``queue`` may come into: ``(filled, visits)``.

    ``state`` is then `THERE` for them, or `RESTS`. -1 where a motion may leave the grid, where there are more than
    ``most`` visits of successors, and once ``body.halt`` is above 0.
    """
    done, visits = 0, 0
    while done < filled:
        at = queue[done]
        done += 1
        count = successors(at, cells, body, wall)
        if count == LEAVES or visits > most or body.halt[0] > 0.0:
            return -1, visits
        if count == CAPTURED:
            state[at] = RESTS
            continue
        for i in range(count):
            for column in range(cells.boxes[4 * i], cells.boxes[4 * i + 1] + 1):
                base = column * cells.rows
                for row in range(cells.boxes[4 * i + 2], cells.boxes[4 * i + 3] + 1):
                    visits += 1
                    if state[base + row] == UNSEEN:
                        state[base + row] = THERE
                        queue[filled] = base + row
                        filled += 1
    return filled, visits


def trim_cells(state, queue, filled, degree, cells, body, wall):
    """Leave only cells to which a circle leads: ``(how many, visits)``; the others become `UNSEEN`. -1 once halted.

    The first ``filled`` of ``queue`` are all cells that are `THERE`, and are overwritten by those that are left.
    """
    visits = 0
    for k in range(filled):
        degree[queue[k]] = 0
    for k in range(filled):
        if body.halt[0] > 0.0:
            return -1, visits
        count = successors(queue[k], cells, body, wall)
        if count == CAPTURED:
            state[queue[k]] = RESTS
            continue
        for i in range(count):
            for column in range(cells.boxes[4 * i], cells.boxes[4 * i + 1] + 1):
                base = column * cells.rows
                for row in range(cells.boxes[4 * i + 2], cells.boxes[4 * i + 3] + 1):
                    visits += 1
                    degree[base + row] += 1
    left, gone = 0, filled  # those that are left in front, those that have no predecessor in a stack behind
    stack = 0
    for k in range(filled):
        at = queue[k]
        if state[at] == THERE and degree[at] > 0:
            queue[left] = at
            left += 1
        elif state[at] == THERE:
            queue[gone + stack] = at
            stack += 1
        else:
            state[at] = UNSEEN
    while stack > 0:
        stack -= 1
        at = queue[gone + stack]
        state[at] = UNSEEN
        count = successors(at, cells, body, wall)
        for i in range(count):
            for column in range(cells.boxes[4 * i], cells.boxes[4 * i + 1] + 1):
                base = column * cells.rows
                for row in range(cells.boxes[4 * i + 2], cells.boxes[4 * i + 3] + 1):
                    visits += 1
                    degree[base + row] -= 1
                    if degree[base + row] == 0 and state[base + row] == THERE:
                        queue[gone + stack] = base + row
                        stack += 1
    kept = 0
    for k in range(left):
        if state[queue[k]] == THERE:
            queue[kept] = queue[k]
            kept += 1
    return kept, visits


def root_of(at, parent):
    """The cell that stands for all that are connected with a cell."""
    while parent[at] != at:
        parent[at] = parent[parent[at]]
        at = parent[at]
    return at


def hold_range(at, cells, body, wall):
    """Bounds on the position of a motion from a cell, from a sample to the next: ``(least, most)``."""
    rx, rv = 0.5 * cells.width, 0.5 * cells.height
    x, v = centre_of(at, cells)
    shown = read(x, wall)
    u = command(shown, shown, wall)
    y = u + body.drive - body.beta * x
    fast = abs(v) + rv + abs(y) + body.beta * rx
    hard = abs(y) + body.beta * (rx + fast) + body.alpha * fast
    least, most, half = x - rx, x + rx, 0.5 / HOLD
    for i in range(HOLD):
        part = 3 * (2**LEVELS - 1 + i)
        s, g, f = cells.parts[part], cells.parts[part + 1], cells.parts[part + 2]
        at_x = x + s * v + g * y
        off = abs(1.0 - body.beta * g) * rx + abs(s) * rv
        pace = abs(f * v + s * y) + abs(body.beta * s) * rx + abs(f) * rv
        off += half * (pace + half * hard) + rounded(x, fast, hard, u, body)
        least, most = min(least, at_x - off), max(most, at_x + off)
    return least, most


def widest_range(state, queue, filled, joined, cells, body, wall):
    """The widest range of positions of one motion for ever within the ``filled`` cells of ``queue``.

    Between samples, too. Cells that are connected by successors, either way, are one: a motion never leaves them.
    ``joined`` is overwritten.
    """
    parent, place, lows, highs = joined.parent, joined.place, joined.lows, joined.highs
    for k in range(filled):
        parent[queue[k]], place[queue[k]] = queue[k], k
    for k in range(filled):
        lows[k], highs[k] = hold_range(queue[k], cells, body, wall)
        one = root_of(queue[k], parent)
        count = successors(queue[k], cells, body, wall)
        for i in range(count):
            for column in range(cells.boxes[4 * i], cells.boxes[4 * i + 1] + 1):
                base = column * cells.rows
                for row in range(cells.boxes[4 * i + 2], cells.boxes[4 * i + 3] + 1):
                    if state[base + row] == THERE and parent[base + row] != one:
                        parent[root_of(base + row, parent)] = one
    widest = 0.0
    for k in range(filled):
        root = place[root_of(queue[k], parent)]
        lows[root], highs[root] = min(lows[root], lows[k]), max(highs[root], highs[k])
        widest = max(widest, highs[root] - lows[root])
    return widest
