"""The answer first: what a result of many cells says, in a sentence with its scope."""

from collections.abc import Collection, Mapping, Sequence
from typing import Any, NamedTuple

from hknob_cli.report.sweep_words import every_clock_text, jitter_text, of_cells, range_text, rattle_text
from hknob_cli.report.table import short

Row = Mapping[str, Any]
RECORDED = ", in the trials recorded"
ERROR, DEVIATION = "standard error", "standard deviation over persons"  # what stands behind a plus and minus
# Parameters of a hand: columns, names, and scales to units that are read easily.
_HAND = {
    "inertia_kg_m2": ("inertia", 1e7, "g·cm²"),
    "damping_nm_s_per_rad": ("damping", 1e3, "mN·m·s/rad"),
    "stiffness_nm_per_rad": ("stiffness", 1e3, "mN·m/rad"),
}


class Buzz(NamedTuple):
    """What the cells of a sweep, or of a campaign on a knob, say together.

    ``most`` and ``least``: rows of the cells with the largest and the smallest of the cells' largest cycles; None where
    none cycles. ``resting``: cells in which every trial comes to rest. ``scope``: from which starts. ``rattles``:
    swings of the knob (rad) in cells where the teeth of a gear part and no trial repeats. ``unproven``: how many cells
    have a part of their range of starts without a proven end, and the largest such part. ``jitters``: swings (rad) in
    cells where the sample clock jitters and some trial has not come to rest. ``bounds``: on swings (rad) under every
    clock, of the cells where one is proven.
    """

    cells: int
    buzzing: int
    resting: int
    most: Row | None
    least: Row | None
    scope: str
    rattles: tuple[float, ...] = ()
    unproven: tuple[int, float] = (0, 0.0)
    jitters: tuple[float, ...] = ()
    bounds: tuple[float, ...] = ()

    def text(self, axes: Collection[str]) -> str:
        """The answer in a sentence or four; ``axes``: the names that vary."""
        cells, share = self.unproven
        said = self._cycles(axes) + rattle_text(self.rattles, f" in {of_cells(len(self.rattles), self.cells)}")
        said += jitter_text(self.jitters, f" in {of_cells(len(self.jitters), self.cells)}")
        said += every_clock_text(self.bounds, self.cells)
        if not cells:
            return said
        most = "" if cells == 1 else "up to "
        where = "" if self.cells == 1 else f"In {of_cells(cells, self.cells)} "
        return f"{said} {where}{most}{percent(share)} of the range has no proven end."

    def _cycles(self, axes: Collection[str]) -> str:
        if not self.cells:
            return "No trial could be measured."
        if self.most is None or self.least is None:
            if self.scope == RECORDED:
                return f"No sustained buzz in {of_cells(0, self.cells)}{RECORDED}."
            if self.resting == self.cells:
                return f"It comes to rest in {of_cells(self.cells, self.cells)}{self.scope}."
            return f"No limit cycle in {of_cells(0, self.cells)}{self.scope}."
        where = f"It buzzes in {of_cells(self.buzzing, self.cells)}{self.scope}"
        if self.buzzing == 1:
            return f"{where}: {buzz_size(self.most)}{_at(self.most, axes)}."
        return (
            f"{where}. The most: {buzz_size(self.most)}{_at(self.most, axes)}. "
            f"The least: {buzz_size(self.least)}{_at(self.least, axes)}."
        )


def buzz_of(cells: Sequence[Row]) -> Buzz:
    """Of rows of ``cells.parquet``, or of the cells of a campaign on a knob."""
    buzz = [row for row in cells if row["p2p_max_rad"]]
    return Buzz(
        len(cells),
        len(buzz),
        sum(row["at_rest_fraction"] == 1.0 for row in cells),
        max(buzz, key=lambda row: row["p2p_max_rad"], default=None),
        min(buzz, key=lambda row: row["p2p_max_rad"], default=None),
        scope_of(cells[0], complete=all(row.get("complete", True) for row in cells)) if cells else "",
        tuple(row["rattle_max_rad"] for row in cells if row.get("rattle_max_rad")),
        unproven_of(cells),
        tuple(row["jitter_max_rad"] for row in cells if row.get("jitter_max_rad")),
        tuple(row["clock_bound_rad"] for row in cells if row.get("clock_bound_rad") is not None),
    )


def unproven_of(cells: Sequence[Row]) -> tuple[int, float]:
    """Of how many cells a part of the range of starts has no proven end, and the largest such part.

    Nothing is proven of a range in which no set was followed, whatever its random starts do. Cells whose motions grow
    without bound are left out: their list says so itself.
    """
    shares = [share for row in cells if (share := _unproven(row)) > 0.0]
    return len(shares), max(shares, default=0.0)


def _unproven(row: Row) -> float:
    # `share_error` is of one start, and only sets of starts have pieces.
    if row.get("complete", True) or "share_error" in row or "piece_count" not in row or row.get("grows_rad"):
        return 0.0
    return float(row["undecided_fraction"]) if row["piece_count"] else 1.0


def percent(share: float) -> str:
    """A share that is never called all or nothing by rounding."""
    said = f"{100.0 * share:.3g}"
    return "almost 100 %" if said == "100" and share < 1.0 else f"{said} %"


def grid_verdict(cells: Sequence[Row], axes: Collection[str]) -> str:
    """The answer of many cells in a sentence or three; ``axes``: the names that vary."""
    return buzz_of(cells).text(axes)


def scope_of(columns: Collection[str], *, complete: bool) -> str:
    """From which starts, by the columns of the cells: of a campaign, of starts tried, or of all that a spec has."""
    if "sustained" in columns:
        return RECORDED
    return ", from every start of the spec" if complete and "complete" in columns else ", from the starts tried"


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
    size = range_text([1e3 * row["p2p_rad"] for row in cycles], "mrad peak to peak")
    pitches = [row["frequency_hz"] for row in cycles if row["frequency_hz"] is not None]
    pitch = f" at {range_text(pitches, 'Hz')}" if pitches else ""
    none = f"; no limit cycle in {len(inside) - len(cycles)} of these" if len(cycles) < len(inside) else ""
    return f"{name}: {size}{pitch}, where its assumptions hold ({of}{none})."


def quietest(grid: Mapping[str, Row]) -> str:
    """Of a trial of remedies: the one that makes the largest cycles smallest over the grid; empty if none does."""
    helped = {name: row for name, row in grid.items() if (row["ratio_median"] or 0.0) > 1.0}
    return max(helped, key=lambda key: helped[key]["ratio_median"]) if helped else ""


def best_remedy(grid: Mapping[str, Row]) -> str:
    """Of a trial of remedies: which bring the knob to rest, which makes cycles smallest over the grid, how surely."""
    rests = [one for one, row in grid.items() if row["at_rest_fraction"] > 1.0 - 1e-9]
    still = f"To rest everywhere: {', '.join(rests)}. " if rests else ""
    name = quietest(grid)
    if not name:
        return still.strip() or "No remedy makes the buzz smaller over the grid."
    row = grid[name]
    proven = "all proven" if row["certified_fraction"] == 1.0 else f"{100.0 * row['certified_fraction']:.3g} % proven"
    least = f"at least {row['ratio_least']:.3g} times" if row["ratio_least"] else "in some cell it buzzes anew"
    smaller = f"{name}, {row['ratio_median']:.3g} times smaller (median over the grid; {least}; {proven})."
    return f"{still}Smallest buzz{' of the others' if still else ''}: {smaller}"


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


def alone(rows: Sequence[Row]) -> Sequence[Row]:
    """Rows that no mean over persons stands for: those of the only person, or of knobs that nobody grips."""
    own = [row for row in rows if row["level"] == "subject"]
    held = any(row["grip_target_n"] for row in own)
    return own if not held or len({row["subject"] for row in own}) == 1 else []


def found_of(rows: Sequence[Row]) -> str:
    """What all conditions of ``conditions.parquet`` say together."""
    single = alone(rows)
    return identified(single or [row for row in rows if row["level"] == "all"], errors=ERROR if single else DEVIATION)


def _known(row: Row, column: str) -> bool:
    """Whether a parameter was found: what was given has no error."""
    return row[column] is not None and row[f"{column}_std"] != 0.0


def _doubts(rows: Sequence[Row]) -> int:
    return sum(bool(row["flags"]) for row in rows)


def _explained(rows: Sequence[Row]) -> float:
    from statistics import median

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

    ``cells``: of each cell of the other axes the share, median and quantiles that `large.describe_people` gives.
    """
    shares = [100.0 * row["buzzing_fraction"] for row in cells]
    where = "" if len(cells) == 1 else f", depending on the cell ({len(cells)} cells)"
    buzz = [row for row in cells if row["buzzing_fraction"]]
    text = f"It buzzes for {range_text(shares, '%')} of {cells[0]['people']} people{where}, from the starts tried."
    if not buzz:
        return text
    sizes = range_text([1e3 * row["p2p_max_rad_median"] for row in buzz], "mrad")
    large = range_text([1e3 * row["p2p_max_rad_p95"] for row in buzz], "mrad")
    pitch = range_text([row["frequency_at_max_hz_median"] for row in buzz], "Hz")
    return f"{text} The median of all people is {sizes}; one in twenty has more than {large}; median pitch {pitch}."


def compared(scenes: Sequence[Row]) -> str:
    """Of a benchmark: where the exact engine is accurate, and how much longer the fastest accurate rival takes.

    ``scenes``: times at equal error, a row a scene, of `bench.equal_error`.
    """
    from statistics import median

    good = [row for row in scenes if row["exact_seconds"] is not None]
    ratios = [row["ratio"] for row in good if row["ratio"] is not None]
    text = f"The exact engine is accurate in {len(good)} of {len(scenes)} scenes."
    if ratios:
        text += f" The fastest accurate rival takes {range_text(ratios, 'times')} as long"
        text += f" (median {short(median(ratios), 3)})" if len(ratios) > 1 else ""
        without = len(good) - len(ratios)
        text += f"; in {without} of these scenes no rival is accurate." if without else "."
    return text


def buzz_size(row: Row) -> str:
    """Size and pitch of the largest cycle of a cell."""
    return f"{short(1e3 * row['p2p_max_rad'])} mrad at {short(row['frequency_at_max_hz'])} Hz"


def _at(row: Row, axes: Collection[str]) -> str:
    place = ", ".join(f"{axis} = {short(row[axis], 6)}" for axis in axes)
    return f" ({place})" if place else ""
