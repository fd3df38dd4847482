"""The harmonics of an orbit beyond the plain loop, from its pieces between events.

Over a piece z' = G z, so that the integral of exp(-iωt) z(t) is (G - iω)^-1 (exp(-iωT) z(T) - z(0)), exactly. Pieces
with the same G add up to a sum over the jumps of z between them, of which those at samples are one Fourier transform.
"""

import numpy as np

from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.search import PeriodSegments
from hknob_cli.measure.forms import generator
from hknob_cli.measure.harmonics import Array, Complex

MOST_WORK = 400_000_000  # pieces times harmonics of an orbit, some seconds
_BLOCK = 1 << 19  # numbers worked on at once
_SAME = 1e-11  # samples; what roundings of lengths leave between a sum of them and the sample where it ends


def of_chart(body: Body, chart: PeriodSegments, period_samples: int, split: float, count: int) -> Complex:
    """Amplitudes (count,), in counts, of the period that a chart has piece by piece; ``split`` of the delay."""
    m, width = len(chart.spans), body.order + 3
    before = np.zeros((m, width))
    before[:, : body.order] = chart.states[:-1]
    before[:, body.order] = 1.0
    before[:, body.order + 1] = chart.commands
    before[:, body.order + 2] = -chart.modes * body.friction
    after = before.copy()
    after[:, : body.order] = chart.states[1:]
    starts = np.concatenate([[0.0], np.cumsum(chart.spans)[:-1]])
    total = np.zeros(count, dtype=np.complex128)
    w: Array = np.asarray(2.0 * np.pi / period_samples * np.arange(1, count + 1), dtype=np.float64)
    for held in (False, True):
        these = ((chart.modes == 0.0) == held)[:, None]
        if not these.any():
            continue
        # The piece before the first is the last, one period ago.
        jumps = np.roll(these * after, 1, axis=0) - these * before
        # First row of (G - iω)^-1, one per harmonic: the angle's part.
        shifted = generator(body, held=held).T[None] - 1j * w[:, None, None] * np.eye(width)
        rows = np.linalg.solve(shifted, np.eye(width)[:, :1])[..., 0]
        total += (rows * _transform(starts, jumps, period_samples, split, w)).sum(axis=1)
    return 2.0 / period_samples * total


def _transform(times: Array, jumps: Array, n: int, split: float, w: Array) -> Complex:
    """Sum of jumps (m, width) times exp(-iωt) of their times: (len(w), width), ω = 2πk/n, k = 1, 2, ..."""
    some = jumps.any(axis=1)
    times, jumps = times[some], jumps[some]
    found = np.zeros((len(w), jumps.shape[1]), dtype=np.complex128)
    left = np.ones(len(times), dtype=bool)
    for offset in (0.0, split) if split > 0.0 else (0.0,):
        at = np.rint(times - offset)
        there = left & (np.abs(times - offset - at) <= _SAME)
        bins = np.zeros((n, jumps.shape[1]))
        np.add.at(bins, at[there].astype(np.int64) % n, jumps[there])
        found += np.fft.fft(bins, axis=0)[np.arange(1, len(w) + 1) % n] * np.exp(-1j * offset * w)[:, None]
        left &= ~there
    block = max(1, _BLOCK // max(1, int(left.sum())))
    for first in range(0, len(w) if left.any() else 0, block):
        part = slice(first, first + block)
        # Not a matrix product, whose last digit may depend on the number of threads.
        found[part] += np.einsum("ij,jk->ik", np.exp(-1j * np.outer(w[part], times[left])), jumps[left])
    return found
