"""Remedies tried on a knob in words: which leaves the smallest buzz, as measured and as computed."""

from collections.abc import Sequence
from statistics import median
from typing import Any

import pyarrow as pa

from hknob_cli.report.table import short, table

Row = dict[str, Any]
_HEADS = ("buzz", "mrad", "Hz", "smaller", "least")
_COMPUTED = ("mrad comp.", "Hz comp.", "smaller comp.", "least comp.")


def describe_tried(remedies: pa.Table, *, reference: str, against: str) -> dict[str, Any]:
    """What a campaign's summary says of remedies, as plain data; ``against``: the folder of what was computed."""
    return {"reference": reference, "against": against, "remedies": over_the_trials(remedies.to_pylist())}


def over_the_trials(rows: Sequence[Row]) -> list[Row]:
    """Each remedy of a campaign's ``remedies.parquet`` over all its cells, that with the smallest buzz first.

    Sizes (rad) and pitches (Hz) are medians over the cells that buzz; ``times``: how many times smaller than the
    reference's, median over the cells where both buzz, and ``times_least``. The same as ``computed_...`` where it was.
    """
    found = []
    for name in dict.fromkeys(row["remedy"] for row in rows):
        mine = [row for row in rows if row["remedy"] == name]
        row = {
            "remedy": name,
            "trials": sum(one["trials"] for one in mine),
            "sustained": sum(one["sustained"] for one in mine),
            **_sizes(mine, ""),
        }
        if "computed_p2p_rad" in mine[0]:
            row |= {
                **_sizes(mine, "computed_"),
                "p2p_over_computed": _median(mine, "p2p_over_computed"),
                "frequency_over_computed": _median(mine, "frequency_over_computed"),
            }
        found.append(row)
    return sorted(found, key=_buzz)


def _sizes(rows: list[Row], which: str) -> Row:
    ratios = [row[f"{which}p2p_ratio"] for row in rows if row[f"{which}p2p_ratio"] is not None]
    return {
        f"{which}p2p_rad": _median(rows, f"{which}p2p_rad"),
        f"{which}frequency_hz": _median(rows, f"{which}frequency_hz"),
        f"{which}times": median(ratios) if ratios else None,
        f"{which}times_least": min(ratios, default=None),
    }


def _median(rows: list[Row], column: str) -> float | None:
    values = [row[column] for row in rows if row[column]]
    return median(values) if values else None


def _buzz(row: Row) -> tuple[float, float]:
    """What rests is quietest, then what makes the buzz smallest."""
    return (0.0, 0.0) if not row["sustained"] else (1.0, -(row["times"] or 0.0))


def tried_verdict(found: Sequence[Row], reference: str) -> str:
    """Of remedies tried on a knob: which leaves the smallest buzz, and whether that was computed, too."""
    if not found:
        return "No trial could be measured."
    others = [row for row in found if row["remedy"] != reference]
    best = next(iter(others), None)
    if best is None:
        return "No remedy was tried beside the reference."
    if not best["sustained"]:
        return f"No sustained buzz: {best['remedy']}, in any of {best['trials']} trials."
    if (best["times"] or 0.0) <= 1.0:
        return "No remedy made the buzz smaller in the trials recorded."
    text = f"Smallest buzz: {best['remedy']}, {short(best['times'], 3)} times smaller (median of the cells; "
    text += f"at least {short(best['times_least'], 3)} times"
    if best.get("computed_times"):
        text += f"; {short(best['computed_times'], 3)} times as computed"
    return f"{text})."


def tried_text(summary: dict[str, Any]) -> list[str]:
    """The verdict, a line a remedy, and what the columns say; of a summary with what `describe_tried` says."""
    found, reference, against = (summary[name] for name in ("remedies", "reference", "against"))
    heads = ["", *_HEADS, *(_COMPUTED if against else ())]
    lines = [
        tried_verdict(found, reference),
        "",
        *table(heads, [_line(row, bool(against)) for row in found], left={0}),
        "",
        "buzz: trials with a sustained buzz. mrad, Hz: peak to peak and pitch, medians over the cells that buzz.",
        f"smaller: times, {reference} over the remedy in the same cell, median, and least, of cells where both buzz.",
    ]
    return [*lines, f"comp.: as computed, in {against}, means over the starts."] if against else lines


def _line(row: Row, computed: bool) -> list[str]:
    shown = [row["remedy"], f"{row['sustained']}/{row['trials']}", *_four(row, "")]
    return [*shown, *_four(row, "computed_")] if computed else shown


def _four(row: Row, which: str) -> list[str]:
    scales = {"p2p_rad": 1e3, "frequency_hz": 1.0, "times": 1.0, "times_least": 1.0}
    return [short(None if (value := row[f"{which}{name}"]) is None else by * value, 3) for name, by in scales.items()]
