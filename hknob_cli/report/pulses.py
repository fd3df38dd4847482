"""A campaign of pulses in words and numbers: what fired, at which grip, and how far the knob turned."""

from collections.abc import Sequence
from statistics import fmean, stdev
from typing import Any

import pyarrow as pa

from hknob_cli.report.hw_run import clock_lines
from hknob_cli.report.table import short, table

Row = dict[str, Any]
FOUND = ("pulse_torque_nm", "fired_s", "grip_n", "peak_rad")
_COLUMNS = (
    ("pulse mN*m", "pulse_torque_nm", 1e3),
    ("fired after s", "fired_s", 1.0),
    ("grip N", "grip_n", 1.0),
    ("peak mrad", "peak_rad", 1e3),
)


def describe_pulses(trials: pa.Table) -> dict[str, Any]:
    """Summary as plain data: every trial, and means over those of a grip that fired."""
    rows = trials.to_pylist()
    targets = list(dict.fromkeys(sorted(row["grip_target_n"] for row in rows)))
    return {
        "trials": rows,
        "pulses": [_of_grip(target, [row for row in rows if row["grip_target_n"] == target]) for target in targets],
        "fired": sum(row["fired"] for row in rows),
        "samples": sum(row["samples"] for row in rows),
        "gaps": sum(row["gaps"] for row in rows),
        "overruns": sum(row["overruns"] for row in rows),
    }


def _of_grip(target: float, rows: list[Row]) -> Row:
    fired = [row for row in rows if row["fired"]]
    found: Row = {"grip_target_n": target, "trials": len(rows), "fired": len(fired)}
    for name in FOUND:
        values = [row[name] for row in fired]
        found[name] = fmean(values) if values else None
        found[f"{name}_std"] = stdev(values) if len(values) > 1 else None
    return found


def pulses_text(summary: dict[str, Any]) -> str:
    """What fired, then a table over grip force."""
    rows, trials = summary["pulses"], len(summary["trials"])
    stale = " (up to date)" if summary["status"] == "up to date" else ""
    lines = [f"{summary['name']}: {trials} trial{'s' if trials != 1 else ''}, {summary['fired']} with a pulse{stale}"]
    lines += ["", pulses_verdict(rows), "", "mean ± standard deviation over the trials that fired"]
    body = []
    for row in rows:
        cells = [short(row["grip_target_n"]), f"{row['fired']} of {row['trials']}"]
        cells += [_spread(row[name], row[f"{name}_std"], scale) for _, name, scale in _COLUMNS]
        body.append(cells)
    lines += table(["target N", "fired", *(head for head, _, _ in _COLUMNS)], body)
    lines += ["", *clock_lines(summary), *_doubts(summary["trials"])]
    return "\n".join(line.rstrip() for line in lines)


def _doubts(rows: Sequence[Row]) -> list[str]:
    """A line for each trial in which something is doubtful."""
    return [
        f"trial {row['order']} ({row['grip_target_n']:g} N, block {row['block']}): {row['fault']}"
        for row in rows
        if row["fault"]
    ]


def pulses_verdict(rows: Sequence[Row]) -> str:
    """The answer in a sentence."""
    peaks = [1e3 * row["peak_rad"] for row in rows if row["peak_rad"] is not None]
    if not peaks:
        return "No pulse came: the grip never was as asked for."
    range_ = f"{short(min(peaks), 3)} to {short(max(peaks), 3)}" if len(peaks) > 1 else short(peaks[0], 3)
    return f"The pulses turned the knob by {range_} mrad. hknob sysid reads samples.parquet."


def _spread(value: float | None, std: float | None, scale: float) -> str:
    if value is None:
        return "-"
    return short(scale * value, 3) + (f" ± {short(scale * std, 2)}" if std else "")
