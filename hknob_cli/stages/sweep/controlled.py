"""Cells of a sweep under a controller from sets of starts: those of one sample rate and one controller side by side."""

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from math import nan
from typing import Any

import numpy as np

from hknob_cli.controllers.cells import make_lanes
from hknob_cli.controllers.controller import make_control_law
from hknob_cli.controllers.search import Settled
from hknob_cli.controllers.sets.starts import follow_starts
from hknob_cli.engine.alarm import Alarm
from hknob_cli.engine.attractors import Attractor
from hknob_cli.engine.outcome import Outcome
from hknob_cli.measure.orbit import OrbitMeasures, measure_settled, settled_harmonics
from hknob_cli.scene.sampled_knob import SampledKnob
from hknob_cli.specs.cells import cells_of
from hknob_cli.specs.plan import RATE, Cell, SweepPlan, scene_at
from hknob_cli.stages.sweep.cell import REMEDIED, CellResult, engine_group
from hknob_cli.stages.sweep.every_start import why_open

MOST_LANES = 4096  # side by side


def block_of(plan: SweepPlan) -> int:
    """Cells of a grid that are found together; it is fixed which, for rounding depends on what is side by side."""
    most = max(1, MOST_LANES // plan.starts.phases)
    return 1 << (most.bit_length() - 1)


def remedied_results(
    plan: SweepPlan, some: Sequence[Cell] | None = None, *, find: Callable[[Cell], CellResult]
) -> Iterator[CellResult]:
    """Results of ``some`` cells, by default all of the grid, in order; those of one rate are found together.

    ``find``: finds a cell whose starts are not followed as sets.
    """
    if some is None:
        grid, block = cells_of(plan), block_of(plan)
        for start in range(0, len(grid), block):
            yield from remedied_results(plan, list(grid.run(start, min(len(grid), start + block))), find=find)
        return
    every = list(some)
    alike: dict[tuple[object, ...], deque[int]] = {}
    alone = {i for i, cell in enumerate(every) if engine_group(plan, scene_at(plan.scene, cell)) != REMEDIED}
    for i, cell in enumerate(every):
        if i in alone:
            continue
        alike.setdefault(_key(plan, cell), deque()).append(i)
    done: dict[int, CellResult] = {}
    for i, cell in enumerate(every):
        if i in alone:
            yield find(cell)
            continue
        if i not in done:
            left = alike[_key(plan, cell)]
            group = [left.popleft() for _ in range(min(len(left), max(1, MOST_LANES // plan.starts.phases)))]
            done.update(zip(group, _found(plan, [every[j] for j in group]), strict=True))
        yield done.pop(i)


def _key(plan: SweepPlan, cell: Cell) -> tuple[object, ...]:
    return cell[RATE], scene_at(plan.scene, cell).controller


def _found(plan: SweepPlan, some: list[Cell]) -> list[CellResult]:
    controller = scene_at(plan.scene, some[0]).controller
    assert controller
    remedy = make_control_law(controller)
    alarm = Alarm(None if plan.seconds_per_cell is None else plan.seconds_per_cell * len(some))
    knobs, lanes = make_lanes(plan.scene, some)
    ends = follow_starts(remedy, lanes, knobs, plan.starts, lambda: alarm.over)
    found = []
    for cell, knob, one in zip(some, knobs, ends, strict=True):
        result = _result(plan, cell, knob, remedy.parts, one.ends, one.samples)
        bound = one.undecided if plan.starts.span else None
        found.append(
            result._replace(
                complete=one.undecided == 0.0, pieces=one.pieces, undecided=bound, why=why_open(result.attractors)
            )
        )
    return found


def _result(
    plan: SweepPlan, cell: Cell, knob: SampledKnob, parts: tuple[float, ...], ends: list[Settled], samples: int
) -> CellResult:
    closed = [one for one in ends if one.outcome is not Outcome.UNDECIDED]
    rows = [(_attractor(one), measure_settled(knob, parts, one), _perceived(plan, knob, parts, one)) for one in closed]
    loose = [one for one in ends if one.outcome is Outcome.UNDECIDED]
    if loose:
        measured = [measure_settled(knob, parts, one) for one in loose]
        many = _attractor(loose[0])._replace(trials=sum(one.trials for one in loose))
        rows.append((many, _mean(measured), _perceived(plan, knob, parts, loose[0])))
    rows.sort(key=lambda row: (-row[0].trials, row[0].outcome, row[0].period, row[0].x))
    return CellResult(
        cell=cell,
        quantum_rad=knob.quantum_rad,
        attractors=tuple(row[0] for row in rows),
        measures=tuple(row[1] for row in rows),
        samples=samples,
        group=REMEDIED,
        perceived=tuple(row[2] for row in rows) if plan.perceive else (),
    )


def _perceived(plan: SweepPlan, knob: SampledKnob, parts: tuple[float, ...], one: Settled) -> Any:
    """What is felt and heard of an orbit, if the plan asks for it; of what does not repeat nothing is said."""
    if plan.perceive is None:
        return None
    from hknob_cli.stages.sweep.perceived import HIGHEST_HZ, Perceived, perceive

    if one.outcome is not Outcome.CYCLE:
        return Perceived()
    return perceive(settled_harmonics(knob, parts, one, HIGHEST_HZ), plan.perceive)


def _attractor(one: Settled) -> Attractor:
    at = len(one.x) > 0
    return Attractor(
        outcome=one.outcome,
        reason=one.reason,
        trials=one.trials,
        period=one.period,
        x=float(one.x[0]) if at else 0.0,
        v=float(one.v[0]) if at else 0.0,
        margin=one.margin,
        edge=one.margin,
        closure=one.closure,
    )


def _mean(measured: list[OrbitMeasures]) -> OrbitMeasures:
    """Means over trials that did not repeat, and their extremes."""
    every = [one for one in measured if np.isfinite(one.p2p_rad)]
    if not every:
        return OrbitMeasures()
    return OrbitMeasures(
        p2p_rad=float(np.mean([one.p2p_rad for one in every])),
        min_rad=min(one.min_rad for one in every),
        max_rad=max(one.max_rad for one in every),
        rms_rad=float(np.mean([one.rms_rad for one in every])),
        frequency_hz=float(np.mean([one.frequency_hz for one in every])),
        wall_work_j=nan,
    )
