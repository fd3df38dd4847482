"""One recorded trial, and the keys that say of whom and when it is."""

from typing import Any, NamedTuple

import numpy as np

Array = np.ndarray[Any, np.dtype[np.float64]]


class Key(NamedTuple):
    """What tells trials apart: person, experiment (grasp and knob), target of the grip force (N), block, trial."""

    subject: str
    experiment: str
    grip_target_n: float
    block: int
    trial: int


class Trial(NamedTuple):
    """Samples of one trial, all arrays of one length.

    ``time_s`` rises; ``torque_nm`` is commanded, positive as ``angle_rad``; ``measured_torque_nm`` where there is a
    torque sensor; ``grip_n`` is NaN where there is no grip cell. ``notes``: what is surprising about its numbers.
    ``source`` and ``first_row`` say where it was read (rows count from 1 below the header of a file).
    """

    key: Key
    time_s: Array
    torque_nm: Array
    angle_rad: Array
    grip_n: Array
    measured_torque_nm: Array | None = None
    source: str = ""
    first_row: int = 1
    notes: tuple[str, ...] = ()
