"""What makes a record with a continuous excitation suspicious: gaps, no torque, no motion, other counts than stated."""

import math
from collections.abc import Iterator

import numpy as np

from hknob_cli.recordings.health import FEWEST_COUNTS, FINER, clock_flags
from hknob_cli.recordings.plateau import quantum
from hknob_cli.recordings.trial import Trial


def running_flags(trial: Trial, *, counts_per_rev: float | None = None) -> tuple[str, ...]:
    """What is suspicious about a record, a short sentence each; none if nothing is. As `health.flags` of a pulse."""
    return (*clock_flags(trial, None), *_sizes(trial, counts_per_rev))


def _sizes(trial: Trial, counts_per_rev: float | None) -> Iterator[str]:
    if not np.any(trial.torque_nm):
        yield "the torque is zero throughout"
    elif np.ptp(trial.torque_nm) == 0.0:
        yield "the torque never changes: inertia shows only where the motion begins"
    moved = float(np.ptp(trial.angle_rad))
    if moved == 0.0:
        yield "the angle never changes"
        return
    finest = quantum(trial.angle_rad)
    step = finest if counts_per_rev is None else 2.0 * math.pi / counts_per_rev
    if 0.0 < finest < FINER * step:
        yield f"the angle changes by {finest:.2g} rad, less than a count of {step:.2g} rad: is counts_per_rev right?"
    if step > 0.0 and moved / step < FEWEST_COUNTS:
        yield f"encoder too coarse: the motion is {moved / step:.1f} counts, fewer than {FEWEST_COUNTS}"
