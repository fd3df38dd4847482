"""Which axis of a grid or design matters most for the size of the limit cycles, and how.

Cells are put in order of size, those at rest first, and into bins along each axis: at its values, or with as many cells
in each. How much of the variance of a cell's place in that order is between the bins is what the axis explains by
itself, on average over the others (Kruskal and Wallis, 1952), less what bins of so few cells explain of nothing (the
epsilon squared of Kelley, 1935). It sees a turn as well as a rise, any scale is the same to it, and rest counts. What
the axes together leave is their interplay.
"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import pyarrow as pa

from hknob_cli.report.table import short, table
from hknob_cli.results.arrays import reals
from hknob_cli.results.columns import ONE, PEOPLE, WORST
from hknob_cli.specs.plan import PERSON

if TYPE_CHECKING:
    from numpy.typing import NDArray

MOST_BINS = 12
_IN_A_BIN = 20  # cells, at least, unless an axis has so few values
_LEAST_CELLS = 16
SWINGS = ("rattle_max_rad", "jitter_max_rad")  # of what does not repeat
_BAND = (10.0, 50.0, 90.0)  # percentiles

Columns = dict[str, "NDArray[Any]"]


class Bin(NamedTuple):
    """Cells at one value of an axis, or between two: the middle one's value, and 10, 50 and 90 % of what buzzes.

    Size and pitch of a cell are those of its largest cycle.

    ``share``: mean of the share that is told beside it, of trials at rest or of cells in domain.
    """

    cells: int
    value: float
    p2p_rad: tuple[float, float, float] | None
    frequency_hz: tuple[float, float, float] | None
    share: float


class Matter(NamedTuple):
    """What an axis ``explained`` of the order of sizes, 0 to 1; its rank correlation with it; its bins."""

    axis: str
    explained: float
    correlation: float
    bins: tuple[Bin, ...]


def columns_of(table: pa.Table, names: Sequence[str]) -> Columns:
    """Columns of a table as numbers, nan for none."""
    return {name: reals(table[name]) for name in names}


def axes_that_matter(axes: Sequence[str], names: Sequence[str]) -> list[str]:
    """Axes of a sweep; in place of the number of a person what there is of the person's hand."""
    return [*(axis for axis in axes if axis != PERSON), *(one.name for one in PEOPLE if one.name in names)]


def matters_of(rows: Sequence[dict[str, Any]], axes: Sequence[str]) -> list[Matter]:
    """What matters in the cells of a sweep; nothing where they are a map, which shows it.

    What moves on without repeating has the size of its swing.
    """
    import numpy as np

    plain = [axis for axis in axes if axis != PERSON]
    if is_map(columns_in(rows, plain), plain):
        return []
    names = axes_that_matter(axes, list(rows[0]))
    columns = columns_in(rows, [*names, *WORST, "at_rest_fraction"])
    for swing in (one for one in SWINGS if one in rows[0]):
        largest = columns_in(rows, [swing])[swing]
        columns[WORST[0]] = np.fmax(columns[WORST[0]], largest)
    return what_matters(columns, names)


def columns_in(rows: Sequence[Mapping[str, Any]], names: Sequence[str]) -> Columns:
    """Columns of rows as numbers, nan for none."""
    import numpy as np

    return {name: np.array([row[name] for row in rows], dtype=float) for name in names}  # None becomes nan


def is_map(columns: Columns, axes: Sequence[str]) -> bool:
    """Whether at most two axes vary, and every combination of their values is there, so that a map shows them."""
    import numpy as np

    places = [np.unique(columns[axis], return_inverse=True) for axis in axes]
    wide = [(len(values), place) for values, place in places if len(values) > 1]
    if len(wide) != 2:
        return len(wide) < 2
    (down, first), (across, second) = wide
    return len(np.unique(first * across + second)) == down * across


def what_matters(columns: Columns, axes: Sequence[str], *, share: str = "at_rest_fraction") -> list[Matter]:
    """Every axis that varies, the one that explains most first; none where too few cells have a size.

    ``columns``: one number a cell, nan for none: the axes, size (0 where all rests) and pitch, which are `WORST` or
    `ONE`, and ``share``.
    """
    import numpy as np

    size = measures_in(columns)[0]
    known = np.isfinite(columns[size])
    if known.sum() < _LEAST_CELLS:
        return []
    kept = {name: values[known] for name, values in columns.items()}
    order = ranks(kept[size])
    found = []
    for axis in axes:
        values = kept[axis]
        if values.min() == values.max():
            continue
        place = _places(values)
        bins = tuple(_bin(values, kept, place == i, share) for i in range(int(place.max()) + 1))
        found.append(Matter(axis, _explained(order, place), _correlation(ranks(values), order), bins))
    return sorted(found, key=lambda one: -one.explained)


def measures_in(columns: Columns) -> tuple[str, str]:
    """Names of the columns of size and pitch: `WORST`, or `ONE` where these are not there."""
    return WORST if WORST[0] in columns else ONE


def _places(values: "NDArray[Any]") -> "NDArray[Any]":
    """Number of the bin of every value."""
    import numpy as np

    distinct, place = np.unique(values, return_inverse=True)
    if len(distinct) <= MOST_BINS:
        return np.asarray(place)
    count = min(MOST_BINS, max(3, len(values) // _IN_A_BIN))
    edges = np.unique(np.quantile(values, np.arange(1, count) / count))
    return np.unique(np.searchsorted(edges, values, side="right"), return_inverse=True)[1]


def ranks(values: "NDArray[Any]") -> "NDArray[Any]":
    """Places in the order of values, equal ones sharing theirs."""
    import numpy as np

    _, place, count = np.unique(values, return_inverse=True, return_counts=True)
    return np.asarray((np.cumsum(count) - 0.5 * (count - 1))[place])


def _explained(order: "NDArray[Any]", place: "NDArray[Any]") -> float:
    """Epsilon squared: share of the variance of places in order that lies between bins, less what chance explains."""
    import numpy as np

    count = np.bincount(place)
    spread = float(((order - order.mean()) ** 2).sum())
    free = len(order) - len(count)
    if spread == 0.0 or free <= 0:
        return 0.0
    means = np.bincount(place, weights=order) / count
    within = float(((order - means[place]) ** 2).sum())
    return max(0.0, 1.0 - within / free * (len(order) - 1) / spread)


def _correlation(first: "NDArray[Any]", second: "NDArray[Any]") -> float:
    import numpy as np

    first, second = first - first.mean(), second - second.mean()
    size = float(np.sqrt((first**2).sum() * (second**2).sum()))
    return float((first * second).sum()) / size if size else 0.0


def _bin(values: "NDArray[Any]", columns: Columns, here: "NDArray[Any]", share: str) -> Bin:
    import numpy as np

    size, pitch = measures_in(columns)
    buzzing = here & (columns[size] > 0.0)

    def band(name: str) -> tuple[float, float, float] | None:
        there = columns[name][buzzing]
        there = there[np.isfinite(there)]
        if not len(there):
            return None
        low, middle, high = (float(one) for one in np.percentile(there, _BAND))
        return low, middle, high

    middle = float(np.median(values[here]))
    return Bin(int(here.sum()), middle, band(size), band(pitch), float(columns[share][here].mean()))


def describe_matters(matters: Sequence[Matter]) -> list[dict[str, Any]]:
    """The same as plain data."""
    return [{**one._asdict(), "bins": [found._asdict() for found in one.bins]} for one in matters]


def matters_text(matters: Sequence[dict[str, Any]], cells: str) -> list[str]:
    """Lines of the terminal's table: what each axis explains, and what there is at its two ends; of how many cells."""
    heads = ["what matters most", "explains", "", "p2p mrad", "frequency Hz", "at rest %"]
    body = [[one["axis"], f"{100.0 * one['explained']:.0f} %", _way(one), *_ends(one["bins"])] for one in matters]
    left = 100.0 * max(0.0, 1.0 - sum(one["explained"] for one in matters))
    return [
        *table(heads, body, left=range(len(heads))),
        f"of the order of {cells} cells by size, rest the least; {left:.0f} % is the interplay of axes, or within bins",
        "medians of cells that buzz, each by its largest cycle or swing, from one end of an axis to the other",
    ]


def _way(one: dict[str, Any]) -> str:
    """Whether size rises or falls along an axis, if it does."""
    if abs(one["correlation"]) < 0.1:
        return ""
    return "larger" if one["correlation"] > 0.0 else "smaller"


def _ends(bins: list[dict[str, Any]]) -> list[str]:
    first, last = bins[0], bins[-1]

    def both(name: str, scale: float) -> str:
        ends = [None if one[name] is None else scale * one[name][1] for one in (first, last)]
        return " to ".join(short(value, 3) for value in ends)

    rest = " to ".join(short(100.0 * one["share"], 2) for one in (first, last))
    return [both("p2p_rad", 1e3), both("frequency_hz", 1.0), rest]
