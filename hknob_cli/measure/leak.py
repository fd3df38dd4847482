"""Where the energy leaks in: the work of the wall, split by when it is done.

A wall that answered at once would give back what it takes: its torque depends on the angle alone, and its potential U
comes back over a cycle. What the sampled one adds, it adds late (Hasser, secs. 6.2 and 9.1):

- *late entry*: the knob is inside the wall, and no torque acts yet;
- *late exit*: the knob is outside again, and torque still acts;
- *staircase*: the knob is inside, and the torque is that of an earlier angle.

While the torque u is constant, its work less that of the wall that answers at once is u (x1 - x0) + U(x1) - U(x0), with
x clipped to the part in question: no crossing times are needed. The three add up to the work of the wall over a cycle.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Leak(NamedTuple):
    """Work of the wall over one period by when it is done, in units of J (counts per sample)²."""

    entry: float
    exit: float
    staircase: float


def potential(depth: Array, *, kappa: float, offset: float, analog: bool) -> Array:
    """Work to push the knob ``depth`` counts (m,) into a wall that answers at once; 0 outside."""
    deep = np.maximum(depth, 0.0)
    if analog:
        square: Array = 0.5 * kappa * deep * deep
        return square
    whole = np.floor(deep)
    full = whole * (0.5 * (whole + 1.0) - offset)
    found: Array = kappa * (full + (deep - whole) * (whole + 1.0 - offset))
    return found


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
    depth = edge - x
    stored = potential(depth, kappa=kappa, offset=offset, analog=analog)
    gained = stored[1:] - stored[:-1]
    deep = np.maximum(depth, 0.0)
    inside = deep[:-1] - deep[1:]
    entry = float(gained @ (torque == 0.0))
    return Leak(
        entry=entry,
        exit=float(torque @ (x[1:] - x[:-1] - inside)),
        staircase=float(torque @ inside) + (float(gained.sum()) - entry),
    )
