"""The ensemble of one cell in the general loop: trials by phase, followed one after another, counted by their orbit."""

from typing import Any, NamedTuple

from hknob_cli.engine.certificate import DIFFERENT, NOT_CAPTURED, PROVEN
from hknob_cli.engine.ensemble import near
from hknob_cli.engine.follow import (
    CYCLE_CONTINUUM,
    CYCLE_ON_EDGE,
    CYCLE_PROVEN,
    REST_EDGE,
    REST_PROVEN,
)
from hknob_cli.engine.general.advance import advance_span
from hknob_cli.engine.general.body import copy_to
from hknob_cli.engine.general.captured import FIELDS
from hknob_cli.engine.general.controller import read, read_after, told
from hknob_cli.engine.general.follow import CYCLE_AT_EVENT, CYCLE_EXPANDS, CYCLE_PARTS, KNOWN, downgrade, follow_trial
from hknob_cli.engine.general.interval import advance, begin_clock, pass_over
from hknob_cli.engine.general.laws.law import REST_NOT_PROVEN
from hknob_cli.engine.general.orbit_proof import certify
from hknob_cli.engine.general.torque_curve import has_curve, place_at


class TrialSpace(NamedTuple):
    """Work space of the trials of a cell, and the ends found so far: lists or arrays.

    ``z`` (order) and ``ring`` (delay line) are the trial; the next four keep states and lines of it beside. Each row of
    ``table`` has `FIELDS`; of ``states`` the orbit's state at its deepest sample, of ``lines`` the commands under way
    there, oldest first; ``counts``: of rows that are filled.
    """

    z: Any
    ring: Any
    check: Any
    check_ring: Any
    keep: Any
    keep_ring: Any
    counts: Any
    table: Any
    states: Any
    lines: Any
    space: Any


def is_cycle(fate):
    """Whether a fate is a limit cycle, proven or not."""
    return (
        fate == CYCLE_PROVEN
        or fate == CYCLE_ON_EDGE
        or fate == CYCLE_CONTINUUM
        or fate == CYCLE_AT_EVENT
        or fate == CYCLE_EXPANDS
        or fate == CYCLE_PARTS
    )


def is_rest(fate):
    """Whether a fate is a rest, proven or not."""
    return fate == REST_PROVEN or fate == REST_EDGE or fate == REST_NOT_PROVEN


def shown_at_rest(fate, z, before, body, wall):
    """What rests that friction holds are told apart by: their reading, or the place on a curve; of other ends nan."""
    if not is_rest(fate) or body.friction == 0.0:
        return float("nan")
    if wall.analog == 0.0:
        shown = read_after(z[0], before, wall)
        return told(shown, wall) if wall.hysteresis > 0.0 else shown
    shown = -1.0 if z[0] < 0.0 else 0.0
    if has_curve(wall.curve):
        shown += 2.0 * place_at(z[0], wall.curve)
    return shown


def begin(z, start, part, body, pad):
    """State ``part`` of a sample period after ``start``, no torque commanded yet."""
    for j in range(body.order):
        z[j] = start[j]
    advance_span(z, 0.0, part, body, pad)


def deepest(before, head, period, trial, body, wall):
    """Turn the orbit of ``trial`` to its deepest sample and its shortest period: ``(before, head, period)``."""
    z, ring, orbit, line = trial.z, trial.ring, trial.space.orbit, trial.space.orbit_line
    best, best_ring = trial.check, trial.check_ring
    n, delay = body.order, len(ring)
    for j in range(n):
        orbit[j], best[j] = z[j], z[j]
    for j in range(delay):
        line[j], best_ring[j] = ring[j], ring[j]
    first, best_before, best_head = head, before, head
    for i in range(period):
        if i > 0 and period % i == 0:
            again = True
            for j in range(n):
                again = again and near(z[j], orbit[j])
            for j in range(delay):
                again = again and near(ring[(head + j) % delay], line[(first + j) % delay])
            if again:
                period = i
                break
        if z[0] < best[0]:
            best_before, best_head = before, head
            for j in range(n):
                best[j] = z[j]
            for j in range(delay):
                best_ring[j] = ring[j]
        before, head = advance(z, before, ring, head, body, wall, trial.space.pad)
    for j in range(n):
        z[j] = best[j]
    for j in range(delay):
        ring[j] = best_ring[j]
    return best_before, best_head, period


def find(fate, period, z, shown, rows, table, states, order):
    """Row of this attractor, or ``rows`` if new. Rest points held by friction count as one per reading, as `told`."""
    for row in range(rows):
        base = row * FIELDS
        if table[base] != fate or table[base + 1] != period:
            continue
        if period == 0:
            return row
        if shown == shown:
            if table[base + 9] == shown:
                return row
            continue
        same = True
        for j in range(order):
            same = same and near(z[j], states[row * order + j])
        if same:
            return row
    return rows


def enter_row(row, fate, period, proof, last, trial, head, rest):
    """Write an end where it is new; of one at rest, how far its trials reach.

    ``proof``: margin, edge, closure and bound of `orbit_proof.certify`; ``last``: reading that the row keeps.
    """
    table, z, ring = trial.table, trial.z, trial.ring
    base, n, delay = row * FIELDS, len(z), len(ring)
    if row == int(trial.counts[0]):
        trial.counts[0] = row + 1
        table[base], table[base + 1] = fate, period
        for j in range(4):
            table[base + 2 + j] = proof[j]
        table[base + 6] = 0.0
        table[base + 7], table[base + 8] = z[0], z[0]
        table[base + 9] = last
        for j in range(n):
            trial.states[row * n + j] = z[j]
        for j in range(delay):
            trial.lines[row * delay + j] = ring[(head + j) % delay]
    if rest:
        table[base + 7] = min(table[base + 7], z[0])
        table[base + 8] = max(table[base + 8], z[0])


def enter(fate, period, before, head, trial, body, wall):
    """Enter the end of `follow_trial` where it is new: its row, or as many as ``table`` has where there is no room.

    A proof is taken again at the deepest sample of the orbit, where ``trial.z`` and ``trial.ring`` are left. Once
    ``body.halt`` is above 0 the row is -1.

    Args:
        fate: What the trial came to, of `engine.follow` and `general.follow`.
        period: Of the orbit, samples; 0 without one.
        before: Reading one sample before the state in ``trial.z``.
        head: Where the oldest command is in ``trial.ring``.
        trial: `TrialSpace`, or what has fields of these names.
        body: What moves.
        wall: What commands.
    """
    z, ring, space, table = trial.z, trial.ring, trial.space, trial.table
    n, rows = body.order, int(trial.counts[0])
    cycle = is_cycle(fate)
    turns = period
    margin, edge, closure, bound = 0.0, 0.0, 0.0, 0.0
    if cycle:
        before, head, period = deepest(before, head, period, trial, body, wall)
    rest, shown = is_rest(fate), shown_at_rest(fate, z, before, body, wall)
    row = find(fate, period, z, shown, rows, table, trial.states, n)
    if cycle and row == rows:
        status, margin, edge, closure, bound = certify(z, before, ring, head, period, body, wall, space)
        if status == DIFFERENT and period < turns:
            period = turns
            row = find(fate, period, z, shown, rows, table, trial.states, n)
            status, margin, edge, closure, bound = certify(z, before, ring, head, period, body, wall, space)
        if status == PROVEN or status == NOT_CAPTURED:
            if fate == CYCLE_PROVEN:
                copy_to(z, space.orbit)
                copy_to(ring, space.orbit_line)
                before = space.reading[0]
        elif fate == CYCLE_PROVEN or status == DIFFERENT:
            fate = downgrade(status)
            if not is_cycle(fate):
                # Nothing is left of the cycle but that the trial has not settled.
                period, margin, edge, closure, bound = 0, 0.0, 0.0, 0.0, 0.0
            row = find(fate, period, z, shown, rows, table, trial.states, n)
    if body.halt[0] > 0.0:
        return -1
    if row == len(table) // FIELDS:
        return row
    last = shown if shown == shown else before
    enter_row(row, fate, period, (margin, edge, closure, bound), last, trial, head, rest)
    return row


class Batch(NamedTuple):
    """Trials to run: from ``first`` up to before ``stop``, of ``phases`` of the sample clock.

    Trial i is first sampled (i + 1/2)/phases of a period after its start.
    """

    phases: int
    first: int
    stop: int


def count_end(row, trial):
    """Count a trial that has come to the end in a row: how many find no room in the table."""
    if row == len(trial.table) // FIELDS:
        return 1
    trial.table[row * FIELDS + 6] += 1.0
    return 0


def run_trials(start, batch, budget, trial, body, wall):
    """Run the trials of a batch and count them by attractor: ``(overflow, samples)``.

    Once ``body.halt`` is above 0, no trial is counted any more.

    Args:
        start: State of order ``body.order`` that all trials start from.
        batch: Which trials.
        budget: How long a trial is followed.
        trial: Work space, and the ends found so far.
        body: What moves.
        wall: What commands.
    """
    z, ring = trial.z, trial.ring
    overflow, samples = 0, 0
    for i in range(batch.first, batch.stop):
        begin(z, start, (i + 0.5) / batch.phases, body, trial.space.pad)
        begin_clock(wall.clock, float(i))
        for j in range(len(ring)):
            ring[j] = 0.0
        head = 0 * len(ring)
        before = read(z[0], wall)
        before, head = pass_over(z, before, ring, head, budget, body, wall, trial.space.pad)
        fate, row, before, head, used = follow_trial(trial, before, head, budget, body, wall)
        samples += used + budget.skip
        if body.halt[0] > 0.0:
            return overflow, samples
        if fate != KNOWN:
            row = enter(fate, row, before, head, trial, body, wall)
            if row < 0:
                return overflow, samples
        overflow += count_end(row, trial)
    return overflow, samples
