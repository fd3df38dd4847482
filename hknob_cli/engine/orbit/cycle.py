"""The measures of one period of an orbit, in counts and samples: how far it swings, and what it does with energy."""

from math import sqrt

from hknob_cli.engine.orbit.energy import wall_work
from hknob_cli.engine.orbit.extrema import find_extrema
from hknob_cli.engine.orbit.holds import LENGTH, fill_parts
from hknob_cli.engine.orbit.leak import find_leak
from hknob_cli.engine.orbit.moments import find_moments
from hknob_cli.engine.trace import holds_per_sample, trace


def measure_holds(x, v, drive, n, parts, kinds, alpha, beta):
    """Measures of ``n`` samples of ``kinds`` holds each, whose end is their start.

    ``x``, ``v``: state at the start of each hold and, last, at the end; ``drive``: the constant acceleration in each;
    ``parts``: numbers of the kinds of holds, `orbit.holds`. Returns ``(cycles, swing, lowest, highest, rms, work,
    loss)``: local maxima; their mean less that of the minima; least and largest position; root mean square about the
    mean; work of the wall and loss in the damping, in units of J (counts per sample)². Nothing turns: no cycles.
    """
    count = n * kinds
    reference = 0.0
    for i in range(count):
        reference += x[i]
    reference /= count
    peaks, peak_sum, highest, troughs, trough_sum, lowest = find_extrema(
        x, v, drive, count, parts, kinds, alpha, beta, reference
    )
    if peaks == 0 or troughs == 0:
        none = float("nan")
        return 0, none, none, none, none, none, none
    total, square, speed = find_moments(x, v, drive, count, parts, kinds, beta, reference)
    mean = total / n
    return (
        peaks,
        peak_sum / peaks - trough_sum / troughs,
        reference + lowest,
        reference + highest,
        sqrt(max(square / n - mean * mean, 0.0)),
        wall_work(x, v, drive, count, parts, kinds, beta),
        alpha * speed,
    )


def measure_cycle(x, v, ring, head, n, loop, parts, xs, vs, drive):
    """Measures of the orbit of ``n`` samples through ``(x, v)``, as `measure_holds`, and the leak, as `find_leak`.

    ``ring``, ``head``: the delay line there. ``parts`` is filled in if it is empty, its first number 0; ``xs``, ``vs``
    and ``drive`` are work space, as `trace` takes it.
    """
    if parts[LENGTH] == 0.0:
        fill_parts(parts, loop)
    trace(x, v, ring, head, n, loop, xs, vs, drive)
    kinds = holds_per_sample(loop)
    found = measure_holds(xs, vs, drive, n, parts, kinds, loop.alpha, loop.beta)
    edge = 0.0 if loop.sense > 0.0 else -1.0
    return (*found, *find_leak(xs, drive, n * kinds, loop.gamma, edge, loop.kappa, loop.offset, False))
