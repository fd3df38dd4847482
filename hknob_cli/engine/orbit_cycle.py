"""The measures of one period of an orbit, in counts and samples: how far it swings, and what it does with energy.

Peaks and troughs of the motion between samples are all found, in closed form. The zeros of the velocity are known
(`engine.turning`). Holds shorter than half a ringing period hold at most one, and do exactly when the velocity changes
sign; longer ones may hold many.

Integrals are of the position, its square, the square of the velocity, and work. Over a hold all are linear and
quadratic in what it begins with, the position, the velocity and the drive. So those are added up over the holds of a
kind, and their products, and the forms of the kind are taken of the sums, once.

Where the energy leaks in: the work of the wall, split by when it is done. A wall that answered at once would give back
what it takes: its torque depends on the angle alone, and its potential U comes back over a cycle. What the sampled one
adds, it adds late (Hasser, secs. 6.2 and 9.1):

- *late entry*: the knob is inside the wall, and no torque acts yet;
- *late exit*: the knob is outside again, and torque still acts;
- *staircase*: the knob is inside, and the torque is that of an earlier angle.

While the torque u is constant, its work less that of the wall that answers at once is u (x1 - x0) + U(x1) - U(x0), with
x clipped to the part in question: no crossing times are needed. The three add up to the work of the wall over a cycle.
"""

from math import ceil, sqrt
from typing import NamedTuple

from hknob_cli.engine.loop import floor
from hknob_cli.engine.orbit_holds import LENGTH, MEAN, PART, SPEED, SQUARE, G, S, fill_parts, holds_per_sample, trace
from hknob_cli.engine.propagator import hold_coefficients
from hknob_cli.engine.turning import first_zero, zero_spacing


def potential(depth, kappa, offset, analog):
    """Work to push the knob ``depth`` counts into a wall that answers at once; 0 outside.

    ``kappa``: stiffness of the wall, K T^2 / J; ``offset``: angle that an encoder level reports, less the level, in
    counts; ``analog``: whether the sensor has no counts.
    """
    if depth <= 0.0:
        return 0.0
    if analog:
        return 0.5 * kappa * depth * depth
    whole = floor(depth)
    full = whole * (0.5 * (whole + 1.0) - offset)
    return kappa * (full + (depth - whole) * (whole + 1.0 - offset))


def find_leak(x, drive, count, push, edge, kappa, offset, analog):
    """Split the work of the wall over ``count`` holds into ``(late entry, late exit, staircase)``.

    The torque of the wall is ``drive`` plus ``push``, as an acceleration; ``edge``: the position below which a wall
    that answers at once would act.
    """
    entry, left, staircase = 0.0, 0.0, 0.0
    deep, stored = max(edge - x[0], 0.0), potential(edge - x[0], kappa, offset, analog)
    for i in range(count):
        torque = drive[i] + push
        deeper = max(edge - x[i + 1], 0.0)
        after = potential(deeper, kappa, offset, analog)
        inside = deep - deeper
        if torque == 0.0:
            entry += after - stored
        else:
            left += torque * (x[i + 1] - x[i] - inside)
            staircase += torque * inside + (after - stored)
        deep, stored = deeper, after
    return entry, left, staircase


MOST_TURNS = 1e7  # of a period: a second of compiled code, and of a knob that rings millions of times in an interval


def direction(x, v, drive, beta):
    """Which way the knob moves just after it was at ``(x, v)`` under a ``drive``: 1, -1, or 0 if it stays."""
    if v == 0.0:
        v = drive - beta * x
    return 1 if v > 0.0 else (-1 if v < 0.0 else 0)


def turns_within(first, span, spacing, odd):
    """Number of turning points in a hold of length ``span``: at ``first``, and one every ``spacing`` after it.

    The directions at both ends fix whether it is ``odd`` (0 or 1); rounding can only move a zero at the very end.
    """
    if spacing >= span:
        return odd
    count = ceil((span - first) / spacing) if first < span else 0
    if count % 2 != odd:
        count += 1 if (first + count * spacing) - span < span - (first + (count - 1) * spacing) else -1
    return max(0, count)


def find_extrema(holds, count, parts, kinds, alpha, beta, reference):
    """All local maxima and minima of a period of ``count`` holds, relative to ``reference``.

    Returns ``(peaks, sum of peaks, highest, troughs, sum of troughs, lowest)``; no peaks where nothing moves, or where
    there are more than `MOST_TURNS`.
    """
    x, v, drive = holds
    spacing = zero_spacing(alpha, beta)
    if count > MOST_TURNS * kinds * spacing:
        return 0, 0.0, 0.0, 0, 0.0, 0.0
    peaks, peak_sum, highest = 0, 0.0, -float("inf")
    troughs, trough_sum, lowest = 0, 0.0, float("inf")
    # A knob that stays where it is for a hold moves as it did before; so does the first hold of a period.
    first, last = direction(x[0], v[0], drive[0], beta), count
    while first == 0 and last > 0:
        last -= 1
        first = direction(x[last], v[last], drive[last], beta)
    going = first
    base, other = 0, (kinds - 1) * PART
    for i in range(count):
        following = first
        if i + 1 < count:
            following = direction(x[i + 1], v[i + 1], drive[i + 1], beta)
            following = going if following == 0 else following
        span = parts[base + LENGTH]
        base = other - base
        odd = 1 if following != going else 0
        # One that stays where it is does not ring.
        apart = float("inf") if direction(x[i], v[i], drive[i], beta) == 0 else spacing
        if odd == 1 or apart < span:
            y = drive[i] - beta * x[i]
            at = first_zero(v[i], y, alpha, beta)
            up = going > 0
            for turn in range(turns_within(at, span, apart, odd)):
                # Not ``turn * spacing`` alone: an infinite spacing times 0 is no number.
                t = min(at + turn * spacing, span) if turn > 0 else min(at, span)
                s, g, _ = hold_coefficients(alpha, beta, t)
                turned = (x[i] - reference) + (s * v[i] + g * y)
                if up:
                    peaks += 1
                    peak_sum += turned
                    highest = max(highest, turned)
                else:
                    troughs += 1
                    trough_sum += turned
                    lowest = min(lowest, turned)
                up = not up
        going = following
    return peaks, peak_sum, highest, troughs, trough_sum, lowest


def add_up(holds, kind, count, kinds, reference, mean):
    """Sums over the holds of one ``kind`` of a, b, d, a², ab, ad, b², bd and d².

    a: position less ``reference``; b: velocity; d: drive less its ``mean``. Without those the sums would lose digits
    where the knob is pushed deep.
    """
    x, v, drive = holds
    a, b, d = 0.0, 0.0, 0.0
    aa, ab, ad, bb, bd, dd = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(kind, count, kinds):
        place, speed, force = x[i] - reference, v[i], drive[i] - mean
        a, b, d = a + place, b + speed, d + force
        aa, ab, ad = aa + place * place, ab + place * speed, ad + place * force
        bb, bd, dd = bb + speed * speed, bd + speed * force, dd + force * force
    return a, b, d, aa, ab, ad, bb, bd, dd


def form_of(parts, at, products):
    """Value of the symmetric form that begins at ``at``, of sums of products."""
    aa, ab, ac, bb, bc, cc = products
    return (
        parts[at] * aa
        + 2.0 * (parts[at + 1] * ab + parts[at + 2] * ac)
        + (parts[at + 3] * bb + 2.0 * parts[at + 4] * bc)
        + parts[at + 5] * cc
    )


def find_integrals(holds, count, parts, kinds, beta, reference, mean):
    """Integrals over ``count`` holds: of x less ``reference`` (a position near the motion), of its square, of v², work.

    The work is that of the wall torque, in units of J (counts per sample)²: torque times distance. On a limit cycle it
    is what the damping takes out (bias and hand stiffness return what they take), alpha times the integral of v²; that
    one is of v alone, so that their difference checks the orbit and its integrals. The ``mean`` drive does no work.
    """
    total, square, speed, work = 0.0, 0.0, 0.0, 0.0
    spare = mean - beta * reference
    for kind in range(kinds):
        base = kind * PART
        a, b, d, aa, ab, ad, bb, bd, dd = add_up(holds, kind, count, kinds, reference, mean)
        c = d + (count // kinds) * spare  # the drive less what holds the knob at the reference
        products = (aa, ab, ad + spare * a, bb, bd + spare * b, dd + spare * (d + c))
        total += parts[base + MEAN] * a + parts[base + MEAN + 1] * b + parts[base + MEAN + 2] * c
        square += form_of(parts, base + SQUARE, products)
        speed += form_of(parts, base + SPEED, products)
        work += parts[base + S] * bd + parts[base + G] * ((dd + spare * d) - beta * ad)
    return total, square, speed, work


class CycleMeasures(NamedTuple):
    """Measures of one period of an orbit, in counts and samples.

    ``cycles``: local maxima; ``swing``: their mean less that of the minima; ``lowest``, ``highest``: extremes of the
    position, and ``rms`` about its mean. In units of J (counts per sample)²: ``wall_work``, ``damping_loss``, and the
    work of the wall by when it is done (`engine.orbit_cycle`).
    """

    cycles: int
    swing: float
    lowest: float
    highest: float
    rms: float
    wall_work: float
    damping_loss: float
    late_entry: float
    late_exit: float
    staircase: float


def measure_holds(holds, n, parts, kinds, alpha, beta, places, drives):
    """Measures of ``n`` samples of ``kinds`` holds each, whose end is their start.

    ``places``, ``drives``: sums of the positions at which ``holds`` start, and of their drives; ``parts``: numbers of
    the kinds of holds, `orbit_holds`. Returns the first seven of `CycleMeasures`; without cycles where nothing turns.
    """
    count = n * kinds
    reference = places / count
    peaks, peak_sum, highest, troughs, trough_sum, lowest = find_extrema(
        holds, count, parts, kinds, alpha, beta, reference
    )
    if peaks == 0 or troughs == 0:
        none = float("nan")
        return 0, none, none, none, none, none, none
    total, square, speed, work = find_integrals(holds, count, parts, kinds, beta, reference, drives / count)
    mean = total / n
    return (
        peaks,
        peak_sum / peaks - trough_sum / troughs,
        reference + lowest,
        reference + highest,
        sqrt(max(square / n - mean * mean, 0.0)),
        work,
        alpha * speed,
    )


def measure_cycle(x, v, ring, head, n, loop, parts, holds):
    """Numbers of `CycleMeasures` of the orbit of ``n`` samples through ``(x, v)``.

    ``ring``, ``head``: the delay line there. ``parts`` is filled in if it is empty, its first number 0; ``holds`` is
    work space, as `trace` takes it.
    """
    if parts[LENGTH] == 0.0:
        fill_parts(parts, loop)
    places, drives = trace(x, v, ring, head, n, loop, holds)
    kinds = holds_per_sample(loop)
    found = measure_holds(holds, n, parts, kinds, loop.alpha, loop.beta, places, drives)
    edge = 0.0 if loop.sense > 0.0 else -1.0
    return (*found, *find_leak(holds.x, holds.drive, n * kinds, loop.gamma, edge, loop.kappa, loop.offset, False))
