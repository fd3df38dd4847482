"""The wall with its counts: the describing function of the whole staircase, and exact cycles of the sampled relay.

Of a motion x0 + A sin(wt) the wall gives a mean and a fundamental. The mean carries push and hand's spring, which sets
x0; the fundamental keeps the motion up (the dual-input describing function of Gelb & Vander Velde 1968, ch. 6). Each
edge e with a torque step h below it adds a mean h (1/2 + asin(d)/pi) and a gain 2 h sqrt(1 - d^2)/(pi A), where
d = (e - x0)/A is within -1 to 1. The wall has no memory, so that the pitch is that of one relay
(`relay.describing_function`). Angles are in counts, times in samples, torques accelerations.

A bounded lag keeps a part of a step and gives the rest late. Within one count the law is the lag K (keep tau s +
1)/(tau s + 1). At the frequency w of the buzz it acts as a spring K (1 + keep tau^2 w^2)/(1 + tau^2 w^2) and as a
damper -(1 - keep) K tau/(1 + tau^2 w^2), which is below 0: the lag drives, and works only while w tau is large. The
quantizer turns K into a gain G that falls with the amplitude. With G keep well above the hand's stiffness and w tau
well above 1, w^2 = G keep/J, and the buzz is where the loss of the sample's delay and of the lag is the damping b:

    G keep T/2 + (1 - keep) J/(keep tau) = b.

So G = (2 b/(keep T)) (1 - r (1 - keep)/keep) with r = J/(b tau); the plain wall's (keep = 1) is 2 b/T, and the
amplitude goes as 1/G. The buzz is smaller than the plain wall's for r < keep < 1, smallest at keep = 2 r/(1 + r), where
it is (1 + r)^2/(4 r) times smaller. Below keep = r/(1 + r) the lag drives a slow oscillation of its own; from r = 1 on
no lag makes the buzz smaller. Sample delay, friction and the hand's stiffness are left out: the last helps.

Unlike `relay`, nothing is approximated: the zero-order hold, the sampling and the bias are as they are. What is left
out is only the choice between orbits that a trial's start makes, and cycles over more than two levels or several turns.
"""

from math import ceil, floor, pi, sqrt
from typing import Any, NamedTuple

import numpy as np

from hknob_cli.engine.loop import Loop, drive_of
from hknob_cli.engine.propagator import hold_coefficients
from hknob_cli.engine.relay_cycles import Candidates

MOST_COUNTS = 1000.0  # amplitude; larger motions are not looked for
_LEAST = 1e-2  # counts
_FINER = 1.08  # of neighbours on the grid of amplitudes
_STEPS = 50  # of a bisection


class Swing(NamedTuple):
    """A motion that the wall keeps up: amplitude (half of peak to peak) and mean, in counts."""

    amplitude: float
    mean: float


def mean_and_gain(loop: Loop, amplitude: float, mean: float) -> tuple[float, float]:
    """Mean torque of the wall, and its fundamental over the amplitude, of the motion mean + amplitude sin."""
    first = 0.0 if loop.sense > 0.0 else -1.0
    deepest = max(0, floor(first - (mean - amplitude)) + 1)
    edges = first - np.arange(deepest)
    steps = np.full(deepest, loop.kappa)
    steps[:1] *= 1.0 - loop.offset
    d = np.clip((edges - mean) / amplitude, -1.0, 1.0)
    whole = float((steps * (0.5 + np.arcsin(d) / pi)).sum())
    return whole, float((steps * np.sqrt(1.0 - d * d)).sum()) * 2.0 / (pi * amplitude)


def balanced(loop: Loop, amplitude: float) -> float:
    """Mean of the motion at which the wall carries push and spring; its torque falls with the mean, theirs rises."""
    low, high = -amplitude - loop.gamma / loop.kappa - 2.0, amplitude + 1.0
    for _ in range(_STEPS):
        middle = 0.5 * (low + high)
        if mean_and_gain(loop, amplitude, middle)[0] > loop.gamma + loop.beta * middle:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def swings(loop: Loop, response: float) -> list[Swing]:
    """Motions with ``response`` times the wall's gain = 1, smallest first, ``response`` the plant's at their pitch.

    Only those where the gain falls as the motion grows: the others do not last.
    """

    def spare(amplitude: float) -> float:
        return response * mean_and_gain(loop, amplitude, balanced(loop, amplitude))[1] - 1.0

    found = []
    low, before = _LEAST, spare(_LEAST)
    while low < MOST_COUNTS:
        high = low * _FINER
        after = spare(high)
        if before > 0.0 >= after:
            first, last = low, high
            for _ in range(_STEPS):
                middle = 0.5 * (first + last)
                first, last = (middle, last) if spare(middle) > 0.0 else (first, middle)
            found.append(Swing(0.5 * (first + last), balanced(loop, 0.5 * (first + last))))
        low, before = high, after
    return found


def slowness(*, inertia_kg_m2: float, damping_nm_s_per_rad: float, time_constant_s: float) -> float:
    """Time J/b in which knob and hand lose their speed, over that of the lag; infinite without damping."""
    loss = damping_nm_s_per_rad * time_constant_s
    return inertia_kg_m2 / loss if loss > 0.0 else float("inf")


def best_keep(r: float) -> float:
    """Part of a step that leaves the smallest buzz; 1, the plain wall, where none makes it smaller."""
    return 2.0 * r / (1.0 + r) if r < 1.0 else 1.0


MOST_PAIRS = 20_000_000
CAPACITY = 512
_SHALLOW = 12.0  # jumps above the wall's edge that the mean of a cycle may reach
_DEEPEST = 10_000  # levels apart
_GUESSED = 400  # levels apart, where no bound is known
_LONGEST = 1000  # samples on one side, for which the depths of cycles are worked out


class SampledCycle(NamedTuple):
    """One cycle: ``inside`` of ``period`` samples on the inner level; extremes (mean maximum and minimum) in counts.

    ``x``, ``v``: state at the first sample inside; ``upper``, ``lower``: the encoder levels it alternates between.
    """

    inside: int
    period: int
    highest: float
    lowest: float
    cycles: int
    x: float
    v: float
    upper: int
    lower: int


def level_pairs(loop: Loop, *, delayed: bool = False) -> list[tuple[int, int]]:
    """Pairs of an upper and a lower level between which torque turns the knob back on both sides.

    Levels further apart than one are taken together only by a knob fast enough to jump over those between, and turned
    back within a count all the same: (d - 1)^2 / (2 kappa d) < 1 + d asks for kappa > 1/4. ``delayed``: whether the
    torque is; then, and for an overdamped plant, how far apart they may be is a guess.
    """
    if loop.kappa == 0.0 or loop.beta + loop.gamma == 0.0:
        return []
    rest = -(loop.gamma / (loop.kappa + loop.beta))
    uppers = {q for q in range(floor(rest) - 2, ceil(rest) + 3) if q <= 0} | {0}
    return [
        (upper, upper - depth)
        for upper in sorted(uppers, reverse=True)
        for depth in _depths(loop, upper, rest, delayed=delayed)
        if drive_of(float(upper), loop) < loop.beta * (upper + 1.0)
        and drive_of(float(upper - depth), loop) > loop.beta * (upper - depth)
    ]


def _depths(loop: Loop, upper: int, rest: float, *, delayed: bool) -> list[int]:
    """How many levels below ``upper`` the other level of a cycle can be, ascending.

    Under a constant torque the knob stays on one side of its place of rest for at most half a turn of the plant, which
    bounds the samples inside and outside. For given numbers of them all positions are linear in the depth, and that the
    first and the last sample inside see the lower level leaves a range of depths.
    """
    if loop.kappa < 0.25:
        return [1]
    turn = sqrt(max(loop.beta - 0.25 * loop.alpha * loop.alpha, 0.0))
    if delayed or not pi / _LONGEST < turn < pi:
        return list(range(1, min(_GUESSED, int(20 - 10 * rest)) + 1))
    most = 2 + int(pi / turn)
    s, g, f = np.array([hold_coefficients(loop.alpha, loop.beta, float(t)) for t in range(2 * most + 1)]).T
    inside, outside = (one.ravel() for one in np.meshgrid(np.arange(1, most + 1), np.arange(1, most + 1)))
    n = inside + outside
    # The periodic motion under a unit torque inside and none outside, at its first sample inside and at the last.
    zx = g[inside] - loop.beta * g[outside] * g[inside] + s[outside] * s[inside]
    zv = f[outside] * s[inside] - loop.beta * s[outside] * g[inside]
    p = loop.beta * g[n]
    q = p + loop.alpha * s[n]
    det = p * q + loop.beta * s[n] * s[n]
    x, v = (q * zx + s[n] * zv) / det, (p * zv - loop.beta * s[n] * zx) / det
    last = inside - 1
    low, high = np.ones(len(n)), np.full(len(n), float(_DEEPEST))
    for at in (x, x + s[last] * v + g[last] * (1.0 - loop.beta * x)):
        slope = loop.kappa * at + 1.0
        shift = loop.kappa * loop.offset * at if upper == 0 else 0.0
        level = upper - drive_of(float(upper), loop) / loop.beta + shift
        with np.errstate(divide="ignore"):
            ends = (level - 1.0) / slope, (level + 1.0) / slope  # a count to both sides, however the encoder rounds
        low, high = np.maximum(low, np.minimum(*ends)), np.minimum(high, np.maximum(*ends))
    some = low <= high
    found: set[int] = set()
    for first, final in zip(low[some], high[some], strict=True):
        found.update(range(ceil(first), floor(final) + 1))
    return sorted(found)


def _bounds(loop: Loop, upper: int, lower: int, delay: float) -> tuple[int, int]:
    """Most samples inside and outside that a cycle between two levels can have; (0, 0) if there is none.

    Inside, the torque stops the knob within one count: a (n - 2 - 2 d)^2 / 8 <= 1 + a, a the least push outward.
    """
    out = drive_of(float(lower), loop) - loop.beta * (lower + 1)
    back = loop.beta * upper - drive_of(float(upper), loop)
    if out <= 0.0:
        return 0, 0
    inside = ceil(1.2 * (2.0 + 3.0 * delay + sqrt(8.0 * (1.0 + out) / out)))
    if back > 0.0 and upper < 0:
        outside = ceil(1.2 * (2.0 + 3.0 * delay + sqrt(8.0 * (1.0 + back) / back)))
    else:
        weakest = max(0.25 * loop.beta - drive_of(float(upper), loop), 1e-12)
        outside = ceil(inside * (out / weakest + 2.0) + 3.0 * delay)
    return inside, outside


def sampled_cycles(loop: Loop, *, delay_line: int, functions: dict[str, Any]) -> list[SampledCycle] | None:
    """All one-turn two-level cycles, shortest first; None if there are more candidates than `MOST_PAIRS`.

    ``functions`` is the compiled engine. A plant without damping or hand stiffness has no isolated cycles: none.
    """
    if loop.alpha == 0.0 or loop.beta == 0.0:
        return []
    whole = max(0, delay_line - 1)
    found: list[SampledCycle] = []
    pairs = 0
    for upper, lower in level_pairs(loop, delayed=delay_line > 0):
        inside, outside = _bounds(loop, upper, lower, whole + loop.split)
        pairs += inside * outside
        if pairs > MOST_PAIRS:
            return None
        if inside == 0:
            continue
        count = inside + outside + 1
        tables = np.zeros((6, count))
        functions["hold_table"](loop.alpha, loop.beta, 0.0, count, *tables[:3])
        if loop.split > 0.0:
            functions["hold_table"](loop.alpha, loop.beta, loop.split, count, *tables[3:])
        rows = np.zeros((CAPACITY, 7))
        widest = _SHALLOW * (upper - lower) if upper == 0 else 1.5
        candidates = Candidates(float(upper), float(lower), inside, outside, whole, widest)
        number = functions["relay_cycles"](loop, candidates, tables, np.zeros(delay_line), np.zeros(4), rows)
        for within, period, highest, lowest, cycles, x, v in rows[:number].tolist():
            found.append(SampledCycle(int(within), int(period), highest, lowest, int(cycles), x, v, upper, lower))
    return sorted(found, key=lambda cycle: (cycle.period, cycle.inside, -cycle.upper, -cycle.lower))
