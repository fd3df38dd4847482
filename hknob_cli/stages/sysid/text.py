"""An identification on the terminal: the hand by experiment, grip force and estimator, as the printed tables.

Studies of the estimators on the terminal: bias and spread by cause, and what a second-order fit does not see.
"""

import re
from collections import Counter
from statistics import median
from textwrap import wrap
from typing import Any

import pyarrow as pa

from hknob_cli.identify.fit import MISFIT, ODDS
from hknob_cli.recordings.columns import UNNAMED
from hknob_cli.report.table import short, table
from hknob_cli.report.verdicts import DEVIATION, ERROR, alone, biased, calibrated, identified
from hknob_cli.stages.sysid.remarks import DISAGREE

Row = dict[str, Any]
# What is varied, in words; and the scale and unit in which a level is shown.
NUISANCES = {
    "noise_rad": ("noise of the angle, mrad rms", 1e3),
    "coulomb_nm": ("Coulomb friction, mN*m", 1e3),
    "lag_s": ("lag of the amplifier, ms", 1e3),
    "counts_per_rev": ("encoder, counts per revolution", 1.0),
    "decimation": ("smoothing, factor of decimation", 1.0),
}
PARAMETERS = ("inertia", "damping", "stiffness", "coulomb")

MOST_REMARKS = 6
_NUMBER = re.compile(r"-?\d+(\.\d+)?(e[-+]?\d+)?")
_COLUMNS = (
    ("J g*cm^2", "inertia_kg_m2", 1e7),
    ("B mN*m*s", "damping_nm_s_per_rad", 1e3),
    ("K mN*m/rad", "stiffness_nm_per_rad", 1e3),
    ("zeta", "damping_ratio", 1.0),
)


def study_text(summary: dict[str, Any]) -> str:
    """One table a grip force and nuisance; and one of the finger behind its pad."""
    lines = [f"{summary['name']}: estimators compared with the truth"]
    rows = summary.get("bias", [])
    lines += ["", biased(rows)] if rows else []
    for grip, nuisance in dict.fromkeys((row["grip_n"], row["nuisance"]) for row in rows):
        chosen = [row for row in rows if (row["grip_n"], row["nuisance"]) == (grip, nuisance)]
        lines += ["", f"{NUISANCES[nuisance][0]}, grip {short(grip)} N: bias ± standard deviation, %"]
        lines += _biases(chosen, NUISANCES[nuisance][1])
    if hidden := summary.get("hidden_inertia"):
        lines += ["", "second-order fits of finger, pad and knob: inertia beyond the knob's own, g*cm^2"]
        lines += _hidden(hidden)
    return "\n".join(lines)


def _biases(rows: list[Row], scale: float) -> list[str]:
    found = {(row["level"], row["estimator"], row["parameter"]): row for row in rows}
    estimators = list(dict.fromkeys(row["estimator"] for row in rows))
    parameters = [name for name in PARAMETERS if any(row["parameter"] == name for row in rows)]
    body = [
        [
            short(scale * level, 3),
            estimator,
            *(_bias_and_std(found.get((level, estimator, name))) for name in parameters),
        ]
        for level in dict.fromkeys(row["level"] for row in rows)
        for estimator in estimators
    ]
    return table(["level", "", *parameters], body, keys=2)


def _bias_and_std(row: Row | None) -> str:
    if row is None:
        return "-"
    return f"{row['bias_percent']:+.2f} ± {row['std_percent']:.2f}"


def _hidden(rows: list[Row]) -> list[str]:
    estimators = list(dict.fromkeys(row["estimator"] for row in rows))
    found = {(row["ratio"], row["estimator"]): row for row in rows}
    knob, finger = 1e7 * rows[0]["knob_inertia_kg_m2"], 1e7 * rows[0]["finger_inertia_kg_m2"]
    lines = [f"knob {short(knob)}, finger {short(finger)}; K1/K2 = B1/B2 is the ratio of finger to pad"]
    body = [
        [short(ratio, 3), *(short(1e7 * found[ratio, name]["inertia_kg_m2"] - knob, 3) for name in estimators)]
        for ratio in dict.fromkeys(row["ratio"] for row in rows)
    ]
    return [*lines, *table(["ratio", *estimators], body)]


def describe_sysid(trials: pa.Table, conditions: pa.Table) -> dict[str, Any]:
    """Summary as plain data: conditions over all persons, and what is doubtful."""
    rows, fits = conditions.to_pylist(), trials.to_pylist()
    said = ((row["estimator"], flag) for row in fits for flag in row["flags"].split("; ") if flag)
    alike: dict[tuple[str, str], Counter[str]] = {}  # by estimator, and by flag without its numbers
    for estimator, flag in said:
        alike.setdefault((estimator, _NUMBER.sub("…", flag)), Counter())[flag] += 1
    flags = Counter({flag_text(estimator, found): found.total() for (estimator, _), found in alike.items()})
    return {
        "fits": trials.num_rows,
        "subjects": len({row["subject"] for row in rows if row["level"] == "subject"}),
        "conditions": [row for row in rows if row["level"] == "all"],
        "alone": alone(rows),
        "flags": dict(flags.most_common(20)),
        "averages": _averages(fits),
        "remarks": list(dict.fromkeys(_remark(row) for row in rows if DISAGREE in row["flags"])),
    }


def flag_text(estimator: str, found: Counter[str]) -> str:
    """A flag with its numbers; of flags that differ in their numbers the first."""
    return f"{estimator}: {next(iter(found))}{', and alike' if len(found) > 1 else ''}"


def _remark(row: dict[str, Any]) -> str:
    """Where the estimators of a person's condition disagree."""
    said = [flag for flag in row["flags"].split("; ") if flag.startswith(DISAGREE)]
    return f"{row['subject']}, experiment {row['experiment']}, {row['grip_target_n']:g} N: {'; '.join(said)}"


def _averages(fits: list[dict[str, Any]]) -> dict[str, float] | None:
    """Averages whose residuals are not white for no other reason than that their trials differ; None if there are none.

    Shares of the peak angle by which the trials differ, least, median and largest; how many of how many fits.
    """
    blends = [
        row["trials_differ"]
        for row in fits
        if row["trials_differ"] and row["white"] is not None and row["white"] < ODDS and MISFIT not in row["flags"]
    ]
    if not blends:
        return None
    of = sum(row["trials_differ"] is not None for row in fits)
    return {"fits": len(blends), "of": of, "least": min(blends), "median": median(blends), "largest": max(blends)}


def sysid_text(summary: dict[str, Any]) -> str:
    """A table of each experiment and estimator: mean and standard deviation over persons; what is doubtful below.

    Of one person, or of setups that nobody grips, each by its name, mean over blocks and its standard error.
    """
    if "calibration" in summary:
        return _calibration_text(summary)
    rows = summary["alone"] or summary["conditions"]
    named = len({row["subject"] for row in rows}) > 1 or not any(row["grip_target_n"] for row in rows)
    whose = ERROR if summary["alone"] else DEVIATION
    people = summary["subjects"]
    lines = [f"{summary['name']}: {summary['fits']} fits, {people} subject{'s' if people != 1 else ''}"]
    lines += ["", identified(rows, errors=whose)]
    for key in dict.fromkeys((row["experiment"], row["estimator"]) for row in rows):
        where = "" if key[0] == UNNAMED else f"experiment {key[0]}, "
        lines += ["", f"{where}{key[1]}: mean ± {whose}"]
        own = [row for row in rows if (row["experiment"], row["estimator"]) == key]
        lines += _conditions(own, named=named)
    if blend := summary["averages"]:
        lines += ["", *_blended(blend)]
    if errors := summary.get("truth"):
        lines += ["", *_errors(errors)]
    if summary["remarks"]:
        lines += ["", *summary["remarks"][:MOST_REMARKS]]
        left = len(summary["remarks"]) - MOST_REMARKS
        lines += [f"and {left} more conditions in which they disagree"] if left > 0 else []
    if summary["flags"]:
        lines += ["", "* doubtful in some fits; the column flags says which:"]
        lines += [f"  {count:5} x {flag}" for flag, count in summary["flags"].items()]
    return "\n".join(lines)


def _conditions(rows: list[Row], *, named: bool) -> list[str]:
    """A table of one experiment and estimator; ``named``: a row a setup, and not a grip force."""
    body = []
    for row in rows:
        cells = [str(row["subject"]) if named else short(row["grip_target_n"])]
        cells += [_cell(row[column], row[f"{column}_std"], scale) for _, column, scale in _COLUMNS]
        cells.append("-" if row["vaf"] is None else f"{100 * row['vaf']:.2f}")
        body.append([*cells, "*" if row["flags"] else ""])
    head = ["setup" if named else "grip N", *(one[0] for one in _COLUMNS), "VAF %", ""]
    return table(head, body, left={6})


def _blended(blend: dict[str, float]) -> list[str]:
    """What `_averages` found."""
    least, largest, middle = (f"{100.0 * blend[name]:.2g}" for name in ("least", "largest", "median"))
    return [
        f"{blend['fits']} of {blend['of']} fits: residuals not white, but as small as noise or averaging make;",
        f"trials of a condition differ by {least} to {largest} % of the motion beyond noise (median {middle} %):",
        "their mean is not one motion's. prepare: {average: false} fits each trial",
    ]


def _errors(rows: list[Row]) -> list[str]:
    """How far off each estimator is of the hands that were simulated."""
    body = [
        [
            row["estimator"],
            row["parameter"],
            f"{row['bias_percent']:+.2f}" + (f" ± {row['std_percent']:.2f}" if row["std_percent"] is not None else ""),
            f"{row['hold']} of {row['fits']}",
        ]
        for row in rows
    ]
    head = "against the simulated hands: error, mean ± standard deviation; 95 % intervals that hold the truth"
    return [*wrap(head, 79), *table(["estimator", "", "error %", "hold"], body, left={1}, keys=2)]


def _calibration_text(summary: dict[str, Any]) -> str:
    quantities = summary["calibration"]
    lines = [f"{summary['name']}: {len(quantities)} quantities", "", calibrated(quantities), ""]
    body = [
        [row["quantity"], row["condition"], _spread(row["value"], row["std"], 1.0), row["unit"], row["flags"]]
        for row in summary["calibration"]
    ]
    lines += table(["quantity", "condition", "value", "unit", ""], body, left={0, 1, 3, 4}, keys=2, flow=4)
    return "\n".join(lines)


def _cell(value: float | None, std: float | None, scale: float) -> str:
    """A parameter; one without any error was given."""
    return f"{short(scale * value, 3)} (fixed)" if value is not None and std == 0.0 else _spread(value, std, scale)


def _spread(value: float | None, std: float | None, scale: float) -> str:
    if value is None:
        return "-"
    return short(scale * value, 3) + (f" ± {short(scale * std, 2)}" if std is not None else "")
