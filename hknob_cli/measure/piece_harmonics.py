"""The harmonics of an orbit beyond the plain loop, from its pieces between events.

Over a piece z' = G z, so that the integral of exp(-iωt) z(t) is (G - iω)^-1 (exp(-iωT) z(T) - z(0)), exactly. Pieces
with the same G add up to a sum over the jumps of z between them: one Fourier transform of those at samples, and a
series of a few of all others.
"""

import numpy as np

from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.search import PeriodSegments
from hknob_cli.measure.behind import knob_row
from hknob_cli.measure.forms import Array, generator, piece_starts, regimes
from hknob_cli.measure.harmonics import Complex

_SAME = 1e-11  # samples; what roundings of lengths leave between a sum of them and the sample where it ends
NEGLIGIBLE = 1e-20  # term of the series of a coefficient that changes no digit of it


def of_chart(
    body: Body, chart: PeriodSegments, period_samples: int, split: float, count: int, *, behind: bool = False
) -> Complex:
    """Amplitudes (count,), in counts, of the period that a chart has piece by piece; ``split`` of the delay.

    ``behind``: of the knob behind its gear, not of the encoder.
    """
    before = piece_starts(body, chart)
    width = before.shape[1]
    after = before.copy()
    after[:, : body.order] = chart.states[1:]
    starts = np.concatenate([[0.0], np.cumsum(chart.spans)[:-1]])
    seen = knob_row(body) if behind else np.eye(width)[0]
    total = np.zeros(count, dtype=np.complex128)
    w: Array = np.asarray(2.0 * np.pi / period_samples * np.arange(1, count + 1), dtype=np.float64)
    for mask, held, teeth in regimes(chart.modes):
        these = mask[:, None]
        # The piece before the first is the last, one period ago.
        jumps = np.roll(these * after, 1, axis=0) - these * before
        # What sees the angle of (G - iω)^-1, one row per harmonic: its first.
        shifted = generator(body, held=held, teeth=teeth).T[None] - 1j * w[:, None, None] * np.eye(width)
        rows = np.linalg.solve(shifted, seen[:, None])[..., 0]
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
    if left.any():
        found += _scattered(times[left] / n, jumps[left], len(w))
    return found


def _scattered(turns: Array, jumps: Array, count: int) -> Complex:
    """Sum of jumps (m, width) times exp(-2πik turn), turns (m,) in periods: (count, width), k = 1, 2, ...

    Each jump goes to the nearest of N points of the period, and what is left of its turn into a Taylor series, one
    Fourier transform a term (Anderson & Dahleh, SIAM J. Sci. Comput. 17, 1996). Its argument is at most πk / N < π/2.
    """
    points = 1 << (2 * count).bit_length()
    at = np.rint(points * turns)
    apart, at = points * turns - at, at.astype(np.int64) % points
    step = -2.0j * np.pi / points * np.arange(1, count + 1)
    order, term = 0, 1.0
    while term > NEGLIGIBLE:
        order += 1
        term *= np.pi * count / points / order
    found = np.zeros((jumps.shape[1], count), dtype=np.complex128)
    for power in range(order, -1, -1):
        bins = np.array([np.bincount(at, one, minlength=points) for one in jumps.T * apart**power])
        found = found * (step / (power + 1)) + np.fft.rfft(bins)[:, 1 : count + 1]
    return found.T
