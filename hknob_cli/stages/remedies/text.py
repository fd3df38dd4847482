"""A trial of remedies on the terminal: at every case, what each leaves of the buzz, at what pitch, at what cost."""

from collections.abc import Mapping, Sequence
from typing import Any

import pyarrow as pa

from hknob_cli.report.remedies import (
    cost_lines,
    effort_of,
    grid_text,
    over_axis,
    over_text,
    over_the_grid,
    times,
    tuned_values,
)
from hknob_cli.report.table import short, table
from hknob_cli.report.verdicts import best_remedy, quietest
from hknob_cli.results.columns import from_where, together
from hknob_cli.stages.work import counted

Row = dict[str, Any]
LEVELS = ("touch_db", "touch_change_db", "hearing_change_db")
_HEAD = ("max mrad", "Hz", "smaller", "mean mrad", "static K", "knock", "grid", "proven %")
_RANGED = ("from", "one start")
_ANEW = "starts: for some hand it buzzes, or diverges, where the reference does not."
_FELT = ("touch dB", "louder", "by ear")


def describe_trial(
    grid: pa.Table, cases: pa.Table, further: Sequence[str] = (), remedies: Mapping[str, Any] | None = None
) -> dict[str, Any]:
    """Summary as plain data: of every case and remedy the hands together, the remedy that does most first.

    ``further``: axes of the grid beside sample rate and counts; how much each remedy helps over each of them.
    ``remedies``: by name, as the spec has them; what each costs follows from them.
    """
    over = grid.to_pylist()
    rows = cases.to_pylist()
    everywhere = over_the_grid(over)
    found: dict[str, list[Row]] = {}
    for case in dict.fromkeys(row["case"] for row in rows):
        here = [
            _together([row for row in rows if row["case"] == case and row["remedy"] == name]) for name in everywhere
        ]
        found[case] = sorted(here, key=_size)
    outside = {
        name: sum(row.get("in_domain") is False for row in (*over, *rows) if row["remedy"] == name)
        for name in everywhere
    }
    loose = sum((row.get("undecided_fraction") or 0.0) > 0.0 for row in (*over, *rows))
    hands = list(dict.fromkeys(row["hand"] for row in over))
    return {
        "hands": hands,
        "grid": everywhere,
        "cases": found,
        "over": {axis: over_axis(over, axis) for axis in further},
        "tuned": {name: said for name in everywhere if (said := tuned_values(rows, over, further, name))},
        "needs": {name: (remedies or {}).get(name, {}).get("needs", "") for name in everywhere},
        "costs": {name: effort_of((remedies or {}).get(name, {})) for name in everywhere},
        "outside_domain": {name: count for name, count in outside.items() if count},
        "undecided": loose,
    }


def _size(row: Row) -> float:
    """By the largest motion of any hand; what diverges, or has no decided end, is larger than all."""
    diverges = row["p2p_max_rad"] is None or row["diverged_fraction"] > 0.0
    return float("inf") if diverges else float(row["p2p_max_rad"])


def _together(rows: list[Row]) -> Row:
    """Hands together: the largest motion and its pitch, the least gain, and the means of what it costs."""
    bounded = [row for row in rows if row["p2p_max_rad"] is not None]
    worst = max(bounded, key=lambda row: row["p2p_max_rad"]) if bounded else None
    ratios = [row["p2p_ratio"] for row in rows if row["p2p_ratio"] is not None]
    return {
        "remedy": rows[0]["remedy"],
        "needs": rows[0]["needs"],
        "p2p_max_rad": worst["p2p_max_rad"] if worst else None,
        "frequency_at_max_hz": worst["frequency_at_max_hz"] if worst else None,
        "p2p_rad": worst["p2p_rad"] if worst else None,
        "frequency_hz": worst["frequency_hz"] if worst else None,
        "hand": worst["hand"] if worst else None,
        "ratio_least": min(ratios) if ratios else None,
        "at_rest_fraction": sum(row["at_rest_fraction"] for row in rows) / len(rows),
        "diverged_fraction": sum(row["diverged_fraction"] for row in rows) / len(rows),
        "certified_fraction": sum(row["certified_fraction"] for row in rows) / len(rows),
        "stiffness_kept": _mean(rows, "stiffness_kept"),
        "knock_ratio": _mean(rows, "knock_ratio"),
        **(together(rows) if "complete" in rows[0] else {}),
        **({name: _most(rows, name) for name in LEVELS} if LEVELS[0] in rows[0] else {}),
    }


def _most(rows: list[Row], column: str) -> float | None:
    """Of the hand that notices most."""
    return max((row[column] for row in rows if row[column] is not None), default=None)


def _mean(rows: list[Row], column: str) -> float | None:
    values = [row[column] for row in rows if row[column] is not None]
    return sum(values) / len(values) if values else None


def trial_text(summary: dict[str, Any]) -> str:
    """A table of each case, and what its columns say."""
    stale = " (up to date)" if summary["status"] == "up to date" else ""
    remedies, hands = len(summary["grid"]), len(summary["hands"])
    cells = next(iter(summary["grid"].values()))["cells"] // hands
    sizes = f"{counted(remedies, 'remedy', 'remedies')}, {counted(hands, 'hand')}, a grid of {counted(cells, 'cell')}"
    lines = [f"{summary['name']}: {sizes}{stale}", "", best_remedy(summary["grid"])]
    kept = {name: _least_kept(summary, name) for name in summary["grid"]}
    lines += cost_lines(
        summary["grid"], quietest(summary["grid"]), needs=summary["needs"], costs=summary["costs"], kept=kept
    )
    felt = any(LEVELS[0] in row for rows in summary["cases"].values() for row in rows)
    ranged = any("complete" in row for rows in summary["cases"].values() for row in rows)
    heads = (*_HEAD[:1], *(_RANGED if ranged else ()), *_HEAD[1:], *(_FELT if felt else ()))
    for case, rows in summary["cases"].items():
        body = [[row["remedy"], *_line(row, summary["grid"][row["remedy"]], len(heads))] for row in rows]
        lines += ["", f"{case}: of the hand that buzzes most", *table(["", *heads], body, left={0})]
    if not summary["cases"]:
        lines += ["", *grid_text(summary["grid"])]
    for axis, values in summary["over"].items():
        lines += ["", *over_text(axis, values)]
    if summary["cases"]:
        lines += [
            "",
            "max mrad, Hz: peak to peak and pitch of the largest cycle; mean mrad: mean of the trials that cycle.",
            "smaller: times, by the largest cycles, for the hand that gains least.",
            *([_ANEW] if any(row["ratio_least"] == 0.0 for rows in summary["cases"].values() for row in rows) else []),
            "static K: stiffness under a steady push, and knock: depth of a quick knock, both over the reference's.",
            "grid: median over cells and hands, where the remedy does not rest, of how many times smaller.",
        ]
    if ranged:
        lines += [
            "one start: max mrad from 20 mrad, at rest.",
            "from: all starts of the ranges, none of which ends in a larger cycle; or so many random ones.",
        ]
    lines += [f"{name}: tuned to {text}" for name, text in summary["tuned"].items()]
    for name, count in summary["outside_domain"].items():
        rows = f"{count} row{'s' if count > 1 else ''}"
        lines.append(f"{name}: outside its domain in {rows}, where it may make the buzz larger (in_domain).")
    if felt:
        lines += [
            "touch dB: above threshold. louder: dB that it is felt more than the reference, by ear: that it sounds",
            "louder; of the hand that notices most.",
        ]
        if summary["undecided"]:
            lines += [
                f"{summary['undecided']} rows have undecided trials: they do not repeat in time, or their period",
                "is too long to measure. Those have no level.",
            ]
    return "\n".join(lines)


def _least_kept(summary: dict[str, Any], name: str) -> float | None:
    """The least share of the stiffness that a remedy keeps in any case; None where no case tells."""
    kept = [row["stiffness_kept"] for rows in summary["cases"].values() for row in rows if row["remedy"] == name]
    return min((share for share in kept if share is not None), default=None)


def _line(row: Row, grid: Row, count: int) -> list[str]:
    ranged = _starts(row) if "complete" in row else []
    if row["p2p_max_rad"] is None:
        blank = [*ranged, *[""] * 5, times(grid["ratio_median"])]
        return ["diverges" if row["diverged_fraction"] > 0.0 else "undecided", *blank, *[""] * (count - 1 - len(blank))]
    rests = row["p2p_max_rad"] == 0.0
    return [
        "rest" if rests else short(1e3 * row["p2p_max_rad"]),
        *ranged,
        "" if rests else short(row["frequency_at_max_hz"]),
        "rest" if rests else "starts" if row["ratio_least"] == 0.0 else times(row["ratio_least"]),
        "" if rests else short(1e3 * row["p2p_rad"]),
        times(row["stiffness_kept"]),
        times(row["knock_ratio"]),
        times(grid["ratio_median"]),
        f"{100 * row['certified_fraction']:.0f}",
        *(decibel(row[name], signed=name != "touch_db") for name in LEVELS if name in row),
    ]


def _starts(row: Row) -> list[str]:
    """The largest from one start, and how many starts the largest of all is of."""
    single = row["p2p_one_start_rad"]
    return [from_where(row), "-" if single is None else "rest" if single == 0.0 else short(1e3 * single)]


def decibel(value: float | None, *, signed: bool = False) -> str:
    """A level; a dash for none."""
    return "-" if value is None else f"{value:+.1f}" if signed else f"{value:.1f}"
