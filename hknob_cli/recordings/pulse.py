"""The torque pulse of a trial: where it begins and ends, by the commanded torque."""

from typing import NamedTuple

import numpy as np

from hknob_cli.recordings.trial import Array

# A command is part of the pulse from this share of its peak on: a real pulse is square, zero around it.
SHARE = 0.1


class Pulse(NamedTuple):
    """First pulse of a trial.

    ``onset``: first sample with torque, which acts from it on, so that the knob is still at rest there; ``end``: first
    sample after the pulse, the number of samples if it never ends; ``torque_nm``: its mean torque, with sign;
    ``others``: further pulses after it.
    """

    onset: int
    end: int
    torque_nm: float
    others: int


def find_pulse(torque_nm: Array) -> Pulse | None:
    """First pulse of a commanded torque; None if it never leaves zero."""
    size = np.abs(torque_nm)
    peak = float(size.max(initial=0.0))
    if peak == 0.0:
        return None
    edges = np.flatnonzero(np.diff(np.concatenate([[0], size > SHARE * peak, [0]]).astype(np.int8)))
    onset, end = int(edges[0]), int(edges[1])
    return Pulse(onset, end, float(torque_nm[onset:end].mean()), edges.size // 2 - 1)
