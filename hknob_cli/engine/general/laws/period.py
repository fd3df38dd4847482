"""Proof of a limit cycle under a law: the periodic memory of its readings, and the plant's periodic motion under it.

What fades goes to its fixed point, over a period an affine map whose slope is known; all else that is
remembered must come back to the last bit. The plant's fixed point is found as in `general.period_map`, with the
torques of that memory. What the torques may be wrong by enters the bound on the orbit's error.
"""

from math import sqrt

from hknob_cli.engine.certificate import DIFFERENT, EPSILON, NEUTRAL, NOT_CAPTURED, ON_EDGE, PROVEN
from hknob_cli.engine.general.body import copy_to
from hknob_cli.engine.general.cogging import SIZE, cog_number, hold_stiffness, reach_on
from hknob_cli.engine.general.columns import begin_columns, begin_marks
from hknob_cli.engine.general.controller import count_gap, edge_gap, read_after, table_size
from hknob_cli.engine.general.corners import NEAREST, end_sample, goes_over, join_parts, room_over_corners
from hknob_cli.engine.general.laws.cascade import (
    apart,
    faded,
    nearly_same,
    same_count,
    settle_faded,
    size_faded,
    sums_agree,
)
from hknob_cli.engine.general.laws.law import AT_SWITCH, LOOK, PIECE, ROUNDINGS
from hknob_cli.engine.general.laws.sensed import certify_sensed, move_piece_columns
from hknob_cli.engine.general.laws.step import FREE, advance_with_law, count_piece, decide
from hknob_cli.engine.general.orbit_proof import (
    AT_EVENT,
    EXPANDS,
    PARTS,
    bound_error,
    margin_of_parts,
    meets_event,
    scale_of,
)
from hknob_cli.engine.general.period_map import NEWTON_STEPS, closure_of
from hknob_cli.engine.general.powers import dissipates, invert

REPEATS = 1e-8  # counts, relative: by which what cannot be proven must come back
SURE = 1e-9  # of a sum: far more than the roundings of all samples that are ever taken


def turn_with_law(past, period, body, wall, law, space, m):
    """Run the orbit in ``space`` over a period with its derivative, and ``past`` with it.

    Returns ``(margin, edge, reach, pace, guard, strength, anchored)``: the first four as `period_map.turn` does, the
    least guard, the largest torque, and whether the law's memory has begun anew.
    """
    n, width = body.order, space.width
    begin_columns(space, m)
    for c in range(m):
        space.cols[width * width + c] = 0.0  # torques do not depend on where the plant is, between edges
    for i in range(n):
        space.state[i] = space.orbit[i]
    begin_marks(space.marks)
    margin, edge, guard = float("inf"), float("inf"), FREE
    reach, pace, strength = cog_number(body.cogs, SIZE), 0.0, 0.0
    anchored = law.anchor < 0
    newest = law.line + (law.ages - 1) * law.parts
    for k in range(period):
        x = space.state[0]
        before = past[law.line - 1]
        shown = read_after(x, before, wall)
        margin = min(margin, edge_gap(x, shown, before, law.watch))
        edge = min(edge, count_gap(x, wall))
        reach = max(reach, abs(x))
        pace = max(pace, abs(space.state[1]))
        guard = min(guard, decide(shown, space.state[1], past, wall, law))
        if wall.hysteresis > 0.0:
            past[law.line - 1] = shown
        for i in range(law.parts):
            strength = max(strength, abs(past[newest + i]) + table_size(shown, wall))
        if law.anchor >= 0 and past[law.anchor] > 0.0:
            anchored = True
        for piece in range(law.pieces):
            at = piece * PIECE
            if wall.hysteresis > 0.0:
                for i in range(n):
                    space.away[i] = space.state[i]
                margin = min(margin, count_piece(space.away, past, piece, body, law.watch, law, space.pad))
            move_piece_columns(past, at, body, law, space, m)
            look = int(law.sched[at + LOOK])
            if look >= 0:
                before = past[law.line - 1]
                past[look] = read_after(space.state[0], before, wall)
                margin = min(margin, edge_gap(space.state[0], past[look], before, law.watch))
        end_sample(k, period, body, space, m)
        pace = max(pace, abs(space.state[0] - x))
    join_parts(body, space, m)
    return margin, edge, reach, pace, guard, strength, anchored


def find_periodic_past(z, past, period, body, wall, law, space):
    """Leave in ``law.periodic`` what is remembered at the start of a period of the readings that ``z`` gets.

    False where more than what fades is not as it was. The torques under way are those of the periods before.
    """
    copy_to(space.state, z)
    copy_to(law.periodic, past)
    for _ in range(period):
        advance_with_law(space.state, law.periodic, body, wall, law, space.pad)
    if not same_count(law.periodic, past, law):
        return False
    settle_faded(law.periodic, past, period, law)
    # Where all that is remembered is counted, and no torque is under way, another period is this one again.
    done = period if law.fading < 0 and law.drifts < 0 and law.ages == 1 else 0
    while done < law.ages:
        copy_to(space.state, z)
        for _ in range(period):
            advance_with_law(space.state, law.periodic, body, wall, law, space.pad)
        if not same_count(law.periodic, past, law):
            return False
        done += period
    return True


def drift_of(guard, strength, pace, period, law):
    """Whether a sum that did not begin anew decides nothing for ever, and by how much it may rise until it does.

    ``guard``: by how much it may rise in the period that has ended in ``law.beside``. It must fall from period to
    period. The torques are the same as long as it decides nothing, and rounding does not change the order of two sums.
    """
    if law.drifts < 0:
        return False, -float("inf")
    before, after = law.periodic[law.drifts], law.beside[law.drifts]
    size = 1.0 + abs(before) + abs(after) + strength / law.unit * pace
    spare = guard - SURE * size
    return before - after > ROUNDINGS * EPSILON * period * size and spare > 0.0, spare


def certify_repeat(z, past, period, body, wall, law, space):
    """What `certify_with_law` says of a law that cannot be proven: whether the trial comes back, to eight digits."""
    copy_to(space.orbit, z)
    copy_to(law.beside, past)
    margin, edge, reach, pace, _, _, _ = turn_with_law(law.beside, period, body, wall, law, space, body.order)
    closure = 0.0
    for i in range(body.order):
        closure = max(closure, abs(space.state[i] - z[i]))
    copy_to(law.periodic, past)
    if closure <= REPEATS * (reach + pace) and nearly_same(law.beside, past, law, REPEATS):
        return EXPANDS, margin, edge, closure, closure
    return DIFFERENT, 0.0, 0.0, 0.0, 0.0


def is_late(past, law):
    """By how much torques under way are not those of a period before."""
    late = 0.0
    for j in range(law.line + law.parts, law.line + law.ages * law.parts):
        late = max(late, abs(past[j] - law.periodic[j]))
    return late


def find_orbit_with_law(period, body, wall, law, space):
    """Find the plant's fixed point under the periodic memory, near the state in ``space.orbit``, by Newton's method.

    Returns ``(same, solved, closure, missed, late, turned)``: whether all that is counted comes back; whether the
    derivative could be inverted; by what the number that fades, and torques under way, do not come back;
    ``turned``: as `turn_with_law` has it.
    """
    n, best = body.order, float("inf")
    turned, solved = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, True), True
    closure, missed, late = 0.0, 0.0, 0.0
    for step in range(NEWTON_STEPS):
        copy_to(law.beside, law.periodic)
        turned = turn_with_law(law.beside, period, body, wall, law, space, n)
        if not same_count(law.beside, law.periodic, law):
            return False, solved, closure, missed, late, turned
        missed, late = faded(law.beside, law.periodic, law), is_late(law.beside, law)
        for i in range(n):
            space.residual[i] = space.state[i] - space.orbit[i]
        closure = closure_of(space, n)
        solved = invert(space.matrix, space.cols, n, space.width)
        reach, pace = turned[2], turned[3]
        small = closure <= 4.0 * EPSILON * (reach + pace)
        if not solved or small or closure >= 0.5 * best or step == NEWTON_STEPS - 1:
            break
        best = min(best, closure)
        for i in range(n):
            for j in range(n):
                space.orbit[i] += space.matrix[i * 2 * n + n + j] * space.residual[j]
        settle_faded(law.beside, law.periodic, period, law)
        copy_to(law.periodic, law.beside)
    return True, solved, closure, missed, late, turned


def wrong_torque(missed, late, turned, period, law):
    """How wrong the number that fades may be, and how wrong a torque: ``(worn, wrong)``.

    By what does not come back (``missed``, ``late``) and by the rounding of each update.
    """
    _, _, reach, pace, _, strength, anchored = turned
    worn = 0.0
    if law.fading >= 0:
        size, swell = size_faded(law.periodic, law)
        scale = (size + strength / law.unit + reach) * swell
        worn = missed / (1.0 - law.fade**period) + ROUNDINGS * EPSILON * scale / (1.0 - law.fade)
    size = law.coarse * (strength + law.unit * (1.0 + reach))  # of the terms of a torque, which may cancel
    wrong = law.weight * worn + late + ROUNDINGS * EPSILON * size
    if law.anchor >= 0 and anchored:
        wrong += ROUNDINGS * EPSILON * size * period * period * (1.0 + pace)  # a sum since it began anew
    return worn, wrong


def is_captured(z, past, margin, bound, body, law, space):
    """Whether a trial is followed for ever by the orbit in ``space.orbit``, which is known to within ``bound``."""
    for i in range(body.order):
        space.residual[i] = z[i] - space.orbit[i]
    if not apart(space.residual, space.orbit[0], past, law.periodic, body, law) + bound < margin:
        return False
    if not sums_agree(past, law.periodic, law.room[0], law):
        return False
    return not law.guarded or faded(past, law.periodic, law) < law.room[0]


def certify_with_law(z, past, period, body, wall, law, space):
    """Try to prove an orbit of ``period`` samples from a trial at ``z`` whose readings seem to repeat.

    Returns ``(status, margin, edge, closure, bound)`` as `engine.certificate.certify` does. The orbit's state at this
    sample is left in ``space.orbit``, what is remembered there in ``law.periodic``.
    """
    n = body.order
    if not law.provable:
        return certify_repeat(z, past, period, body, wall, law, space)
    if law.senses:
        return certify_sensed(z, past, period, body, wall, law, space)
    if not find_periodic_past(z, past, period, body, wall, law, space):
        return DIFFERENT, 0.0, 0.0, 0.0, 0.0
    copy_to(space.orbit, z)
    same, solved, closure, missed, late, turned = find_orbit_with_law(period, body, wall, law, space)
    margin, edge, reach, pace, guard, strength, anchored = turned
    if not same or not closure < 1e-6 * (reach + pace):
        return DIFFERENT, 0.0, 0.0, 0.0, 0.0
    if not solved:
        return NEUTRAL, margin, edge, closure, 0.0
    settled, spare = drift_of(guard, strength, pace, period, law) if not anchored else (True, -float("inf"))
    if anchored and not sums_agree(law.beside, law.periodic, spare, law):
        return DIFFERENT, 0.0, 0.0, 0.0, 0.0
    worn, wrong = wrong_torque(missed, late, turned, period, law)
    # A torque that is wrong all along moves a speed by so much at most, by energy, and a position by that over a way.
    drift = wrong * period * (1.0 + sqrt(body.ratio))
    reached = reach_on(body.cogs, space.orbit[0], body)
    shift = drift * max(1.0, min(float(period), reached))
    rounding = 8.0 * EPSILON * period * law.pieces
    fast, slow = rounding * (reach + pace) + shift, rounding * 2.0 * pace + drift
    far, spread = bound_error(fast, slow, body, space, n)
    holds = hold_stiffness(body.cogs, space.orbit[0], body) > 0.0
    bound = space.away[0]
    if holds:  # at every sample; no end where nothing holds it
        bound = far + reached * wrong * period
    if body.friction > 0.0 and meets_event(spread, wrong, period, body, space):
        return AT_EVENT, margin, edge, closure, bound
    parts, margin = margin_of_parts(margin, bound, holds, body, space)
    if not margin > bound:
        return ON_EDGE, margin, edge, closure, bound
    law.room[0] = guard - worn if law.drifts < 0 else spare
    if law.guarded and not guard > worn:
        return AT_SWITCH, margin, edge, closure, bound
    scale = scale_of(reach, pace)
    if not settled or not dissipates(space.cols, space.width, space.power, space.spare, n, scale, period):
        return (DIFFERENT if parts and settled else EXPANDS), margin, edge, closure, bound
    if parts:
        if not goes_over(body):
            return PARTS, margin, edge, closure, bound
        room, off, grown = room_over_corners(fast, slow, margin, 1.0, period, body, space, scale)
        if not room > NEAREST * (reach + pace):
            return PARTS, margin, edge, closure, bound
        margin, bound = room / grown + off, off  # torques under way may push a motion, too
    captured = is_captured(z, past, margin, bound, body, law, space)
    return (PROVEN if captured else NOT_CAPTURED), margin, edge, closure, bound
