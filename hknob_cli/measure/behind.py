"""How far the knob behind a gear that yields swings, which a hand feels, and what the mesh carries.

The knob is the second body, at x - d, and the mesh carries k d + c d', on the other flank of a backlash k (d + play) +
c d', and between them nothing. Where it carries a torque one way all the time, the teeth stay on one flank: the motion
is one of the same gear with any backlash, too. A piece of motion between events is cut into steps of
a part of the fastest mode, and each turn of the number in question is refined by Newton's method on the exact motion:
z' = G z.
"""

from collections.abc import Callable
from math import ceil, nan

import numpy as np
from numpy.typing import NDArray

from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.search import PeriodSegments
from hknob_cli.engine.general.teeth import APART, BACK
from hknob_cli.measure.forms import WALL, generator, piece_starts, regimes

Array = NDArray[np.float64]

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
