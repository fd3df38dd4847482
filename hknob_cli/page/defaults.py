"""What a page shows where its spec lists no chapters: pictures and tables of each result, by its kind."""

from collections.abc import Callable
from typing import TypeVar

from hknob_cli.errors import MISSHAPEN, UsageError
from hknob_cli.figures.defaults import figures_of
from hknob_cli.results.result_set import CAMPAIGN, Result, ResultSet
from hknob_cli.specs.stage_plans import ChapterPlan, TablePlan

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
    CAMPAIGN: ("cells", "remedies", "trials"),
    "bench": ("bench",),
}
_FLAGS = ("chosen", "present", "next_cheaper", "front")

T = TypeVar("T")


def tables_of(result: Result) -> tuple[TablePlan, ...]:
    """A table of each file that is there and has rows; recordings are drawn, not listed."""
    return tuple(_table(result, file) for file in _FILES.get(result.stage, ()) if _has_rows(result, file))


def _has_rows(result: Result, file: str) -> bool:
    if result.stage == CAMPAIGN and file == "cells":
        if result.has_remedies or result.has_pulses:  # whose table has the same cells, or which has none
            return False
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
