"""An orbit beyond the plain loop, from its pieces between events: its harmonics, and swings behind a gear that yields.

Behind such a gear the knob, which a hand feels, is the second body, at x - d, and the mesh carries k d + c d', on the
other flank of a backlash k (d + play) + c d', and between them nothing. Where it carries a torque one way all the time,
the teeth stay on one flank: the motion is one of the same gear with any backlash, too. A piece of motion between events
is cut into steps of a part of the fastest mode, and each turn of the number in question is refined by Newton's method
on the exact motion: z' = G z.

Over a piece z' = G z, so that the integral of exp(-iωt) z(t) is (G - iω)^-1 (exp(-iωT) z(T) - z(0)), exactly. Pieces
with the same G add up to a sum over the jumps of z between them. One Fourier transform sums those at the same part of
an interval, as torques and looks have it, and a series of a few all others.
"""

from collections.abc import Callable
from math import ceil, nan

import numpy as np

from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.search import PeriodSegments
from hknob_cli.engine.general.teeth import APART, BACK
from hknob_cli.measure.forms import WALL, Array, generator, piece_starts, regimes
from hknob_cli.measure.orbit import Complex

PART = 0.2  # of the fastest mode's time, a step
MOST_NUMBERS = 20_000_000  # steps times pieces of an orbit; beyond, no extremes
_TERMS = 24  # of the series of exp over a step, whose generator has a norm of PART at most
_NEWTON = 6


def knob_row(body: Body, teeth: int = WALL) -> Array:
    """What makes the angle of the knob of a vector (z, 1, u, f), in counts: (order + 3,); the same on all ``teeth``."""
    del teeth
    row = np.zeros(body.order + 3)
    row[0], row[2] = 1.0, -1.0
    return row


def mesh_row(body: Body, teeth: int = WALL) -> Array:
    """What makes the torque of the mesh on the knob, as an acceleration of the motor, of such a vector."""
    row = np.zeros(body.order + 3)
    if teeth != APART:
        row[2], row[3] = body.pad_stiffness, body.pad_damping
    if teeth == BACK:
        row[body.order] = body.pad_stiffness * body.play
    return row


def extremes(body: Body, chart: PeriodSegments, row_of: Callable[[Body, int], Array]) -> tuple[float, float]:
    """Smallest and largest value over a period of (z, 1, u, f) times what ``row_of`` says for the teeth.

    NaN of a period with too many pieces.
    """
    start = piece_starts(body, chart)
    width = start.shape[1]
    found: list[float] = []
    if body.play == 0.0:
        found = [float(value) for value in chart.states @ row_of(body, WALL)[: body.order]]
    for these, held, teeth, slope in regimes(chart.modes):
        g, row = generator(body, held=held, teeth=teeth, slope=slope), row_of(body, teeth)
        if body.play > 0.0:
            for states in (chart.states[:-1][these], chart.states[1:][these]):
                found += [float(value) for value in states @ row[: body.order] + row[body.order]]
        pace = float(np.abs(_balanced(g)).sum(axis=1).max())
        steps = max(1, ceil(float(chart.spans[these].max()) * pace / PART))
        if steps * int(these.sum()) * width > MOST_NUMBERS:
            return nan, nan
        found += _turns(g, row, start[these], chart.spans[these] / steps, steps)
    return min(found), max(found)


def _turns(g: Array, row: Array, state: Array, step: Array, steps: int) -> list[float]:
    """Values where pieces that begin at ``state`` (m, w) turn round, in ``steps`` steps of ``step`` (m,) each."""
    over = _exponential(g, step)
    found: list[float] = []
    for _ in range(steps):
        then = np.einsum("mij,mj->mi", over, state)
        before, after = state @ g.T @ row, then @ g.T @ row
        turning = before * after < 0.0
        if turning.any():
            found += _refined(g, row, state[turning], step[turning], before[turning], after[turning])
        state = then
    return found


def _refined(g: Array, row: Array, state: Array, step: Array, before: Array, after: Array) -> list[float]:
    """Values at the zero of their rate within each step: Newton's method, from the chord."""
    t = step * before / (before - after)
    for _ in range(_NEWTON):
        at = np.einsum("mij,mj->mi", _exponential(g, t), state)
        rate = at @ g.T
        t = np.clip(t - (rate @ row) / (rate @ g.T @ row), 0.0, step)
    at = np.einsum("mij,mj->mi", _exponential(g, t), state)
    return [float(value) for value in at @ row]


def _exponential(g: Array, t: Array) -> Array:
    """exp(g t) of short times (m,): (m, w, w)."""
    total = term = np.broadcast_to(np.eye(len(g)), (len(t), *g.shape))
    for k in range(1, _TERMS):
        term = np.einsum("mij,jk->mik", term, g) * (t / k)[:, None, None]
        total = total + term
    return np.asarray(total)


def _balanced(g: Array) -> Array:
    """The generator with its entries' sizes evened out, as far as powers of 2 do it: what paces it, in any unit."""
    sizes = np.abs(g)
    scale = np.ones(len(g))
    for _ in range(60):
        rows = (sizes * scale[None, :] / scale[:, None]).sum(axis=1)
        columns = (sizes * scale[None, :] / scale[:, None]).sum(axis=0)
        both = (rows > 0.0) & (columns > 0.0)
        factor = np.ones(len(g))
        factor[both] = np.exp2(np.rint(0.5 * np.log2(rows[both] / columns[both])))
        if (factor == 1.0).all():
            break
        scale = scale * factor
    return np.asarray(g * scale[None, :] / scale[:, None])


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
