"""A run of cells: from their numbers to their attractors, ranked and measured, without leaving compiled code.

What `attractors.Engine` does for one cell, by the same functions, so that results are the same to the last bit.
"""

from typing import Any, NamedTuple

from hknob_cli.engine.budget import OPEN, TOO_MANY, TrialBudget, prospect, unrepeated
from hknob_cli.engine.ensemble import CLOSURE, EDGE, FATE, PERIOD, ROW, TRIALS, TrialRoom, V, X, ensemble, first_sample
from hknob_cli.engine.follow import CYCLE_CONTINUUM, REST_EDGE, REST_PROVEN, UNSETTLED
from hknob_cli.engine.loop import make_loop
from hknob_cli.engine.orbit_cycle import CycleMeasures, measure_cycle
from hknob_cli.engine.orbit_holds import LENGTH, Holds, holds_per_sample
from hknob_cli.engine.propagator import slowest_rate

UNMEASURED = 20  # the end of a cycle that does not turn but by rounding

# Numbers of a cell: the given ones of its loop, except for the sense; commands under way; and its start.
NUMBERS = ("alpha", "beta", "kappa", "gamma", "offset", "split", "delay_line", "x", "v")
# Numbers of an attractor, the last of which are its measures.
FIELDS = ("cell", "fate", "trials", "period", "edge", "closure", *CycleMeasures._fields)
CELL, FIELD, MEASURES = len(NUMBERS), len(FIELDS), FIELDS.index("cycles")


class Room(NamedTuple):
    """Work space of one cell: arrays of floats.

    ``x``, ``v``, ``line``: a block of lanes; ``ring``: a delay line; ``table``, ``lines``: the orbits of a cell, as
    `ensemble` wants them, with one row more; ``order``: of their rows; ``holds``: of one period;
    ``parts``: their numbers; ``outcome_of``: outcome of every fate.
    """

    x: Any
    v: Any
    line: Any
    ring: Any
    table: Any
    lines: Any
    order: Any
    holds: Holds
    parts: Any
    outcome_of: Any


class Asked(NamedTuple):
    """What is asked of a run of cells, and how much a call does of it: ``most`` trial-samples, and no cell more."""

    sense: float
    phases: int
    max_samples: int
    most: int


def set_end(table, row, fate, trials):
    """Make a row of the table an end without an orbit."""
    for k in range(ROW):
        table[row * ROW + k] = 0.0
    table[row * ROW + FATE] = fate
    table[row * ROW + TRIALS] = trials


def find_ends(loop, x, v, delay, phases, max_samples, capacity, room):
    """Fill the table with the ends of all trials of a cell; ``(rows, samples)``."""
    table = room.table
    fate, budget, skip, limit = prospect(x, v, max_samples, loop)
    if fate != OPEN:
        set_end(table, 0, fate, phases)
        return 1, 0
    at = first_sample(x, v, phases, loop)
    lanes = TrialRoom(
        room.x, room.v, room.line[: len(room.x) * delay], room.ring[:delay], table[: capacity * ROW], room.lines
    )
    most = TrialBudget(skip, budget, True, limit)
    rows, overflow, samples, _ = ensemble(at, phases, 0, phases, most, 0, lanes, loop)
    why = unrepeated(slowest_rate(loop.alpha, loop.beta), budget, loop.beta > 0.0)
    for row in range(rows):
        if table[row * ROW + FATE] == UNSETTLED:
            table[row * ROW + FATE] = why
    if overflow > 0:
        set_end(table, rows, TOO_MANY, overflow)
        rows += 1
    return rows, samples


def precedes(one, other, table, outcome_of):
    """Whether the end in row ``one`` comes before that in ``other``, as `attractors.ranked` has them."""
    a, b = one * ROW, other * ROW
    if table[a + TRIALS] != table[b + TRIALS]:
        return table[a + TRIALS] > table[b + TRIALS]
    first, second = outcome_of[int(table[a + FATE])], outcome_of[int(table[b + FATE])]
    if first != second:
        return first < second
    if table[a + PERIOD] != table[b + PERIOD]:
        return table[a + PERIOD] < table[b + PERIOD]
    return table[a + PERIOD] > 0.0 and table[a + X] < table[b + X]


def rank(rows, table, order, outcome_of):
    """Put the rows in order, the most frequent first; equal ones stay as they are."""
    for row in range(rows):
        at = row
        while at > 0 and precedes(row, int(order[at - 1]), table, outcome_of):
            order[at] = order[at - 1]
            at -= 1
        order[at] = row


def measure_end(row, delay, loop, room, out, base):
    """Write the numbers of one end, except for its cell, to ``out`` from ``base`` on."""
    table, at = room.table, row * ROW
    fate, n, x, v = int(table[at + FATE]), int(table[at + PERIOD]), table[at + X], table[at + V]
    edge, closure, trials = table[at + EDGE], table[at + CLOSURE], table[at + TRIALS]
    for k in range(MEASURES, FIELD):
        out[base + k] = float("nan")
    if fate <= CYCLE_CONTINUUM:
        ring = room.lines[row * delay : (row + 1) * delay]
        cycles, swing, lowest, highest, rms, work, loss, entry, left, staircase = measure_cycle(
            x, v, ring, 0, n, loop, room.parts, room.holds
        )
        if cycles == 0:
            fate, n, edge, closure = UNMEASURED, 0, 0.0, 0.0
        else:
            found = (float(cycles), swing, lowest, highest, rms, work, loss, entry, left, staircase)
            for k in range(len(found)):
                out[base + MEASURES + k] = found[k]
    elif fate == REST_PROVEN or fate == REST_EDGE:
        edge = min(x % 1.0, 1.0 - x % 1.0)
        for k in range(MEASURES, FIELD):
            out[base + k] = 0.0
        out[base + MEASURES + 2] = out[base + MEASURES + 3] = x
    out[base + 1], out[base + 2], out[base + 3] = fate, trials, n
    out[base + 4], out[base + 5] = edge, closure


def longest_orbit(found, table, loop):
    """Holds of the longest period of the first rows of a table."""
    longest = 0
    for row in range(found):
        if table[row * ROW + FATE] <= CYCLE_CONTINUUM:
            longest = max(longest, int(table[row * ROW + PERIOD]))
    return longest * holds_per_sample(loop)


def write_ends(at, found, delay, loop, room, out, rows):
    """Write the ends of cell ``at`` to ``out`` from row ``rows`` on, ranked and measured."""
    rank(found, room.table, room.order, room.outcome_of)
    for k in range(found):
        base = (rows + k) * FIELD
        out[base] = at
        measure_end(int(room.order[k]), delay, loop, room, out, base)


def keep_ends(at, found, delay, loop, plant, room, out, rows):
    """Write the ends of a cell, or where one has a period too long for ``room`` its number of holds; else 0.

    ``plant``: alpha, beta and split of the cell before.
    """
    longest = longest_orbit(found, room.table, loop)
    if longest > len(room.holds.drive):
        return longest
    if loop.alpha != plant[0] or loop.beta != plant[1] or loop.split != plant[2]:
        room.parts[LENGTH] = 0.0  # of another plant than the cell's before
    write_ends(at, found, delay, loop, room, out, rows)
    return 0


def run_cells(cells, first, stop, asked, room, out):
    """Run cells ``first`` to ``stop``, or fewer: until enough trial-samples are taken, or ``out`` is full.

    ``cells`` holds `NUMBERS` of every cell, ``out`` takes `FIELDS` of every attractor. Returns ``(next, rows, samples,
    holds)``: the first cell not run, rows of ``out`` filled, trial-samples taken, and, where the next cell has a period
    too long for ``room``, its number of holds, else 0.
    """
    capacity = len(room.order) - 1
    rows, samples = 0, 0
    plant = (-1.0, -1.0, -1.0)
    for at in range(first, stop):
        if samples > asked.most or rows + len(room.order) > len(out) // FIELD:
            return at, rows, samples, 0
        base = at * CELL
        alpha, beta, kappa, gamma = cells[base], cells[base + 1], cells[base + 2], cells[base + 3]
        loop = make_loop(alpha, beta, kappa, gamma, asked.sense, cells[base + 4], cells[base + 5])
        delay, x, v = int(cells[base + 6]), cells[base + 7], cells[base + 8]
        found, taken = find_ends(loop, x, v, delay, asked.phases, asked.max_samples, capacity, room)
        holds = keep_ends(at, found, delay, loop, plant, room, out, rows)
        if holds:
            return at, rows, samples, holds
        plant = loop.alpha, loop.beta, loop.split
        rows += found
        samples += taken
    return stop, rows, samples, 0
