"""A remedy that is tuned: of each cell the value whose largest cycle of any hand is smallest.

A controller does not know who holds the knob, so that one value serves all hands; it knows its device, so that another
cell may have another value.
"""

from collections.abc import Sequence
from math import inf

from hknob_cli.specs.plan import PERSON
from hknob_cli.specs.remedies_plan import Remedy
from hknob_cli.stages.remedies.trial import Row, Rows


def ways(remedy: Remedy) -> list[Remedy]:
    """The remedy at each value of what it tunes; itself where it tunes nothing."""
    return [remedy._replace(grid=one.grid, cases=one.cases) for one in remedy.tuned] or [remedy]


def tuned_rows(remedy: Remedy, found: Sequence[Rows]) -> Rows:
    """Rows of the best value of each cell, with the value as ``tuned``; ``found`` has those of each of its `ways`."""
    if not remedy.tuned:
        return [{**row, "tuned": None} for row in found[0]]
    axes = [name for name in remedy.grid.axes if name != PERSON and name in found[0][0]]

    def cell(row: Row) -> tuple[object, ...]:
        return tuple(row[name] for name in axes)

    worst: dict[tuple[object, ...], list[float]] = {}
    for i, rows in enumerate(found):
        for row in rows:
            sizes = worst.setdefault(cell(row), [0.0] * len(found))
            sizes[i] = max(sizes[i], _size(row))
    best = {key: sizes.index(min(sizes)) for key, sizes in worst.items()}
    return [
        {**found[best[cell(row)]][i], "tuned": remedy.tuned[best[cell(row)]].value} for i, row in enumerate(found[0])
    ]


def _size(row: Row) -> float:
    """Of the largest cycle; of what diverges, or is not known, larger than all."""
    if row["p2p_max_rad"] is None or row["diverged_fraction"] > 0.0:
        return inf
    return float(row["p2p_max_rad"])
