"""The trials of one cell under a law, one after another, counted by their orbit: as `general.ensemble`."""

from hknob_cli.engine.certificate import DIFFERENT, NOT_CAPTURED, ON_EDGE, PROVEN
from hknob_cli.engine.ensemble import near
from hknob_cli.engine.follow import CYCLE_PROVEN, REST_EDGE, REST_PROVEN, UNSETTLED
from hknob_cli.engine.general.body import copy_to
from hknob_cli.engine.general.captured import FIELDS
from hknob_cli.engine.general.cogging import has_gone
from hknob_cli.engine.general.controller import read
from hknob_cli.engine.general.ensemble import begin, count_end, enter_row, find, is_cycle, is_rest, shown_at_rest
from hknob_cli.engine.general.follow import KNOWN
from hknob_cli.engine.general.interval import begin_clock, jitters
from hknob_cli.engine.general.laws.cascade import nearly_same
from hknob_cli.engine.general.laws.follow import fate_of, follow_with_law
from hknob_cli.engine.general.laws.law import CYCLE_AT_SWITCH, CYCLE_NOT_AFFINE, REST_NOT_PROVEN
from hknob_cli.engine.general.laws.period import certify_with_law
from hknob_cli.engine.general.laws.step import advance_jittering_with_law, advance_with_law, begin_past

SAME = 1e-9  # of what is remembered at one sample of an orbit and at another, relative


def is_cycle_of_law(fate):
    """Whether a fate is a limit cycle, proven or not."""
    return is_cycle(fate) or fate == CYCLE_AT_SWITCH or fate == CYCLE_NOT_AFFINE


def turn_to_deepest(period, trial, body, wall, law):
    """Turn the orbit of ``trial`` to its deepest sample and its shortest period, which is returned."""
    z, past, space = trial.z, trial.ring, trial.space
    best, bestpast = trial.check, trial.check_ring
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


def rest_of_law(trial, body, wall, law):
    """Fate of a motion that is the same at every sample; a trial is moved to it where that is proven."""
    z, past, space = trial.z, trial.ring, trial.space
    if not law.provable:
        return REST_NOT_PROVEN
    status, _, _, _, _ = certify_with_law(z, past, 1, body, wall, law, space)
    if status == PROVEN or status == NOT_CAPTURED:
        copy_to(z, space.orbit)
        copy_to(past, law.periodic)
        return REST_PROVEN
    return REST_EDGE if status == ON_EDGE else REST_NOT_PROVEN


def enter_with_law(fate, period, trial, body, wall, law):
    """Enter the end of `follow_with_law` where it is new: its row; as `general.ensemble.enter`."""
    z, past, space, table, states = trial.z, trial.ring, trial.space, trial.table, trial.states
    n, rows = body.order, int(trial.counts[0])
    cycle = is_cycle_of_law(fate)
    turns = period
    margin, edge, closure, bound = 0.0, 0.0, 0.0, 0.0
    if cycle:
        period = turn_to_deepest(period, trial, body, wall, law)
        if period == 1 and (law.senses or not law.provable):
            cycle, fate = False, rest_of_law(trial, body, wall, law)
    rest, shown = is_rest(fate), shown_at_rest(fate, z, past[law.line - 1], body, wall)
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
            if not is_cycle_of_law(fate):
                fate, period, margin, edge, closure, bound = UNSETTLED, 0, 0.0, 0.0, 0.0, 0.0
            row = find(fate, period, z, shown, rows, table, states, n)
    if body.halt[0] > 0.0:
        return -1
    if row == len(table) // FIELDS:
        return row
    last = shown if shown == shown else law.room[0]
    enter_row(row, fate, period, (margin, edge, closure, bound), last, trial, 0 * len(past), rest)
    return row


def run_trials_with_law(start, batch, budget, trial, body, wall, law):
    """Run the trials of a batch and count them by attractor: as `general.ensemble.run_trials`.

    Each row of ``trial.lines`` has what is remembered at the orbit's deepest sample.
    """
    z, past, pad = trial.z, trial.ring, trial.space.pad
    overflow, samples = 0, 0
    for i in range(batch.first, batch.stop):
        begin(z, start, (i + 0.5) / batch.phases, body, pad)
        begin_past(past, read(z[0], wall), law)
        begin_clock(wall.clock, float(i))
        for _ in range(budget.skip):
            if jitters(wall.clock):
                advance_jittering_with_law(z, past, body, wall, law, pad)
            else:
                advance_with_law(z, past, body, wall, law, pad)
            if has_gone(body.cogs, z, budget.limit) or body.halt[0] > 0.0:
                break
        fate, row, used = follow_with_law(trial, budget, body, wall, law)
        samples += used + budget.skip
        if body.halt[0] > 0.0:
            return overflow, samples
        if fate != KNOWN:
            row = enter_with_law(fate, row, trial, body, wall, law)
            if row < 0:
                return overflow, samples
        overflow += count_end(row, trial)
    return overflow, samples
