"""The wall that host and target agreed on: the torque of every sample follows from its angle and the one before.

Source: docs/reference/wire.md, "What a target does". Angles are whole counts, so that nothing is open but the rounding
of floats.
"""

from math import tau
from typing import NamedTuple

import numpy as np

from hknob_cli.hardware.port import Array, Counts, Settings


class WallTorque(NamedTuple):
    """Torque of the wall at samples (n,), N·m; ``terms``: sizes of its parts added, which roundings are shares of.

    ``coarse``: the angle in counts of the encoder that the wall sees.
    """

    torque_nm: Array
    terms: Array
    coarse: Counts


def wall_torque(angle_counts: Counts, settings: Settings, native_counts: int, *, before: int | None) -> WallTorque:
    """Torque at these angles (n,), in counts of the device's own encoder.

    ``before``: coarse angle of the sample before the first, None where there was none.
    """
    coarse = np.floor_divide(angle_counts * settings.counts_per_rev, native_counts)
    step = np.diff(coarse, prepend=coarse[:1] if before is None else before)
    quantum = tau / settings.counts_per_rev
    spring = -settings.wall_stiffness * coarse * quantum
    damper = -settings.wall_damping * step * quantum / settings.interval_s
    limit = settings.torque_limit_nm
    inside = coarse < 0
    torque = np.where(inside, np.clip(spring + damper, -limit, limit), 0.0)
    return WallTorque(torque, np.where(inside, np.abs(spring) + np.abs(damper), 0.0), coarse)
