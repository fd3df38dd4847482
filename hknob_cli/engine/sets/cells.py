"""A run of cells, every clock phase of one start of each: as `engine.cells` for sampled phases.

What `sets.search` does for one cell, by the same functions, so that results are the same to the last bit.
"""

from typing import Any, NamedTuple

from hknob_cli.engine.budget import OPEN, prospect
from hknob_cli.engine.cells import CELL, FIELD, find_ends, keep_ends, set_end
from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.follow import UNSETTLED
from hknob_cli.engine.loop import make_loop
from hknob_cli.engine.sets.arc import (
    COVERED,
    DONE,
    TAKEN,
    UNDECIDED,
    WAITING,
    WHOLE,
    begin_arcs,
    follow_arcs,
)
from hknob_cli.engine.sets.ball import Start
from hknob_cli.engine.sets.room import ArcRoom

TOLD = 3  # numbers that are told of a cell: whether its list is complete, its arcs, the error of a share
UNFOLLOWED = 1e-9  # share of starts that is rounding
TRANSIENTS = 2  # as part of the transient, the samples in no known attractor after which one is looked for
FEWEST = 64


class ArcWork(NamedTuple):
    """Work space of the sets of a run of cells, and what is told of each: `TOLD` numbers.

    ``arcs``: an `ArcRoom`; ``known``: a `Known`, which shares the table and lines of the cells' room, one row less;
    ``capacity``: ends that are kept of sampled phases.
    """

    arcs: Any
    known: Any
    told: Any
    capacity: int


def first_patience(skip):
    """Samples in no known attractor, after which one is looked for, where ``skip`` pass before trials are looked at."""
    return max(FEWEST, skip // TRANSIENTS)


def follow_cell(loop, start, max_samples, tries, most, arcs, known):
    """Follow the clock phases of a cell, for ``most`` samples; ``(state, samples)`` that this call took.

    ``tries``: samples that a motion gets at first, 0: all of its own. ``state``: -1 where arcs cannot be followed, 0
    where some still wait, 1 where all have ended.
    """
    fate, budget, skip, limit = prospect(start.x, start.v, max_samples, loop)
    if fate != OPEN or not loop.alpha > 0.0 or not loop.beta > 0.0:
        return -1, 0
    if arcs.progress[WAITING] == 0.0:
        begin_arcs(start, first_patience(skip), arcs, loop)
        known.counts[0], known.counts[1], known.counts[2] = 0.0, 0.0, 0.0
    final = tries == 0 or tries >= budget
    taken = follow_arcs(start, budget if final else tries, limit, most, final, arcs, known, loop)
    if arcs.progress[WHOLE] == 0.0:
        return -1, taken
    return (0 if arcs.progress[WAITING] > 0.0 else 1), taken


def lost_share(table, rows, progress):
    """Share of the starts that ended in none of the first ``rows`` of a table; 0 where all ended proven."""
    if progress[UNDECIDED] == 0.0:
        return 0.0
    reached = 0.0
    for row in range(rows):
        reached += table[row * 10 + 8]
    lost = 1.0 - reached / progress[COVERED]
    return lost if lost > UNFOLLOWED else 0.0


def share_error(progress):
    """Bound on the error of a share: what arcs overlap by, and the rounding of their lengths."""
    return max(progress[COVERED] - 1.0, 0.0) + EPSILON * (progress[DONE] + 1.0)


def run_arc_cells(cells, first, stop, asked, work, room, out):
    """Run cells ``first`` to ``stop``, or fewer, as `engine.cells.run_cells`; a call may end within a cell.

    Phases are sampled where arcs cannot be followed.
    """
    arcs, known, told = work.arcs, work.known, work.told
    rows, samples, spent = 0, 0, 0
    plant = (-1.0, -1.0, -1.0)
    for at in range(first, stop):
        if spent > asked.most or rows + len(room.order) > len(out) // FIELD:
            return at, rows, samples, 0
        base = at * CELL
        alpha, beta, kappa, gamma = cells[base], cells[base + 1], cells[base + 2], cells[base + 3]
        loop = make_loop(alpha, beta, kappa, gamma, asked.sense, cells[base + 4], cells[base + 5])
        delay, x, v = int(cells[base + 6]), cells[base + 7], cells[base + 8]
        own = ArcRoom(
            arcs.stack, arcs.rings, arcs.ring[:delay], arcs.spare[:delay], arcs.cuts, arcs.ended, arcs.progress
        )
        left = asked.most - spent + 1
        state, taken = follow_cell(loop, Start(x, v, delay), asked.max_samples, 0, left, own, known)
        spent += taken
        if state == 0:
            return at, rows, samples, 0
        if state > 0:
            found, taken = int(known.counts[0]), int(arcs.progress[TAKEN])
            told[TOLD * at] = 1.0 if arcs.progress[UNDECIDED] == 0.0 else 0.0
            told[TOLD * at + 1], told[TOLD * at + 2] = arcs.progress[DONE], share_error(arcs.progress)
            lost = lost_share(room.table, found, arcs.progress)
            if lost > 0.0:
                set_end(room.table, found, UNSETTLED, lost)
                found += 1
        else:
            found, taken = find_ends(loop, x, v, delay, asked.phases, asked.max_samples, work.capacity, room)
            told[TOLD * at], told[TOLD * at + 1], told[TOLD * at + 2] = 0.0, 0.0, float("nan")
            spent += taken
        holds = keep_ends(at, found, delay, loop, plant, room, out, rows)
        if holds:
            return at, rows, samples, holds
        plant = loop.alpha, loop.beta, loop.split
        rows += found
        samples += taken
    return stop, rows, samples, 0
