"""Motion under a controller, by the general loop's own intervals, in the interpreter."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hknob_cli.engine.general.laws.law import Law
from hknob_cli.engine.general.laws.step import advance_with_law


def states_with_law(knob: Any, law: Law, z: list[float], past: list[float], samples: int) -> NDArray[np.float64]:
    """States at so many samples and one more, (samples + 1, order); ``z`` and ``past`` go on with them."""
    n = knob.body.order
    pad, states = [0.0] * (2 * n), [list(z[:n])]
    for _ in range(samples):
        advance_with_law(z, past, knob.body, knob.wall, law, pad)
        states.append(list(z[:n]))
    return np.array(states)
