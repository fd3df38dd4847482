"""The trials of a campaign as cells of a sweep: the same columns, so that recorded and simulated knobs compare.

Terminal, pictures and page read these cells, so that a size and a pitch mean the same in all of them.
"""

from collections.abc import Sequence
from statistics import fmean
from typing import Any

import pyarrow as pa

from hknob_cli.results.arrays import build_table
from hknob_cli.results.columns import Column
from hknob_cli.specs.plan import COUNTS, RATE

Row = dict[str, Any]

_REAL, _WHOLE = pa.float64(), pa.int64()
COLUMNS = (
    Column(RATE, _REAL, "Hz", "sample rate"),
    Column(COUNTS, _WHOLE, "1/rev", "encoder counts per revolution"),
    Column("p2p_rad", _REAL, "rad", "mean peak minus mean trough, mean of the trials that buzz; null where none does"),
    Column("p2p_max_rad", _REAL, "rad", "peak to peak of the trial that buzzes most; 0 where none does"),
    Column("rms_rad", _REAL, "rad", "root mean square about the mean, mean of the trials that buzz"),
    Column("frequency_hz", _REAL, "Hz", "cycles per second, mean of the trials that buzz; null where none does"),
    Column("frequency_at_max_hz", _REAL, "Hz", "frequency_hz of the trial that buzzes most; null where none does"),
    Column("spectral_hz", _REAL, "Hz", "highest peak of the spectrum, mean of the trials that buzz"),
    Column("at_rest_fraction", _REAL, "1", "share of the trials without a sustained buzz"),
    Column("diverged_fraction", _REAL, "1", "share of the trials that diverge: none, for the wall is switched off"),
    Column("undecided_fraction", _REAL, "1", "share of the trials that are neither: none"),
    Column("trials", _WHOLE, "1", "trials of the cell"),
    Column("sustained", _WHOLE, "1", "trials that buzz: whose buzz is sustained"),
    Column("at_rest", _WHOLE, "1", "trials that ended because the knob rested"),
    Column("grip_mean_n", _REAL, "N", "mean grip force of the trials"),
    Column("wall_torque_nm", _REAL, "N*m", "mean torque of the wall in the trials"),
)
_BUZZING = ("p2p_rad", "rms_rad", "frequency_hz", "spectral_hz")  # means of the trials that buzz
_EVERY = ("grip_mean_n", "wall_torque_nm")  # of all trials
NEEDED = (RATE, COUNTS, "sustained", "ended", *_BUZZING, *_EVERY)  # columns of trials
_AT_REST = "rest"  # why such a trial ended


def campaign_cells(trials: Sequence[Row]) -> pa.Table:
    """One row for each cell of the grid, in its order; ``trials``: rows of a campaign's ``trials.parquet``."""
    return build_table(COLUMNS, cell_rows(trials))


def cell_rows(trials: Sequence[Row]) -> list[Row]:
    """The same as rows. A trial whose buzz is not sustained is in no size and in no pitch."""
    cells: dict[tuple[float, int], list[Row]] = {}
    for row in sorted(filter(_is_measured, trials), key=lambda row: (row[RATE], row[COUNTS])):
        cells.setdefault((row[RATE], row[COUNTS]), []).append(row)
    return [_cell(rate, counts, same) for (rate, counts), same in cells.items()]


def _is_measured(trial: Row) -> bool:
    """Whether a trial has measures: one that could not be measured is in no cell."""
    return trial["p2p_rad"] is not None


def _cell(rate: float, counts: int, same: list[Row]) -> Row:
    buzzing = [one for one in same if one["sustained"]]
    most = max(buzzing, key=lambda one: one["p2p_rad"], default=None)
    return {
        RATE: rate,
        COUNTS: counts,
        **{name: _mean(buzzing, name) for name in _BUZZING},
        "p2p_max_rad": most["p2p_rad"] if most else 0.0,
        "frequency_at_max_hz": most["frequency_hz"] if most else None,
        "at_rest_fraction": 1.0 - len(buzzing) / len(same),
        "diverged_fraction": 0.0,
        "undecided_fraction": 0.0,
        "trials": len(same),
        "sustained": len(buzzing),
        "at_rest": sum(one["ended"] == _AT_REST and not one["sustained"] for one in same),
        **{name: _mean(same, name) for name in _EVERY},
    }


def _mean(trials: list[Row], name: str) -> float | None:
    found = [one[name] for one in trials if one[name] is not None]
    return fmean(found) if found else None
