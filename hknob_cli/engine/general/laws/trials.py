"""The trials of one cell under a law, one after another, counted by their orbit: as `general.ensemble`."""

from hknob_cli.engine.certificate import DIFFERENT, NOT_CAPTURED, ON_EDGE, PROVEN
from hknob_cli.engine.ensemble import near
from hknob_cli.engine.follow import CYCLE_PROVEN, REST_EDGE, REST_PROVEN, UNSETTLED
from hknob_cli.engine.general.cogging import has_gone
from hknob_cli.engine.general.controller import read, read_after
from hknob_cli.engine.general.ensemble import begin, find, is_cycle
from hknob_cli.engine.general.follow import FIELDS, KNOWN
from hknob_cli.engine.general.jitter import begin_clock, jitters
from hknob_cli.engine.general.laws.cascade import nearly_same
from hknob_cli.engine.general.laws.follow import fate_of, follow_with_law
from hknob_cli.engine.general.laws.law import CYCLE_AT_SWITCH, CYCLE_NOT_AFFINE, REST_NOT_PROVEN
from hknob_cli.engine.general.laws.period import certify_with_law
from hknob_cli.engine.general.laws.step import advance_jittering_with_law, advance_with_law, begin_past, copy_to

SAME = 1e-9  # of what is remembered at one sample of an orbit and at another, relative


def is_cycle_of_law(fate):
    """Whether a fate is a limit cycle, proven or not."""
    return is_cycle(fate) or fate == CYCLE_AT_SWITCH or fate == CYCLE_NOT_AFFINE


def turn_to_deepest(z, past, period, body, wall, law, space, best, bestpast):
    """Turn an orbit to its deepest sample and its shortest period, which is returned."""
    copy_to(law.periodic, past)
    copy_to(best, z)
    copy_to(bestpast, past)
    copy_to(space.away, z)
    for i in range(period):
        if i > 0 and period % i == 0 and nearly_same(past, law.periodic, law, SAME):
            again = True
            for j in range(body.order):
                again = again and near(z[j], space.away[j])
            if again:
                period = i
                break
        if z[0] < best[0]:
            copy_to(best, z)
            copy_to(bestpast, past)
        advance_with_law(z, past, body, wall, law, space.pad)
    copy_to(z, best)
    copy_to(past, bestpast)
    return period


def rest_of_law(z, past, body, wall, law, space):
    """Fate of a motion that is the same at every sample; ``z`` and ``past`` are moved to it where that is proven."""
    if not law.provable:
        return REST_NOT_PROVEN
    status, _, _, _, _ = certify_with_law(z, past, 1, body, wall, law, space)
    if status == PROVEN or status == NOT_CAPTURED:
        copy_to(z, space.orbit)
        copy_to(past, law.periodic)
        return REST_PROVEN
    return REST_EDGE if status == ON_EDGE else REST_NOT_PROVEN


def enter_with_law(
    fate, period, z, past, capacity, rows, table, states, pasts, body, wall, law, space, check, checkpast
):
    """Enter the end of `follow_with_law` where it is new: ``(row, rows)``; as `general.ensemble.enter`."""
    n, length = body.order, len(past)
    cycle = is_cycle_of_law(fate)
    turns = period
    margin, edge, closure, bound = 0.0, 0.0, 0.0, 0.0
    if cycle:
        period = turn_to_deepest(z, past, period, body, wall, law, space, check, checkpast)
        if period == 1 and (law.senses or not law.provable):
            cycle, fate = False, rest_of_law(z, past, body, wall, law, space)
    rest = fate == REST_NOT_PROVEN or fate == REST_PROVEN or fate == REST_EDGE
    shown = read_after(z[0], past[law.line - 1], wall) if rest and body.friction > 0.0 else float("nan")
    if wall.analog > 0.0 and shown == shown:
        shown = -1.0 if z[0] < 0.0 else 0.0
    row = find(fate, period, z, shown, rows, table, states, n)
    if cycle and row == rows:
        status, margin, edge, closure, bound = certify_with_law(z, past, period, body, wall, law, space)
        if status == DIFFERENT and period < turns:
            period = turns
            row = find(fate, period, z, shown, rows, table, states, n)
            status, margin, edge, closure, bound = certify_with_law(z, past, period, body, wall, law, space)
        if status == PROVEN or status == NOT_CAPTURED:
            if fate == CYCLE_PROVEN:
                copy_to(z, space.orbit)
                copy_to(past, law.periodic)
        elif fate == CYCLE_PROVEN or status == DIFFERENT:
            fate = fate_of(status, law)
    if cycle and not is_cycle_of_law(fate):
        cycle, period = False, 0
        margin, edge, closure, bound = 0.0, 0.0, 0.0, 0.0
        fate = UNSETTLED
        row = find(fate, period, z, shown, rows, table, states, n)
    if body.halt[0] > 0.0:
        return -1, rows
    if row == capacity:
        return capacity, rows
    base = row * FIELDS
    if row == rows:
        rows += 1
        table[base], table[base + 1] = fate, period
        table[base + 2], table[base + 3] = margin, edge
        table[base + 4], table[base + 5] = closure, bound
        table[base + 6] = 0.0
        table[base + 7], table[base + 8] = z[0], z[0]
        table[base + 9] = shown if rest and body.friction > 0.0 else law.room[0]
        for j in range(n):
            states[row * n + j] = z[j]
        for j in range(length):
            pasts[row * length + j] = past[j]
    if rest:
        table[base + 7] = min(table[base + 7], z[0])
        table[base + 8] = max(table[base + 8], z[0])
    return row, rows


def run_trials_with_law(
    start,
    phases,
    first,
    stop,
    skip,
    budget,
    final,
    limit,
    capacity,
    rows,
    table,
    states,
    pasts,
    body,
    wall,
    law,
    space,
    z,
    past,
    check,
    checkpast,
    keep,
    keeppast,
):
    """Run trials ``first`` to ``stop`` of ``phases`` and count them by attractor: as `general.ensemble.run_trials`.

    Each row of ``pasts`` has what is remembered at the orbit's deepest sample.
    """
    overflow, samples = 0, 0
    for trial in range(first, stop):
        begin(z, start, (trial + 0.5) / phases, body, space.pad)
        begin_past(past, read(z[0], wall), law)
        begin_clock(wall.clock, float(trial))
        for _ in range(skip):
            if jitters(wall.clock):
                advance_jittering_with_law(z, past, body, wall, law, space.pad)
            else:
                advance_with_law(z, past, body, wall, law, space.pad)
            if has_gone(body.cogs, z, limit) or body.halt[0] > 0.0:
                break
        fate, period, used = follow_with_law(
            z,
            past,
            budget - skip,
            final,
            limit,
            body,
            wall,
            law,
            space,
            check,
            checkpast,
            keep,
            keeppast,
            rows,
            table,
            states,
            pasts,
        )
        samples += used + skip
        if body.halt[0] > 0.0:
            return rows, overflow, samples
        if fate == KNOWN:
            table[period * FIELDS + 6] += 1.0
            continue
        row, rows = enter_with_law(
            fate, period, z, past, capacity, rows, table, states, pasts, body, wall, law, space, check, checkpast
        )
        if row < 0:
            return rows, overflow, samples
        if row == capacity:
            overflow += 1
            continue
        table[row * FIELDS + 6] += 1.0
    return rows, overflow, samples
