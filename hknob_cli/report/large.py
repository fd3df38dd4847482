"""Sweeps told by counts, in words and numbers: of more cells than anyone reads, and over a population.

Counts, shares and extremes of a large one are taken from its parts one by one. Of people: for how many a knob buzzes,
how much, and at what pitch. It buzzes for a person if any of the trials ends in a limit cycle. Size and pitch are those
of the person's largest cycle: peak to peak over all people, 0 where the knob comes to rest; frequency over those for
whom it buzzes. Quantiles interpolate linearly between people.
"""

from collections.abc import Collection, Sequence
from math import ceil
from typing import Any

import numpy as np
import pyarrow as pa

from hknob_cli.engine.outcome import Outcome
from hknob_cli.report.sweep_words import Reason, Undecided, undecided_text
from hknob_cli.report.table import MAX_ROWS, fits, matrix, short, table
from hknob_cli.report.verdicts import people_buzz
from hknob_cli.report.what_matters import (
    Columns,
    axes_that_matter,
    columns_of,
    describe_matters,
    matters_text,
    what_matters,
)
from hknob_cli.results.arrays import tally
from hknob_cli.results.columns import MEANS, WORST
from hknob_cli.results.parted import PART_CELLS, Parted
from hknob_cli.specs.plan import PERSON

Row = dict[str, Any]
QUANTILES = {"p5": 0.05, "median": 0.5, "p95": 0.95}
_MEASURES = ("p2p_max_rad", "frequency_at_max_hz")


def by_cell(rows: list[Row], axes: list[str]) -> list[tuple[Row, list[Row]]]:
    """Cells of the axes beside the person, in the order of the grid, each with the rows of its people."""
    others = [axis for axis in axes if axis != PERSON]
    found: dict[tuple[Any, ...], list[Row]] = {}
    for row in rows:
        found.setdefault(tuple(row[axis] for axis in others), []).append(row)
    return [(dict(zip(others, key, strict=True)), people) for key, people in found.items()]


def sizes(people: list[Row]) -> list[float]:
    """Peak to peak (rad) of everyone for whom it is known, in order."""
    return sorted(row["p2p_max_rad"] for row in people if row["p2p_max_rad"] is not None)


def pitches(people: list[Row]) -> list[float]:
    """Frequencies (Hz) of those for whom the knob buzzes, in order."""
    return sorted(row["frequency_at_max_hz"] for row in people if row["p2p_max_rad"])


def describe_people(cells: list[Row], axes: list[str]) -> list[Row]:
    """Share, median and 5 and 95 % of each cell of the axes beside the person."""
    return [{**cell, **_describe(people)} for cell, people in by_cell(cells, axes)]


def _describe(people: list[Row]) -> Row:
    measures = dict(zip(_MEASURES, (sizes(people), pitches(people)), strict=True))
    return {
        "people": len(people),
        "buzzing_fraction": len(measures["frequency_at_max_hz"]) / len(people),
        "unknown_fraction": 1.0 - len(measures["p2p_max_rad"]) / len(people),
        **{
            f"{measure}_{name}": _quantile(values, part)
            for measure, values in measures.items()
            for name, part in QUANTILES.items()
        },
    }


def _quantile(values: list[float], part: float) -> float | None:
    """Quantile of ordered values; None of none."""
    if not values:
        return None
    place = part * (len(values) - 1)
    below = int(place)
    above = min(below + 1, len(values) - 1)
    return values[below] + (place - below) * (values[above] - values[below])


def people_text(summary: Row, axes: list[str]) -> list[str]:
    """Lines of the terminal's table: matrices over two axes, else a line for each cell."""
    rows, axes = summary["population"], [axis for axis in axes if axis != PERSON]
    wide = [axis for axis in axes if len({row[axis] for row in rows}) > 1]
    said = [people_buzz(rows), ""]
    if len(wide) == 2 and fits(rows, wide):
        titles = {
            "buzzing_fraction": (100.0, "people for whom the knob buzzes, %"),
            "p2p_max_rad_median": (1e3, "peak to peak, mrad, median of the people"),
            "p2p_max_rad_p95": (1e3, "peak to peak, mrad, 95 % of the people have less"),
            "frequency_at_max_hz_median": (1.0, "frequency, Hz, median of those for whom it buzzes"),
        }
        tables = (matrix(rows, wide, name, scale=scale, title=title) for name, (scale, title) in titles.items())
        lines = [line for table in tables for line in (*table, "")]
        lines.pop()
    else:
        lines = _list(rows, wide)
    if any(row["unknown_fraction"] for row in rows):
        lines += ["", "without those whose trials all diverge or stay undecided; unknown_fraction says how many"]
    return [*said, *lines]


def _list(rows: list[Row], axes: list[str]) -> list[str]:
    heads = [*axes, "people", "buzz %", *(f"{name} {unit}" for unit in ("mrad", "Hz") for name in QUANTILES)]
    body = [
        [
            *(short(row[axis], 6) for axis in axes),
            str(row["people"]),
            short(100.0 * row["buzzing_fraction"]),
            *(
                short(None if row[f"{measure}_{name}"] is None else scale * row[f"{measure}_{name}"])
                for measure, scale in zip(_MEASURES, (1e3, 1.0), strict=True)
                for name in QUANTILES
            ),
        ]
        for row in rows[:MAX_ROWS]
    ]
    lines = table(heads, body, keys=len(axes) or 1)
    return [*lines, *([f"... and {len(rows) - MAX_ROWS} more cells"] if len(rows) > MAX_ROWS else [])]


SHARES = ("certified_fraction", "at_rest_fraction", "diverged_fraction", "undecided_fraction")
MEASURES = WORST
# What is looked at to say what matters most: columns of cells, and how many parts at most.
LOOKED_AT = (*MEASURES, "at_rest_fraction")
MOST_LOOKED_AT = 256


def describe_large(
    cells: Parted,
    orbits: Parted,
    *,
    axes: dict[str, list[float | int]],
    ranges: Collection[str] = (),
    trials: int = 1,
) -> dict[str, Any]:
    """Summary as plain data: cells, orbits by outcome, mean shares of the trials, and the extremes with their cells.

    ``ranges``: axes of a design of which ``axes`` has the ends alone; ``trials``: of a cell.
    """
    names = axes_that_matter(list(axes), cells.column_names)
    thinning, some = Thinning(cells), []
    count = 0
    sums = dict.fromkeys(SHARES, 0.0)
    still = 0
    extremes: dict[str, dict[str, Any]] = {}
    for number, part in enumerate(cells.tables([*{*axes, *names}, *SHARES, *MEASURES, *MEANS.values()])):
        count += part.num_rows
        some += thinning.take(number, part, [*names, *LOOKED_AT])
        column = columns_of(part, [*SHARES, *MEASURES])
        for name in SHARES:
            sums[name] += float(column[name].sum())
        still += int((column["at_rest_fraction"] == 1.0).sum())
        for name in MEASURES:
            _widen(extremes, name, column[name], part, list(axes))
    found = dict.fromkeys((outcome.name.lower() for outcome in Outcome), 0)
    for part in orbits.tables(["outcome"], coded=["outcome"]):
        for outcome, number in tally(part["outcome"]).items():
            found[outcome] += number
    undecided = _undecided(orbits, trials) if found["undecided"] else []
    return {
        "axes": {
            name: {
                **({} if name in ranges else {"values": len(values)}),
                "least": min(values),
                "most": max(values),
            }
            for name, values in axes.items()
        },
        "cell_count": count,
        "orbits": found,
        **{name: total / count for name, total in sums.items()},
        **({"undecided": undecided} if undecided else {}),
        "cells_at_rest": still,
        "what_matters": describe_matters(what_matters(_joined(some), names)),
        "extremes": extremes,
    }


def _undecided(orbits: Parted, trials: int) -> list[Reason]:
    """Why trials are undecided."""
    import pyarrow.compute as pc

    counted = Undecided(trials)
    for part in orbits.tables(["outcome", "reason", "basin_fraction"]):
        some = part.filter(pc.equal(part["outcome"], "undecided"))
        counted.take(*(some[name].to_pylist() for name in some.column_names))
    return counted.reasons()


class Thinning:
    """Some cells from all over a table, at random, about as many as a part has; the same every time.

    Of every part that is looked at the same share is taken: the last one has fewer cells than the others.
    """

    def __init__(self, cells: Parted) -> None:
        # At random: parts evenly spaced may all have the same value of an axis.
        self.parts = np.sort(np.random.default_rng(0).permutation(cells.parts)[:MOST_LOOKED_AT]).tolist()
        self._share = min(1.0, PART_CELLS * cells.parts / (cells.num_rows * len(self.parts)))

    def take(self, number: int, table: pa.Table, names: Sequence[str]) -> list[Columns]:
        """Columns of some cells of a part; none where it is not looked at."""
        if number not in self.parts:
            return []
        count = table.num_rows
        rows = np.sort(np.random.default_rng(number).permutation(count)[: ceil(self._share * count)])
        return [{name: values[rows] for name, values in columns_of(table, names).items()}]


def thinned(cells: Parted, names: Sequence[str]) -> Columns:
    """Columns of some cells, by `Thinning`."""
    thinning = Thinning(cells)
    return _joined([one for i in thinning.parts for one in thinning.take(i, cells.part(i, names), names)])


def matters_at_large(cells: Parted, axes: Sequence[str]) -> tuple[list[str], Columns]:
    """Axes that may matter in so many cells, and columns of some of them."""
    names = axes_that_matter(axes, cells.column_names)
    return names, thinned(cells, [*names, *LOOKED_AT])


def varying(cells: Parted, axes: Sequence[str]) -> list[str]:
    """Axes with several values."""
    ends: dict[str, list[float]] = {axis: [] for axis in axes}
    for part in cells.tables(axes):
        for axis, values in columns_of(part, axes).items():
            ends[axis] += [float(values.min()), float(values.max())]
    return [axis for axis in axes if min(ends[axis]) < max(ends[axis])]


def _joined(some: Sequence[Columns]) -> Columns:
    return {name: np.concatenate([one[name] for one in some]) for name in some[0]}


def _widen(extremes: dict[str, dict[str, Any]], name: str, values: Any, table: pa.Table, axes: list[str]) -> None:
    """Take in the least above 0, and the most, of one part's values, which are of the largest cycle of each cell."""
    above = np.where(values > 0.0, values, np.nan)
    if not np.isfinite(above).any():
        return
    for which, at in (("least", int(np.nanargmin(above))), ("most", int(np.nanargmax(above)))):
        value, known = float(above[at]), extremes.get(f"{which}_{name}")
        if known is None or (value < known[name] if which == "least" else value > known[name]):
            others = (MEANS[name], *axes)
            extremes[f"{which}_{name}"] = {name: value, **{other: table[other][at].as_py() for other in others}}


def large_text(summary: dict[str, Any]) -> str:
    """The summary on the terminal."""
    counts = ", ".join(f"{number:,} {kind}" for kind, number in summary["orbits"].items() if number)
    proven = summary["certified_fraction"]
    stale = " (up to date)" if summary["status"] == "up to date" else ""
    ends = {"come to rest": SHARES[1], "diverge": SHARES[2], "undecided": SHARES[3]}
    found = [f"{100 * summary[name]:.4g} % {text}" for text, name in ends.items() if summary[name]]
    lines = [
        f"{summary['name']}: {summary['cell_count']:,} cells{stale}",
        f"attractors: {counts}; " + ("all proven" if proven == 1.0 else f"{100 * proven:.6g} % of trials proven"),
    ]
    lines += [f"trials: {', '.join(found)}"] if found else []
    lines += [undecided_text(summary["undecided"])] if "undecided" in summary else []
    if summary["cells_at_rest"]:
        lines.append(f"cells where every trial comes to rest: {summary['cells_at_rest']:,}")
    names = {"p2p_max_rad": ("peak to peak", 1e3, "mrad"), "frequency_at_max_hz": ("frequency", 1.0, "Hz")}
    words = {"least": "least", "most": "greatest"}
    for key, row in summary["extremes"].items():
        which, name = key.split("_", 1)
        what, scale, unit = names[name]
        where = ", ".join(f"{axis} = {short(value)}" for axis, value in row.items() if axis not in (name, MEANS[name]))
        size, mean = (short(scale * row[one]) for one in (name, MEANS[name]))
        beside = f" (mean of the cell {mean})" if mean != size else ""
        lines.append(f"{words[which]} {what}: {size} {unit}{beside}, at {where}")
    if summary["what_matters"]:
        looked_at = sum(one["cells"] for one in summary["what_matters"][0]["bins"])
        lines += ["", *matters_text(summary["what_matters"], f"{looked_at:,} of {summary['cell_count']:,}")]
    return "\n".join(lines)
