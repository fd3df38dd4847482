"""The files of a campaign: their columns, of the wall or of pulses, and its trials as cells of a sweep.

The trials of a campaign as cells of a sweep: the same columns, so that recorded and simulated knobs compare.

Terminal, pictures and page read these cells, so that a size and a pitch mean the same in all of them.
"""

from collections.abc import Sequence
from statistics import fmean
from typing import Any

import pyarrow as pa

from hknob_cli.results.arrays import build_table
from hknob_cli.results.columns import Column
from hknob_cli.specs.plan import COUNTS, RATE

_REAL, _WHOLE, _TEXT, _FLAG = pa.float64(), pa.int64(), pa.string(), pa.bool_()

CELL = (
    Column(RATE, _REAL, "Hz", "sample rate of the trial"),
    Column(COUNTS, _WHOLE, "1/rev", "encoder counts per revolution that the wall sees"),
)
# Beside those of a recording.
MORE_SAMPLES = (
    *CELL,
    Column("sample", _WHOLE, "1", "index of the sample since arming, by the device"),
    Column("device_time_us", _WHOLE, "us", "time since arming, by the device's clock"),
    Column("angle_counts", _WHOLE, "count", "angle in counts of the device's own encoder"),
    Column("running", _FLAG, "", "whether the wall was on"),
)
# Of a device with an accelerometer.
ACCELERATION = Column("acceleration_rad_s2", _REAL, "rad/s^2", "measured angular acceleration, at the sample")
TRIAL_KEYS = (
    Column("order", _WHOLE, "1", "number of the trial, in the order they were run"),
    Column("block", _WHOLE, "1", "how often the grid was gone through, from 1"),
    *CELL,
)
TRIALS = (
    *TRIAL_KEYS,
    Column(
        "sustained",
        _FLAG,
        "",
        "whether the torque changed at least every 50 ms for as long as the least buzz asked for (1 s), without a "
        "break, anywhere in the trial",
    ),
    Column("p2p_rad", _REAL, "rad", "mean local maximum minus mean local minimum of the steady part; 0 at rest"),
    Column("rms_rad", _REAL, "rad", "root mean square about the mean of the steady part; 0 at rest"),
    Column(
        "frequency_hz",
        _REAL,
        "Hz",
        "cycles per second of the steady part, as a sweep counts them: cycle_hz, or torque_hz where the swing is below "
        "ten counts of the device's own encoder, of which it misses maxima; 0 at rest",
    ),
    Column(
        "spectral_hz", _REAL, "Hz", "principal frequency, the highest peak of the steady part's spectrum; 0 at rest"
    ),
    Column("cycle_hz", _REAL, "Hz", "local maxima per second of the steady part; 0 at rest"),
    Column("torque_hz", _REAL, "Hz", "rises of the torque per second, one a cycle below a count in size; 0 at rest"),
    Column("grip_mean_n", _REAL, "N", "mean grip force of the steady part"),
    Column("grip_std_n", _REAL, "N", "standard deviation of the grip force in the steady part"),
    Column("grip_zero_n", _REAL, "N", "what the grip cell showed before the start, subtracted"),
    Column("wall_torque_nm", _REAL, "N*m", "mean torque of the wall in the steady part: what hand and push hold it by"),
    Column("ended", _TEXT, "", "why it ended: buzz, rest, longest, operator, over"),
    Column("settled_s", _REAL, "s", "from the start until the grip counted as held; null if it never did"),
    Column("steady_s", _REAL, "s", "length of the steady part"),
    Column("steady_first", _WHOLE, "1", "row of the trial at which the steady part begins, from 0"),
    Column("steady_last", _WHOLE, "1", "row of the trial at which it ends"),
    Column("samples", _WHOLE, "1", "samples received"),
    Column("gaps", _WHOLE, "1", "samples whose index is missing"),
    Column("overruns", _WHOLE, "1", "samples for which the device's loop was late"),
    Column("fault", _TEXT, "", "what is doubtful about it, in words; empty where nothing is"),
    Column("device", _TEXT, "", "what the device calls itself"),
    Column("native_counts", _WHOLE, "1/rev", "counts per revolution of the device's own encoder"),
)
# Where a controller, or a trial of remedies, is asked for.
CONTROLLED = (Column("controller", _TEXT, "", "what acts in place of the wall's spring, or beside it, in SI units"),)
# Where there is a torque over the angle.
SHAPED = (
    Column(
        "over_angle_digest",
        _TEXT,
        "",
        "SHA-256, its first 16 digits, of the table of torques over the angle as the wire carries it, which differs by "
        "counts and wall",
    ),
)
# Where there is an encoder or an actuator of the spec's own.
CONVERTED = (
    Column("converters", _TEXT, "", "how the wall reads the encoder, and what becomes of its torque, in SI units"),
    Column(
        "converters_digest",
        _TEXT,
        "",
        "SHA-256, its first 16 digits, of the same as the wire carries it; empty without converters",
    ),
)
REMEDY = Column("remedy", _TEXT, "", "name of the remedy that it tries")
# Where remedies are tried.
TRIED = (
    REMEDY,
    Column("wall_stiffness", _REAL, "N*m/rad", "stiffness of the wall under this remedy"),
    Column("wall_damping", _REAL, "N*m*s/rad", "damping of the wall under this remedy"),
    Column(
        "control_digest",
        _TEXT,
        "",
        "SHA-256, its first 16 digits, of the controller's law, numbers and memory as the wire carries them, which "
        "differ by sample rate, counts and wall; empty without a controller",
    ),
)
# How evenly a trial was sampled, by the device's own clock; intervals are those between samples of consecutive index.
TIMING = (
    *TRIAL_KEYS,
    Column("samples", _WHOLE, "1", "samples received"),
    Column("period_s", _REAL, "s", "interval that was asked for"),
    Column("interval_mean_s", _REAL, "s", "mean interval"),
    Column("interval_std_s", _REAL, "s", "standard deviation of the intervals"),
    Column("interval_min_s", _REAL, "s", "shortest interval"),
    Column("interval_max_s", _REAL, "s", "longest interval"),
    Column("jitter_p50_s", _REAL, "s", "median distance of an interval from the one asked for"),
    Column("jitter_p95_s", _REAL, "s", "95th percentile of it"),
    Column("jitter_p99_s", _REAL, "s", "99th percentile of it"),
    Column("jitter_p999_s", _REAL, "s", "99.9th percentile of it"),
    Column("jitter_max_s", _REAL, "s", "greatest distance of an interval from the one asked for"),
    Column("drift", _REAL, "1", "share by which a tick takes longer than asked for, first sample to last"),
    Column("gaps", _WHOLE, "1", "samples whose index is missing"),
    Column("gap_count", _WHOLE, "1", "places at which some are missing"),
    Column("repeated", _WHOLE, "1", "indices that do not rise"),
    Column("missed_ticks", _WHOLE, "1", "ticks of the clock at which no sample was taken"),
    Column("overruns", _WHOLE, "1", "samples for which the device's loop was late"),
    Column("backwards", _WHOLE, "1", "times that do not rise"),
    Column(
        "host_drift",
        _REAL,
        "1",
        "share by which the device's clock is fast by this computer's; null for a device in its own time",
    ),
    Column(
        "host_drift_uncertainty",
        _REAL,
        "1",
        "how far that may be wrong: blocks are late, and not all alike",
    ),
)


Row = dict[str, Any]


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
    """One row for each cell of the grid, and each remedy, in its order; ``trials``: rows of ``trials.parquet``."""
    rows = cell_rows(trials)
    return build_table((*COLUMNS, REMEDY) if rows and REMEDY.name in rows[0] else COLUMNS, rows)


def cell_rows(trials: Sequence[Row]) -> list[Row]:
    """The same as rows. A trial whose buzz is not sustained is in no size and in no pitch."""
    cells: dict[tuple[float, int, str], list[Row]] = {}
    for row in filter(_is_measured, trials):
        cells.setdefault((row[RATE], row[COUNTS], row.get(REMEDY.name, "")), []).append(row)
    return [_cell(rate, counts, cells[rate, counts, remedy]) for rate, counts, remedy in sorted(cells)]


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
        **({REMEDY.name: same[0][REMEDY.name]} if REMEDY.name in same[0] else {}),
    }


def _mean(trials: list[Row], name: str) -> float | None:
    found = [one[name] for one in trials if one[name] is not None]
    return fmean(found) if found else None


PULSE_KEYS = (
    Column("order", _WHOLE, "1", "number of the trial, in the order they were run; the trial of the recordings"),
    Column("block", _WHOLE, "1", "block of trials, from 1"),
    Column("grip_target_n", _REAL, "N", "grip force at which the pulse fires"),
    Column(RATE, _REAL, "Hz", "sample rate of the device's loop"),
)
PULSE_TRIALS = (
    *PULSE_KEYS,
    Column("fired", _FLAG, "", "whether the pulse came"),
    Column("pulse_torque_nm", _REAL, "N*m", "torque of the pulse that was asked for"),
    Column("pulse_width_s", _REAL, "s", "time for which it acted, by the samples; null where it did not come"),
    Column("fired_s", _REAL, "s", "from the start to the first sample of the pulse; null where it did not come"),
    Column("grip_n", _REAL, "N", "grip force at the first sample of the pulse"),
    Column("grip_pulse_n", _REAL, "N", "mean grip force during the pulse"),
    Column("grip_zero_n", _REAL, "N", "what the grip cell showed before the start, subtracted"),
    Column("peak_rad", _REAL, "rad", "how far the knob turned from where it was before the pulse, at most"),
    Column("ended", _TEXT, "", "why it ended: released, gripping (the hand did not relax), unfired, operator, over"),
    Column("samples", _WHOLE, "1", "samples kept, about the pulse; of an unfired trial the last ones"),
    Column("gaps", _WHOLE, "1", "samples whose index is missing"),
    Column("overruns", _WHOLE, "1", "samples for which the device's loop was late"),
    Column("fault", _TEXT, "", "what is doubtful about it, in words; empty where nothing is"),
    Column("device", _TEXT, "", "what the device calls itself"),
    Column("native_counts", _WHOLE, "1/rev", "counts per revolution of the device's own encoder"),
)
# Of a simulated knob and hand together, at the grip at which the pulse came; null where it did not.
TRUTH = (
    Column("true_inertia_kg_m2", _REAL, "kg*m^2", "inertia of the simulated knob and hand at the pulse"),
    Column("true_damping_nm_s_per_rad", _REAL, "N*m*s/rad", "damping of the same"),
    Column("true_stiffness_nm_per_rad", _REAL, "N*m/rad", "stiffness of the same"),
)
PULSE_TIMING = (*PULSE_KEYS, *TIMING[len(TRIAL_KEYS) :])
