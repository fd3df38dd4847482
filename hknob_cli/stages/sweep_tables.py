"""The tables of a sweep, with the columns that its scene has."""

from collections.abc import Callable, Iterator, Sequence
from math import isfinite, nan
from typing import Any

import pyarrow as pa

from hknob_cli.engine.outcome import WORDS, Outcome
from hknob_cli.measure.orbit import OrbitMeasures
from hknob_cli.results.arrays import build_table
from hknob_cli.results.columns import CELLS, CONTACT, FRICTION, GROWTH, ORBITS, PEOPLE, SAMPLED, Column, axis_column
from hknob_cli.spec.plan import COUNTS, PERSON, SweepPlan, scene_at
from hknob_cli.stages.cell import CellResult, may_bounce

NEEDS_COUNTS = ("p2p_counts", "margin_counts")


def cells_table(plan: SweepPlan, results: Sequence[CellResult]) -> pa.Table:
    """One row per cell."""
    columns = (*CELLS, *(GROWTH if may_bounce(plan) else ()))
    rows = [{**result.cell, **_cell_row(result)} for result in results]
    if plan.perceive:
        from hknob_cli.results.perceived_columns import cell_columns
        from hknob_cli.stages.perceived import cell_row

        columns = (*columns, *cell_columns(gained=plan.perceive.sound_gain is not None, counted=_is_counted(plan)))
        for row, result in zip(rows, results, strict=True):
            total = sum(one.trials for one in result.attractors)
            shares = [one.trials / total for one in result.attractors]
            row.update(cell_row(result.perceived, shares, plan.perceive, _step_db(plan, result)))
    return _table(plan, columns, rows)


def orbits_table(plan: SweepPlan, results: Sequence[CellResult]) -> pa.Table:
    """One row per attractor."""
    rows = [{**result.cell, **row} for result in results for row in _orbit_rows(result)]
    columns = (*ORBITS, *(FRICTION if _has_friction(plan) else ()))
    if not plan.scene.sampled:
        columns = (*(one for one in columns if one.name not in SAMPLED), *CONTACT)
    if plan.perceive:
        from hknob_cli.results.perceived_columns import orbit_columns
        from hknob_cli.stages.perceived import orbit_row

        columns = (*columns, *orbit_columns(gained=plan.perceive.sound_gain is not None, counted=_is_counted(plan)))
        found = [
            orbit_row(one, plan.perceive, _step_db(plan, result)) for result in results for one in result.perceived
        ]
        rows = [{**row, **more} for row, more in zip(rows, found, strict=True)]
    return _table(plan, columns, rows)


def _table(plan: SweepPlan, columns: Sequence[Column], rows: list[dict[str, Any]]) -> pa.Table:
    axes = [axis_column(name, plan.units[name]) for name in plan.axes]
    people = plan.scene.hand.by_person if plan.scene.hand else ()
    if people:
        names = [column.name for column in PEOPLE]
        axes += PEOPLE
        rows = [{**row, **dict(zip(names, people[row[PERSON] - 1], strict=False))} for row in rows]
    return build_table([*axes, *(one for one in columns if _is_counted(plan) or one.name not in NEEDS_COUNTS)], rows)


def _is_counted(plan: SweepPlan) -> bool:
    return COUNTS in plan.axes and plan.scene.encoder is not None


def _step_db(plan: SweepPlan, result: CellResult) -> float:
    """Level of the torque step of a cell's counts."""
    from hknob_cli.stages.perceived import step_db

    if plan.perceive is None or not _is_counted(plan):
        return nan
    stiffness = scene_at(plan.scene, result.cell).wall.stiffness
    return step_db(plan.perceive, stiffness=stiffness, counts=int(result.cell[COUNTS]))


def _has_friction(plan: SweepPlan) -> bool:
    return plan.scene.knob.coulomb_torque > 0.0 or any(plan.axes.get("knob.coulomb_torque", []))


def _cell_row(result: CellResult) -> dict[str, Any]:
    total = sum(one.trials for one in result.attractors)
    share = {outcome: sum(a.trials for a in result.attractors if a.outcome is outcome) / total for outcome in Outcome}
    bounded = [
        (a.trials, m)
        for a, m in zip(result.attractors, result.measures, strict=True)
        if a.outcome in (Outcome.CYCLE, Outcome.REST) or isfinite(m.p2p_rad)
    ]
    weight = sum(trials for trials, _ in bounded)

    def mean(of: Callable[[OrbitMeasures], float]) -> float:
        return sum(trials * of(m) for trials, m in bounded) / weight if weight else nan

    p2p = mean(lambda m: m.p2p_rad)
    return {
        "p2p_rad": p2p,
        "p2p_counts": p2p / result.quantum_rad,
        "frequency_hz": mean(lambda m: m.frequency_hz),
        "rms_rad": mean(lambda m: m.rms_rad),
        "orbit_count": len(bounded),
        "certified_fraction": sum(a.trials for a in result.attractors if a.certified) / total,
        "at_rest_fraction": share[Outcome.REST],
        "diverged_fraction": share[Outcome.DIVERGED],
        "undecided_fraction": share[Outcome.UNDECIDED],
        **_growth(result),
    }


def _growth(result: CellResult) -> dict[str, Any]:
    names = {
        "growth_j_per_s2": "growth_j_per_s2",
        "growth_std_j_per_s2": "growth_std_j_per_s2",
        "growth_residual": "residual",
        "growth_fits": "fits",
        "bounces": "bounces",
    }
    return {name: getattr(result.growth, field) if result.growth else None for name, field in names.items()}


def _orbit_rows(result: CellResult) -> Iterator[dict[str, Any]]:
    total = sum(one.trials for one in result.attractors)
    for number, (one, m) in enumerate(zip(result.attractors, result.measures, strict=True)):
        orbit = one.period > 0 or result.contact is not None
        yield {
            "orbit": number,
            "outcome": one.outcome.name.lower(),
            "reason": WORDS[one.reason],
            "period_samples": one.period if orbit else None,
            "cycles_per_period": m.cycles if orbit else None,
            "p2p_rad": m.p2p_rad,
            "min_rad": m.min_rad,
            "max_rad": m.max_rad,
            "rms_rad": m.rms_rad,
            "frequency_hz": m.frequency_hz,
            "basin_fraction": one.trials / total,
            "certified": one.certified,
            "margin_counts": one.edge if orbit else None,
            "closure_rad": one.closure * result.quantum_rad if orbit else None,
            "wall_work_j": m.wall_work_j,
            "damping_loss_j": m.damping_loss_j,
            "friction_loss_j": m.friction_loss_j,
            "late_entry_j": m.late_entry_j,
            "late_exit_j": m.late_exit_j,
            "staircase_j": m.staircase_j,
            **{
                name: getattr(result.contact, name, None)
                for name in ("contact_s", "settling_s", "bounces", "energy_drift")
            },
        }
