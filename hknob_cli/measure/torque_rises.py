"""How often the wall's torque rises: the pitch of a buzz that is too small for the encoder to show its maxima."""

from typing import Any

import numpy as np

Array = np.ndarray[Any, np.dtype[np.float64]]


def torque_rises_hz(time_s: Array, torque_nm: Array) -> float:
    """Rises of the commanded torque per second of some samples, arrays (n,), n >= 2 where there is any; 0 without one.

    A swing below one count of the wall's encoder crosses one edge of it, so that each cycle switches the torque on
    once: then it is cycles per second, however small they are. A wider swing has several rises a cycle. Counted from
    the first rise to the last.
    """
    rises = np.flatnonzero(np.diff(torque_nm) > 0.0) + 1
    if rises.size < 2:
        return 0.0
    return float((rises.size - 1) / (time_s[rises[-1]] - time_s[rises[0]]))
