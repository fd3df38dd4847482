"""A sweep of more cells than anyone reads: counts, shares and extremes, taken from its parts one by one."""

from collections.abc import Collection, Sequence
from math import ceil
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from hknob_cli.engine.outcome import Outcome
from hknob_cli.report.sweep_words import Reason, Undecided, undecided_text
from hknob_cli.report.table import short
from hknob_cli.report.what_matters import (
    Columns,
    axes_that_matter,
    columns_of,
    describe_matters,
    matters_text,
    what_matters,
)
from hknob_cli.results.arrays import tally
from hknob_cli.results.means import MEANS, WORST
from hknob_cli.results.parted import PART_CELLS, Parted

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
    for number, table in enumerate(cells.tables([*{*axes, *names}, *SHARES, *MEASURES, *MEANS.values()])):
        count += table.num_rows
        some += thinning.take(number, table, [*names, *LOOKED_AT])
        column = columns_of(table, [*SHARES, *MEASURES])
        for name in SHARES:
            sums[name] += float(column[name].sum())
        still += int((column["at_rest_fraction"] == 1.0).sum())
        for name in MEASURES:
            _widen(extremes, name, column[name], table, list(axes))
    found = dict.fromkeys((outcome.name.lower() for outcome in Outcome), 0)
    for table in orbits.tables(["outcome"], coded=["outcome"]):
        for outcome, number in tally(table["outcome"]).items():
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
    counted = Undecided(trials)
    for table in orbits.tables(["outcome", "reason", "basin_fraction"]):
        some = table.filter(pc.equal(table["outcome"], "undecided"))
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
    for table in cells.tables(axes):
        for axis, values in columns_of(table, axes).items():
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
