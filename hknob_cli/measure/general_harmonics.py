"""The harmonics of an orbit beyond the plain loop, from its pieces between events.

Over a piece z' = G z, so that the integral of exp(-iωt) z(t) is (G - iω)^-1 (exp(-iωT) z(T) - z(0)), exactly.
"""

import numpy as np

from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.search import Chart
from hknob_cli.measure.forms import generator
from hknob_cli.measure.harmonics import Complex

_BLOCK = 1 << 19  # numbers worked on at once


def of_chart(body: Body, chart: Chart, period_samples: int, count: int) -> Complex:
    """Amplitudes (count,), in counts, of the period that a chart has piece by piece."""
    m, width = len(chart.spans), body.order + 3
    before = np.zeros((m, width))
    before[:, : body.order] = chart.states[:-1]
    before[:, body.order] = 1.0
    before[:, body.order + 1] = chart.commands
    before[:, body.order + 2] = -chart.modes * body.friction
    after = before.copy()
    after[:, : body.order] = chart.states[1:]
    ends = np.cumsum(chart.spans)
    starts = ends - chart.spans
    total = np.zeros(count, dtype=np.complex128)
    w = 2.0 * np.pi / period_samples * np.arange(1, count + 1)
    for held in (False, True):
        these = (chart.modes == 0.0) == held
        if not these.any():
            continue
        # First row of (G - iω)^-1, one per harmonic: the angle's part.
        shifted = generator(body, held=held).T[None] - 1j * w[:, None, None] * np.eye(width)
        rows = np.linalg.solve(shifted, np.eye(width)[:, :1])[..., 0]
        block = max(1, _BLOCK // int(these.sum()))
        for first in range(0, count, block):
            part = slice(first, first + block)
            leaving = np.exp(-1j * np.outer(w[part], ends[these])) @ after[these]
            entering = np.exp(-1j * np.outer(w[part], starts[these])) @ before[these]
            total[part] += (rows[part] * (leaving - entering)).sum(axis=1)
    return 2.0 / period_samples * total
