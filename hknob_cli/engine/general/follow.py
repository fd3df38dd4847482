"""Following one trial of the general loop until its fate is proven: as `engine.follow`, with friction and the rest."""

from hknob_cli.engine.certificate import DIFFERENT, NEUTRAL, NOT_CAPTURED, ON_EDGE, PROVEN
from hknob_cli.engine.follow import (
    CYCLE_CONTINUUM,
    CYCLE_ON_EDGE,
    CYCLE_PROVEN,
    FIRST_REST_TEST,
    FIRST_TOLERANCE,
    GREW,
    LEFT,
    REST_EDGE,
    REST_PROVEN,
    UNDAMPED,
    UNSETTLED,
    same_line,
)
from hknob_cli.engine.general.body import copy_to
from hknob_cli.engine.general.captured import LOOK_AGAIN, came_back, captured, has_period, may_be_captured, turn_level
from hknob_cli.engine.general.cogging import gap_apart, has_cogs, has_gone
from hknob_cli.engine.general.controller import command, depth_level, inside, read, read_after
from hknob_cli.engine.general.inner_region import stands
from hknob_cli.engine.general.interval import advance, advance_jittering, rubs_alone
from hknob_cli.engine.general.jitter import jitters
from hknob_cli.engine.general.laws.law import REST_NOT_PROVEN
from hknob_cli.engine.general.orbit_proof import AT_EVENT, EXPANDS, PARTS, certify
from hknob_cli.engine.general.slide_two import step_with_friction
from hknob_cli.engine.general.standstill import SETTLING, is_followed, settles
from hknob_cli.engine.general.torque_curve import has_curve, place_at
from hknob_cli.engine.rest import AT_REST, LEAVES, MOVING, REST_ON_EDGE, RINGS

CYCLE_AT_EVENT = 9
CYCLE_EXPANDS = 10
CYCLE_PARTS = 15
KNOWN = 11  # reaches an orbit that another trial has proven
WAIT = -1  # a candidate left for later
BESIDE = 1e-6  # counts from a cycle through the play of teeth, at which a trial is not followed further
PATIENCE = 12  # times that one is, each at a quarter of the gap
PROOF_COST = 8  # periods that a trial with a continuous sensor goes on for after an attempt that took about as many


def rub_on(x, v, shown, most, since, limit, trial, body, wall):
    """Move a trial that `rubs_alone` on, until a sample is to be looked at: ``(x, v, reading, samples)``.

    It moves over the interval after a sample that has been looked at, and over up to ``most`` more, each from the same
    level, within ``limit`` and beside no proven orbit. Readings go to the trail from ``since`` on.
    """
    trail = trial.space.trail
    level, u = depth_level(shown, wall), command(shown, shown, wall)
    x, v = step_with_friction(x, v, u, 1.0, body.s2, body.g2, body.f2, body)
    for i in range(most):
        now = read(x, wall)
        if depth_level(now, wall) != level or not -limit < x < limit or may_be_captured(x, trial, body):
            return x, v, shown, i
        shown = now
        if since + i < len(trail):
            trail[since + i] = shown
        x, v = step_with_friction(x, v, u, 1.0, body.s2, body.g2, body.f2, body)
    return x, v, shown, most


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


def contracts_to_rest(trial, shown, before, head, body, wall):
    """Whether the loop of a continuous sensor, whose intervals are alike, is proven to bring a trial to rest.

    Then its state and delay line are left as they are there.
    """
    z, ring, space = trial.z, trial.ring, trial.space
    if not is_followed(shown, wall) or jitters(wall.clock):
        return False
    status, _, _, _, _ = certify(z, before, ring, head, 1, body, wall, space)
    if status != PROVEN:
        return False
    copy_to(z, space.orbit)
    z[1] = 0.0
    copy_to(ring, space.orbit_line)
    return True


def downgrade(status):
    """Fate of a periodic motion by the ``status`` of a proof that has failed."""
    if status == ON_EDGE:
        return CYCLE_ON_EDGE
    if status == AT_EVENT:
        return CYCLE_AT_EVENT
    if status == PARTS:
        return CYCLE_PARTS
    return CYCLE_EXPANDS if status == EXPANDS else UNSETTLED


def beside_orbit(trial, body):
    """How far a trial is from the orbit that the last proof was of, by `cogging.gap_apart`."""
    away = trial.space.away
    for j in range(body.order):
        away[j] = trial.z[j] - trial.space.orbit[j]
    return gap_apart(body.cogs, away, body)


def look_at_rest(trial, shown, before, head, body, wall):
    """What becomes of a trial that may come to rest: ``(fate, reading, settling)``; at rest it is left there.

    `UNSETTLED` if nothing is known; ``settling``: whether its reading never changes, and friction brings it to rest.
    """
    z, ring, space = trial.z, trial.ring, trial.space
    fate, _ = settles(z, shown, before, ring, body, wall, space.orbit, space.away)
    settling = fate == SETTLING
    if fate == AT_REST or (settling and stands(z, before, ring, head, body, wall, space)):
        copy_to(z, space.orbit)
        return REST_PROVEN, shown if wall.hysteresis > 0.0 else before, settling
    if fate == MOVING and contracts_to_rest(trial, shown, before, head, body, wall):
        return REST_PROVEN, z[0], settling
    if fate == LEAVES:
        return LEFT, before, settling
    if fate == RINGS:
        return UNDAMPED, before, settling
    return REST_EDGE if fate == REST_ON_EDGE else UNSETTLED, before, settling


def last_look(trial, shown, before, head, body, wall, settling, on_edge):
    """What a trial has come to that gets no more samples: ``(fate, period, reading)``; as `look_at_rest`.

    ``settling`` and ``on_edge``: of the last such look. Looks grow rare: without one more, the share at rest could fall
    when the limit is raised.
    """
    z, ring, space = trial.z, trial.ring, trial.space
    if not on_edge:
        shown = read_after(z[0], before, wall)
    fate, _ = settles(z, shown, before, ring, body, wall, space.orbit, space.away)
    if on_edge:
        if fate == REST_ON_EDGE:
            copy_to(z, space.orbit)
        return REST_EDGE, 1, before
    if settling or fate == SETTLING or fate == AT_REST:
        copy_to(z, space.orbit)
        return REST_PROVEN, 1, shown if wall.hysteresis > 0.0 else before
    if fate == MOVING and contracts_to_rest(trial, shown, before, head, body, wall):
        return REST_PROVEN, 1, z[0]
    return (UNSETTLED if body.damped else UNDAMPED), 0, before


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


def changes_level(shown, last, level, wall):
    """The level of a sample that shows ``shown``, after ``last`` and ``level``: ``(level, whether it acts alike)``."""
    now = depth_level(shown, wall)
    same = now == level if wall.analog == 0.0 else (shown < 0.0) == (last < 0.0)
    if has_curve(wall.curve):
        now = turn_level(shown, last, level)
        same = same and place_at(shown, wall.curve) == place_at(last, wall.curve)
    return now, same


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
    have, events, next_checkpoint, since = False, 0, 1, 0
    chead, tolerance = head, FIRST_TOLERANCE
    kept, kept_fate, kept_head, kept_before = 0, CYCLE_ON_EDGE, head, before
    on_edge, settling = False, False
    shown = read(z[0], wall)
    level = 0.0 if has_curve(wall.curve) else depth_level(shown, wall)
    run, next_test = 0, FIRST_REST_TEST
    left_alone, wait = 0, 0
    rubs = rubs_alone(ring, body, wall)
    i = 0
    while i < samples:
        x = z[0]
        if body.halt[0] > 0.0:
            return UNSETTLED, 0, before, head, i
        if has_gone(body.cogs, z, budget.limit):
            return GREW, 0, before, head, i
        if wall.analog == 0.0 and may_be_captured(x, trial, body):
            row = captured(trial, before, head, body, wall)
            if row >= 0:
                return KNOWN, row, before, head, i
        last = shown
        shown = read_after(x, before, wall)
        level_before = level
        level, same = changes_level(shown, last, level, wall)
        if same:
            run += 1
            if run >= next_test:
                next_test = 2 * run
                fate, reading, settles_now = look_at_rest(trial, shown, before, head, body, wall)
                settling = settling or settles_now
                on_edge = fate == REST_EDGE
                if fate == REST_PROVEN:
                    return fate, 1, reading, head, i
                if fate == LEFT or fate == UNDAMPED:
                    return fate, 0, before, head, i
        else:
            run, next_test = 0, FIRST_REST_TEST
            on_edge, settling = False, False
        if jitters(wall.clock) and wall.analog > 0.0 and i % LOOK_AGAIN == 0:
            if have and came_back(trial, head, chead, body):
                return REST_NOT_PROVEN, 1, before, head, i
            have, chead = True, head
            copy_to(trial.check, z)
            copy_to(trial.check_ring, ring)
        if level < level_before and not jitters(wall.clock):
            if have:
                for j in range(body.order):
                    space.away[j] = z[j] - trial.check[j]
                gap = gap_apart(body.cogs, space.away, body)
                if gap < tolerance and (wall.analog > 0.0 or same_line(ring, head, trial.check_ring, chead)):
                    status, margin = DIFFERENT, 0.0
                    known = wall.analog == 0.0 and has_period(since, int(trial.counts[0]), trial.table)
                    if i < wait:
                        status = WAIT
                    elif known and gap > 0.0 and left_alone < PATIENCE:
                        # Probably an orbit known already, whose deepest sample will show it.
                        status, left_alone = WAIT, left_alone + 1
                        tolerance = 0.25 * gap
                    else:
                        status, margin = prove_repeat(trial, before, head, since, gap, body, wall)
                        if wall.analog > 0.0:
                            wait = i + PROOF_COST * since
                    if status == PROVEN or status == NEUTRAL:
                        copy_to(z, space.orbit)
                        copy_to(ring, space.orbit_line)
                        fate = CYCLE_PROVEN if status == PROVEN else CYCLE_CONTINUUM
                        return fate, since, space.reading[0], head, i
                    if status == ON_EDGE or status == AT_EVENT or status == EXPANDS or status == PARTS:
                        kept, kept_head, kept_before = since, head, space.reading[0]
                        kept_fate = downgrade(status)
                        copy_to(trial.keep, space.orbit)
                        copy_to(trial.keep_ring, space.orbit_line)
                        if status == PARTS and beside_orbit(trial, body) < BESIDE:
                            copy_to(z, trial.keep)
                            copy_to(ring, trial.keep_ring)
                            return CYCLE_PARTS, since, kept_before, head, i
                    if status != WAIT:
                        tolerance = tolerance_after(status, gap, margin, trial, body)
            events += 1
            if events == next_checkpoint:
                next_checkpoint = 2 * events
                have, since = True, 0
                chead, tolerance = head, FIRST_TOLERANCE
                copy_to(trial.check, z)
                copy_to(trial.check_ring, ring)
        if since < len(space.trail):
            space.trail[since] = shown
        since += 1
        if rubs:
            most = min(samples - i, next_test - run) - 1
            z[0], z[1], shown, more = rub_on(x, z[1], shown, most, since, budget.limit, trial, body, wall)
            before, since, run, i = shown, since + more, run + more, i + more
        elif jitters(wall.clock):
            before, head = advance_jittering(z, before, ring, head, body, wall, space.pad)
        else:
            before, head = advance(z, before, ring, head, body, wall, space.pad)
        i += 1
    if not budget.final:  # what has repeated without proof may yet be left, or proven
        return (UNSETTLED if body.damped else UNDAMPED), 0, before, head, samples
    if kept > 0:
        copy_to(z, trial.keep)
        copy_to(ring, trial.keep_ring)
        return kept_fate, kept, kept_before, kept_head, samples
    fate, period, before = last_look(trial, shown, before, head, body, wall, settling, on_edge)
    return fate, period, before, head, samples
