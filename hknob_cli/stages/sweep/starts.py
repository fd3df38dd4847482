"""Many starts of the cells of a sweep: columns of a search from all, and maps of which attractor each one ends in.

A map is of starts on a grid over a box of states.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pyarrow as pa

from hknob_cli.engine.outcome import Outcome
from hknob_cli.results.arrays import join_columns, spell
from hknob_cli.results.columns import ANYWHERE, BASINS, EVERY_START, ONE_START, Column, axis_column
from hknob_cli.scene.plain_knob import sample_knob
from hknob_cli.specs.cells import WHOLE, cells_of
from hknob_cli.specs.plan import COUNTS, RATE, SweepPlan, scene_at
from hknob_cli.stages.sweep.cell import CellFinder, CellResult
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


MOST_SAMPLES = 5000  # of an orbit that are shown


def map_basins(plan: SweepPlan, progress: Callable[[int, int], None] = lambda _done, _total: None) -> pa.Table:
    """Rows of ``basins.parquet``: every start of the maps, and behind those of a cell the samples of its attractors.

    Raises `ComputationError` if a scene's numbers overflow.
    """
    assert plan.basins
    assert plan.starts.span
    from hknob_cli.engine.jit import compiled
    from hknob_cli.engine.sets.search import SetEngine

    functions = compiled("sets")
    finder, engine = CellFinder({"sets": functions}), SetEngine(functions)
    low, high, slowest, fastest = plan.starts.span
    # Starts in the middle of the map's squares: none lies on its border, and few on a count edge.
    part = (np.arange(plan.basins) + 0.5) / plan.basins
    angle, velocity = np.meshgrid(low + (high - low) * part, slowest + (fastest - slowest) * part)
    columns: dict[str, list[Any]] = {name: [] for name in (*plan.axes, *(one.name for one in BASINS))}
    cells = cells_of(plan)
    for done, cell in enumerate(cells):
        knob = sample_knob(scene_at(plan.scene, cell), sample_rate_hz=cell[RATE], counts_per_rev=int(cell[COUNTS]))
        attractors = finder.find(plan, cell).attractors
        starts = np.column_stack(
            [angle.ravel() / knob.quantum_rad - knob.shift, velocity.ravel() * knob.period_s / knob.quantum_rad]
        )
        found = engine.map_starts(knob.loop, starts, attractors, max_samples=plan.max_samples)
        angles, velocities, orbits = [angle.ravel()], [velocity.ravel()], [found]
        for number, one in enumerate(attractors):
            if one.outcome is Outcome.CYCLE:
                xs, vs, _, _ = finder.trace(knob.loop, one)
            else:
                xs, vs = np.array([one.x, one.x]), np.zeros(2)
            many = min(len(xs) - 1, MOST_SAMPLES) if one.period else 0
            angles.append((xs[:many] + knob.shift) * knob.quantum_rad)
            velocities.append(vs[:many] * knob.quantum_rad / knob.period_s)
            orbits.append(np.full(many, number))
        count = sum(len(values) for values in angles)
        for name in plan.axes:
            columns[name].append(np.full(count, cell[name], dtype=np.int64 if name in WHOLE else np.float64))
        columns["angle_rad"].append(np.concatenate(angles))
        columns["velocity_rad_s"].append(np.concatenate(velocities))
        columns["orbit"].append(np.where((orbit := np.concatenate(orbits)) < 0, np.nan, orbit))
        columns["on_orbit"].append(np.arange(count) >= len(starts))
        progress(done + 1, len(cells))
    axes = [axis_column(name, plan.units[name]) for name in plan.axes]
    return join_columns([*axes, *BASINS], {name: np.concatenate(values) for name, values in columns.items()})
