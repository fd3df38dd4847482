"""Nearby motions under a law: the proof of a limit cycle under one that senses the velocity, and how fast they part.

Without friction, and while no reading and no guard of the law changes, an interval is an affine map of the plant's
state and the torques under way, and so is a period: its derivative M is carried along with the slopes of the torques.
Newton's method finds the fixed point. What rounding adds in an interval goes through all later ones of the period; a
bound on that is carried along as well, block by block, and summed at some samples of a block, from which those after
them go on. The powers of M, or an ellipse that M shrinks, say how far a trial's difference from the orbit can ever get
at the start of a period, and the derivative up to a sample what that means there. Where no sample comes to an edge, nor
the speed to where the law acts otherwise, the trial stays for ever.

Rest is a period of one sample.

Nearby motions have the same readings, so that a law's torques do not tell them apart, unless it senses the velocity.
What fades of its memory decays by itself.
"""

from math import log

from hknob_cli.engine.certificate import DIFFERENT, EPSILON, NEUTRAL, NOT_CAPTURED, ON_EDGE, PROVEN
from hknob_cli.engine.general.advance import rub_columns
from hknob_cli.engine.general.body import copy_to
from hknob_cli.engine.general.columns import Columns, begin_columns
from hknob_cli.engine.general.controller import count_gap, edge_gap, read, read_after, table_size
from hknob_cli.engine.general.laws.cascade import same_count
from hknob_cli.engine.general.laws.law import AT_SWITCH, BLOCK, LOOK, PIECE, ROUNDINGS, SPAN, STOP, TORQUE, F, G, S
from hknob_cli.engine.general.laws.step import count_piece, decide
from hknob_cli.engine.general.orbit_proof import EXPANDS, scale_of
from hknob_cli.engine.general.period_map import NEWTON_STEPS, closure_of, normalise
from hknob_cli.engine.general.powers import bound_growth, dissipates, invert


def move_piece_columns(past, at, body, law, space, count):
    """Move the motion in ``space`` and ``count`` columns over the piece whose numbers begin at ``at``."""
    u, span = past[int(law.sched[at + TORQUE])], law.sched[at + SPAN]
    sgf = (law.sched[at + S], law.sched[at + G], law.sched[at + F])
    columns = Columns(space.cols, space.width * space.width, count, space.width)
    rub_columns(space.state, u, span, sgf, body, space.pad, columns, space.marks)


def move_columns(past, body, law, space, count):
    """Move the motion in ``space`` and its columns over an interval whose torques are decided.

    A column has the state, then the torques, the oldest first; at a sample the oldest no longer counts.
    """
    n, width = body.order, space.width
    for piece in range(law.pieces):
        at = piece * PIECE
        torque = int(law.sched[at + TORQUE])
        for c in range(count):
            space.cols[width * width + c] = space.cols[c * width + n + torque - law.line]
        move_piece_columns(past, at, body, law, space, count)
    for c in range(count):
        for j in range(law.ages - 1):
            space.cols[c * width + n + j] = space.cols[c * width + n + j + 1]


def sense(past, wall, law, space, m):
    """Sense and decide at a sample: ``(margin, edge, guard, slope)``; the torque's slope is put into the columns."""
    x = space.state[0]
    shown = read(x, wall)
    guard = decide(shown, space.state[1], past, wall, law)
    slope = law.out[law.parts]
    for c in range(m):
        space.cols[c * space.width + m] = slope * space.cols[c * space.width + 1]
    return edge_gap(x, shown, shown, law.watch), count_gap(x, wall), guard, slope


def turn_sensed(past, period, body, wall, law, space, m):
    """Run the orbit in ``space`` over a period with its derivative: ``(margin, edge, reach, pace, strength)``."""
    begin_columns(space, m)
    copy_to(space.state, space.orbit)
    margin, edge, reach, pace, strength = float("inf"), float("inf"), 0.0, 0.0, 0.0
    for _ in range(period):
        x = space.state[0]
        reach, pace = max(reach, abs(x)), max(pace, abs(space.state[1]))
        gap, beside, _, _ = sense(past, wall, law, space, m)
        margin, edge = min(margin, gap), min(edge, beside)
        strength = max(strength, abs(past[law.line + law.ages - 1]) + table_size(read(x, wall), wall))
        move_columns(past, body, law, space, m)
        pace = max(pace, abs(space.state[0] - x))
    return margin, edge, reach, pace, strength


def chart_interval(past, body, law, space, m):
    """Leave in ``law.affine`` the map of an interval whose torque has no slope, and what a torque of 1 adds to it.

    Column c is at ``c * m``; the last one, of the torque, at ``m * m``.
    """
    begin_columns(space, m + 1)
    copy_to(space.state, space.orbit)
    move_columns(past, body, law, space, m + 1)
    for c in range(m + 1):
        for i in range(m):
            law.affine[c * m + i] = space.cols[c * space.width + i]


def carried(entry, begin, start, count, law, m, row):
    """Bound on what rounding has come to in ``entry`` of the state, ``count`` intervals into a block.

    ``law.noise`` has what an interval adds (m), and, from ``start`` on, what there was ``begin`` intervals into the
    block (m). ``row`` is work space.
    """
    for c in range(m):
        row[c] = 1.0 if c == entry else 0.0
    total = 0.0
    for j in range(count - 1, begin - 1, -1):
        pushed = 0.0
        for i in range(m):
            total += abs(row[i]) * law.noise[i]
            pushed += row[i] * law.affine[m * m + i]
        for c in range(m):
            entry_c = law.slopes[j] * pushed if c == 1 else 0.0
            for i in range(m):
                entry_c += row[i] * law.affine[c * m + i]
            row[m + c] = entry_c
        for c in range(m):
            row[c] = row[m + c]
    for c in range(m):
        total += abs(row[c]) * law.noise[start + c]
    return total


def sum_block(start, count, law, m, row):
    """Leave in ``law.noise``, from ``start`` on, what rounding has come to ``count`` intervals into a block."""
    for i in range(m):
        law.noise[2 * m + i] = carried(i, 0, m, count, law, m, row)
    for i in range(m):
        law.noise[start + i] = law.noise[2 * m + i]


def begin_period(space, law, m):
    """Put the orbit, the columns and what rounding has come to at the start of a period."""
    begin_columns(space, m)
    copy_to(space.state, space.orbit)
    for i in range(m):
        law.noise[m + i] = 0.0


def chart_rounding(past, period, body, wall, law, space, m):
    """Leave in ``law.noise`` what rounding has come to at the end of a period, and its derivative in the columns."""
    begin_period(space, law, m)
    count = 0
    for _ in range(period):
        _, _, _, law.slopes[count] = sense(past, wall, law, space, m)
        count += 1
        move_columns(past, body, law, space, m)
        if count == BLOCK:
            sum_block(m, count, law, m, space.spare)
            count = 0
    sum_block(m, count, law, m, space.spare)


def within(past, period, body, wall, law, space, m):
    """Whether readings and guards of a period stay: ``(edges, guards, near, bound)``.

    By the orbit's error, ``space.power`` at its start, every sample keeps its reading, and every speed its guard; and
    both by a difference of ``space.away`` there. ``bound``: on the error of a position.
    """
    width = space.width
    begin_period(space, law, m)
    edges, guards, near, bound, count = True, True, True, 0.0, 0
    for _ in range(period):
        gap, _, guard, law.slopes[count] = sense(past, wall, law, space, m)
        if count % STOP == 0:
            sum_block(3 * m, count, law, m, space.spare)
        begin = count - count % STOP
        place = carried(0, begin, 3 * m, count, law, m, space.spare)
        pace = carried(1, begin, 3 * m, count, law, m, space.spare)
        far, fast = place, pace
        for c in range(m):
            place += abs(space.cols[c * width]) * space.power[c]
            pace += abs(space.cols[c * width + 1]) * space.power[c]
            far += abs(space.cols[c * width]) * space.away[c]
            fast += abs(space.cols[c * width + 1]) * space.away[c]
        edges, guards = edges and place < gap, guards and pace < guard
        near = near and far < gap and fast < guard
        bound = max(bound, place)
        count += 1
        move_columns(past, body, law, space, m)
        if count == BLOCK:
            sum_block(m, count, law, m, space.spare)
            count = 0
    return edges, guards, near, bound


def measure_residual(state, past, body, law, space):
    """Leave in ``space.residual`` what a state and its torques under way differ by from the orbit's."""
    n, under_way = body.order, law.line + 1
    for i in range(n):
        space.residual[i] = state[i] - space.orbit[i]
    for j in range(law.ages - 1):
        space.residual[n + j] = past[under_way + j] - law.periodic[under_way + j]


def find_sensed_orbit(period, body, wall, law, space, m):
    """Find the fixed point of a period near ``space.orbit`` and ``law.periodic``, by Newton's method.

    Returns ``(same, solved, closure, turned)``: whether all that is counted comes back; whether the derivative could be
    inverted; what `turn_sensed` says of the last turn.
    """
    n, under_way = body.order, law.line + 1
    turned, closure = (0.0, 0.0, 0.0, 0.0, 0.0), 0.0
    solved, best = True, float("inf")
    for step in range(NEWTON_STEPS):
        copy_to(law.beside, law.periodic)
        turned = turn_sensed(law.beside, period, body, wall, law, space, m)
        if not same_count(law.beside, law.periodic, law):
            return False, solved, closure, turned
        measure_residual(space.state, law.beside, body, law, space)
        closure = closure_of(space, m)
        solved = invert(space.matrix, space.cols, m, space.width)
        small = closure <= 4.0 * EPSILON * (turned[2] + turned[3])
        if not solved or small or closure >= 0.5 * best or step == NEWTON_STEPS - 1:
            break
        best = closure
        for i in range(m):
            change = 0.0
            for j in range(m):
                change += space.matrix[i * 2 * m + m + j] * space.residual[j]
            if i < n:
                space.orbit[i] += change
            else:
                law.periodic[under_way + i - n] += change
    return True, solved, closure, turned


def certify_sensed(z, past, period, body, wall, law, space):
    """Try to prove an orbit of ``period`` samples, as `laws.period.certify_with_law` does."""
    n, width = body.order, space.width
    m = n + law.ages - 1  # of the state, and of the torques of the samples before
    copy_to(space.orbit, z)
    copy_to(law.periodic, past)
    same, solved, closure, turned = find_sensed_orbit(period, body, wall, law, space, m)
    margin, edge, reach, pace, strength = turned
    if not same or not closure < 1e-6 * (reach + pace):
        return DIFFERENT, 0.0, 0.0, 0.0, 0.0
    if not solved:
        return NEUTRAL, margin, edge, closure, 0.0
    # A torque that is wrong by so much moves a speed, and a place, by no more in an interval.
    pull = abs(body.drive) + (body.beta + body.pad_stiffness) * reach
    wrong = ROUNDINGS * EPSILON * (law.coarse * (strength + law.unit * (1.0 + reach + pace)) + pull)
    rounding = 8.0 * EPSILON * law.pieces
    for i in range(m):
        law.noise[i] = wrong
        if i < n:
            law.noise[i] += rounding * ((reach + pace) if i % 2 == 0 else 2.0 * pace)
    chart_interval(law.beside, body, law, space, m)
    copy_to(law.beside, law.periodic)
    chart_rounding(law.beside, period, body, wall, law, space, m)
    for i in range(m):
        total = 0.0
        for j in range(m):
            total += abs(space.matrix[i * 2 * m + m + j]) * (abs(space.residual[j]) + law.noise[m + j])
        space.away[i] = total
    bound = space.away[0]
    scale = scale_of(reach, pace)
    if not dissipates(space.cols, width, space.power, space.spare, m, scale, period):
        return EXPANDS, margin, edge, closure, bound
    for i in range(m):
        space.power[i] = space.away[i]
    measure_residual(z, past, body, law, space)
    if not bound_growth(space, m, scale, period):
        return EXPANDS, margin, edge, closure, bound
    copy_to(law.beside, law.periodic)
    edges, guards, near, bound = within(law.beside, period, body, wall, law, space, m)
    if not edges:
        return ON_EDGE, margin, edge, closure, bound
    if not guards:
        return AT_SWITCH, margin, edge, closure, bound
    return (PROVEN if near else NOT_CAPTURED), margin, edge, closure, bound


def slope_columns(slope, body, law, space, m):
    """Put the slope of the newest torque by the speed into the columns, whose oldest torque no longer counts."""
    n, width = body.order, space.width
    for c in range(m):
        for j in range(law.ages - 1):
            space.cols[c * width + n + j] = space.cols[c * width + n + j + 1]
        space.cols[c * width + n + law.ages - 1] = slope * space.cols[c * width + 1]


def parting_with_law(z, past, samples, body, wall, law, space):
    """Mean growth of the logarithm of a difference of motions with the same readings, per sample.

    Args:
        z: State at the start, left at the end.
        past: What is remembered there.
        samples: How long the motion is followed.
        body: What moves.
        wall: What commands.
        law: The controller.
        space: Work space of the general loop.
    """
    n, width = body.order, space.width
    m = n + law.ages if law.senses else n  # of the state, and of the torques of a law that senses the speed
    begin_columns(space, m)
    copy_to(space.state, z)
    total = 0.0
    for _ in range(samples):
        shown = read_after(space.state[0], past[law.line - 1], wall)
        decide(shown, space.state[1], past, wall, law)
        if wall.hysteresis > 0.0:
            past[law.line - 1] = shown
        if law.senses:
            slope_columns(law.out[law.parts], body, law, space, m)
        for piece in range(law.pieces):
            at = piece * PIECE
            if wall.hysteresis > 0.0:
                for i in range(n):
                    space.away[i] = space.state[i]
                count_piece(space.away, past, piece, body, wall, law, space.pad)
            for c in range(m):
                torque = n + int(law.sched[at + TORQUE]) - law.line
                space.cols[width * width + c] = space.cols[c * width + torque] if law.senses else 0.0
            move_piece_columns(past, at, body, law, space, m)
            look = int(law.sched[at + LOOK])
            if look >= 0:
                past[look] = read_after(space.state[0], past[law.line - 1], wall)
        size = normalise(space.cols, width, m)
        if not size > 0.0:
            return -float("inf")
        total += log(size)
    copy_to(z, space.state)
    return total / samples
