"""What each result on a page answers, in the words of the terminal, and the numbers that a page shows first."""

from collections.abc import Iterator, Sequence

import numpy as np
import pyarrow as pa

from hknob_cli.errors import MISSHAPEN, UsageError
from hknob_cli.page.book import Tile
from hknob_cli.report.bench import equal_error
from hknob_cli.report.hw_run import describe_pulses, pulses_verdict
from hknob_cli.report.large import describe_people, varying
from hknob_cli.report.remedies import over_the_grid, over_the_trials, tried_verdict
from hknob_cli.report.table import short
from hknob_cli.report.theory import largest_cycles, passive_verdict
from hknob_cli.report.verdicts import (
    Buzz,
    Row,
    best_remedy,
    biased,
    calibrated,
    compared,
    expected,
    found_of,
    people_buzz,
    quietest,
    scope_of,
    unproven_of,
)
from hknob_cli.report.what_matters import columns_of
from hknob_cli.results.columns import WORST
from hknob_cli.results.result_set import CAMPAIGN, MissingError, Result, ResultSet
from hknob_cli.specs.plan import COUNTS, PERSON, RATE

_SHARES = ("at_rest_fraction", "certified_fraction")
_RANGED = ("complete", "share_error", "grows_rad", "undecided_fraction", "piece_count")
_OTHERS = (*_RANGED, "sustained", "growth_j_per_s2", "rattle_max_rad", "jitter_max_rad", "clock_bound_rad")


def answers_of(evidence: ResultSet) -> tuple[str, ...]:
    """The answer of each result, its name first. Raises `UsageError` for tables of another shape than its stage's."""
    return tuple(f"{name}: {text}" for name in evidence.names for text in checked(evidence[name]))


def checked(result: Result) -> list[str]:
    """The answers of one result. Raises `UsageError`."""
    try:
        return list(_answers(result))
    except MissingError:
        return []
    except MISSHAPEN as error:
        text = f"the tables of '{result.name}' in {result.folder} are not as its stage writes them"
        raise UsageError(f"results: {text}: {error}") from error


def _answers(result: Result) -> Iterator[str]:
    kind = result.stage
    if result.has_remedies:
        yield tried_verdict(over_the_trials(result.rows("remedies")), result.reference)
    elif result.has_pulses:
        yield pulses_verdict(describe_pulses(result.table("trials"))["pulses"])
    elif kind in ("sweep", CAMPAIGN):
        if PERSON in result.axes and not result.parted("cells"):
            yield people_buzz(describe_people(result.rows("cells"), result.axes))
        elif found := buzz_in(result):
            yield f"{found.text(varying_axes(result))}{_surely(result)}"
    elif kind in ("dfa", "predict"):
        by = "method" if kind == "dfa" else "law"
        if kind == "predict":
            yield passive_verdict(result.rows("passivity"))
        rows = result.rows(kind)
        for name in dict.fromkeys(row[by] for row in rows):
            mine = [row for row in rows if row[by] == name]
            yield expected(name, largest_cycles(mine, list(result.axes)) if kind == "dfa" else mine)
    elif kind == "remedies":
        yield best_remedy(over_the_grid(result.rows("remedies")))
    elif kind == "design":
        yield _designed(result)
    elif kind == "bench":
        yield compared(_scenes(result.rows("bench")))
    elif kind == "sysid":
        yield from _identified(result)


def buzz_in(result: Result) -> Buzz | None:
    """What the cells of a sweep or campaign say together, part by part where it is large; None where none settles."""
    size, pitch = WORST
    axes = list(result.axes)
    found = Buzz(0, 0, 0, None, None, "")
    for table in result.tables("cells", [*axes, *WORST, *_SHARES, *_OTHERS]):
        if "growth_j_per_s2" in table.column_names or size not in table.column_names:
            return None
        column = columns_of(table, [size, pitch, *({_SHARES[0]} & set(table.column_names))])
        resting = column.get(_SHARES[0], np.zeros(table.num_rows))
        if not np.isfinite(column[pitch][column[size] > 0.0]).all():
            raise ValueError("of cells with a size some have no pitch")
        complete = "complete" not in table.column_names or bool(np.all(table["complete"].to_numpy()))
        found = _merged(found, _part(table, column[size], resting, complete=complete))
    return found


def _part(table: pa.Table, sizes: "np.ndarray", resting: "np.ndarray", *, complete: bool) -> Buzz:
    moving = np.flatnonzero(sizes > 0.0)
    ends: list[Row | None] = [None, None]
    if moving.size:
        places = (moving[np.argmax(sizes[moving])], moving[np.argmin(sizes[moving])])
        ends = [table.slice(int(place), 1).to_pylist()[0] for place in places]
    scope = scope_of(table.column_names, complete=complete)
    swings, moves, bounds = (
        tuple(table[name].drop_null().to_pylist()) if name in table.column_names else ()
        for name in ("rattle_max_rad", "jitter_max_rad", "clock_bound_rad")
    )
    still = int((resting == 1.0).sum())
    return Buzz(
        table.num_rows, int(moving.size), still, ends[0], ends[1], scope, swings, _unproven(table), moves, bounds
    )


def _unproven(table: pa.Table) -> tuple[int, float]:
    names = [name for name in _RANGED if name in table.column_names]
    return unproven_of(table.select(names).to_pylist()) if "complete" in names else (0, 0.0)


def _merged(one: Buzz, other: Buzz) -> Buzz:
    size = WORST[0]
    most = [row for row in (one.most, other.most) if row]
    least = [row for row in (one.least, other.least) if row]
    return Buzz(
        one.cells + other.cells,
        one.buzzing + other.buzzing,
        one.resting + other.resting,
        max(most, key=lambda row: row[size], default=None),
        min(least, key=lambda row: row[size], default=None),
        one.scope if one.cells and one.scope != scope_of(("complete",), complete=True) else other.scope,
        (*one.rattles, *other.rattles),
        (one.unproven[0] + other.unproven[0], max(one.unproven[1], other.unproven[1])),
        (*one.jitters, *other.jitters),
        (*one.bounds, *other.bounds),
    )


def varying_axes(result: Result) -> list[str]:
    """Names of the axes that have several values."""
    if large := result.parted("cells"):
        return varying(large, result.axes)
    table = result.table("cells")
    return [axis for axis in result.axes if len(set(table.column(axis).to_pylist())) > 1]


def _surely(result: Result) -> str:
    """How much of a sweep is proven."""
    if result.stage == CAMPAIGN:
        return ""
    name = _SHARES[1]
    least = min(float(columns_of(table, [name])[name].min()) for table in result.tables("cells", [name]))
    if not np.isfinite(least):
        raise ValueError("some cells are neither proven nor not")
    if least == 0.0:
        return " In some cells no trial is proven." if len(varying_axes(result)) else " No trial is proven."
    part = "Every trial is" if least == 1.0 else f"At least {100 * least:.0f} % of the trials of a cell are"
    return f" {part} proven."


def _designed(result: Result) -> str:
    rows = result.rows("design")
    chosen = next((row for row in rows if row["chosen"]), None)
    if chosen is None:
        return "No design meets every limit."
    axes = [name for name in chosen if name in (RATE, COUNTS) or "." in name]
    what = ", ".join([chosen["remedy"], *(f"{name} = {short(chosen[name], 6)}" for name in axes)])
    proof = "every orbit of everyone is proven" if chosen["certified"] else "not all of it is proven"
    return f"Cheapest that meets every limit: {what}, at a cost of {chosen['cost']:g}; {proof}."


def _scenes(rows: Sequence[Row]) -> list[Row]:
    scenes = dict.fromkeys(row["scene"] for row in rows)
    return [equal_error([dict(row) for row in rows if row["scene"] == scene]) for scene in scenes]


def _identified(result: Result) -> Iterator[str]:
    if "conditions.parquet" in result.files:
        yield found_of(result.rows("conditions"))
    if "calibration.parquet" in result.files:
        yield calibrated(result.rows("calibration"))
    if "bias.parquet" in result.files:
        yield biased(result.rows("bias"))


def tiles_of(evidence: ResultSet, first: Sequence[str]) -> tuple[Tile, ...]:
    """The numbers that a page begins with: of the first sweep that buzzes or rests, and of the first remedies.

    ``first``: names of results that come before the others, those of the page's first picture.
    """
    names = list(dict.fromkeys([*(name for name in first if name in evidence), *evidence.names]))
    found: list[Tile] = []
    for name in names:
        result = evidence[name]
        cells = result.stage in ("sweep", CAMPAIGN) and not (result.has_remedies or result.has_pulses)
        if cells and (buzz := buzz_in(result)) and buzz.cells:
            found += _of_buzz(buzz, name)
            break
    for name in names:
        if evidence[name].stage == "remedies":
            grid = over_the_grid(evidence[name].rows("remedies"))
            if best := quietest(grid):
                times = f"{grid[best]['ratio_median']:.3g} times"
                said = f"smaller with {best}, the quietest fix that leaves a buzz (median over the grid)"
                found.append(Tile(times, said, name))
            break
    return tuple(found)


def _of_buzz(buzz: Buzz, name: str) -> Iterator[Tile]:
    if buzz.cells > 1:
        yield Tile(f"{buzz.buzzing:,} of {buzz.cells:,}", f"cells buzz{buzz.scope}", name)
    if buzz.most is None:
        if buzz.cells == 1:
            yield Tile("at rest" if buzz.resting else "no limit cycle", buzz.scope.removeprefix(", "), name)
        return
    size, pitch = (short(scale * buzz.most[key], 3) for key, scale in zip(WORST, (1e3, 1.0), strict=True))
    what = "largest buzz, peak to peak" if buzz.cells > 1 else "buzz, peak to peak"
    yield Tile(f"{size} mrad", f"{what}, at {pitch} Hz", name)
