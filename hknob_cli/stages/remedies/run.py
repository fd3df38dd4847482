"""The trial of remedies: every remedy over the grid, and at the cases what it costs in stiffness."""

from collections.abc import Callable
from functools import partial
from math import nan
from typing import TYPE_CHECKING, Any

import pyarrow as pa

from hknob_cli.results.arrays import build_table
from hknob_cli.results.columns import RANGED, Column, axis_column
from hknob_cli.specs.cells import Cells
from hknob_cli.specs.plan import PERSON
from hknob_cli.specs.stage_plans import RemediesPlan, Remedy
from hknob_cli.spread.cores import usable_cores
from hknob_cli.spread.forks import Forked, Forks
from hknob_cli.stages.lag_domain import has_domain
from hknob_cli.stages.remedies.columns import AXES, BUZZ, CASES, DOMAIN, KEYS, NEEDS, TUNED, level_columns, louder
from hknob_cli.stages.remedies.trial import Row, Rows, case_rows, grid_rows, tuned_rows, ways

FEW = 2000  # trials, which are over before another process has begun

if TYPE_CHECKING:
    from hknob_cli.stages.kept import Kept

Progress = Callable[[int, int], None]
Task = tuple[int, int | None, int]  # number of the remedy, of a case (without one, the grid), of the value it tunes
Found = dict[tuple[int, int | None], Rows]


class RemediesStage(Forked):
    """A trial that is ready to run."""

    def __init__(self, plan: RemediesPlan, *, jobs: int | None = None) -> None:
        """Make ready; ``jobs`` processes, as many as cores if None, begun on entering; without, one.

        The results do not depend on them.
        """
        self.plan = plan
        cases: list[int | None] = [None, *range(len(plan.cases))]
        every = [ways(one) for one in plan.remedies]
        self.tasks: list[Task] = [
            (i, case, way) for case in cases for i in range(len(every)) for way in range(len(every[i]))
        ]
        trials = sum(len(Cells(one.grid.axes)) * one.grid.starts.phases for some in every for one in some)
        self.jobs = 1 if trials < FEW else min(jobs or usable_cores(), len(self.tasks))
        self._forks = Forks(self.jobs)

    def run(
        self, progress: Progress = lambda _done, _total: None, kept: "Kept | None" = None
    ) -> tuple[pa.Table, pa.Table]:
        """The grid's rows and the cases'; what is ``kept`` is not found again. Raises `ComputationError`."""
        there = [kept.get(number) if kept else None for number in range(len(self.tasks))]
        results: dict[int, Rows] = {number: rows for number, rows in enumerate(there) if rows is not None}
        left = [number for number in range(len(self.tasks)) if number not in results]
        for i, rows in self._forks.each(partial(_rows, self.plan), [self.tasks[number] for number in left]):
            results[left[i]] = rows
            if kept:
                kept.put(left[i], rows)
            progress(len(results), len(self.tasks))
        each: dict[tuple[int, int | None], list[Rows]] = {}
        for number, (i, case, _) in enumerate(self.tasks):
            each.setdefault((i, case), []).append(results[number])
        found = {key: tuned_rows(self.plan.remedies[key[0]], some) for key, some in each.items()}
        return self._grid(found), self._cases(found)

    def _grid(self, found: Found) -> pa.Table:
        remedies = self.plan.remedies
        at = self._reference()
        rows = []
        for i, one in enumerate(remedies):
            cell = _cell_of(remedies[at], one)
            of = {cell(row): row for row in found[at, None]}
            for row in found[i, None]:
                other = of.get(cell(row))
                row = louder(self.plan, row, other)
                rows.append({"remedy": one.name, **row, **_ratios(other, row)})
        axes = [*AXES, *(axis_column(name, unit) for name, unit in self.plan.further.items())]
        return build_table([*KEYS, *axes, *BUZZ, *self._more(), *level_columns(self.plan)], rows)

    def _cases(self, found: Found) -> pa.Table:
        remedies = self.plan.remedies
        at = self._reference()
        rows = []
        for i, one in enumerate(remedies):
            for case in range(len(self.plan.cases)):
                for row, other in zip(found[i, case], found[at, case], strict=True):
                    against = {
                        **_ratios(other, row),
                        "stiffness_kept": _over(row["_static"], other["_static"]),
                        "knock_ratio": _over(row["_knock"], other["_knock"]),
                    }
                    row = louder(self.plan, row, other)
                    rows.append({"remedy": one.name, "needs": one.needs, "source": one.source, **row, **against})
        columns = [*KEYS, *CASES[:1], *AXES, *BUZZ, *CASES[1:], *self._more(), *level_columns(self.plan), *NEEDS]
        return build_table(columns, rows)

    def _reference(self) -> int:
        return next(i for i, one in enumerate(self.plan.remedies) if one.name == self.plan.reference)

    def _more(self) -> tuple[Column, ...]:
        """Columns for the domain of controllers, where one has a domain, and for what is tuned."""
        stated = any(has_domain(one.grid.scene) for one in self.plan.remedies)
        tunes = any(one.tuned for one in self.plan.remedies)
        ranged = RANGED if self.plan.ranged else ()
        return (*ranged, *([TUNED] if tunes else []), *([DOMAIN] if stated else []))


def _rows(plan: RemediesPlan, task: Task) -> Rows:
    which, case, way = task
    remedy = ways(plan.remedies[which])[way]
    return grid_rows(plan, remedy) if case is None else case_rows(plan, remedy, case)


def _cell_of(reference: Remedy, remedy: Remedy) -> Callable[[Row], tuple[Any, ...]]:
    """What tells cells apart in which two remedies are compared: the hand, and every axis that either varies."""
    names = [
        name
        for name in remedy.grid.axes
        if name != PERSON and (len(remedy.grid.axes[name]) > 1 or len(reference.grid.axes[name]) > 1)
    ]
    return lambda row: (row["hand"], *(row[name] for name in names))


def _ratios(reference: Row | None, row: Row) -> Row:
    """How many times smaller a remedy makes the largest cycle, and the mean of what cycles."""
    if reference is None or reference["p2p_max_rad"] is None or reference["diverged_fraction"] > 0.0:
        worst = nan
    elif row["diverged_fraction"] > 0.0:
        worst = 0.0
    else:  # without an end that is decided there is nothing to compare
        worst = _over(reference["p2p_max_rad"], row["p2p_max_rad"])
    return {
        "p2p_ratio": worst,
        "p2p_mean_ratio": _over(reference["p2p_rad"] if reference else None, row["p2p_rad"]),
    }


def _over(one: float | None, other: float | None) -> float:
    """A ratio; NaN without the one, or over nothing."""
    return one / other if one is not None and other else nan
