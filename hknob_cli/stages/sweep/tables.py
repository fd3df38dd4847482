"""The tables of a sweep, with the columns that its scene has.

The attractors of many cells in columns, as the tables of a sweep are made of them.
"""

from collections.abc import Mapping, Sequence
from math import nan
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from hknob_cli.engine.outcome import WORDS, Outcome, Reason
from hknob_cli.measure.orbit import OrbitMeasures
from hknob_cli.results.arrays import join_columns, spell
from hknob_cli.results.columns import (
    BEHIND,
    CELLS,
    CONTACT,
    FRICTION,
    GROWTH,
    JITTER,
    JITTER_MAX,
    ORBITS,
    PEOPLE,
    PLAY,
    RATTLE,
    SAMPLED,
    Column,
    axis_column,
)
from hknob_cli.scene.plain_knob import hands_of
from hknob_cli.scene.torque_over_angle import is_shaped
from hknob_cli.specs.cells import WHOLE
from hknob_cli.specs.perception import Perceive
from hknob_cli.specs.plan import (
    COUNTS,
    JITTERS,
    PERSON,
    ROAMS,
    RUBS,
    YIELDS,
    SweepPlan,
    knob_counts,
    may_have,
    scene_at,
)
from hknob_cli.stages.sweep.cell import CellResult, may_bounce
from hknob_cli.stages.sweep.starts import starts_columns

Array = NDArray[np.float64]
Whole = NDArray[np.int64]

NEEDS_COUNTS = ("p2p_counts", "margin_counts")
_OUTCOMES = [outcome.name.lower() for outcome in Outcome]
_REASONS = [WORDS[reason] for reason in Reason]
Axes = Mapping[str, NDArray[Any]]


class AttractorColumns(NamedTuple):
    """Attractors of cells, those of a cell together, the most frequent first; arrays with one entry an attractor.

    ``cell``: number of its cell, from 0; ``outcome``, ``reason``: codes of `engine.outcome`; ``closed``: whether it is
    an orbit, whose cycles are counted; ``edge``, ``closure`` in counts; ``measures``: arrays as well. ``quantum_rad``
    has one entry a cell.
    """

    quantum_rad: Array
    cell: Whole
    outcome: Whole
    reason: Whole
    trials: Array
    period: Whole
    closed: NDArray[np.bool_]
    edge: Array
    closure: Array
    measures: OrbitMeasures

    @property
    def number(self) -> Whole:
        """Number of each attractor within its cell, from 0."""
        counts = np.bincount(self.cell, minlength=len(self.quantum_rad))
        numbers: Whole = np.arange(len(self.cell)) - (np.cumsum(counts) - counts)[self.cell]
        return numbers

    def total(self, values: NDArray[Any]) -> Array:
        """Sum over the attractors of each cell, in their order."""
        sums: Array = np.bincount(self.cell, values, len(self.quantum_rad)).astype(np.float64)
        return sums

    def largest(self, values: Array) -> Whole:
        """Which attractor of each cell has the largest of ``values``, the first of equal ones.

        The number is one past the last where a cell has none with a value.
        """
        most = np.full(len(self.quantum_rad), -np.inf)
        known = np.isfinite(values)
        np.maximum.at(most, self.cell[known], values[known])
        found = np.flatnonzero(known & (values == most[self.cell]))[::-1]
        which = np.full(len(self.quantum_rad), len(values), dtype=np.int64)
        which[self.cell[found]] = found  # of several the last one written stays, which is the first
        return which


def in_columns(results: Sequence[CellResult]) -> AttractorColumns:
    """The attractors of some cells."""
    every = [(i, result.contact, one) for i, result in enumerate(results) for one in result.attractors]
    measures = zip(*(m for result in results for m in result.measures), strict=True)
    return AttractorColumns(
        quantum_rad=np.array([result.quantum_rad for result in results]),
        cell=_whole([i for i, _, _ in every]),
        outcome=_whole([one.outcome for _, _, one in every]),
        reason=_whole([one.reason for _, _, one in every]),
        trials=np.array([one.trials for _, _, one in every], dtype=np.float64),
        period=_whole([one.period for _, _, one in every]),
        closed=np.array([one.period > 0 or contact is not None for _, contact, one in every], dtype=bool),
        edge=np.array([one.edge for _, _, one in every]),
        closure=np.array([one.closure for _, _, one in every]),
        measures=OrbitMeasures(*(np.array(values, dtype=np.float64) for values in measures)),  # type: ignore[arg-type]
    )


def _whole(values: list[Any]) -> Whole:
    return np.array(values, dtype=np.int64)


class SweepTables(NamedTuple):
    """The two tables of a sweep, or of some of its cells, and the trial-samples they took."""

    cells: pa.Table
    orbits: pa.Table
    samples: int


def joined(found: Sequence[SweepTables]) -> SweepTables:
    """The tables of runs of cells, one run behind the other."""
    cells, orbits = (pa.concat_tables([getattr(one, name) for one in found]) for name in ("cells", "orbits"))
    return SweepTables(cells.combine_chunks(), orbits.combine_chunks(), sum(one.samples for one in found))


def cells_table(plan: SweepPlan, results: Sequence[CellResult]) -> pa.Table:
    """One row per cell."""
    columns: tuple[Column, ...] = CELLS
    some: tuple[Column, ...]
    more: dict[str, list[Any]] = {}
    if may_bounce(plan):
        columns, more = (*CELLS, *GROWTH), _growth(results)
    for paths, some, name in ((ROAMS, RATTLE, "rattle_p2p_rad"), (JITTERS, JITTER_MAX, "jitter_p2p_rad")):
        if may_have(plan.scene, plan.axes, *paths):
            every = [[getattr(one, name) for one in result.measures] for result in results]
            columns, more = (*columns, *some), more | {some[0].name: [float(np.fmax.reduce(one)) for one in every]}
    more |= (
        {"clock_bound_rad": [one.clock_bound for one in results]} if may_have(plan.scene, plan.axes, *JITTERS) else {}
    )
    if not plan.starts.sampled and plan.scene.sampled:
        some, values = starts_columns(plan, results)
        columns, more = (*columns, *some), more | values
    if plan.perceive:
        some, values = _perceived_columns(plan, plan.perceive, results)
        columns, more = (*columns, *some), more | values
    return lay_out_cells(plan, _axes(plan, results), in_columns(results), columns, more)


def _perceived_columns(
    plan: SweepPlan, perceive: Perceive, results: Sequence[CellResult]
) -> tuple[tuple[Column, ...], dict[str, list[Any]]]:
    """Columns of how cells feel, and their values."""
    from hknob_cli.results.columns import cell_columns
    from hknob_cli.stages.sweep.perceived import cell_row

    rows = []
    for result in results:
        total = sum(one.trials for one in result.attractors)
        shares = [one.trials / total for one in result.attractors]
        rows.append(cell_row(result.perceived, shares, perceive, _step_db(plan, result)))
    return tuple(cell_columns(gained=perceive.gained, counted=_is_counted(plan))), _turned(rows)


def orbits_table(plan: SweepPlan, results: Sequence[CellResult]) -> pa.Table:
    """One row per attractor."""
    parts = ((FRICTION, RUBS), (BEHIND, YIELDS), (PLAY, ROAMS), (JITTER, JITTERS))
    there = [some for some, paths in parts if may_have(plan.scene, plan.axes, *paths)]
    columns: tuple[Column, ...] = (*ORBITS, *(one for some in there for one in some))
    more: dict[str, list[Any]] = {}
    if not plan.scene.sampled:
        columns = (*(one for one in columns if one.name not in SAMPLED), *CONTACT)
        more = _contact(results)
    if plan.perceive:
        from hknob_cli.results.columns import orbit_columns
        from hknob_cli.stages.sweep.perceived import orbit_row

        columns = (*columns, *orbit_columns(gained=plan.perceive.gained, counted=_is_counted(plan)))
        more |= _turned(
            [orbit_row(one, plan.perceive, _step_db(plan, result)) for result in results for one in result.perceived]
        )
    return lay_out_orbits(plan, _axes(plan, results), in_columns(results), columns, more)


def lay_out_cells(
    plan: SweepPlan,
    axes: Axes,
    found: AttractorColumns,
    columns: Sequence[Column] = CELLS,
    more: Mapping[str, Sequence[Any]] | None = None,
) -> pa.Table:
    """One row per cell, from their attractors; ``axes``: their values on each axis, ``more``: further columns.

    Sizes and frequencies are of what cycles, by the trials that reach it. Trials whose motion is measured but not
    proven count among them; rest does not: ``at_rest_fraction`` says how much of it there is.
    """
    m = found.measures
    known = np.isfinite(m.p2p_rad)
    moving = known & (found.outcome != Outcome.REST)
    bounded = moving | (found.outcome == Outcome.CYCLE) | (found.outcome == Outcome.REST)
    weights, trials = found.trials * moving, found.total(found.trials)
    weight = found.total(weights)

    def mean(values: Any) -> Array:
        """Mean over a cell's cycles by the trials that reach them; NaN where there is none."""
        means = np.full(len(weight), nan)
        np.divide(found.total(weights * np.where(moving, values, 0.0)), weight, out=means, where=weight > 0.0)
        return means

    def part(which: NDArray[np.bool_]) -> Array:
        return found.total(found.trials * which) / trials

    p2p = mean(m.p2p_rad)
    sizes: Any = m.p2p_rad
    largest = found.largest(sizes)
    frequency = np.append(np.where(moving, m.frequency_hz, nan), nan)
    values = {
        "p2p_rad": p2p,
        "p2p_max_rad": np.append(m.p2p_rad, nan)[largest],
        "p2p_counts": p2p / found.quantum_rad,
        "frequency_hz": mean(m.frequency_hz),
        "frequency_at_max_hz": frequency[largest],
        "rms_rad": mean(m.rms_rad),
        "orbit_count": found.total(bounded),
        "certified_fraction": part(found.reason == Reason.NONE),
        "at_rest_fraction": part(found.outcome == Outcome.REST),
        "diverged_fraction": part(found.outcome == Outcome.DIVERGED),
        "undecided_fraction": part(found.outcome == Outcome.UNDECIDED),
        **(more or {}),
    }
    return _table(plan, axes, columns, values)


def lay_out_orbits(
    plan: SweepPlan,
    axes: Axes,
    found: AttractorColumns,
    columns: Sequence[Column] = ORBITS,
    more: Mapping[str, Sequence[Any]] | None = None,
) -> pa.Table:
    """One row per attractor; ``axes``: values of its cells on each axis, ``more``: further columns."""
    measures = found.measures._asdict()
    values = {
        "orbit": found.number,
        "outcome": spell(_OUTCOMES, found.outcome),
        "reason": spell(_REASONS, found.reason),
        "period_samples": np.where(found.closed, found.period, nan),
        "cycles_per_period": np.where(found.closed, measures.pop("cycles"), nan),
        "basin_fraction": found.trials / found.total(found.trials)[found.cell],
        "certified": found.reason == Reason.NONE,
        "margin_counts": np.where(found.closed, found.edge, nan),
        "closure_rad": np.where(found.closed, found.closure * found.quantum_rad[found.cell], nan),
        **measures,
        **(more or {}),
    }
    return _table(plan, {name: column[found.cell] for name, column in axes.items()}, columns, values)


def _table(plan: SweepPlan, axes: Axes, columns: Sequence[Column], values: Mapping[str, Any]) -> pa.Table:
    first = [axis_column(name, plan.units[name]) for name in plan.axes]
    hand = plan.scene.hand
    people: dict[str, Any] = {}
    if hand and hand.by_person:
        people = dict(zip([column.name for column in PEOPLE], hands_of(hand, axes[PERSON]), strict=True))
        first += PEOPLE
    kept = [one for one in columns if _is_counted(plan) or one.name not in NEEDS_COUNTS]
    return join_columns([*first, *kept], {**values, **people, **axes})


def _axes(plan: SweepPlan, results: Sequence[CellResult]) -> dict[str, NDArray[Any]]:
    return {
        name: np.array([result.cell[name] for result in results], dtype=np.int64 if name in WHOLE else np.float64)
        for name in plan.axes
    }


def _is_counted(plan: SweepPlan) -> bool:
    return COUNTS in plan.axes and plan.scene.encoder is not None


def _step_db(plan: SweepPlan, result: CellResult) -> float:
    """Level of the torque step of a cell's counts."""
    from hknob_cli.stages.sweep.perceived import step_db

    scene = scene_at(plan.scene, result.cell)
    if plan.perceive is None or not _is_counted(plan) or is_shaped(scene):
        return nan
    return step_db(plan.perceive, stiffness=scene.wall.stiffness, counts=knob_counts(scene, result.cell))


def _growth(results: Sequence[CellResult]) -> dict[str, list[Any]]:
    fields = ("growth_j_per_s2", "growth_std_j_per_s2", "residual", "fits", "bounces")
    return {
        column.name: [getattr(result.growth, field) if result.growth else None for result in results]
        for column, field in zip(GROWTH, fields, strict=True)
    }


def _contact(results: Sequence[CellResult]) -> dict[str, list[Any]]:
    return {
        column.name: [getattr(result.contact, column.name, None) for result in results for _ in result.attractors]
        for column in CONTACT
    }


def _turned(rows: Sequence[Mapping[str, Any]]) -> dict[str, list[Any]]:
    """Columns of rows that all have the same names."""
    return {name: [row[name] for row in rows] for name in rows[0]} if rows else {}
