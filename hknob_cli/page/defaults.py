"""What a page says and shows where its spec lists neither sentences nor chapters: each result, by its kind.

The tables that a page shows of each kind of result where its spec lists no chapters.
"""

from collections.abc import Callable
from typing import TypeVar

import numpy as np

from hknob_cli.errors import MISSHAPEN, UsageError
from hknob_cli.figures.defaults import figures_of
from hknob_cli.report.what_matters import columns_of
from hknob_cli.results.means import SAME, WORST
from hknob_cli.results.result_set import CAMPAIGN, MissingError, Result, ResultSet
from hknob_cli.specs.page_plan import ChapterPlan, TablePlan

_MEAN = "Peak to peak and frequency are means over the trials that cycle."
_TITLES = {
    "cells": "cells",
    "orbits": "attractors",
    "dfa": "limit cycles by method",
    "predict": "predictions by law",
    "passivity": "passivity and stability limits",
    "differences": "differences from the sweep",
    "remedies": "remedies over the grid",
    "cases": "remedies at each case",
    "design": "designs",
    "conditions": "conditions",
    "trials": "trials",
    "calibration": "calibration",
    "bias": "bias of the estimators",
    "hidden_inertia": "hidden inertia",
    "bench": "runs",
}
# Of a table too long to be shown whole, the column whose largest values are shown.
_KEYS = {
    "cells": ("p2p_max_rad", "p2p_rad", "growth_j_per_s2"),
    "orbits": ("p2p_rad",),
    "dfa": ("p2p_rad",),
    "predict": ("p2p_rad",),
    "remedies": ("p2p_ratio",),
    "cases": ("p2p_ratio",),
}
_FILES = {
    "sweep": ("cells", "orbits"),
    "dfa": ("dfa", "differences"),
    "predict": ("predict", "passivity", "differences"),
    "remedies": ("cases", "remedies"),
    "design": ("design",),
    "sysid": ("conditions", "trials", "calibration", "bias", "hidden_inertia"),
    CAMPAIGN: ("cells", "trials"),
    "bench": ("bench",),
}
_FLAGS = ("chosen", "present", "next_cheaper", "front")

T = TypeVar("T")


def tables_of(result: Result) -> tuple[TablePlan, ...]:
    """A table of each file that is there and has rows; recordings are drawn, not listed."""
    return tuple(_table(result, file) for file in _FILES.get(result.stage, ()) if _has_rows(result, file))


def _has_rows(result: Result, file: str) -> bool:
    if result.stage == CAMPAIGN and file == "cells":
        return bool(result.table(file).num_rows)
    if f"{file}.parquet" not in result.files:
        return False
    if result.parted(file):  # attractors of a hundred thousand cells say less than their cells
        return file != "orbits"
    return bool(result.table(file).num_rows)


def _table(result: Result, file: str) -> TablePlan:
    slug = "".join(letter if letter.isalnum() else "-" for letter in f"{result.name}-{file}".lower()).strip("-")
    made = "trials.parquet, averaged by cell" if result.stage == CAMPAIGN and file == "cells" else ""
    columns = result.table(file).column_names if made else result.columns(file)
    is_design = file == "design"
    return TablePlan(
        id=f"table-{slug}",
        of=result.name,
        file=file,
        title=f"{result.name}: {_TITLES[file]}",
        caption=_MEAN if file == "cells" and "p2p_max_rad" in columns and "growth_j_per_s2" not in columns else "",
        key=next((name for name in _KEYS.get(file, ()) if name in columns), ""),
        first=tuple(name for name in _FLAGS if name in columns) if is_design else (),
        first_are="the front, the answer, the next cheaper and the present design" if is_design else "",
        made=made,
    )


def chapters_of(evidence: ResultSet) -> tuple[ChapterPlan, ...]:
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


def sentences_of(evidence: ResultSet) -> tuple[str, ...]:
    """A sentence for each sweep, and each campaign on a knob: how many cells, how large, what pitch, how surely."""
    return tuple(text for name in evidence.names if (text := _of(evidence[name], _sentence)))


def _sentence(result: Result) -> str:
    size, pitch = WORST
    names = ("p2p_rad", *WORST, "at_rest_fraction", "certified_fraction")
    try:
        parts = [columns_of(table, table.column_names) for table in result.tables("cells", names)]
    except MissingError:
        return ""
    column = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    count = len(next(iter(column.values()), ()))
    cells = f"{result.name}: {count:,} cell{'s' if count != 1 else ''}"
    resting = column.get("at_rest_fraction", np.zeros(count))
    moving = column[size] > 0.0 if size in column else np.zeros(count, dtype=bool)
    if not moving.any():
        where = "in all" if count > 1 else "there"
        return f"{cells}, the knob comes to rest {where}." if count and (resting == 1.0).all() else ""
    sizes, pitches = 1e3 * column[size][moving], column[pitch][moving]
    proven = 1.0 if result.stage == CAMPAIGN else column["certified_fraction"].min()
    if not (np.isfinite(pitches).all() and np.isfinite(proven)):
        raise ValueError("of cells with a size some have no pitch, or are neither proven nor not")
    means = 1e3 * column["p2p_rad"][moving] if "p2p_rad" in column else sizes
    differs = bool((np.abs(means - sizes) > SAME * sizes).any())
    mean = f"; mean of those that cycle {_span(means)} mrad" if differs else ""
    surely = "recorded" if result.stage == CAMPAIGN else _surely(float(proven))
    found = f"peak to peak of the largest cycle {_span(sizes)} mrad, {_span(pitches).removeprefix('from ')} Hz"
    return f"{cells}: {found}{mean}{_rest(resting, count)}; {surely}."


def _span(values: "np.ndarray") -> str:
    """Least and largest of some values; the one, where they are equal as written."""
    least, most = f"{values.min():.3g}", f"{values.max():.3g}"
    return most if least == most else f"from {least} to {most}"


def _rest(resting: "np.ndarray", count: int) -> str:
    """In how many cells the knob comes to rest, always or from some starts."""
    still, some = int((resting == 1.0).sum()), int(((resting > 0.0) & (resting < 1.0)).sum())
    if count == 1:
        return f"; {100.0 * float(resting[0]):.3g} % of the trials come to rest" if some else ""
    found = [f"at rest in {still}"] if still else []
    found += [f"some trials come to rest in {some}"] if some else []
    return "".join(f"; {one}" for one in found)


def _surely(proven: float) -> str:
    return "every trial proven" if proven == 1.0 else f"at least {100 * proven:.0f} % of the trials of a cell proven"
