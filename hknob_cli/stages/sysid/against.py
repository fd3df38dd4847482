"""Tables beside those of hands: calibrations, studies of the estimators, and fits beside the truth of a device.

A calibration is of the motor or of the grip cell: readings taken or made, lines through them. Studies are of bias and
of hidden fingers. The truth is of a campaign of pulses on a virtual device; of an average it is the mean over its
trials, each with the hand at the grip at which its pulse came.
"""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from statistics import fmean, stdev
from typing import Any, NamedTuple

import pyarrow as pa

from hknob_cli.apparatus.experiment import record_grip_cell, record_motor_calibration
from hknob_cli.apparatus.hand_recording import virtual_rig
from hknob_cli.apparatus.people import mean_hand
from hknob_cli.errors import UsageError
from hknob_cli.identify import identified
from hknob_cli.identify.studies import NUISANCES, UNITS, bias_study, hidden_inertia
from hknob_cli.printed import apparatus_inertia
from hknob_cli.recordings.files import GRIP_CELL, MOTOR, read_columns
from hknob_cli.results.arrays import build_table
from hknob_cli.results.campaign_files import TRUTH
from hknob_cli.specs.identification import CAMPAIGN_SAMPLES, BiasPlan, HiddenPlan, SysidPlan
from hknob_cli.specs.named_file import digest_of
from hknob_cli.stages.compare import read_table, result_file
from hknob_cli.stages.sysid import columns
from hknob_cli.stages.sysid.columns import PARAMETERS
from hknob_cli.stages.sysid.run import Fitted, SysidStage


def calibrate(plan: SysidPlan) -> tuple[pa.Table, pa.Table]:
    """Quantities, and the points that each rests on with its line there. Raises `UsageError`."""
    motor = plan.what == "motor"
    readings: Mapping[str, Any]
    if plan.virtual is None:
        readings = read_columns(plan.recordings, MOTOR if motor else GRIP_CELL)
    elif motor:
        readings = record_motor_calibration(virtual_rig(plan), seed=plan.virtual.seed)._asdict()
    else:
        readings = record_grip_cell(seed=plan.virtual.seed)._asdict()
    found = identified.motor(readings) if motor else identified.grip_cell(readings)
    quantities = [{**one._asdict(), "flags": "; ".join(one.flags)} for one in found]
    points = [
        {
            "quantity": one.quantity,
            "condition": one.condition,
            "x": x,
            "x_unit": one.line.x_unit,
            "y": y,
            "y_unit": one.line.y_unit,
            "fitted": fitted,
        }
        for one in found
        if one.line is not None
        for x, y, fitted in zip(one.line.x, one.line.y, one.line.fitted, strict=True)
    ]
    return build_table(columns.CALIBRATION, quantities), build_table(columns.CALIBRATION_POINTS, points)


_FILE = "trials.parquet"
_WHAT = "campaign of pulses"
_NAMES = dict(zip(("inertia", "damping", "stiffness"), (column.name for column in TRUTH), strict=True))
_QUANTILE = 1.96  # of the normal distribution, 95 %

Row = dict[str, Any]


class Truths(NamedTuple):
    """Values by number of trial."""

    by_trial: dict[int, Row]

    def of(self, fitted: Fitted, name: str) -> float | None:
        """Of the trials that a fit rests on; None where one of them has none."""
        found = [self.by_trial.get(trial, {}).get(_NAMES[name]) for trial in fitted.of.trials]
        known = [one for one in found if one is not None]
        return fmean(known) if known and len(known) == len(found) else None


def truth_path(folder: str) -> Path:
    """Where the trials of a campaign are, or are yet to be."""
    return Path(folder) / _FILE


def check_of(plan: SysidPlan) -> None:
    """Raise `UsageError` where there is no truth, or not of these recordings."""
    _truths(plan.against)
    ours = digest_of(Path(plan.against) / CAMPAIGN_SAMPLES)
    if any(digest_of(path) != ours for path in plan.files):
        raise UsageError(f"against: {plan.against} must be what all of recordings are of: name that folder in both")


def _truths(folder: str) -> Truths:
    path = result_file(folder, _FILE, "hw-run", what=_WHAT)
    table = read_table(path, what=_WHAT)
    if lacking := [name for name in ("order", *_NAMES.values()) if name not in table.column_names]:
        text = "which a campaign of pulses on a virtual device has"
        raise UsageError(f"against: {path} has no column {', '.join(lacking)}, {text}")
    return Truths({int(row["order"]): row for row in table.to_pylist()})


def truth_table(stage: SysidStage) -> pa.Table:
    """A row of each fit and parameter that can be told. Raises `UsageError`."""
    truths = _truths(stage.plan.against)
    rows = [row for fitted in stage.fitted for row in _rows(stage, fitted, truths)]
    return build_table(columns.TRUTH, rows)


def _rows(stage: SysidStage, fitted: Fitted, truths: Truths) -> list[Row]:
    rows = []
    for name in _NAMES:
        one, truth = fitted.parameters.get(name), truths.of(fitted, name)
        if one is None or not one.identifiable or truth is None or name in stage.plan.fixed:
            continue
        if name == "inertia":
            truth -= stage.apparatus_of(fitted.of) or 0.0
        rows.append(
            {
                **fitted.of.condition._asdict(),
                "trial": fitted.trial,
                "estimator": fitted.fit.estimator,
                "parameter": name,
                "value": one.value,
                "std": one.std,
                "truth": truth,
                "unit": columns.PARAMETERS[name][1],
                "error_percent": 100.0 * (one.value / truth - 1.0) if truth else None,
                "holds": abs(one.value - truth) <= _QUANTILE * one.std,
            }
        )
    return rows


def describe_truth(table: pa.Table) -> list[Row]:
    """By estimator and parameter: mean and standard deviation of the error, intervals that hold the truth."""
    rows = table.to_pylist()
    found = []
    for estimator, parameter in dict.fromkeys((row["estimator"], row["parameter"]) for row in rows):
        same = [row for row in rows if (row["estimator"], row["parameter"]) == (estimator, parameter)]
        errors = [row["error_percent"] for row in same if row["error_percent"] is not None]
        found.append(
            {
                "estimator": estimator,
                "parameter": parameter,
                "fits": len(same),
                "bias_percent": fmean(errors) if errors else float("nan"),
                "std_percent": stdev(errors) if len(errors) > 1 else None,
                "hold": sum(row["holds"] for row in same),
            }
        )
    return found


Progress = Callable[[int, int], None]


def levels_of(plan: BiasPlan) -> Mapping[str, Sequence[float]]:
    """Levels of each nuisance by its name: those asked for, or all there are."""
    return plan.nuisances or NUISANCES


def study_bias(plan: BiasPlan, progress: Progress = lambda _done, _total: None) -> pa.Table:
    """Bias and spread of every estimator and parameter at each level of each nuisance."""
    found = bias_study(
        plan.repeats,
        table=plan.table,
        grips_n=plan.grips_n,
        nuisances=levels_of(plan),
        seed=plan.seed,
        progress=progress,
    )
    units = {name: unit for name, (_, unit, _) in PARAMETERS.items()}
    rows = [{**one._asdict(), "level_unit": UNITS[one.nuisance], "unit": units[one.parameter]} for one in found]
    return build_table(columns.BIAS, rows)


def study_hidden(plan: HiddenPlan, progress: Progress = lambda _done, _total: None) -> pa.Table:
    """Second-order fits of the fourth-order hand, over the ratio of finger to pad."""
    hand = mean_hand(plan.table, plan.grip_n)
    knob = apparatus_inertia(plan.table)
    found = hidden_inertia(
        hand.damping,
        hand.stiffness,
        inertia=knob,
        finger_inertia=plan.finger_inertia,
        ratios=plan.ratios,
        progress=progress,
    )
    rows = [
        {
            "ratio": one.ratio,
            "estimator": one.estimator,
            "inertia_kg_m2": one.inertia,
            "damping_nm_s_per_rad": one.damping,
            "stiffness_nm_per_rad": one.stiffness,
            "vaf": one.vaf,
            "knob_inertia_kg_m2": knob,
            "finger_inertia_kg_m2": plan.finger_inertia,
        }
        for one in found
    ]
    return build_table(columns.HIDDEN, rows)
