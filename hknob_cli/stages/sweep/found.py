"""The attractors of many cells in columns, as the tables of a sweep are made of them."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hknob_cli.measure.orbit import OrbitMeasures
from hknob_cli.stages.sweep.cell import CellResult

Array = NDArray[np.float64]
Whole = NDArray[np.int64]


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
