"""A campaign's trials as the cells of a sweep: the same columns, so that recorded and simulated knobs compare."""

from math import pi
from statistics import fmean
from typing import Any

import pyarrow as pa

from hknob_cli.results.arrays import build_table
from hknob_cli.results.columns import Column
from hknob_cli.spec.plan import COUNTS, RATE

Row = dict[str, Any]

_REAL, _WHOLE = pa.float64(), pa.int64()
COLUMNS = (
    Column(RATE, _REAL, "Hz", "sample rate"),
    Column(COUNTS, _WHOLE, "1/rev", "encoder counts per revolution"),
    Column("p2p_rad", _REAL, "rad", "mean peak minus mean trough, mean of the trials; rest counts as 0"),
    Column("rms_rad", _REAL, "rad", "root mean square about the mean, mean of the trials; rest counts as 0"),
    Column("frequency_hz", _REAL, "Hz", "cycles per second, mean of the trials; rest counts as 0"),
    Column("spectral_hz", _REAL, "Hz", "highest peak of the spectrum, mean of the trials; rest counts as 0"),
    Column("at_rest_fraction", _REAL, "1", "share of the trials without a sustained buzz"),
    Column("diverged_fraction", _REAL, "1", "share of the trials that diverge: none, for the wall is switched off"),
    Column("undecided_fraction", _REAL, "1", "share of the trials that are neither: none"),
    Column("trials", _WHOLE, "1", "trials of the cell"),
    Column("grip_mean_n", _REAL, "N", "mean grip force of the trials"),
    Column("wall_torque_nm", _REAL, "N*m", "mean torque of the wall in the trials"),
)
# The other columns of a trial.
_MEANS = {
    "p2p_rad": "p2p_rad",
    "rms_rad": "rms_rad",
    "spectral_hz": "frequency_hz",
    "grip_mean_n": "grip_mean_n",
    "wall_torque_nm": "wall_torque_nm",
}
NEEDED = (RATE, COUNTS, "sustained", "cycle_hz", "torque_hz", "native_counts", *_MEANS.values())
LEAST_COUNTS = 10.0  # of the device's own encoder: of a smaller swing it misses maxima


def campaign_cells(trials: list[Row]) -> pa.Table:
    """One row for each cell of the grid, in its order; trials that are repeated are averaged, as a sweep does phases.

    ``trials``: rows of a campaign's ``trials.parquet``. A trial is at rest if it is not sustained.
    """
    cells: dict[tuple[float, int], list[Row]] = {}
    for row in sorted(filter(_is_measured, trials), key=lambda row: (row[RATE], row[COUNTS])):
        cells.setdefault((row[RATE], row[COUNTS]), []).append(row)
    return build_table(COLUMNS, [_cell(rate, counts, same) for (rate, counts), same in cells.items()])


def _is_measured(trial: Row) -> bool:
    """Whether a trial has measures: one that could not be measured is in no cell."""
    return trial["p2p_rad"] is not None


def _cell(rate: float, counts: int, same: list[Row]) -> Row:
    row: Row = {RATE: rate, COUNTS: counts, "trials": len(same)}
    row |= {"diverged_fraction": 0.0, "undecided_fraction": 0.0}
    row["at_rest_fraction"] = sum(not one["sustained"] for one in same) / len(same)
    for name, column in _MEANS.items():
        found = [one[column] for one in same if one[column] is not None]
        row[name] = fmean(found) if found else None
    row["frequency_hz"] = fmean(_pitch(one) for one in same)
    return row


def _pitch(trial: Row) -> float:
    """Cycles per second, as a sweep counts them: local maxima, or, of a swing too small for that, rises of the torque.

    So small a swing crosses one edge of the wall's encoder, if that is the coarser, and so raises the torque once.
    """
    own = 2.0 * pi / trial["native_counts"]
    small = trial["p2p_rad"] < LEAST_COUNTS * own < 2.0 * pi / trial[COUNTS]
    return float(trial["torque_hz"] if small else trial["cycle_hz"])
