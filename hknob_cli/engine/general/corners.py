"""Proof of a limit cycle that passes corners of cogging, or stays on a slope that does not hold the knob.

Let d be the difference of a motion from the orbit, and N(d), its size, the root of its energy with the spring of a
stable slope. On a stable slope N never grows. On any other, and where the two motions are on two, it grows at a rate of
at most sqrt((b/2)^2 + p^2) - b/2, of the knob's damping b and p = slope / sqrt(springs of the hand + slope).

Up to any time of a period d becomes M d, with M the derivative along the orbit, and what is added while a corner lies
between the two. There the slopes of their torques differ by at most twice the slope of cogging. As long as positions
are within ``far`` of the orbit's, that is while the orbit is within ``far`` of a corner. It passes one at a speed v.
With accelerations of at most a the speed stays above v / 2 over a way of 3 v^2 / (8 a) on either side, so that this
takes 8/3 far / v; and elsewhere the orbit comes no nearer to a corner than where it turns round. So if sizes are at
most q in a period, what is added is at most ``bend`` q^2, and to the difference of two such motions at most ``bend`` q
times the most of that difference.

What is added goes on to a later time, where it is at most so many times as large as the derivative makes it: this is
part of ``bend``. The derivative is kept for 64 parts of a period. Their products say what it makes of a size from any
part to any other; within a part a size grows at the rate above. So the growth of a whole period at that rate, which may
be immense, does not matter. Where what is added up to any time is at most half of q, q is at most twice what the
derivative makes of the difference at the start.

Let ``swell`` bound what the sum of the absolute powers of the derivative of a period makes of a size of 1, ``most``
what a period at any time makes of it, and ``missed`` the residual of the orbit. With q = most X, and
swell (N + missed + bend q^2) <= X at the start, no difference at a later start is larger than X (induction over
periods). Where swell bend most^2 X <= 1/2, any two of these motions come together, because the difference that is left
in the end is at most half of itself. Both hold for X = 2 swell (N + missed), as long as that is at most
1 / (2 swell bend most^2). So there is one periodic motion, and all of them come to it.

Friction takes energy out of any difference. Where it turns a motion round, at a deceleration r, a difference of speeds
shrinks by the ratio of the accelerations after and before. Motions whose speeds differ by at most q from the orbit's
turn within 4 q / r of it. By then forces differ from the orbit's by what springs and damping make of q, and by what a
force changes in that time. So that ratio is known to a part of that over r, and what else a motion does in that time is
known to that time: both add to ``bend``. A motion is held, or let go, at the samples at which the orbit is, by more
than those differences.

It turns nowhere else. Between two corners, under one torque, the speed v and a difference y of speeds obey the same
equation of second order, so that y / v is monotone as long as v is not 0: it is largest at an end. There it is less
than 1, at the end of a hold by the speed, and after a start from 0 by the level of friction. At a corner ``bend`` q <=
1/2 has it below 0.19 where a slope does not hold; and where all hold, a speed has no least value in between.

With more states none of this is so: the least speed of a slide, and the least that friction can hold beside a torque,
are looked for (`piece_marks`), and q is less. A knob may then be let go within a hold, where the torque grows at a rate
p. Let ``steep`` bound the rates of differences in any mode. Torques differ by ``steep`` q, so that other motions are
let go within 2 steep q / p of it. In that time rates of the two differ by at most twice ``steep`` times a difference,
which adds to ``bend``; the derivative goes through a release as it is. Neither is held again, or turns, as long as the
torque grows at half of p at least, and the speed is above q from there on.

Where the orbit begins with a speed of 0, another motion begins with one of at most q. It stops within q / level, and
moves by at most a quarter of its size until then; from there on it is one that began at rest.
"""

from math import exp, inf, sqrt

from hknob_cli.engine.general.body import HELD, coil_at, norm, turn_finger
from hknob_cli.engine.general.cogging import COGGED, LENGTH, ROOT, SLOPE, has_cogs, unit_reach
from hknob_cli.engine.general.columns import (
    FASTEST,
    LOOSE,
    SLOWEST,
    SLOWNESS,
    SWOLLEN,
    TURN_ROOM,
    begin_columns,
)
from hknob_cli.engine.general.piece_marks import WITHIN, turn_alike
from hknob_cli.engine.general.powers import GONE, TAIL, growth_bound, unit

WINDOW = 0.375  # of v^2 / a: the way beside a corner on which the speed is at least half of that at it
PASSING = 8.0 / 3.0  # times far / v: the time within ``far`` of a corner
BESIDE = 0.1  # of an exponent: growth while a corner lies between two motions
MOST_GROWTH = 100.0  # exponent of a growth beyond which a room would be less than any rounding
MOST_PARTS = 64  # of a period, whose derivatives are kept
FROM_STANDSTILL = 0.8  # of a size, where the orbit begins with a speed of 0 and another motion has yet to stop
NEAREST = 1e-13  # of an orbit's size: a trial so near to it is as near as it may come


def goes_over(body):
    """Whether a body is of the kind whose cycles over corners are proven.

    Teeth with play take energy out of a difference only on one flank.
    """
    return has_cogs(body.cogs) and body.play == 0.0


def growth_rate(body):
    """At what rate a size grows at most where no stable slope holds both motions."""
    push = body.cogs[SLOPE] * unit_reach(body)
    return push * push / (sqrt(0.25 * body.alpha * body.alpha + push * push) + 0.5 * body.alpha)


def size_of(dz, body):
    """A bound on N, as the module has it, of a difference whose numbers are at most ``dz``, at least 0."""
    turn_finger(dz, body)
    size = norm(dz, body) + body.cogs[ROOT] * dz[0]
    turn_finger(dz, body)
    return size


def largest_entries(body, out):
    """Leave in ``out`` how large each number of a difference can be whose size is 1."""
    out[0], out[1] = unit_reach(body), 1.0
    if body.ratio > 0.0:
        way = inf
        if body.pad_stiffness > 0.0:
            way = 1.0 / sqrt(body.pad_stiffness)
        if body.finger_stiffness > 0.0:
            way = min(way, out[0] + sqrt(body.ratio / body.finger_stiffness))
        out[2], out[3] = way, 1.0 + sqrt(body.ratio)
    if body.coil > 0.0:
        out[coil_at(body)] = 1.0 / sqrt(body.coil)
    if body.lag > 0.0:
        out[body.order - 1] = body.lag


def rate_bound(body, pad):
    """Bound on the size of the rate of a difference of size 1, in any mode, on any slope. Overwrites ``pad``."""
    n, most = body.order, 0.0
    for which in (HELD, COGGED, COGGED + 1):
        largest_entries(body, pad)
        for i in range(n):
            pad[n + i] = 0.0
            for j in range(n):
                pad[n + i] += abs(body.matrices[which * n * n + i * n + j]) * pad[j]
        for i in range(n):
            pad[i] = pad[n + i]
        most = max(most, size_of(pad, body))
    return most


def samples_of_part(period):
    """Samples of each of the parts of a period, of which there are at most `MOST_PARTS`; the last may have fewer."""
    return (period + MOST_PARTS - 1) // MOST_PARTS


def multiply(left, at, width, right, start, out, to, m):
    """Put the product of two matrices (m, m) into ``out`` at ``to``; they are by columns, and begin at places.

    ``width``: from one column of ``left`` to the next; of the others m.
    """
    for c in range(m):
        for i in range(m):
            entry = 0.0
            for j in range(m):
                entry += left[at + j * width + i] * right[start + c * m + j]
            out[to + c * m + i] = entry


def size_by(map_, at, body, space, m):
    """What a matrix makes at most of a size of 1; overwrites ``away`` and ``spare``."""
    largest_entries(body, space.spare)
    for i in range(m):
        space.away[i] = 0.0
        for c in range(m):
            space.away[i] += abs(map_[at + c * m + i]) * space.spare[c]
    return size_of(space.away, body)


def end_sample(k, period, body, space, m):
    """Mark what the derivative has become by the end of a period's sample ``k``; keep it where a part ends.

    The columns are of one part: ``space.chain`` has the derivatives of those before, that of all of them together, and
    room for a product. They begin as 1 where ``k`` is 0.
    """
    if body.cogs is None or not len(body.cogs):
        return
    size, each = m * m, samples_of_part(period)
    whole, new = MOST_PARTS * size, (MOST_PARTS + 1) * size
    if k == 0:
        for i in range(size):
            space.chain[whole + i] = 1.0 if i % (m + 1) == 0 else 0.0
    multiply(space.cols, 0, space.width, space.chain, whole, space.chain, new, m)
    space.marks[SWOLLEN] = max(space.marks[SWOLLEN], size_by(space.chain, new, body, space, m))
    if (k + 1) % each == 0 or k == period - 1:
        part = k // each * size
        for c in range(m):
            for i in range(m):
                space.chain[part + c * m + i] = space.cols[c * space.width + i]
        for i in range(size):
            space.chain[whole + i] = space.chain[new + i]
        begin_columns(space, m)


def join_parts(body, space, m):
    """Put the derivative of a period, of whose parts `end_sample` has kept the product, back into the columns."""
    if body.cogs is None or not len(body.cogs):
        return
    whole = MOST_PARTS * m * m
    for c in range(m):
        for i in range(m):
            space.cols[c * space.width + i] = space.chain[whole + c * m + i]


def carried_between(period, body, space, m):
    """What the derivative makes of a size of 1, from the start of any part of a period: ``(most, to_end)``.

    Up to the end of any part, and of the period. Overwrites what is kept behind the parts, ``away`` and ``spare``.
    """
    size, most, to_end = m * m, 1.0, 1.0
    whole, new = MOST_PARTS * size, (MOST_PARTS + 1) * size
    last = (period - 1) // samples_of_part(period)
    for first in range(last + 1):
        for i in range(size):
            space.chain[whole + i] = 1.0 if i % (m + 1) == 0 else 0.0
        grown = 1.0
        for part in range(first, last + 1):
            multiply(space.chain, part * size, m, space.chain, whole, space.chain, new, m)
            for i in range(size):
                space.chain[whole + i] = space.chain[new + i]
            grown = size_by(space.chain, whole, body, space, m)
            most = max(most, grown)
        to_end = max(to_end, grown)
    return most, to_end


def swell_of(body, space, m, scale):
    """What the sum of the absolute powers of the derivative makes of a size of 1; inf where it is not bounded."""
    if not growth_bound(space.cols, space.width, space.power, space.spare, space.total, m, scale):
        return inf
    largest_entries(body, space.away)
    largest = 0.0
    for i in range(m):
        largest = max(largest, space.away[i] / unit(i, scale))
    for i in range(m):
        space.away[i] += TAIL * GONE * largest * unit(i, scale)
    for i in range(m):
        space.spare[i] = 0.0
        for j in range(m):
            space.spare[i] += space.total[i * m + j] * space.away[j]
    return size_of(space.spare, body)


def missed_by(fast, slow, grown, body, space, m):
    """Size of the residual of an orbit, of which a period adds ``fast`` to positions and ``slow`` to speeds."""
    n = body.order
    for j in range(m):
        space.away[j] = abs(space.residual[j])
        is_slow = j % 2 == 1 and not (body.lag > 0.0 and j == n - 1)
        space.spare[j] = slow if is_slow else fast
    return size_of(space.away, body) + grown * size_of(space.spare, body)


def pass_corners(far, body, marks):
    """How near motions may be to an orbit in position while they pass its corners as it does, and what that adds.

    ``(far, bend)``: ``far`` or less; ``bend`` is of a growth of 1.
    """
    slope, reach, slowness = body.cogs[SLOPE], unit_reach(body), marks[SLOWNESS]
    if slowness == 0.0:
        return far, 0.0
    far = min(far, WITHIN * WINDOW * marks[SLOWEST] ** 2 / marks[FASTEST])
    grows = growth_rate(body) * PASSING * slowness
    if far * grows > BESIDE:
        far = BESIDE / grows
    return far, 2.0 * slope * PASSING * slowness * reach * reach


def room_over_corners(fast, slow, margin, late, period, body, space, scale):
    """How near to an orbit over corners a motion must be to come to it: ``(room, bound, grown)``.

    ``room`` is by `cogging.far_around`, at most 0 where nothing is proven; ``bound``: on how far the orbit itself may
    be off in position; ``grown``: by what a difference may grow within a period. Overwrites ``away``, ``spare``,
    ``power`` and ``total``.

    Args:
        fast: What a period may add to the residual of positions.
        slow: The same, of speeds.
        margin: Least distance of a sample to a change of command.
        late: As `turn_alike` has it.
        period: Samples of a period.
        body: What moves.
        space: As the last turn of the period map has left it.
        scale: How speeds compare to positions.
    """
    if body.cogs is None or not len(body.cogs):
        return -1.0, inf, inf
    marks, reach, rate, m = space.marks, unit_reach(body), growth_rate(body), body.order
    grown = exp(min(rate * marks[LOOSE] + BESIDE, MOST_GROWTH))
    part = exp(min(rate * min(marks[LOOSE], samples_of_part(period)) + BESIDE, MOST_GROWTH))
    far, bend = pass_corners(WITHIN * min(margin, marks[TURN_ROOM], 0.25 * body.cogs[LENGTH]), body, marks)
    pace = far / reach
    if body.friction > 0.0:
        steep = rate_bound(body, space.pad) if body.order > 2 else 0.0
        pace, turning = turn_alike(pace, steep, late, body, marks)
        bend += turning
    between, to_end = carried_between(period, body, space, m)
    most = grown  # by what a difference may grow up to any time of a period
    swollen = 2.0 * max(1.0, marks[SWOLLEN]) * exp(min(rate + BESIDE, MOST_GROWTH))
    if swollen < grown:
        most = swollen
        added = bend * min(grown, between * part * part)
        if pace * added > 0.5:
            pace = 0.5 / added
    carried = min(grown, to_end * part)
    bend *= carried
    missed = missed_by(fast, slow, carried, body, space, m)
    swell = swell_of(body, space, m, scale)
    if not swell < inf:
        return -1.0, inf, grown
    size = pace / most
    if size * swell * bend * most * most > 0.5:
        size = 0.5 / (swell * bend * most * most)
    if body.friction > 0.0 and space.orbit[1] == 0.0:
        size *= FROM_STANDSTILL
    return (size / (2.0 * swell) - missed) * reach, 2.0 * swell * missed * most * reach, grown
