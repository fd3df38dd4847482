"""Following one trial under a law until its fate is proven: as `general.follow`, by the law's memory as well."""

from hknob_cli.engine.certificate import DIFFERENT, NEUTRAL, NOT_CAPTURED, PROVEN
from hknob_cli.engine.follow import (
    CYCLE_CONTINUUM,
    CYCLE_ON_EDGE,
    CYCLE_PROVEN,
    FIRST_REST_TEST,
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
from hknob_cli.engine.general.follow import BESIDE, KNOWN, PATIENCE, WAIT, downgrade
from hknob_cli.engine.general.jitter import jitters
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


def follow_with_law(trial, budget, body, wall, law):
    """Follow a trial until its fate is proven: ``(fate, period, samples)``; as `general.follow.follow_trial`.

    ``trial.ring`` is what the law remembers; it and ``trial.z`` are left at the orbit's state. A motion that repeats to
    the last bit, and was not proven, is not moved through the periods before the next checkpoint, of which each is as
    the one before; they count as samples.
    """
    z, past, space, check, checkpast = trial.z, trial.ring, trial.space, trial.check, trial.check_ring
    n = body.order
    samples = budget.samples - budget.skip
    loosest = FIRST_TOLERANCE if law.provable else REPEATS * (1.0 + abs(z[0]))
    have, events, next_checkpoint, begun, since = False, 0, 1, 0, 0
    tolerance, left_alone = loosest, 0
    kept, kept_fate = 0, CYCLE_ON_EDGE
    on_edge, settling = False, False
    shown = read_after(z[0], past[law.line - 1], wall)
    run, next_test = 0, FIRST_REST_TEST
    level, x_before = 0.0, z[0]
    i = 0
    while i < samples:
        x = z[0]
        if body.halt[0] > 0.0:
            return UNSETTLED, 0, i
        if has_gone(body.cogs, z, budget.limit):
            return GREW, 0, i
        if may_be_captured(x, trial, body):
            row = captured_with_law(trial, body, law)
            if row >= 0:
                return KNOWN, row, i
        last = shown
        read_now = read_after(x, past[law.line - 1], wall)
        shown = read_now
        if law.watch.damping == 0.0:
            shown = depth_level(shown, wall)
        falls = shown < last
        if has_curve(wall.curve):
            shown = 2.0 * place_at(x, wall.curve) + (1.0 if x < 0.0 else 0.0)
            level_before, level = level, turn_level(x, x_before, level)
            falls, x_before = level < level_before, x
        if shown == last:
            run += 1
            if run >= next_test:
                next_test = 2 * run
                fate, settles_now = look_at_rest_with_law(trial, read_now, body, wall, law)
                settling = settling or settles_now
                on_edge = fate == REST_EDGE
                if fate == REST_PROVEN:
                    return fate, 1, i
                if fate == UNDAMPED:
                    return fate, 0, i
        else:
            run, next_test = 0, FIRST_REST_TEST
            on_edge, settling = False, False
        again = (law.senses or not law.provable) and run % LOOK_AGAIN == LOOK_AGAIN - 1
        if jitters(wall.clock):
            if again:
                for j in range(n):
                    space.away[j] = z[j] - check[j]
                if have and came_back(space.away, past, checkpast, CLOSE * (1.0 + abs(x)), body, law):
                    return REST_NOT_PROVEN, 1, i
                have = True
                copy_to(check, z)
                copy_to(checkpast, past)
        elif falls or again:
            # What is not proven to rest by its readings may still come to a standstill within one count.
            if have:
                for j in range(n):
                    space.away[j] = z[j] - check[j]
                gap = unlike(space.away, x, past, checkpast, body, law)
                if gap < tolerance:
                    status, margin = DIFFERENT, 0.0
                    waits = law.provable and not law.senses and gap > 0.0 and left_alone < PATIENCE
                    if waits and has_period(since, int(trial.counts[0]), trial.table):
                        status, left_alone = WAIT, left_alone + 1
                        tolerance = 0.25 * gap
                    else:
                        status, margin = prove_repeat_with_law(trial, since, body, wall, law)
                    if status == PROVEN or status == NEUTRAL:
                        copy_to(z, space.orbit)
                        copy_to(past, law.periodic)
                        return fate_of(status, law), since, i
                    if status != WAIT and status != DIFFERENT and status != NOT_CAPTURED:
                        kept, kept_fate = since, fate_of(status, law)
                        if keep_repeat(trial, status, gap, body, wall, law):
                            copy_to(z, trial.keep)
                            copy_to(past, trial.keep_ring)
                            return kept_fate, since, i
                    if status != WAIT:
                        tolerance = tolerance_with_law(status, gap, margin, loosest, trial, body, law)
                    steady = law.provable and not law.senses and tolerance == 0.0
                    if steady and same_to_the_bit(z, past, check, checkpast):
                        gone = events + 1 - begun
                        passed = periods_passed(samples - 1 - i, since, next_checkpoint - events - 1, gone)
                        i += passed * since
                        events += passed * gone
            events += 1
            if events == next_checkpoint:
                next_checkpoint, begun = 2 * events, events
                have, since, tolerance = True, 0, loosest
                copy_to(check, z)
                copy_to(checkpast, past)
        since += 1
        if jitters(wall.clock):
            advance_jittering_with_law(z, past, body, wall, law, space.pad)
        else:
            advance_with_law(z, past, body, wall, law, space.pad)
        i += 1
    if not budget.final:  # what has repeated without proof may yet be left, or proven
        return (UNSETTLED if body.damped else UNDAMPED), 0, samples
    if kept > 0:
        copy_to(z, trial.keep)
        copy_to(past, trial.keep_ring)
        return kept_fate, kept, samples
    if on_edge:
        return REST_EDGE, 1, samples
    if settling:
        return REST_PROVEN, 1, samples
    return (UNSETTLED if body.damped else UNDAMPED), 0, samples
