"""An arc of states, all clock phases of a start between two, and where it crosses count edges.

A state of phase phi lies at D(phi) less D(middle) from that of the middle, where D is the free motion about its rest
point: so an arc is known in closed form, and its parts between edges are found by Newton's method.
"""

from math import sqrt
from typing import NamedTuple

from hknob_cli.engine.certificate import EPSILON
from hknob_cli.engine.loop import level_of, lower_edge, upper_edge
from hknob_cli.engine.propagator import hold_coefficients
from hknob_cli.engine.turning import first_zero, zero_spacing

NEXT = EPSILON  # apart are phases next to each other
BISECTIONS, ENOUGH = 60, 12  # evaluations of a phase, and those after which rounding may hide the rest
STEPS = 12  # evaluations until an arc that crosses an edge at any speed is within rounding of it
BENT = 0.001  # part of its speed that an arc may lose near an edge; a proof below the root of 2, less 1


class Flight(NamedTuple):
    """The free motion that an arc is told from, at one sample.

    ``dx``, ``dv``: its state of phase 0; ``base``: position of the arc less that of the free motion; ``speed``: along
    the arc, as `arc_speed` bounds it.
    """

    dx: float
    dv: float
    base: float
    speed: float


def free_motion(t, dx, dv, loop):
    """Free motion about the rest point, ``t`` after ``(dx, dv)``."""
    s, g, f = hold_coefficients(loop.alpha, loop.beta, t)
    return dx + (s * dv - loop.beta * g * dx), f * dv - loop.beta * s * dx


def arc_speed(x, v, loop):
    """Bound on the speed along an arc from the state ``(x, v)`` of its free motion on, in the norm that never grows."""
    rate = -loop.beta * x - loop.alpha * v
    return sqrt(v * v + rate * rate / loop.beta) * (1.0 + 64.0 * EPSILON)


def solve_phase(target, low, high, rising, base, dx, dv, loop):
    """Two phases between ``low`` and ``high``, next to each other, between which a monotone arc passes ``target``.

    Newton's method, each step a little too long, and longer until it has passed: so it closes in from both sides. It
    halves where a step leaves them, and ends where rounding hides what is between them.
    """
    phase, before, ahead = low, True, NEXT
    left, right = float("inf"), float("inf")  # distances from the target at either side
    hidden = EPSILON * (abs(target) + abs(base))
    for i in range(BISECTIONS):
        x, v = free_motion(phase, dx, dv, loop)
        below, away = x + base < target, abs(x + base - target)
        ahead = 8.0 * ahead if below == before else NEXT
        before = below
        step = away / abs(v) + ahead if v != 0.0 else 1.0
        if below == rising:
            low, left, phase = phase, away, phase + step
        else:
            high, right, phase = phase, away, phase - step
        if high - low <= 4.0 * NEXT or (i >= ENOUGH and left + right <= hidden):
            break
        if not low < phase < high:
            phase = 0.5 * (low + high)
    return low, high


def part_within(low_edge, high_edge, low, high, base, dx, dv, loop):
    """Phases of a monotone part of an arc whose positions lie between two edges: ``(low, high)``, low > high if none.

    Taken a little too large, never too small.
    """
    a, _ = free_motion(low, dx, dv, loop)
    b, _ = free_motion(high, dx, dv, loop)
    a, b = a + base, b + base
    if max(a, b) < low_edge or min(a, b) > high_edge:
        return 1.0, 0.0
    first, last = low, high
    if a < low_edge:
        first, _ = solve_phase(low_edge, low, high, True, base, dx, dv, loop)
    elif a > high_edge:
        first, _ = solve_phase(high_edge, low, high, False, base, dx, dv, loop)
    if b < low_edge:
        _, last = solve_phase(low_edge, low, high, False, base, dx, dv, loop)
    elif b > high_edge:
        _, last = solve_phase(high_edge, low, high, True, base, dx, dv, loop)
    return first, last


def turn_after(phase, dx, dv, loop):
    """The first phase after ``phase`` at which the arc turns; infinite if none."""
    x, v = free_motion(phase, dx, dv, loop)
    return phase + first_zero(v, -loop.beta * x, loop.alpha, loop.beta)


def extent(low, high, dx, dv, loop):
    """Least and largest position of the free motion over an arc."""
    a, _ = free_motion(low, dx, dv, loop)
    b, _ = free_motion(high, dx, dv, loop)
    least, most = min(a, b), max(a, b)
    turn, spacing = turn_after(low, dx, dv, loop), zero_spacing(loop.alpha, loop.beta)
    while turn < high:
        at, _ = free_motion(turn, dx, dv, loop)
        least, most = min(least, at), max(most, at)
        turn += spacing
    return least, most


def pass_edge(edge, reach, low, high, begin, end, flight, loop):
    """Phases at which a monotone arc comes within ``reach`` of an edge, and leaves it; ``(low, high)`` at most.

    Taken a little too far apart, never too near. ``begin`` and ``end``: positions of its free motion at either end, of
    which the edge lies between, or within ``reach``. Newton's method comes within ``reach`` of the edge. From there the
    arc goes as far as its slope says, less what it may bend on the way: a step longer in proportion to twice that is
    long enough, and where it is longer by less than `BENT`, it is taken.
    """
    dx, dv, base, speed = flight
    rising = end > begin
    bend = speed * sqrt(loop.beta)
    left, right, phase = low, high, 0.5 * (low + high)
    if begin != end:
        phase = min(max(low + (edge - base - begin) / (end - begin) * (high - low), low), high)
    for _ in range(STEPS):
        x, v = free_motion(phase, dx, dv, loop)
        past = x + base - edge if rising else edge - (x + base)
        bent = 2.0 * reach * bend
        if abs(past) <= reach and bent < BENT * v * v:
            slow = (1.0 + bent / (v * v)) / abs(v)
            comes, leaves = phase - ((reach + past) * slow + NEXT), phase + ((reach - past) * slow + NEXT)
            return max(low, comes), min(high, leaves)
        if past < 0.0:
            left = phase
        else:
            right = phase
        phase = phase - past / abs(v) if v != 0.0 else left
        if not left < phase < right:
            phase = 0.5 * (left + right)
    # It hardly moves there.
    comes, leaves = part_within(edge - reach, edge + reach, low, high, base, dx, dv, loop)
    return (comes, leaves) if comes <= leaves else (low, high)


def cut(low, high, x, v, reach, flight, cuts, loop):
    """Cut an arc at the edges that change the torque; the number of its parts, or -1 where there is no room for them.

    Parts are written to ``cuts``, in order along the arc: level, low and high phase. Each takes in what lies within
    ``reach`` of its edges. So whatever a state's true level is, a part with it holds it.

    Args:
        low: First phase.
        high: Last phase.
        x: Position of the free motion at the first phase.
        v: Velocity there.
        reach: Bound on the error of positions.
        flight: The free motion at the sample.
        cuts: Room for the parts.
        loop: The cell.
    """
    dx, dv, base = flight.dx, flight.dv, flight.base
    far, far_v = free_motion(high, dx, dv, loop)
    spacing = zero_spacing(loop.alpha, loop.beta)
    turn = float("inf")
    if not (v * far_v > 0.0 and high - low < spacing):  # else it does not turn
        turn = low + first_zero(v, -loop.beta * x, loop.alpha, loop.beta)
    count, begin, more = 0, low, True
    while more:
        more = turn < high
        end, to = high, far
        if more:
            end = turn
            to, _ = free_motion(turn, dx, dv, loop)
        step = 1.0 if to > x else -1.0
        level = level_of(x + base - step * reach, loop.sense)
        last_level = level_of(to + base + step * reach, loop.sense)
        first = begin
        on = True
        while on:
            on = level != last_level
            comes, leaves = end, end
            if on:
                edge = upper_edge(level, loop.sense) if step > 0.0 else lower_edge(level, loop.sense)
                comes, leaves = pass_edge(edge, reach, begin, end, x, to, flight, loop)
            if count > 0 and cuts[3 * count - 3] == level:  # it turned there
                cuts[3 * count - 1] = leaves
            elif 3 * count + 3 > len(cuts):
                return -1
            else:
                cuts[3 * count], cuts[3 * count + 1], cuts[3 * count + 2] = level, first, leaves
                count += 1
            first = comes
            level += step
        begin, x, turn = end, to, turn + spacing
    return count
