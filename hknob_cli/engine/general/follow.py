"""Following one trial of the general loop until its fate is proven: as `engine.follow`, with friction and the rest."""

from hknob_cli.engine.certificate import DIFFERENT, NEUTRAL, NOT_CAPTURED, ON_EDGE, PROVEN
from hknob_cli.engine.follow import (
    CYCLE_CONTINUUM,
    CYCLE_ON_EDGE,
    CYCLE_PROVEN,
    FIRST_TOLERANCE,
    GREW,
    UNSETTLED,
    same_line,
)
from hknob_cli.engine.general.body import copy_to
from hknob_cli.engine.general.captured import (
    LOOK_AGAIN,
    came_back,
    captured,
    changes_level,
    first_level,
    has_period,
    may_be_captured,
)
from hknob_cli.engine.general.cogging import gap_apart, has_cogs, has_gone
from hknob_cli.engine.general.controller import command, depth_level, inside, read, read_after
from hknob_cli.engine.general.interval import advance, advance_jittering, jitters, rubs_alone
from hknob_cli.engine.general.laws.law import REST_NOT_PROVEN
from hknob_cli.engine.general.looks import (
    GOES_ON,
    Attempts,
    Checkpoint,
    Repeat,
    compare_with_checkpoint,
    keep_checkpoint,
    last_look,
    leave_at,
    look_again,
    no_looks,
    pass_event,
    unsettled,
)
from hknob_cli.engine.general.orbit_proof import AT_EVENT, EXPANDS, PARTS, certify
from hknob_cli.engine.general.slide_two import step_with_friction

CYCLE_AT_EVENT = 9
CYCLE_EXPANDS = 10
CYCLE_PARTS = 15
KNOWN = 11  # reaches an orbit that another trial has proven
WAIT = -1  # a candidate left for later
BESIDE = 1e-6  # counts from a cycle through the play of teeth, at which a trial is not followed further
PATIENCE = 12  # times that one is, each at a quarter of the gap
PROOF_COST = 8  # periods that a trial with a continuous sensor goes on for after an attempt that took about as many


def rub_on(shown, most, since, limit, trial, body, wall):
    """Move a trial that `rubs_alone` on, until a sample is to be looked at: ``(reading, samples)``.

    It moves over the interval after a sample that has been looked at, and over up to ``most`` more, each from the same
    level, within ``limit`` and beside no proven orbit. Readings go to the trail from ``since`` on.
    """
    z, trail = trial.z, trial.space.trail
    x, v = z[0], z[1]
    level, u = depth_level(shown, wall), command(shown, shown, wall)
    x, v = step_with_friction(x, v, u, 1.0, body.s2, body.g2, body.f2, body)
    for i in range(most):
        now = read(x, wall)
        if depth_level(now, wall) != level or not -limit < x < limit or may_be_captured(x, trial, body):
            z[0], z[1] = x, v
            return shown, i
        shown = now
        if since + i < len(trail):
            trail[since + i] = shown
        x, v = step_with_friction(x, v, u, 1.0, body.s2, body.g2, body.f2, body)
    z[0], z[1] = x, v
    return shown, most


def closes_in(trial, before, head, period, gap, body, wall):
    """Whether a trial that came back to within ``gap`` has the same readings again, and comes no less close.

    Motions with the same readings never part, so a candidate period that fails is none; this is cheaper than a proof.
    Where teeth part, or beside cogging, motions may part for a while, too, and only the readings are compared.
    ``space.trail`` of the trial has the readings of the period that led here, as far as it reaches.
    """
    z, ring, space = trial.z, trial.ring, trial.space
    n = body.order
    copy_to(space.state, z)
    copy_to(space.line, ring)
    plain = rubs_alone(ring, body, wall)
    for k in range(period):
        if body.halt[0] > 0.0:
            return False
        shown = read_after(space.state[0], before, wall)
        if k < len(space.trail) and inside(shown, wall) != inside(space.trail[k], wall):
            return False
        if plain:
            u = command(shown, before, wall)
            x, v = step_with_friction(space.state[0], space.state[1], u, 1.0, body.s2, body.g2, body.f2, body)
            space.state[0], space.state[1] = x, v
            before = shown
        else:
            before, head = advance(space.state, before, space.line, head, body, wall, space.pad)
    for j in range(n):
        space.away[j] = space.state[j] - z[j]
    return body.play > 0.0 or has_cogs(body.cogs) or gap_apart(body.cogs, space.away, body) <= gap


def downgrade(status):
    """Fate of a periodic motion by the ``status`` of a proof that has failed."""
    if status == ON_EDGE:
        return CYCLE_ON_EDGE
    if status == AT_EVENT:
        return CYCLE_AT_EVENT
    if status == PARTS:
        return CYCLE_PARTS
    return CYCLE_EXPANDS if status == EXPANDS else UNSETTLED


def fate_of(status):
    """Fate of a periodic motion by the ``status`` of its proof."""
    if status == PROVEN:
        return CYCLE_PROVEN
    return CYCLE_CONTINUUM if status == NEUTRAL else downgrade(status)


def repeats(status):
    """Whether a proof that has failed is of a motion that repeats all the same."""
    return status != WAIT and status != DIFFERENT and status != NOT_CAPTURED


def beside_orbit(trial, body):
    """How far a trial is from the orbit that the last proof was of, by `cogging.gap_apart`."""
    away = trial.space.away
    for j in range(body.order):
        away[j] = trial.z[j] - trial.space.orbit[j]
    return gap_apart(body.cogs, away, body)


def prove_repeat(trial, before, head, since, gap, body, wall):
    """Try to prove an orbit of ``since`` samples from a trial that came back within ``gap``: ``(status, margin)``."""
    if wall.analog == 0.0 and not closes_in(trial, before, head, since, gap, body, wall):
        return DIFFERENT, 0.0
    status, margin, _, _, _ = certify(trial.z, before, trial.ring, head, since, body, wall, trial.space)
    if status == NEUTRAL and body.friction > 0.0:
        return DIFFERENT, margin  # held by friction: no cycle
    return status, margin


def tolerance_after(status, gap, margin, trial, body):
    """How near a trial must come back for the next proof, after one from a ``gap`` has failed."""
    if status == NOT_CAPTURED:
        away = beside_orbit(trial, body)
        return gap * min(1.0, 0.9 * margin / away) if away > 0.0 else 0.5 * gap
    if status == DIFFERENT and gap == 0.0:
        return FIRST_TOLERANCE
    return 0.5 * gap


def end_of(trial, before, head, limit, body, wall):
    """What a sample alone says of a trial: ``(fate, row)``: it is to stop, has grown, or is on a known orbit."""
    if body.halt[0] > 0.0:
        return UNSETTLED, 0
    if has_gone(body.cogs, trial.z, limit):
        return GREW, 0
    if wall.analog == 0.0 and may_be_captured(trial.z[0], trial, body):
        row = captured(trial, before, head, body, wall)
        if row >= 0:
            return KNOWN, row
    return GOES_ON, 0


def keep_repeat(status, since, head, trial, body):
    """Keep an orbit that is not proven: ``(kept, near)``; whether a trial so near to it is not followed further."""
    space = trial.space
    copy_to(trial.keep, space.orbit)
    copy_to(trial.keep_ring, space.orbit_line)
    near = status == PARTS and beside_orbit(trial, body) < BESIDE
    return Repeat(fate_of(status), since, space.reading[0], head), near


def try_return(i, since, tries, trial, before, head, body, wall):
    """Try to prove an orbit of a trial that comes back after ``since`` samples, at sample ``i``: ``(status, tries)``.

    `WAIT` where it is not as near as it must be, or seems to be on an orbit known already.
    """
    compare_with_checkpoint(trial, body)
    gap = gap_apart(body.cogs, trial.space.away, body)
    if not gap < tries.tolerance or i < tries.wait:
        return WAIT, tries
    known = wall.analog == 0.0 and has_period(since, int(trial.counts[0]), trial.table)
    if known and gap > 0.0 and tries.left_alone < PATIENCE:
        # Probably an orbit known already, whose deepest sample will show it.
        return WAIT, Attempts(0.25 * gap, tries.left_alone + 1, tries.wait)
    status, margin = prove_repeat(trial, before, head, since, gap, body, wall)
    wait = i + PROOF_COST * since if wall.analog > 0.0 else tries.wait
    return status, Attempts(tolerance_after(status, gap, margin, trial, body), tries.left_alone, wait)


def follow_trial(trial, before, head, budget, body, wall):
    """Follow a trial until its fate is proven: ``(fate, period, before, head, samples)``.

    It has passed what its budget skips. Where it reaches an end that is known already, the fate is `KNOWN` and the
    period its row.

    Args:
        trial: `ensemble.TrialSpace`, or what has fields of these names; its state is left at the orbit's.
        before: Reading one sample before the state in ``trial.z``.
        head: Where the oldest command is in ``trial.ring``.
        budget: How long it may take.
        body: What moves.
        wall: What commands.
    """
    z, ring, space = trial.z, trial.ring, trial.space
    samples = budget.samples - budget.skip
    mark, tries, since = Checkpoint(head, 0, 0, 1), Attempts(FIRST_TOLERANCE, 0, 0), 0
    kept = Repeat(CYCLE_ON_EDGE, 0, before, head)
    run, looks = 0, no_looks()
    shown = read(z[0], wall)
    level = first_level(shown, wall)
    rubs = rubs_alone(ring, body, wall)
    i = 0
    while i < samples:
        fate, row = end_of(trial, before, head, budget.limit, body, wall)
        if fate != GOES_ON:
            return fate, row, before, head, i
        x, last, level_before = z[0], shown, level
        shown = read_after(x, before, wall)
        level, same = changes_level(shown, last, level, wall)
        if same:
            run += 1
            if run >= looks.due:
                fate, period, reading, looks = look_again(run, looks, trial, shown, before, head, body, wall)
                if fate != GOES_ON:
                    return fate, period, reading, head, i
        else:
            run, looks = 0, no_looks()
        if jitters(wall.clock):
            if wall.analog > 0.0 and i % LOOK_AGAIN == 0:
                if i > 0 and came_back(trial, head, mark.head, body):
                    return REST_NOT_PROVEN, 1, before, head, i
                mark = keep_checkpoint(trial, head, 1)
        elif level < level_before:
            if mark.begun > 0 and (wall.analog > 0.0 or same_line(ring, head, trial.check_ring, mark.head)):
                status, tries = try_return(i, since, tries, trial, before, head, body, wall)
                if status == PROVEN or status == NEUTRAL:
                    leave_at(trial, space.orbit, space.orbit_line)
                    return fate_of(status), since, space.reading[0], head, i
                if repeats(status):
                    kept, near = keep_repeat(status, since, head, trial, body)
                    if near:
                        leave_at(trial, trial.keep, trial.keep_ring)
                        return kept.fate, since, kept.before, head, i
            mark = pass_event(mark, trial, head)
            if mark.begun == mark.events:
                since, tries = 0, Attempts(FIRST_TOLERANCE, tries.left_alone, tries.wait)
        if since < len(space.trail):
            space.trail[since] = shown
        since += 1
        if rubs:
            most = min(samples - i, looks.due - run) - 1
            shown, more = rub_on(shown, most, since, budget.limit, trial, body, wall)
            before, since, run, i = shown, since + more, run + more, i + more
        elif jitters(wall.clock):
            before, head = advance_jittering(z, before, ring, head, body, wall, space.pad)
        else:
            before, head = advance(z, before, ring, head, body, wall, space.pad)
        i += 1
    if not budget.final:  # what has repeated without proof may yet be left, or proven
        return unsettled(body), 0, before, head, samples
    if kept.period > 0:
        leave_at(trial, trial.keep, trial.keep_ring)
        return kept.fate, kept.period, kept.before, kept.head, samples
    fate, period, before = last_look(trial, shown, before, head, body, wall, looks)
    return fate, period, before, head, samples
