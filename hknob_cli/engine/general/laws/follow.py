"""Following one trial under a law until its fate is proven: as `general.follow`, by the law's memory as well."""

from hknob_cli.engine.certificate import DIFFERENT, NEUTRAL, NOT_CAPTURED, PROVEN
from hknob_cli.engine.follow import (
    CYCLE_CONTINUUM,
    CYCLE_ON_EDGE,
    CYCLE_PROVEN,
    FIRST_TOLERANCE,
    GREW,
    REST_EDGE,
    REST_PROVEN,
    UNDAMPED,
    UNSETTLED,
)
from hknob_cli.engine.general.body import copy_to
from hknob_cli.engine.general.captured import CLOSE, FIELDS, LOOK_AGAIN, has_period, may_be_captured, turn_level
from hknob_cli.engine.general.cogging import gap_apart, has_gone
from hknob_cli.engine.general.controller import depth_level, read_after
from hknob_cli.engine.general.follow import BESIDE, KNOWN, PATIENCE, WAIT, downgrade, repeats
from hknob_cli.engine.general.interval import jitters
from hknob_cli.engine.general.laws.cascade import (
    apart,
    faded,
    nearly_same,
    pushed_apart,
    same_count,
    sums_agree,
    torques_apart,
)
from hknob_cli.engine.general.laws.law import AT_SWITCH, CYCLE_AT_SWITCH, REST_NOT_PROVEN
from hknob_cli.engine.general.laws.period import REPEATS, certify_with_law
from hknob_cli.engine.general.laws.rest import settles_with_law
from hknob_cli.engine.general.laws.step import advance_jittering_with_law, advance_with_law
from hknob_cli.engine.general.looks import (
    GOES_ON,
    Attempts,
    Checkpoint,
    compare_with_checkpoint,
    go_on,
    keep_checkpoint,
    leave_at,
    no_looks,
    pass_event,
    unsettled,
)
from hknob_cli.engine.general.orbit_proof import EXPANDS, PARTS
from hknob_cli.engine.general.standstill import SETTLING
from hknob_cli.engine.general.torque_curve import has_curve, place_at
from hknob_cli.engine.rest import AT_REST, REST_ON_EDGE, RINGS


def fate_of(status, law):
    """Fate of a periodic motion by the ``status`` of its proof."""
    if status == PROVEN or status == NOT_CAPTURED:
        return CYCLE_PROVEN
    if status == NEUTRAL:
        return CYCLE_CONTINUUM
    if status == AT_SWITCH:
        return CYCLE_AT_SWITCH
    if status == EXPANDS and not law.provable:
        return law.unproven
    return downgrade(status)


def captured_with_law(trial, body, law):
    """Row of the proven orbit so close, at its deepest sample, to a trial that it is followed for ever; -1 if none.

    The last number of a row is not a reading here, but by how much the orbit's guards clear all errors, or by how much
    a sum that drifts may rise.
    """
    z, past, away = trial.z, trial.ring, trial.space.away
    table, states, pasts = trial.table, trial.states, trial.lines
    n, length = body.order, len(past)
    if law.senses:
        return -1  # the torques of a motion beside the orbit are others: each trial has its own proof
    for row in range(int(trial.counts[0])):
        base = row * FIELDS
        margin = table[base + 2] - table[base + 5]
        if table[base] != CYCLE_PROVEN or abs(z[0] - states[row * n]) >= margin:
            continue
        for j in range(length):
            law.beside[j] = pasts[row * length + j]
        if not same_count(past, law.beside, law) or not sums_agree(past, law.beside, table[base + 9], law):
            continue
        if law.guarded and not faded(past, law.beside, law) < table[base + 9]:
            continue
        for j in range(n):
            away[j] = z[j] - states[row * n + j]
        if apart(away, states[row * n], past, law.beside, body, law) < margin:
            return row
    return -1


def unlike(dz, x, past, other, body, law):
    """How far a trial is from where it was; beyond any tolerance where what is counted differs."""
    if not law.provable:
        return gap_apart(body.cogs, dz, body) if nearly_same(past, other, law, REPEATS) else float("inf")
    if not same_count(past, other, law):
        return float("inf")
    return gap_apart(body.cogs, dz, body) + pushed_apart(torques_apart(past, other, law), x, body)


def came_back(dz, past, other, within, body, law):
    """Whether a motion is where it was 64 samples before, by its difference ``dz``: it has come to a standstill."""
    return gap_apart(body.cogs, dz, body) <= within and nearly_same(past, other, law, REPEATS)


def look_at_rest_with_law(trial, shown, body, wall, law):
    """What becomes of a trial that may come to rest: ``(fate, settling)``; as `general.follow.look_at_rest`."""
    z, past, space = trial.z, trial.ring, trial.space
    fate = settles_with_law(z, shown, past, body, wall, law, space.orbit, space.away)
    if fate == SETTLING:
        copy_to(space.state, z)
        copy_to(law.beside, past)
        advance_with_law(space.state, law.beside, body, wall, law, space.pad)
        for j in range(body.order):
            if space.state[j] != z[j]:
                return UNSETTLED, True
        return REST_PROVEN, True
    if fate == AT_REST:
        copy_to(z, space.orbit)
        return REST_PROVEN, False
    if fate == RINGS:
        return UNDAMPED, False
    return REST_EDGE if fate == REST_ON_EDGE else UNSETTLED, False


def same_to_the_bit(z, past, check, checkpast):
    """Whether a motion is where it was, and all that is remembered as well, so that it repeats for ever."""
    for j in range(len(z)):
        if z[j] != check[j]:
            return False
    for j in range(len(past)):
        if past[j] != checkpast[j]:
            return False
    return True


def periods_passed(left, period, ahead, events):
    """Whole periods in which nothing new is seen: within ``left`` samples, ``ahead`` events before a checkpoint."""
    return max(0, min(left // period, (ahead - 1) // events))


def prove_repeat_with_law(trial, since, body, wall, law):
    """Try to prove an orbit of ``since`` samples from a trial that came back: ``(status, margin)``."""
    status, margin, _, _, _ = certify_with_law(trial.z, trial.ring, since, body, wall, law, trial.space)
    if status == NEUTRAL and body.friction > 0.0:
        return DIFFERENT, margin
    return status, margin


def tolerance_with_law(status, gap, margin, loosest, trial, body, law):
    """How near a trial must come back for the next proof, after one from a ``gap`` has failed."""
    space = trial.space
    if status == NOT_CAPTURED and not law.senses:
        for j in range(body.order):
            space.away[j] = trial.z[j] - space.orbit[j]
        away = apart(space.away, space.orbit[0], trial.ring, law.periodic, body, law)
        return gap * min(1.0, 0.9 * margin / away) if away > 0.0 else 0.5 * gap
    if status == DIFFERENT and gap == 0.0:
        return loosest
    return 0.5 * gap


def keep_repeat(trial, status, gap, body, wall, law):
    """Keep an orbit that is not proven; whether a trial so near to it is not followed further."""
    space, x = trial.space, trial.z[0]
    copy_to(trial.keep, space.orbit)
    copy_to(trial.keep_ring, law.periodic)
    for j in range(body.order):
        space.away[j] = trial.z[j] - trial.keep[j]
    if status == PARTS and unlike(space.away, x, trial.ring, trial.keep_ring, body, law) < BESIDE:
        return True
    return not law.provable and (wall.analog == 0.0 or gap <= CLOSE * (1.0 + abs(x)))


def end_with_law(trial, limit, body, law):
    """What a sample alone says of a trial: ``(fate, row)``: it is to stop, has grown, or is on a known orbit."""
    if body.halt[0] > 0.0:
        return UNSETTLED, 0
    if has_gone(body.cogs, trial.z, limit):
        return GREW, 0
    if may_be_captured(trial.z[0], trial, body):
        row = captured_with_law(trial, body, law)
        if row >= 0:
            return KNOWN, row
    return GOES_ON, 0


def acts_as(x, reading, wall, law):
    """A number that samples have in common to which the law acts alike: reading, level, or place on a curve."""
    if has_curve(wall.curve):
        return 2.0 * place_at(x, wall.curve) + (1.0 if x < 0.0 else 0.0)
    return depth_level(reading, wall) if law.watch.damping == 0.0 else reading


def look_again_with_law(run, looks, trial, reading, body, wall, law):
    """Look at rest after ``run`` samples that act alike: ``(fate, period, looks)``."""
    fate, settling = look_at_rest_with_law(trial, reading, body, wall, law)
    return go_on(run, looks, fate, settling)


def try_return(since, tries, loosest, trial, body, wall, law):
    """Try to prove an orbit of a trial that comes back after ``since`` samples: ``(status, gap, tries)``.

    `WAIT` where it is not as near as it must be, or seems to be on an orbit known already. ``gap``: how near it is.
    """
    compare_with_checkpoint(trial, body)
    gap = unlike(trial.space.away, trial.z[0], trial.ring, trial.check_ring, body, law)
    if not gap < tries.tolerance:
        return WAIT, gap, tries
    waits = law.provable and not law.senses and gap > 0.0 and tries.left_alone < PATIENCE
    if waits and has_period(since, int(trial.counts[0]), trial.table):
        return WAIT, gap, Attempts(0.25 * gap, tries.left_alone + 1, tries.wait)
    status, margin = prove_repeat_with_law(trial, since, body, wall, law)
    tolerance = tolerance_with_law(status, gap, margin, loosest, trial, body, law)
    return status, gap, Attempts(tolerance, tries.left_alone, tries.wait)


def pass_periods(mark, since, left, tries, trial, law):
    """Pass the periods of a motion that is where it was, to the last bit: ``(mark, samples)``, within ``left``."""
    steady = law.provable and not law.senses and tries.tolerance == 0.0
    if not (steady and same_to_the_bit(trial.z, trial.ring, trial.check, trial.check_ring)):
        return mark, 0
    gone = mark.events + 1 - mark.begun
    passed = periods_passed(left, since, mark.due - mark.events - 1, gone)
    return Checkpoint(mark.head, mark.begun, mark.events + passed * gone, mark.due), passed * since


def end_of_samples(kept, kept_fate, looks, final, trial, body):
    """What a trial has come to that gets no more samples: ``(fate, period)``; ``kept``: period of what repeated."""
    if final and kept > 0:
        leave_at(trial, trial.keep, trial.keep_ring)
        return kept_fate, kept
    if final and (looks.on_edge or looks.settling):
        return (REST_EDGE if looks.on_edge else REST_PROVEN), 1
    return unsettled(body), 0  # what has repeated without proof may yet be left, or proven


def follow_with_law(trial, budget, body, wall, law):
    """Follow a trial until its fate is proven: ``(fate, period, samples)``; as `general.follow.follow_trial`.

    ``trial.ring`` is what the law remembers; it and ``trial.z`` are left at the orbit's state. A motion that repeats to
    the last bit, and was not proven, is not moved through the periods before the next checkpoint, of which each is as
    the one before; they count as samples.
    """
    z, past, space = trial.z, trial.ring, trial.space
    samples = budget.samples - budget.skip
    loosest = FIRST_TOLERANCE if law.provable else REPEATS * (1.0 + abs(z[0]))
    mark, tries, since = Checkpoint(0, 0, 0, 1), Attempts(loosest, 0, 0), 0
    kept, kept_fate = 0, CYCLE_ON_EDGE
    run, looks = 0, no_looks()
    x, acts = z[0], read_after(z[0], past[law.line - 1], wall)
    level = 0.0 if has_curve(wall.curve) else acts
    i = 0
    while i < samples:
        fate, row = end_with_law(trial, budget.limit, body, law)
        if fate != GOES_ON:
            return fate, row, i
        x_before, x, acted, level_before = x, z[0], acts, level
        reading = read_after(x, past[law.line - 1], wall)
        acts = acts_as(x, reading, wall, law)
        level = turn_level(x, x_before, level) if has_curve(wall.curve) else acts
        if acts == acted:
            run += 1
            if run >= looks.due:
                fate, period, looks = look_again_with_law(run, looks, trial, reading, body, wall, law)
                if fate != GOES_ON:
                    return fate, period, i
        else:
            run, looks = 0, no_looks()
        again = (law.senses or not law.provable) and run % LOOK_AGAIN == LOOK_AGAIN - 1
        if jitters(wall.clock):
            if again:
                compare_with_checkpoint(trial, body)
                within = CLOSE * (1.0 + abs(x))
                if mark.begun > 0 and came_back(space.away, past, trial.check_ring, within, body, law):
                    return REST_NOT_PROVEN, 1, i
                mark = keep_checkpoint(trial, 0, 1)
        elif level < level_before or again:
            # What is not proven to rest by its readings may still come to a standstill within one count.
            if mark.begun > 0:
                status, gap, tries = try_return(since, tries, loosest, trial, body, wall, law)
                if status == PROVEN or status == NEUTRAL:
                    leave_at(trial, space.orbit, law.periodic)
                    return fate_of(status, law), since, i
                if repeats(status):
                    kept, kept_fate = since, fate_of(status, law)
                    if keep_repeat(trial, status, gap, body, wall, law):
                        leave_at(trial, trial.keep, trial.keep_ring)
                        return kept_fate, since, i
                if status != WAIT:
                    mark, passed = pass_periods(mark, since, samples - 1 - i, tries, trial, law)
                    i += passed
            mark = pass_event(mark, trial, 0)
            if mark.begun == mark.events:
                since, tries = 0, Attempts(loosest, tries.left_alone, tries.wait)
        since += 1
        if jitters(wall.clock):
            advance_jittering_with_law(z, past, body, wall, law, space.pad)
        else:
            advance_with_law(z, past, body, wall, law, space.pad)
        i += 1
    fate, period = end_of_samples(kept, kept_fate, looks, budget.final, trial, body)
    return fate, period, samples
