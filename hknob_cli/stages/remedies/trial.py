"""One remedy on trial, and the best value of one that is tuned: its buzz over a grid, and the stiffness left.

A remedy that is tuned: of each cell the value whose largest cycle of any hand is smallest.

A controller does not know who holds the knob, so that one value serves all hands; it knows its device, so that another
cell may have another value.
"""

from collections.abc import Sequence
from functools import cache
from math import inf, nan
from typing import Any

from hknob_cli.results.means import extent, one_start
from hknob_cli.specs.plan import PERSON, Bias, Record, Starts, SweepPlan, scene_at
from hknob_cli.specs.stage_plans import KNOCKS, RemediesPlan, Remedy
from hknob_cli.stages.attractor_sizes import sizes_of_rows
from hknob_cli.stages.lag_domain import in_domain
from hknob_cli.stages.remedies.columns import level_columns
from hknob_cli.stages.sweep.engines import Engines
from hknob_cli.stages.sweep.record import trajectories
from hknob_cli.stages.sweep.run import SweepStage

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


def _over(one: float, other: float) -> float:
    """A ratio, NaN over 0: a wall that does not give within a count has no stiffness to tell."""
    return one / other if other else nan


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
