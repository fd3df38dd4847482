"""The tables that a page shows of each kind of result where its spec lists no chapters."""

from hknob_cli.results.result_set import CAMPAIGN, Result
from hknob_cli.specs.page_plan import TablePlan

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
