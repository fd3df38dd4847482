"""Further criteria of stability in every cell of a grid, each beside whether the sweep cycles there: one table."""

from collections.abc import Iterator
from math import isfinite
from typing import Any

import pyarrow as pa

from hknob_cli.errors import ComputationError
from hknob_cli.results.arrays import build_table
from hknob_cli.results.columns import Column, axis_column
from hknob_cli.specs.cells import cells_of
from hknob_cli.specs.plan import COUNTS, RATE, PredictPlan, scene_at
from hknob_cli.stages import compare
from hknob_cli.theory.laws import working_edge

_REAL, _FLAG, _TEXT = pa.float64(), pa.bool_(), pa.string()

COLUMNS = (
    Column("criterion", _TEXT, "", "tsypkin, tsai_colgate, miller, love_book or llewellyn"),
    Column("holds", _FLAG, "", "whether the wall without counts satisfies it; null where it does not apply"),
    Column("load", _REAL, "1", "the wall's stiffness over stiffness_limit; null where there is none, or it is 0"),
    Column(
        "stiffness_limit_nm_per_rad",
        _REAL,
        "N*m/rad",
        "largest stiffness that satisfies it without counts; null where every stiffness does, or it does not apply",
    ),
    Column(
        "quantised_stiffness_limit_nm_per_rad",
        _REAL,
        "N*m/rad",
        "the same of the wall with the encoder's counts; null where it says nothing of counts, or every stiffness does",
    ),
    Column(
        "damping_least_nm_s_per_rad",
        _REAL,
        "N*m*s/rad",
        "love_book: least virtual damping that satisfies it at this stiffness; null where none does",
    ),
    Column(
        "damping_most_nm_s_per_rad",
        _REAL,
        "N*m*s/rad",
        "love_book: most virtual damping that satisfies it at this stiffness; null where none does",
    ),
    Column("in_domain", _FLAG, "", "whether the criterion's assumptions hold"),
    Column("reason", _TEXT, "", "the first assumption that does not hold; empty where all do"),
)
AGAINST = (Column("sweep_cycles", _FLAG, "", "whether any trial of the sweep cycles; null where it has no such cell"),)


def evaluate(plan: PredictPlan) -> pa.Table:
    """Every criterion of a plan in every cell.

    Raises `ComputationError` for numbers that overflow, and `UsageError` for a sweep that is not there.
    """
    axes = [axis_column(name, plan.units[name]) for name in plan.axes]
    return build_table([*axes, *COLUMNS, *(AGAINST if plan.against else ())], list(_rows(plan)))


def _rows(plan: PredictPlan) -> Iterator[dict[str, Any]]:
    from hknob_cli.theory.criteria import case_of, judge

    every = cells_of(plan)
    against = compare.Against(plan.against, list(plan.axes), every) if plan.against else None
    for cell in every:
        scene = scene_at(plan.scene, cell)
        edge = working_edge(scene, cell)
        case = case_of(scene, edge)
        for name in plan.criteria:
            try:
                found = judge(name, case)
            except ArithmeticError:
                message = f"at {cell[RATE]:g} Hz and {cell[COUNTS]} counts the scene's numbers overflow"
                raise ComputationError(message) from None
            limit = found.stiffness
            yield {
                **cell,
                "criterion": name,
                "holds": found.holds,
                "load": edge.wall_stiffness / limit if limit else None,
                "stiffness_limit_nm_per_rad": _finite(limit),
                "quantised_stiffness_limit_nm_per_rad": _finite(found.quantised),
                "damping_least_nm_s_per_rad": _finite(found.least_damping),
                "damping_most_nm_s_per_rad": _finite(found.most_damping),
                "in_domain": found.in_domain,
                "reason": found.reason,
                **({"sweep_cycles": against.cycles(cell)} if against else {}),
            }


def _finite(value: float | None) -> float | None:
    return value if value is not None and isfinite(value) else None
