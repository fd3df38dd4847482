"""The work of the wall by when it is done, of a motion in arrays; what that means: `engine.orbit.leak`."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hknob_cli.engine.orbit.leak import find_leak

Array = NDArray[np.float64]


class Leak(NamedTuple):
    """Work of the wall over one period by when it is done, in units of J (counts per sample)²."""

    entry: float
    exit: float
    staircase: float


def split_leak(x: Array, torque: Array, *, edge: float, kappa: float, offset: float, analog: bool = False) -> Leak:
    """Split the work of the wall.

    Args:
        x: Positions, counts (m + 1,).
        torque: What the wall's torque is between them, as an acceleration (m,).
        edge: Position below which a wall that answers at once would act.
        kappa: Stiffness of the wall, K T^2 / J.
        offset: Angle that an encoder level reports, less the level, counts.
        analog: Whether the sensor has no counts.
    """
    return Leak(*find_leak(x.tolist(), torque.tolist(), len(torque), 0.0, edge, kappa, offset, analog))
