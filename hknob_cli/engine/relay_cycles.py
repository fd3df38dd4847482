"""Every cycle of the sampled relay between two levels: n samples inside, m outside, solved exactly and checked.

While the knob crosses one edge of the encoder once in and once out per cycle, the loop is a relay. For each pair of
sample counts the periodic motion is known in closed form; it is a cycle of the sampled system if the samples lie on the
sides they were assumed on. Of the candidates that pass at the four samples beside the crossings, `certificate.certify`
proves or refuses each.
"""

from typing import NamedTuple

from hknob_cli.engine.certificate import PROVEN, certify
from hknob_cli.engine.loop import drive_of, level_of
from hknob_cli.engine.propagator import hold_coefficients
from hknob_cli.engine.turning import first_zero, zero_spacing


class Candidates(NamedTuple):
    """Cycles that are looked for: between two levels, with at most so many samples inside and outside.

    ``whole``: the delay in whole samples, of which the loop's split is the rest; ``widest``: a bound on the mean
    position above the edge, in counts.
    """

    upper: float
    lower: float
    most_in: int
    most_out: int
    whole: int
    widest: float


def hold_table(alpha, beta, fraction, count, s, g, f):
    """Fill coefficients of holds lasting 0, 1, ... samples, less ``fraction`` (the first one never is)."""
    for t in range(count):
        s[t], g[t], f[t] = hold_coefficients(alpha, beta, max(t - fraction, 0.0))


def held(x, v, drive, t, beta, s, g, f):
    """State after a hold of table entry ``t``."""
    y = drive - beta * x
    return x + (s[t] * v + g[t] * y), f[t] * v + s[t] * y


def turning_points(x, v, drive, span, loop, sums):
    """Add the turning points of one hold to ``sums``: maxima's sum and count, then minima's."""
    t = first_zero(v, drive - loop.beta * x, loop.alpha, loop.beta)
    up = v > 0.0 or (v == 0.0 and drive - loop.beta * x > 0.0)
    step = zero_spacing(loop.alpha, loop.beta)
    while t < span:
        s, g, _ = hold_coefficients(loop.alpha, loop.beta, t)
        at = x + (s * v + g * (drive - loop.beta * x))
        if up:
            sums[0] += at
            sums[1] += 1.0
        else:
            sums[2] += at
            sums[3] += 1.0
        up = not up
        t += step


def relay_cycles(loop, candidates, tables, ring, sums, found):
    """Find cycles that alternate between two levels.

    ``tables``: six rows of hold coefficients for whole and for delayed times, long enough for the longest of the
    ``candidates``; ``sums``: work space for four numbers. Each cycle fills a row of ``found``: samples inside, samples
    in all, mean maximum, mean minimum, maxima per period, x, v at the first sample inside. Returns the number of
    cycles, at most as many as there are rows.
    """
    upper, lower, most_in, most_out, whole, widest = candidates
    beta = loop.beta
    s, g, f, sd, gd, fd = tables[0], tables[1], tables[2], tables[3], tables[4], tables[5]
    push_out, push_in = drive_of(lower, loop), drive_of(upper, loop)
    delay = len(ring)
    split = loop.split > 0.0
    cycles = 0
    for inside in range(1, most_in + 1):
        for outside in range(1, most_out + 1):
            n = inside + outside
            # The mean torque is carried by the hand at a mean position between the levels.
            mean = inside * push_out + outside * push_in
            if mean < beta * n * (lower - 0.5):
                break
            if mean > beta * n * (upper + widest):
                continue
            zx, zv = held(0.0, 0.0, push_out, inside, beta, s, g, f)
            zx, zv = held(zx, zv, push_in, outside, beta, s, g, f)
            p = beta * g[n]
            q = p + loop.alpha * s[n]
            det = p * q + beta * s[n] * s[n]
            ax, av = (q * zx + s[n] * zv) / det, (p * zv - beta * s[n] * zx) / det
            bx, bv = held(ax, av, push_out, inside, beta, s, g, f)
            fits = True
            x0, v0 = 0.0, 0.0
            for case in range(4):
                j = 0 if case == 0 else inside - 1 if case == 1 else inside if case == 2 else n - 1
                at = (j - whole) % n
                if split:
                    at = at if at > 0 else n
                    if at <= inside:
                        x, v = held(ax, av, push_out, at, beta, sd, gd, fd)
                    else:
                        x, v = held(bx, bv, push_in, at - inside, beta, sd, gd, fd)
                elif at < inside:
                    x, v = held(ax, av, push_out, at, beta, s, g, f)
                else:
                    x, v = held(bx, bv, push_in, at - inside, beta, s, g, f)
                if case == 0:
                    x0, v0 = x, v
                if level_of(x, loop.sense) != (lower if case < 2 else upper):
                    fits = False
                    break
            if not fits:
                continue
            for k in range(delay):
                ring[k] = lower if (k - delay) % n < inside else upper
            status, ox, ov, _, _, _, _ = certify(x0, v0, ring, 0, n, loop)
            if status != PROVEN:
                continue
            if cycles == len(found):
                return cycles
            for k in range(4):
                sums[k] = 0.0
            turning_points(ax, av, push_out, float(inside), loop, sums)
            turning_points(bx, bv, push_in, float(outside), loop, sums)
            row = found[cycles]
            row[0], row[1] = inside, n
            row[2] = sums[0] / sums[1] if sums[1] > 0.0 else 0.0
            row[3] = sums[2] / sums[3] if sums[3] > 0.0 else 0.0
            row[4] = sums[1]
            row[5], row[6] = ox, ov
            cycles += 1
    return cycles
