"""One whole period of a recorded trial that has settled to a proven cycle."""

import numpy as np

from hknob_cli.figures.recording import At, Recording, one_recording
from hknob_cli.results.result_set import MissingError, ResultSet

CLOSE = 1e-3  # of the swing: how far two periods in a row may be apart, 60 dB below the cycle


def settled_period(evidence: ResultSet, of: str, *, at: At | None = None) -> Recording:
    """The last whole period of the only such recording, from sample to sample, both ends among its rows.

    The period is the shortest of the cell's proven cycles by which the last samples repeat. Raises `MissingError` where
    there is no such cycle, or the trial has not come close to it by the end.
    """
    one = one_recording(evidence, of, at=at)
    orbits = evidence[of].rows("orbits")
    cell = {axis: one.cell[axis] for axis in evidence[of].axes}
    periods = sorted(
        {
            row["period_samples"]
            for row in orbits
            if row["outcome"] == "cycle" and all(row[axis] == value for axis, value in cell.items())
        }
    )
    samples = np.flatnonzero(one.samples)
    angles = one.angle[samples]
    for n in periods:
        if len(angles) > 2 * n:
            last = angles[-n:]
            if np.abs(last - angles[-2 * n : -n]).max() <= CLOSE * (np.ptp(last) or 1.0):
                begin, end = samples[-n - 1], samples[-1]
                return one.between(float(one.time[begin]), float(one.time[end]))
    raise MissingError(f"the recording of '{of}' ends before it repeats itself as one of its proven cycles does")
