"""A run of plain cells of a sweep, whole in compiled code: from axis values to tables without a Python step a cell.

The tables are those that `stages.sweep.cell` and `stages.sweep.tables` give for the same cells, to the last bit.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hknob_cli.engine.cell_run import MOST_PHASES, Ends, FollowedCells, run_cells
from hknob_cli.engine.cells import NUMBERS
from hknob_cli.engine.outcome import Reason
from hknob_cli.measure.orbit import of_cycle
from hknob_cli.results.arrays import spell
from hknob_cli.results.columns import CELLS, EVERY_START, ONE_START, Column
from hknob_cli.scene.plain_knob import SampledKnob, sample_cells
from hknob_cli.specs.capabilities import deciding
from hknob_cli.specs.cells import Cells
from hknob_cli.specs.plan import GRIP, PERSON, SweepPlan, scene_at
from hknob_cli.stages.sweep.cell import group_of
from hknob_cli.stages.sweep.every_start import INCOMPLETE, why_incomplete
from hknob_cli.stages.sweep.tables import AttractorColumns, SweepTables, lay_out_cells, lay_out_orbits

GROUP = "cells"  # of compiled functions, `engine.jit`
EVERY_PHASE_GROUP = "arc_cells"

# Axes that decide, by being 0 or not, whether a scene is plain.
_DECIDING = deciding("plain", "bounces")


def takes_plain(plan: SweepPlan) -> bool:
    """Whether every cell of a sweep is plain, and all that is asked of it is in `plain_chunk`'s tables."""
    asked = plan.scene.controller or plan.perceive or plan.growth_s or plan.seconds_per_cell
    if asked or plan.starts.span or plan.starts.phases > MOST_PHASES:
        return False
    return all(group_of(scene_at(plan.scene, cell)) == "plain" for cell in Cells(_telling(plan)))


def chunk_group(plan: SweepPlan) -> str:
    """Group of compiled functions that `plain_chunk` takes."""
    return GROUP if plan.starts.sampled else EVERY_PHASE_GROUP


def _telling(plan: SweepPlan) -> dict[str, list[float | int]]:
    """The deciding axes with few of their values, that tell as much as all: one that is 0 and one that is not."""
    hand = plan.scene.hand
    axes: dict[str, list[float | int]] = {}
    for name, values in plan.axes.items():
        if name in _DECIDING:
            kinds: dict[Any, float | int] = {value == 0.0: value for value in values}
        elif name == PERSON and hand:
            kinds = {_kind(hand.by_person[int(person) - 1]): person for person in values}
        elif name == GRIP:
            kinds = dict(enumerate(values))
        else:
            continue
        axes[name] = list(kinds.values())
    return axes


def _kind(hand: Any) -> Any:
    return hand.finger is None, hand.damping == 0.0, hand.stiffness == 0.0


def plain_chunk(
    plan: SweepPlan,
    columns: Mapping[str, NDArray[Any]],
    functions: Mapping[str, Callable[..., Any]],
    stopped: Callable[[], bool] = lambda: False,
) -> SweepTables:
    """Run cells of a sweep that `takes_plain`.

    Args:
        plan: The sweep.
        columns: The cells' values on each axis, (n,) each, as `spec.cells.Cells.columns` gives them.
        functions: The compiled functions of its `chunk_group`, by name.
        stopped: Asked every fraction of a second whether to give up.

    Raises `ComputationError` where a scene's numbers overflow, and `engine.attractors.StoppedError` when told to stop.
    """
    knob = sample_cells(plan.scene, columns)
    count = len(next(iter(columns.values())))
    start = {"x": knob.position(plan.starts.angle), "v": knob.speed(plan.starts.velocity)}
    given = {**knob.loop._asdict(), "delay_line": knob.delay_line, **start}
    numbers = np.empty((count, len(NUMBERS)))
    for i, name in enumerate(NUMBERS):
        numbers[:, i] = given[name]
    ends, followed, samples = run_cells(
        numbers,
        sense=knob.loop.sense,
        phases=plan.starts.phases,
        max_samples=plan.max_samples,
        functions=functions,
        stopped=stopped,
        sampled=plan.starts.sampled,
    )
    found = _in_si(knob, ends, count)
    more: dict[str, Any] = {}
    kinds: tuple[Column, ...] = CELLS
    if not plan.starts.sampled:
        kinds = (*CELLS, *EVERY_START, *ONE_START)
        more = {
            "complete": followed.complete,
            "piece_count": followed.pieces,
            "incomplete_reason": spell(INCOMPLETE, _why_incomplete(plan, ends, followed)),
            "share_error": followed.share_error,
        }
    return SweepTables(lay_out_cells(plan, columns, found, kinds, more), lay_out_orbits(plan, columns, found), samples)


def _why_incomplete(plan: SweepPlan, ends: Ends, followed: FollowedCells) -> NDArray[np.int64]:
    """Why the list of each cell is not complete: as the first of its attractors, in order, that is not proven."""
    why = np.full(len(followed.complete), Reason.NO_REPEAT)
    unproven = np.flatnonzero(ends.reason != Reason.NONE)[::-1]
    why[ends.cell[unproven]] = ends.reason[unproven]
    why[followed.pieces == 0] = Reason.NONE
    return why_incomplete(followed.complete, followed.pieces, why, plan.starts)


def _in_si(knob: SampledKnob, ends: Ends, count: int) -> AttractorColumns:
    """The attractors of ``count`` cells as the tables want them."""

    def of_cells(values: Any) -> Any:
        return np.broadcast_to(values, count)[ends.cell]

    scales = knob._replace(
        quantum_rad=of_cells(knob.quantum_rad),
        period_s=of_cells(knob.period_s),
        inertia_kg_m2=of_cells(knob.inertia_kg_m2),
        shift=of_cells(knob.shift),
    )
    period: Any = np.maximum(ends.period, 1)  # of what has none nothing is measured
    return AttractorColumns(
        quantum_rad=np.broadcast_to(knob.quantum_rad, count),
        cell=ends.cell,
        outcome=ends.outcome,
        reason=ends.reason,
        trials=ends.trials,
        period=ends.period,
        closed=ends.period > 0,
        edge=ends.edge,
        closure=ends.closure,
        measures=of_cycle(scales, period, ends.measures),
    )
