"""What a page says and shows where its spec lists neither sentences nor chapters: each result, by its kind."""

from collections.abc import Callable
from typing import TypeVar

import numpy as np

from hknob_cli.errors import MISSHAPEN, UsageError
from hknob_cli.page.default_figures import figures_of
from hknob_cli.page.default_tables import tables_of
from hknob_cli.report.what_matters import columns_of
from hknob_cli.results.evidence import CAMPAIGN, Evidence, MissingError, Result
from hknob_cli.spec.page_plan import ChapterPlan

T = TypeVar("T")


def chapters_of(evidence: Evidence) -> tuple[ChapterPlan, ...]:
    """A chapter for each result, with pictures and tables of its rows. Raises `UsageError` for tables of others."""
    return tuple(_of(evidence[name], _chapter) for name in evidence.names)


def _of(result: Result, make: Callable[[Result], T]) -> T:
    """What is made of a result's tables, where they are as their stage writes them."""
    try:
        return make(result)
    except MISSHAPEN as error:
        text = f"the tables of '{result.name}' in {result.folder} are not as its stage writes them"
        raise UsageError(f"results: {text}: {error}") from error


def _chapter(result: Result) -> ChapterPlan:
    return ChapterPlan(f"{result.name} ({result.stage})", "", figures_of(result), tables_of(result))


def sentences_of(evidence: Evidence) -> tuple[str, ...]:
    """A sentence for each sweep, and each campaign on a knob: how many cells, how large, what pitch, how surely."""
    return tuple(text for name in evidence.names if (text := _of(evidence[name], _sentence)))


def _sentence(result: Result) -> str:
    names = ("p2p_rad", "frequency_hz", "at_rest_fraction", "certified_fraction")
    try:
        parts = [columns_of(table, table.column_names) for table in result.tables("cells", names)]
    except MissingError:
        return ""
    column = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    count = len(next(iter(column.values()), ()))
    cells = f"{result.name}: {count} cell{'s' if count > 1 else ''}"
    resting = column.get("at_rest_fraction", np.zeros(count)) == 1.0
    moving = column["p2p_rad"] > 0.0 if "p2p_rad" in column else np.zeros(count, dtype=bool)
    if not moving.any():
        return f"{cells}, the knob comes to rest in all." if count and resting.all() else ""
    sizes, pitches = 1e3 * column["p2p_rad"][moving], column["frequency_hz"][moving]
    proven = 1.0 if result.stage == CAMPAIGN else column["certified_fraction"].min()
    if not (np.isfinite(pitches).all() and np.isfinite(proven)):
        raise ValueError("of cells with a size some have no pitch, or are neither proven nor not")
    if result.stage == CAMPAIGN:
        surely = "recorded"
    else:
        every = proven == 1.0
        surely = "every trial proven" if every else f"at least {100 * proven:.0f} % of the trials of a cell proven"
    still = int(resting.sum())
    rest = f"; at rest in {still}" if still else ""
    return (
        f"{cells}: peak to peak from {sizes.min():.3g} to {sizes.max():.3g} mrad, "
        f"{pitches.min():.3g} to {pitches.max():.3g} Hz{rest}; {surely}."
    )
