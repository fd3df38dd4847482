"""A campaign in words and numbers: of the wall, or of pulses."""

from collections.abc import Callable, Sequence
from statistics import fmean, stdev
from typing import Any

import pyarrow as pa

from hknob_cli.report.remedies import tried_text
from hknob_cli.report.table import MAX_ROWS, grid, labels, matrix, short, table
from hknob_cli.report.verdicts import grid_verdict
from hknob_cli.results.campaign_files import cell_rows
from hknob_cli.results.columns import differs
from hknob_cli.specs.plan import COUNTS, RATE

Row = dict[str, Any]
AXES = [COUNTS, RATE]


def describe_hw_run(trials: pa.Table, *, target_n: float) -> dict[str, Any]:
    """Summary as plain data: every trial, cells as means over repeats, the grip over all."""
    rows = trials.to_pylist()
    grips = [row["grip_mean_n"] for row in rows if row["grip_mean_n"] is not None]
    return {
        "trials": rows,
        "cells": cells_of(rows),
        "sustained": sum(row["sustained"] for row in rows),
        "grip": {"target_n": target_n, "mean_n": fmean(grips) if grips else None, "std_n": _std(grips)},
        "samples": sum(row["samples"] for row in rows),
        "gaps": sum(row["gaps"] for row in rows),
        "overruns": sum(row["overruns"] for row in rows),
    }


def describe_clock(timing: pa.Table) -> dict[str, Any]:
    """The sample clock of a campaign: ticks left out; how fast it is, by the trial that tells it best."""
    rows = [row for row in timing.to_pylist() if row["host_drift"] is not None]
    best = min(rows, key=lambda row: float(row["host_drift_uncertainty"])) if rows else None
    found = {name: best[name] if best else None for name in ("host_drift", "host_drift_uncertainty")}
    return {"missed_ticks": sum(timing["missed_ticks"].to_pylist()), **found}


def cells_of(rows: list[Row]) -> list[Row]:
    """One row for each cell of the grid, as a page has them, in the order of the table on the terminal."""
    return sorted(cell_rows(rows), key=lambda cell: (cell[COUNTS], cell[RATE]))


def hw_run_text(summary: dict[str, Any]) -> str:
    """Tables over resolution and sample rate; a list where there is no grid of them."""
    rows, cells, grip = summary["trials"], summary["cells"], summary["grip"]
    held = f"grip {_spread(grip['mean_n'], grip['std_n'])} N, target {short(grip['target_n'])}"
    held = held if grip["target_n"] else "no grip cell"
    stale = " (up to date)" if summary["status"] == "up to date" else ""
    lines = [
        f"{summary['name']}: {len(rows)} trial{'s' if len(rows) != 1 else ''}, "
        f"{summary['sustained']} with sustained buzz; "
        f"{held}{stale}"
    ]
    if "remedies" in summary:
        return "\n".join(line.rstrip() for line in [*lines, "", *tried_text(summary), "", *_ends(summary)])
    lines += ["", grid_verdict(cells, [axis for axis in AXES if len({cell[axis] for cell in cells}) > 1])]
    lines += [f"controller: {one}" for one in dict.fromkeys(row["controller"] for row in rows if "controller" in row)]
    across = len({cell[RATE] for cell in cells})
    if len(cells) <= MAX_ROWS and across <= 24:
        for column, scale, title in (
            *_sizes(cells),
            ("rms_rad", 1e3, "root mean square, mrad"),
            ("frequency_hz", 1.0, "frequency, Hz (cycles per second, as a sweep counts them)"),
        ):
            lines += ["", *matrix(cells, AXES, column, scale=scale, title=title, mark=_mark)]
        lines += ["", *grip_table(cells)] if grip["target_n"] else []
    lines += ["", *_ends(summary)]
    return "\n".join(line.rstrip() for line in lines)


def _ends(summary: dict[str, Any]) -> list[str]:
    """What there is to say of the clock, and of trials that are doubtful."""
    return [*_clock(summary), *_doubts(summary["trials"])]


def _sizes(cells: list[Row]) -> list[tuple[str, float, str]]:
    """Tables of size: the trial that buzzes most, and the mean, where cells have several trials that buzz."""
    what = "peak to peak, mrad (mean peak minus mean trough)"
    if not differs(cells):
        return [("p2p_rad", 1e3, what)]
    return [
        ("p2p_max_rad", 1e3, f"{what}, the trial that buzzes most"),
        ("p2p_rad", 1e3, f"{what}, mean of the trials that buzz"),
    ]


def grip_table(cells: list[Row]) -> list[str]:
    """Grip force over the grid with means and sample standard deviations, laid out as Table 8."""
    rates = sorted({cell[RATE] for cell in cells})
    counts = sorted({cell[COUNTS] for cell in cells})
    force = {(cell[COUNTS], cell[RATE]): cell["grip_mean_n"] for cell in cells}
    down = [[force.get((count, rate)) for rate in rates] for count in counts]

    def shown(values: list[float | None]) -> list[str]:
        return ["-" if value is None else f"{value:.2f}" for value in values]

    def over(statistic: Callable[[list[float]], float | None], line: list[float | None]) -> float | None:
        found = [value for value in line if value is not None]
        return statistic(found) if found else None

    columns = [list(column) for column in zip(*down, strict=True)]
    every = [value for values in down for value in values]
    lines = [shown([*values, over(fmean, values), over(_std, values)]) for values in down]
    lines.append([*shown([*(over(fmean, column) for column in columns), over(fmean, every)]), ""])
    lines.append(shown([*(over(_std, column) for column in columns), None, over(_std, every)]))
    names, heads = [*labels(list(counts)), "mean", "std dev"], [*labels(list(rates)), "mean", "std dev"]
    return grid("grip force, N", COUNTS, RATE, names, heads, lines)


def _std(values: list[float]) -> float | None:
    return stdev(values) if len(values) > 1 else None


def quiet_text(cell: Row) -> str:
    """What the trials of a cell were that did not buzz; nothing where all did."""
    quiet = cell["trials"] - cell["sustained"]
    what = "rest" if cell["at_rest"] == quiet else "not sustained"
    return "" if not quiet else f"some {what}" if cell["sustained"] else what


def _mark(row: Row) -> str:
    """Mark of a cell in which not every trial buzzed."""
    return "" if row["sustained"] == row["trials"] else "r"


def _spread(value: float | None, std: float | None) -> str:
    return "-" if value is None else f"{value:.2f}" + (f" ± {std:.2f}" if std is not None else "")


def _clock(summary: dict[str, Any]) -> list[str]:
    quench = (
        []
        if summary["sustained"] == len(summary["trials"]) or "remedies" in summary
        else ["r in some or all trials the buzz was not sustained; they are in no size or frequency"]
    )
    return [*quench, *clock_lines(summary)]


def clock_lines(summary: dict[str, Any]) -> list[str]:
    """How many samples there are, and what the sample clock did to them."""
    missed = summary["missed_ticks"]
    skipped = f", which left out {missed} tick{'s' if missed != 1 else ''} of the clock" if missed else ""
    late = f"{summary['overruns']} late in the loop{skipped}"
    return [f"{summary['samples']} samples, {summary['gaps']} missing, {late}", *_drift(summary)]


def _drift(summary: dict[str, Any]) -> list[str]:
    """How fast the device's clock is, where this computer's was beside it."""
    share, unsure = summary.get("host_drift"), summary.get("host_drift_uncertainty")
    if share is None or unsure is None:
        return []
    how = "fast" if share > 0.0 else "slow"
    return [f"the device's clock is {abs(share):.2%} {how} by this computer's, sure to {unsure:.2%}"]


def _doubts(rows: list[Row]) -> list[str]:
    """A line for each trial in which something is doubtful."""
    return [
        f"trial {row['order']} ({row[RATE]:g} Hz, {row[COUNTS]} counts{_under(row)}): {row['fault']}"
        for row in rows
        if row["fault"]
    ]


def _under(row: Row) -> str:
    return f", {row['remedy']}" if row.get("remedy") else ""


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
        cells += [_scaled_spread(row[name], row[f"{name}_std"], scale) for _, name, scale in _COLUMNS]
        body.append(cells)
    lines += table(["target N", "fired", *(head for head, _, _ in _COLUMNS)], body)
    lines += ["", *clock_lines(summary), *_pulse_doubts(summary["trials"])]
    return "\n".join(line.rstrip() for line in lines)


def _pulse_doubts(rows: Sequence[Row]) -> list[str]:
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


def _scaled_spread(value: float | None, std: float | None, scale: float) -> str:
    if value is None:
        return "-"
    return short(scale * value, 3) + (f" ± {short(scale * std, 2)}" if std else "")
