"""Proof of a limit cycle: solve the period map for its fixed point and check that its levels are the ones assumed.

With damping and hand stiffness the plant is a contraction and a given sequence of levels has exactly one periodic
motion. If that motion, sampled, visits the very levels it was built from, with a margin above rounding, it is an
orbit of the sampled system. A trial whose distance from it, in the norm in which the free plant never grows
(beta x^2 + v^2, its energy), is below the margin follows the same levels for ever and converges to it.
"""

from math import sqrt

from hknob_cli.engine.loop import copy_line, interval, level_of, lower_edge, push, upper_edge
from hknob_cli.engine.propagator import hold_coefficients, slowest_rate

EPSILON = 2.220446049250313e-16
REFINED = 0.1  # part of a rounding to which the period map is worth being solved again

DIFFERENT = 0  # the levels do not repeat, or the periodic motion visits others
PROVEN = 1  # orbit proven, and the trial is captured by it
NOT_CAPTURED = 2  # orbit proven, the trial may still end elsewhere
ON_EDGE = 3  # levels agree, but a margin is within rounding
NEUTRAL = 4  # no hand stiffness: one of a continuum of motions


def distance(dx, dv, loop):
    """Bound on how far apart two motions under the same levels ever get in position, from their distance now.

    Five roundings, each of half an epsilon, make it smaller by 1.25 epsilon at most; it is rounded up by more.
    """
    size = sqrt(dx * dx + dv * dv / loop.beta) if loop.beta > 0.0 else abs(dx) + abs(dv) / loop.alpha
    return size * (1.0 + 2.0 * EPSILON)


def forced_response(x, v, ring, head, n, loop):
    """Response from zero to the ``n`` levels that a motion from ``(x, v)`` visits: ``(zx, zv, repeats)``.

    ``repeats`` is False when the delay line does not return to its own content, or all levels are the same: what
    repeats then is a rest point, which `rest.settles` is to prove.
    """
    line = copy_line(ring)
    delay = len(ring)
    zx, zv = 0.0, 0.0
    at = head
    first = level_of(x, loop.sense)
    repeats = False
    for _ in range(n):
        level = level_of(x, loop.sense)
        if level != first:
            repeats = True
        older, newer = push(level, line, at, loop)
        x, v = interval(x, v, older, newer, loop)
        zx, zv = interval(zx, zv, older, newer, loop)
        if delay > 0:
            at = (at + 1) % delay
    for j in range(delay):
        if line[(at + j) % delay] != ring[(head + j) % delay]:
            repeats = False
    return zx, zv, repeats


def solve_period(rx, rv, n, loop):
    """Solve ``(I - Phi^n) z = r``: the offset of the fixed point that a residual ``r`` of the period map means."""
    s, g, _ = hold_coefficients(loop.alpha, loop.beta, float(n))
    p = loop.beta * g
    q = p + loop.alpha * s
    det = p * q + loop.beta * s * s
    return (q * rx + s * rv) / det, (p * rv - loop.beta * s * rx) / det


def growth(n, loop):
    """Norm of ``(I - Phi^n)^-1``, as `distance` measures: what a residual of a period means for its fixed point."""
    if loop.beta == 0.0:
        s, _, _ = hold_coefficients(loop.alpha, 0.0, float(n))
        return 1.0 / (loop.alpha * s)  # of the velocity; every position repeats
    s, g, _ = hold_coefficients(loop.alpha, loop.beta, float(n))
    p = loop.beta * g
    q = p + loop.alpha * s
    det = p * q + loop.beta * s * s
    return sqrt(p * p + q * q + 2.0 * loop.beta * s * s) / det


def step_error(x, v, older, newer, weight, loop):
    """Bound on what rounding adds to the error of a state in one sample, in the norm of `distance`.

    Each operand is exact to a few units in the last place (`propagator.hold_coefficients`), of which S, F <= 1 and
    G <= 1/2; ``weight`` is 1/sqrt(beta), by which the norm weighs velocities.
    """
    pull = max(abs(older), abs(newer)) + abs(loop.gamma) + loop.beta * abs(x)
    return EPSILON * (2.0 * abs(x) + 8.0 * (1.0 + weight) * (abs(v) + pull))


def errors_kept(n, loop):
    """How many errors of one sample add up over ``n`` samples at most.

    The norm of the free plant never grows, so it is ``n`` at most. With hand stiffness it decays: its sum over all
    later samples is at most 2.55 times the slowest time constant, reached by critical damping.
    """
    if loop.beta == 0.0:
        return float(n)
    return min(float(n), 1.0 + 3.0 / slowest_rate(loop.alpha, loop.beta))


def compare(x, v, tx, tv, ring, head, n, loop):
    """Run a periodic motion beside the trial it was built from, for one period.

    Returns ``(same, ex, ev, margin, edge, rounding)``: whether all levels agree; where the motion ends less where it
    began; its least distance to an edge that changes the torque, and to any count edge; the largest `step_error`.
    """
    line = copy_line(ring)
    delay = len(ring)
    x0, v0 = x, v
    at = head
    margin = float("inf")
    edge = float("inf")
    rounding = 0.0
    weight = 1.0 / (sqrt(loop.beta) if loop.beta > 0.0 else loop.alpha)
    same = True
    for _ in range(n):
        level = level_of(tx, loop.sense)
        if level_of(x, loop.sense) != level:
            same = False
            break
        below = x - lower_edge(level, loop.sense)
        margin = min(margin, below, upper_edge(level, loop.sense) - x)
        part = x % 1.0
        edge = min(edge, part, 1.0 - part)
        older, newer = push(level, line, at, loop)
        rounding = max(rounding, step_error(x, v, older, newer, weight, loop))
        x, v = interval(x, v, older, newer, loop)
        tx, tv = interval(tx, tv, older, newer, loop)
        if delay > 0:
            at = (at + 1) % delay
    return same, x - x0, v - v0, margin, edge, rounding


def certify(x, v, ring, head, n, loop):
    """Try to prove an orbit of ``n`` samples from a trial at ``(x, v)`` whose levels seem to repeat.

    Returns ``(status, x*, v*, margin, edge, closure, bound)``: the orbit's state at this sample, its margins in
    counts as in `compare`, the residual of the period map in counts, and a bound on the error of the orbit's states at
    any sample, in the norm of `distance`, by the residual and by the roundings of states and coefficients.
    """
    zx, zv, repeats = forced_response(x, v, ring, head, n, loop)
    if not repeats:
        return DIFFERENT, x, v, 0.0, 0.0, 0.0, 0.0
    neutral = loop.beta == 0.0
    if neutral:
        s, _, _ = hold_coefficients(loop.alpha, 0.0, float(n))
        ov = zv / (loop.alpha * s)
        ox = x + (v - ov) / loop.alpha
    else:
        ox, ov = solve_period(zx, zv, n, loop)
    same, ex, ev, margin, edge, rounding = compare(ox, ov, x, v, ring, head, n, loop)
    if same and not neutral and distance(ex, ev, loop) > REFINED * rounding:
        # One step of iterative refinement, where the first solution is not good to rounding already.
        cx, cv = solve_period(ex, ev, n, loop)
        ox, ov = ox + cx, ov + cv
        same, ex, ev, margin, edge, rounding = compare(ox, ov, x, v, ring, head, n, loop)
    if not same:
        return DIFFERENT, ox, ov, 0.0, 0.0, 0.0, 0.0
    closure = sqrt(ex * ex + ev * ev)
    added = errors_kept(n, loop) * rounding
    # Without stiffness every position repeats, or none does: what is left is no rounding.
    if neutral and abs(ex) > added:
        return DIFFERENT, ox, ov, margin, edge, closure, 0.0
    # The fixed point is off by what residual and roundings mean for it; at later samples by no more, and by roundings.
    bound = growth(n, loop) * (distance(ex, ev, loop) + added) + added
    if not margin > bound:
        return ON_EDGE, ox, ov, margin, edge, closure, bound
    if not distance(x - ox, v - ov, loop) + bound < margin:
        return NOT_CAPTURED, ox, ov, margin, edge, closure, bound
    return (NEUTRAL if neutral else PROVEN), ox, ov, margin, edge, closure, bound
