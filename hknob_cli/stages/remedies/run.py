"""The trial of remedies: every remedy over the grid, and at the cases what it costs in stiffness.

A remedy that is tuned: of each cell the value whose largest cycle of any hand is smallest.

A controller does not know who holds the knob, so that one value serves all hands; it knows its device, so that another
cell may have another value.
"""

from collections.abc import Callable, Sequence
from functools import cache, partial
from math import inf, nan
from typing import TYPE_CHECKING, Any

import pyarrow as pa

from hknob_cli.results.arrays import build_table
from hknob_cli.results.columns import RANGED, Column, axis_column, extent, one_start
from hknob_cli.specs.cells import Cells
from hknob_cli.specs.plan import PERSON, Bias, Record, Starts, SweepPlan, scene_at
from hknob_cli.specs.stage_plans import KNOCKS, RemediesPlan, Remedy
from hknob_cli.spread.forks import Forked, Forks, usable_cores
from hknob_cli.stages.lag_domain import has_domain, in_domain
from hknob_cli.stages.remedies.columns import AXES, BUZZ, CASES, DOMAIN, KEYS, NEEDS, TUNED, level_columns, louder
from hknob_cli.stages.sweep.perceived import sizes_of_rows
from hknob_cli.stages.sweep.record import trajectories
from hknob_cli.stages.sweep.run import Engines, SweepStage

if TYPE_CHECKING:
    from hknob_cli.stages.make import Kept

SHARES = ("certified_fraction", "at_rest_fraction", "diverged_fraction")

Row = dict[str, Any]
Rows = list[Row]


@cache
def engines() -> Engines:
    """Of all trials of a process: each is short, and together they are worth a compiler."""
    return Engines()


def grid_rows(plan: RemediesPlan, remedy: Remedy) -> Rows:
    """Rows of a remedy over the grid. Raises `ComputationError`."""
    return _swept(plan, remedy.grid)


def case_rows(plan: RemediesPlan, remedy: Remedy, case: int) -> Rows:
    """Rows of a remedy at a case, one a hand, with the stiffness felt slowly and quickly. Raises `ComputationError`.

    ``_static``: added torque over added depth between two steady pushes, N·m/rad; ``_knock``: depth of a knock, rad.
    """
    sweep = remedy.cases[case]
    shallow, deep = (_depths(plan, sweep, torque) for torque in plan.torques)
    gained = plan.torques[1] - plan.torques[0]
    every = zip(_swept(plan, sweep), shallow, deep, _knocks(plan, sweep), strict=True)
    return [
        {"case": plan.cases[case][0], **row, "_static": _over(gained, one - other), "_knock": knock}
        for row, one, other, knock in every
    ]


def _swept(plan: RemediesPlan, sweep: SweepPlan) -> Rows:
    rows, orbits = _cells(sweep)
    axes = list(sweep.axes)
    single = _cells(one_start(sweep))[1] if sweep.starts.span else {}
    scenes = [scene_at(sweep.scene, {name: row[name] for name in axes}) for row in rows]
    kept = [name for name in axes if name != PERSON]
    names = [*kept, *SHARES, *(one.name for one in level_columns(plan) if rows and one.name in rows[0])]
    return [
        {
            "hand": plan.hands[row[PERSON] - 1],
            **{name: row[name] for name in names},
            **sizes_of_rows(orbits[tuple(row[name] for name in axes)])._asdict(),
            **(_beside(row, sweep, single[tuple(row[name] for name in axes)]) if single else {}),
            "in_domain": in_domain(scene),
        }
        for row, scene in zip(rows, scenes, strict=True)
    ]


def _cells(sweep: SweepPlan) -> tuple[Rows, dict[tuple[Any, ...], Rows]]:
    """Rows of the cells, and those of their orbits by the cell's values on the axes."""
    tables = SweepStage(sweep, jobs=1, engines=engines()).run()
    orbits: dict[tuple[Any, ...], Rows] = {}
    for row in tables.orbits.to_pylist():
        orbits.setdefault(tuple(row[name] for name in sweep.axes), []).append(row)
    return tables.cells.to_pylist(), orbits


def _beside(row: Row, sweep: SweepPlan, single: Rows) -> Row:
    """Of which starts the largest cycle of a cell is, and the largest from one start."""
    return {**extent(row, sweep), "p2p_one_start_rad": sizes_of_rows(single).p2p_max_rad}


def _depths(plan: RemediesPlan, sweep: SweepPlan, torque: float) -> list[float]:
    """Angle about which each hand's knob ends under a steady push, rad: the middle of its motion."""
    pushed = one_start(sweep)._replace(scene=sweep.scene._replace(bias=Bias(torque=torque)))
    orbits = SweepStage(pushed, jobs=1, engines=engines()).run().orbits.to_pylist()
    found = []
    for person in range(1, len(plan.hands) + 1):
        ends = [row for row in orbits if row[PERSON] == person and row["min_rad"] is not None]
        share = sum(row["basin_fraction"] for row in ends)
        middle = sum(row["basin_fraction"] * 0.5 * (row["min_rad"] + row["max_rad"]) for row in ends)
        found.append(middle / share if share else nan)
    return found


def _knocks(plan: RemediesPlan, sweep: SweepPlan) -> list[float]:
    """Depth that each hand's knob reaches after a knock on the wall without a push, rad; the mean of the trials."""
    knocked = sweep._replace(
        scene=sweep.scene._replace(bias=None),
        starts=Starts(angle=0.0, velocity=-plan.speed, phases=KNOCKS),
        record=Record(plan.duration, plan.duration / 200.0, KNOCKS),
    )
    deepest: dict[tuple[int, int], float] = {}
    for cell, _, trial, instants in trajectories(knocked):
        deepest[int(cell[PERSON]), trial] = min(0.0, min(one.angle for one in instants))
    return [
        -sum(deepest[person, trial] for trial in range(KNOCKS)) / KNOCKS for person in range(1, len(plan.hands) + 1)
    ]


def ways(remedy: Remedy) -> list[Remedy]:
    """The remedy at each value of what it tunes; itself where it tunes nothing."""
    return [remedy._replace(grid=one.grid, cases=one.cases) for one in remedy.tuned] or [remedy]


def tuned_rows(remedy: Remedy, found: Sequence[Rows]) -> Rows:
    """Rows of the best value of each cell, with the value as ``tuned``; ``found`` has those of each of its `ways`."""
    if not remedy.tuned:
        return [{**row, "tuned": None} for row in found[0]]
    axes = [name for name in remedy.grid.axes if name != PERSON and name in found[0][0]]

    def cell(row: Row) -> tuple[object, ...]:
        return tuple(row[name] for name in axes)

    worst: dict[tuple[object, ...], list[float]] = {}
    for i, rows in enumerate(found):
        for row in rows:
            sizes = worst.setdefault(cell(row), [0.0] * len(found))
            sizes[i] = max(sizes[i], _size(row))
    best = {key: sizes.index(min(sizes)) for key, sizes in worst.items()}
    return [
        {**found[best[cell(row)]][i], "tuned": remedy.tuned[best[cell(row)]].value} for i, row in enumerate(found[0])
    ]


def _size(row: Row) -> float:
    """Of the largest cycle; of what diverges, or is not known, larger than all."""
    if row["p2p_max_rad"] is None or row["diverged_fraction"] > 0.0:
        return inf
    return float(row["p2p_max_rad"])


FEW = 2000  # trials, which are over before another process has begun


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
