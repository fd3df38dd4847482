"""Columns of a sweep whose cells are searched from all of their starts, as far as that can be."""

from collections.abc import Sequence
from typing import Any

from hknob_cli.engine.outcome import Outcome
from hknob_cli.results.arrays import spell
from hknob_cli.results.columns import ANYWHERE, EVERY_START, ONE_START, Column
from hknob_cli.specs.plan import SweepPlan
from hknob_cli.stages.sweep.cell import CellResult
from hknob_cli.stages.sweep.every_start import INCOMPLETE, why_incomplete


def starts_columns(plan: SweepPlan, results: Sequence[CellResult]) -> tuple[tuple[Column, ...], dict[str, list[Any]]]:
    """The columns, and their values: whether every start was followed, and what is known of the others."""
    columns: tuple[Column, ...] = EVERY_START
    complete, pieces = [one.complete for one in results], [one.pieces for one in results]
    why = why_incomplete(complete, pieces, [one.why for one in results], plan.starts)
    values: dict[str, list[Any]] = {
        "complete": complete,
        "piece_count": pieces,
        "incomplete_reason": spell(INCOMPLETE, why),
    }
    if plan.starts.many:
        values["undecided_fraction"] = [_undecided(one) for one in results]
    else:
        columns = (*columns, *ONE_START)
        values["share_error"] = [one.share_error for one in results]
    if plan.starts.anywhere:
        columns = (*columns, *ANYWHERE)
        both = [(*(one.region or (None, None)), *(one.grows or (None, None))) for one in results]
        values |= {column.name: list(found) for column, found in zip(ANYWHERE, zip(*both, strict=True), strict=True)}
    return columns, values


def _undecided(result: CellResult) -> float:
    """Bound on the share of starts without a proven end; where some were drawn, the share of those."""
    if result.undecided is not None:
        return result.undecided
    unknown = sum(one.trials for one in result.attractors if one.outcome is Outcome.UNDECIDED)
    return unknown / sum(one.trials for one in result.attractors)
