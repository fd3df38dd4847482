"""The measures of one period of an orbit, in counts and samples: how far it swings, and what it does with energy."""

from math import sqrt
from typing import NamedTuple

from hknob_cli.engine.orbit.extrema import find_extrema
from hknob_cli.engine.orbit.holds import LENGTH, fill_parts
from hknob_cli.engine.orbit.integrals import find_integrals
from hknob_cli.engine.orbit.leak import find_leak
from hknob_cli.engine.trace import holds_per_sample, trace


class CycleMeasures(NamedTuple):
    """Measures of one period of an orbit, in counts and samples.

    ``cycles``: local maxima; ``swing``: their mean less that of the minima; ``lowest``, ``highest``: extremes of the
    position, and ``rms`` about its mean. In units of J (counts per sample)²: ``wall_work``, ``damping_loss``, and the
    work of the wall by when it is done (`engine.orbit.leak`).
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
    the kinds of holds, `orbit.holds`. Returns the first seven of `CycleMeasures`; without cycles where nothing turns.
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
