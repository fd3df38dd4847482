"""The harmonics of an orbit beyond the plain loop, from its pieces between events.

Over a piece z' = G z, so that the integral of exp(-iωt) z(t) is (G - iω)^-1 (exp(-iωT) z(T) - z(0)), exactly. Pieces
with the same G add up to a sum over the jumps of z between them. One Fourier transform sums those at the same part of
an interval, as torques and looks have it, and a series of a few all others.
"""

import numpy as np

from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.search import PeriodSegments
from hknob_cli.measure.behind import knob_row
from hknob_cli.measure.forms import Array, generator, piece_starts, regimes
from hknob_cli.measure.harmonics import Complex

_SAME = 1e-11  # samples; what roundings of lengths leave between a sum of them and the sample where it ends
_MANY = 8  # parts of an interval that may have a Fourier transform of their own, at most
NEGLIGIBLE = 1e-20  # term of the series of a coefficient that changes no digit of it


def of_chart(body: Body, chart: PeriodSegments, period_samples: int, count: int, *, behind: bool = False) -> Complex:
    """Amplitudes (count,), in counts, of the period that a chart has piece by piece.

    ``behind``: of the knob behind its gear, not of the encoder.
    """
    before = piece_starts(body, chart)
    after = before.copy()
    after[:, : body.order] = chart.states[1:]
    starts = np.concatenate([[0.0], np.cumsum(chart.spans)[:-1]])
    seen = knob_row(body)[: body.order] if behind else np.eye(body.order)[0]
    total = np.zeros(count, dtype=np.complex128)
    w: Array = np.asarray(2.0 * np.pi / period_samples * np.arange(1, count + 1), dtype=np.float64)
    for mask, held, teeth, slope in regimes(chart.modes):
        these = mask[:, None]
        # The piece before the first is the last, one period ago.
        jumps = np.roll(these * after, 1, axis=0) - these * before
        moved = jumps.any(axis=0)
        rows = _sight(generator(body, held=held, teeth=teeth, slope=slope), seen, w)[:, moved]
        total += (rows * _transform(starts, jumps[:, moved], period_samples, w)).sum(axis=1)
    return 2.0 / period_samples * total


def _sight(g: Array, seen: Array, w: Array) -> Complex:
    """What sees the angle, ``seen`` (n,) of the state, of (G - iω)^-1: (len(w), n + 3).

    Only the state moves: with G = (A B; 0 0) the row is seen (A - iω)^-1 of it, and B / iω times that of the rest.
    """
    n = len(seen)
    shifted = g[:n, :n].T[None] - 1j * w[:, None, None] * np.eye(n)
    state = np.linalg.solve(shifted, seen[:, None])[..., 0]
    return np.concatenate([state, state @ g[:n, n:] / (1j * w[:, None])], axis=1)


def _transform(times: Array, jumps: Array, n: int, w: Array) -> Complex:
    """Sum of jumps (m, width) times exp(-iωt) of their times: (len(w), width), ω = 2πk/n, k = 1, 2, ..."""
    some = jumps.any(axis=1)
    times, jumps = times[some], jumps[some]
    found = np.zeros((len(w), jumps.shape[1]), dtype=np.complex128)
    parts = times - np.rint(times)
    left = np.ones(len(times), dtype=bool)
    for offset in _shared(parts):
        there = left & (np.abs(parts - offset) <= _SAME)
        bins = np.zeros((n, jumps.shape[1]))
        np.add.at(bins, np.rint(times[there] - offset).astype(np.int64) % n, jumps[there])
        found += np.fft.fft(bins, axis=0)[np.arange(1, len(w) + 1) % n] * np.exp(-1j * offset * w)[:, None]
        left &= ~there
    if left.any():
        found += _scattered(times[left] / n, jumps[left], len(w))
    return found


def _shared(parts: Array) -> list[float]:
    """Samples themselves, and parts of an interval that so many of the times have that a transform is worth it."""
    _, which, counts = np.unique(np.rint(parts / _SAME), return_inverse=True, return_counts=True)
    means = np.bincount(which, parts) / counts
    often = means[(counts * _MANY >= len(parts)) & (np.abs(means) > _SAME)]
    return [0.0, *(float(mean) for mean in often)]


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
