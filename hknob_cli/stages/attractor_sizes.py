"""Size and pitch of a cell by its attractors: means over what cycles, and the largest, by which a cell is judged."""

from collections.abc import Iterable
from typing import Any, NamedTuple

from hknob_cli.engine.outcome import Outcome
from hknob_cli.stages.sweep.cell import CellResult


class Sizes(NamedTuple):
    """``p2p_rad``, ``frequency_hz``: means by trials over what moves, None where nothing does.

    ``p2p_max_rad``: of the largest attractor, 0 where all rest, None where nothing is bounded;
    ``frequency_at_max_hz``: its frequency, None where it is at rest.
    """

    p2p_rad: float | None
    frequency_hz: float | None
    p2p_max_rad: float | None
    frequency_at_max_hz: float | None


class End(NamedTuple):
    """An attractor: the weight of its trials, whether it is at rest, its peak to peak (rad) and frequency (Hz)."""

    weight: float
    rests: bool
    p2p_rad: float
    frequency_hz: float


def sizes_of(ends: Iterable[End]) -> Sizes:
    """Sizes of a cell from its attractors whose motion is bounded and measured."""
    every = list(ends)
    moving = [one for one in every if not one.rests]
    if not moving:
        return Sizes(None, None, 0.0 if every else None, None)
    weight = sum(one.weight for one in moving)
    largest = max(moving, key=lambda one: one.p2p_rad)  # the first of equal ones, which most trials reach
    return Sizes(
        p2p_rad=sum(one.weight * one.p2p_rad for one in moving) / weight,
        frequency_hz=sum(one.weight * one.frequency_hz for one in moving) / weight,
        p2p_max_rad=largest.p2p_rad,
        frequency_at_max_hz=largest.frequency_hz,
    )


def sizes_of_rows(orbits: Iterable[dict[str, Any]]) -> Sizes:
    """Sizes of a cell from its rows of orbits.parquet."""
    return sizes_of(
        End(row["basin_fraction"], row["outcome"] == "rest", row["p2p_rad"], row["frequency_hz"])
        for row in orbits
        if row["p2p_rad"] is not None
    )


def sizes_of_result(result: CellResult) -> Sizes:
    """Sizes of a cell as the engine found it."""
    return sizes_of(
        End(one.trials, one.outcome is Outcome.REST, measured.p2p_rad, measured.frequency_hz)
        for one, measured in zip(result.attractors, result.measures, strict=True)
        if measured.p2p_rad == measured.p2p_rad  # NaN where nothing is bounded or measured
    )
