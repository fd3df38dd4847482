"""The answer first: what a result of many cells says, in a sentence with its scope."""

from collections.abc import Collection, Mapping, Sequence
from statistics import median
from typing import Any

from hknob_cli.report.table import short

Row = Mapping[str, Any]
# Parameters of a hand: columns, names, and scales to units that are read easily.
_HAND = {
    "inertia_kg_m2": ("inertia", 1e7, "g·cm²"),
    "damping_nm_s_per_rad": ("damping", 1e3, "mN·m·s/rad"),
    "stiffness_nm_per_rad": ("stiffness", 1e3, "mN·m/rad"),
}


def grid_verdict(cells: Sequence[Row], axes: Collection[str]) -> str:
    """Of a sweep: in how many cells it buzzes, and the largest and the smallest of the cells' largest cycles.

    ``cells``: rows of ``cells.parquet``, or the cells of a campaign on a knob; ``axes``: the names that vary.
    """
    buzz = [row for row in cells if row["p2p_max_rad"]]
    count = len(cells)
    if not buzz:
        if not count:
            return "No trial could be measured."
        if "sustained" in cells[0]:
            return f"No sustained buzz in {_of_cells(0, count)}, in the trials recorded."
        rest = all(row["at_rest_fraction"] == 1.0 for row in cells)
        return f"It comes to rest in all {count} cells." if rest else f"No limit cycle in any of {count} cells."
    ends = sorted(buzz, key=lambda row: row["p2p_max_rad"])
    where = _of_cells(len(buzz), count)
    if len(buzz) == 1:
        return f"It buzzes in {where}{_scope(cells)}: {_size(ends[0])}{_at(ends[0], axes)}."
    return (
        f"It buzzes in {where}{_scope(cells)}. The most: {_size(ends[-1])}{_at(ends[-1], axes)}. "
        f"The least: {_size(ends[0])}{_at(ends[0], axes)}."
    )


def _of_cells(some: int, count: int) -> str:
    """So many of the cells, in words."""
    if count == 1:
        return "this cell"
    return (
        f"any of {count} cells" if not some else f"all {count} cells" if some == count else f"{some} of {count} cells"
    )


def _scope(cells: Sequence[Row]) -> str:
    """From which starts: all of the ranges that were asked for, or those that were tried."""
    if "sustained" in cells[0]:
        return ", in the trials recorded"
    if "complete" not in cells[0]:
        return ", from the starts tried"
    return (
        ", from the starts of the ranges"
        if all(row["complete"] for row in cells)
        else ", from the starts that were followed"
    )


def expected(name: str, rows: Sequence[Row]) -> str:
    """Of a formula, one row a cell: the sizes and pitches that it expects where its own assumptions hold."""
    inside = [row for row in rows if row["in_domain"]]
    of = f"{len(inside)} of {len(rows)} cells" if len(rows) > 1 else "this cell"
    if not inside:
        none = f"any of {len(rows)} cells" if len(rows) > 1 else "this cell"
        return f"{name}: its assumptions do not hold in {none}."
    cycles = [row for row in inside if row["p2p_rad"]]
    if not cycles:
        return f"{name}: no limit cycle in the cells where its assumptions hold ({of})."
    size = _range([1e3 * row["p2p_rad"] for row in cycles], "mrad peak to peak")
    pitches = [row["frequency_hz"] for row in cycles if row["frequency_hz"] is not None]
    pitch = f" at {_range(pitches, 'Hz')}" if pitches else ""
    none = f"; no limit cycle in {len(inside) - len(cycles)} of these" if len(cycles) < len(inside) else ""
    return f"{name}: {size}{pitch}, where its assumptions hold ({of}{none})."


def best_remedy(grid: Mapping[str, Row]) -> str:
    """Of a trial of remedies: which makes the largest cycles smallest over the grid, and how surely."""
    helped = {name: row for name, row in grid.items() if (row["ratio_median"] or 0.0) > 1.0}
    if not helped:
        return "No remedy makes the buzz smaller over the grid."
    name = max(helped, key=lambda key: helped[key]["ratio_median"])
    row = helped[name]
    proven = "all proven" if row["certified_fraction"] == 1.0 else f"{100.0 * row['certified_fraction']:.3g} % proven"
    least = f"at least {row['ratio_least']:.3g} times" if row["ratio_least"] else "in some cell it buzzes anew"
    return f"Smallest buzz: {name}, {row['ratio_median']:.3g} times smaller (median over the grid; {least}; {proven})."


def identified(rows: Sequence[Row], *, errors: str) -> str:
    """Of an identification: what the most trustworthy estimator found, with errors, and how far to trust it.

    ``rows``: conditions by all estimators; ``errors``: what stands behind the plus and minus. The most trustworthy
    estimator is that with the fewest doubts; of several, that which explains most of the motion.
    """
    by = {
        name: [row for row in rows if row["estimator"] == name]
        for name in dict.fromkeys(row["estimator"] for row in rows)
    }
    by = {name: mine for name, mine in by.items() if any(_known(row, column) for row in mine for column in _HAND)}
    if not by:
        return "Nothing could be identified."
    name = min(by, key=lambda one: (_doubts(by[one]) / len(by[one]), -_explained(by[one])))
    mine = by[name]
    found = [said for column in _HAND if (said := _spread(mine, column))]
    where = "" if len(mine) == 1 else f", over {len(mine)} conditions"
    doubts = _doubts(mine)
    trust = (
        "Nothing in the data speaks against it."
        if not doubts
        else "It is doubtful: the flags say why."
        if len(mine) == 1
        else f"It is doubtful in {doubts} of these: their flags say why."
    )
    return f"By {name} (± {errors}): {'; '.join(found)}{where}. {trust}"


def _known(row: Row, column: str) -> bool:
    """Whether a parameter was found: what was given has no error."""
    return row[column] is not None and row[f"{column}_std"] != 0.0


def _doubts(rows: Sequence[Row]) -> int:
    return sum(bool(row["flags"]) for row in rows)


def _explained(rows: Sequence[Row]) -> float:
    return float(median([row["vaf"] for row in rows if row["vaf"] is not None] or [0.0]))


def _spread(rows: Sequence[Row], column: str) -> str:
    """A parameter with its error; of several conditions the least and the largest. Empty where none is known."""
    known = sorted((row for row in rows if _known(row, column)), key=lambda row: row[column])
    if not known:
        return ""
    what, scale, unit = _HAND[column]
    ends = [_with_error(row[column], row[f"{column}_std"], scale) for row in (known[0], known[-1])]
    return f"{what} {' to '.join(ends[: len(known)])} {unit}"


def _with_error(value: float, error: float | None, scale: float) -> str:
    return short(scale * value, 3) + (f" ± {short(scale * error, 2)}" if error is not None else "")


def calibrated(quantities: Sequence[Row]) -> str:
    """Of a calibration: how many of its quantities are doubtful."""
    doubts, count = _doubts(quantities), len(quantities)
    return f"{doubts} of {count} quantities are doubtful: their flags say why." if doubts else _no_doubt(count)


def _no_doubt(count: int) -> str:
    return f"Nothing speaks against any of the {count} quantities." if count > 1 else "Nothing speaks against it."


def biased(rows: Sequence[Row]) -> str:
    """Of a study of estimators: the largest bias of each over all causes and parameters, the least first."""
    worst: dict[str, float] = {}
    for row in rows:
        worst[row["estimator"]] = max(worst.get(row["estimator"], 0.0), abs(row["bias_percent"]))
    said = ", ".join(f"{name} {short(value, 3)} %" for name, value in sorted(worst.items(), key=lambda one: one[1]))
    return f"Largest bias of a parameter over everything tried: {said}."


def people_buzz(cells: Sequence[Row]) -> str:
    """Of a population: how many people it buzzes for, and how much.

    ``cells``: of each cell of the other axes the share, median and quantiles that `population.describe_people` gives.
    """
    shares = [100.0 * row["buzzing_fraction"] for row in cells]
    where = "" if len(cells) == 1 else f", depending on the cell ({len(cells)} cells)"
    buzz = [row for row in cells if row["buzzing_fraction"]]
    text = f"It buzzes for {_range(shares, '%')} of {cells[0]['people']} people{where}, from the starts tried."
    if not buzz:
        return text
    sizes = _range([1e3 * row["p2p_max_rad_median"] for row in buzz], "mrad")
    large = _range([1e3 * row["p2p_max_rad_p95"] for row in buzz], "mrad")
    pitch = _range([row["frequency_at_max_hz_median"] for row in buzz], "Hz")
    return f"{text} The median of all people is {sizes}; one in twenty has more than {large}; median pitch {pitch}."


def compared(scenes: Sequence[Row]) -> str:
    """Of a benchmark: where the exact engine is accurate, and how much longer the fastest accurate rival takes.

    ``scenes``: times at equal error, a row a scene, of `bench.equal_error`.
    """
    good = [row for row in scenes if row["exact_seconds"] is not None]
    ratios = [row["ratio"] for row in good if row["ratio"] is not None]
    text = f"The exact engine is accurate in {len(good)} of {len(scenes)} scenes."
    if ratios:
        text += f" The fastest accurate rival takes {_range(ratios, 'times')} as long"
        text += f" (median {short(median(ratios), 3)})" if len(ratios) > 1 else ""
        without = len(good) - len(ratios)
        text += f"; in {without} of these scenes no rival is accurate." if without else "."
    return text


def _size(row: Row) -> str:
    return f"{short(1e3 * row['p2p_max_rad'])} mrad at {short(row['frequency_at_max_hz'])} Hz"


def _at(row: Row, axes: Collection[str]) -> str:
    place = ", ".join(f"{axis} = {short(row[axis], 6)}" for axis in axes)
    return f" ({place})" if place else ""


def _range(values: Sequence[float], unit: str) -> str:
    low, high = short(min(values)), short(max(values))
    return f"{low} {unit}" if low == high else f"{low} to {high} {unit}"
