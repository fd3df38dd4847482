"""The work of ``hknob predict``: closed laws, stability limits and further criteria, for every cell of a grid."""

from collections.abc import Callable, Iterator
from functools import partial
from math import isfinite
from pathlib import Path
from typing import Any, NamedTuple

import pyarrow as pa

from hknob_cli.errors import ComputationError
from hknob_cli.results.arrays import build_table
from hknob_cli.results.columns import Column, axis_column
from hknob_cli.specs.cells import cells_of
from hknob_cli.specs.plan import COUNTS, RATE, Cell, PredictPlan, scene_at
from hknob_cli.stages import compare
from hknob_cli.stages.job import Job
from hknob_cli.stages.predict.text import describe_criteria, describe_predictions, predictions_text
from hknob_cli.stages.work import Tables, Work, compare_scenes, note, overlap_of
from hknob_cli.terminal import progress_bar
from hknob_cli.theory.laws import (
    RMS_ARCS,
    RMS_SINE,
    Prediction,
    WorkingEdge,
    describing_function,
    energy_balance,
    quantum_period,
    working_edge,
)
from hknob_cli.theory.passivity import DEVICE, LIMITS, Verdict, verdict

_REAL, _WHOLE, _TEXT, _FLAG = pa.float64(), pa.int64(), pa.string(), pa.bool_()

PREDICTIONS = (
    Column("law", _TEXT, "", "quantum_period, describing_function or energy_balance"),
    Column("p2p_rad", _REAL, "rad", "peak to peak; null where the law has no value"),
    Column("amplitude_rad", _REAL, "rad", "half of p2p_rad"),
    Column("frequency_hz", _REAL, "Hz", "frequency; null where the law has no value"),
    Column("rms_rad", _REAL, "rad", "root mean square of parabolic arcs, sqrt(8/15) / 2 of p2p_rad"),
    Column("rms_sine_rad", _REAL, "rad", "root mean square by the dissertation's factor, .707 / 2 of p2p_rad"),
    Column("in_domain", _FLAG, "", "whether the law's assumptions hold"),
    Column("reason", _TEXT, "", "the first assumption that does not hold; empty where all do"),
)

# b_k: damping of the knob alone; b: of knob and hand; B: virtual damping; T: sample period; t_d: transport delay;
# q: one count; T_c: Coulomb friction. A delay of part of a sample asks for up to 8 % more than T / 2 + t_d says.
PASSIVITY = (
    Column("device_passive", _FLAG, "", "passive whoever holds the knob: colgate_schenkel and abbott_okamura hold"),
    Column(
        "colgate_schenkel",
        _FLAG,
        "",
        "passivity of the device: b_k > K (T / 2 + t_d) + |B|, with b_k of the knob alone",
    ),
    Column("abbott_okamura", _FLAG, "", "passivity of the device: K <= min(b_k / (T / 2 + t_d), 2 T_c / q)"),
    Column("gil_hulin", _FLAG, "", "stability with this hand: K < (b + B) / (T / 2 + t_d), b of knob and hand"),
    Column("niemeyer", _FLAG, "", "no oscillation over one count, in any hand: q <= T_c / K"),
    Column("colgate_schenkel_load", _REAL, "1", "(K (T / 2 + t_d) + |B|) / b_k; holds below 1; null where infinite"),
    Column("abbott_okamura_load", _REAL, "1", "K / min(b_k / (T / 2 + t_d), 2 T_c / q); holds up to 1; null: infinite"),
    Column("gil_hulin_load", _REAL, "1", "K (T / 2 + t_d) / (b + B); holds below 1; null where infinite"),
    Column("niemeyer_load", _REAL, "1", "K q / T_c; holds up to 1; null where infinite"),
    Column("binding_limb", _TEXT, "", "which of these four limits has the largest load"),
    Column("rate_needed_hz", _REAL, "Hz", "least sample rate that satisfies these limits; null if none does"),
    Column("damping_needed_nm_s_per_rad", _REAL, "N*m*s/rad", "least damping of the knob that satisfies these limits"),
    Column("counts_needed", _WHOLE, "1/rev", "fewest counts that satisfy these limits; null if none do"),
    Column("friction_needed_nm", _REAL, "N*m", "least Coulomb friction of the knob that satisfies these limits"),
)
# Only where the scene has a hand.
WITH_HAND = (
    Column(
        "colgate_schenkel_with_hand", _FLAG, "", "b > K (T / 2 + t_d) + |B|: no oscillation with this hand's damping"
    ),
    Column("abbott_okamura_with_hand", _FLAG, "", "K <= min(b / (T / 2 + t_d), 2 T_c / q), b of knob and hand"),
    Column("colgate_schenkel_with_hand_load", _REAL, "1", "(K (T / 2 + t_d) + |B|) / b; null where infinite"),
    Column("abbott_okamura_with_hand_load", _REAL, "1", "K / min(b / (T / 2 + t_d), 2 T_c / q); null where infinite"),
    Column("binding_limb_with_hand", _TEXT, "", "the limit with the largest load, the hand's damping counted in all"),
    Column("rate_needed_with_hand_hz", _REAL, "Hz", "as rate_needed_hz, the hand's damping counted in all limits"),
    Column(
        "damping_needed_with_hand_nm_s_per_rad",
        _REAL,
        "N*m*s/rad",
        "least damping of knob and hand together that satisfies all limits, the hand's counted in all",
    ),
)


Progress = Callable[[int, int], None]
Law = Callable[[WorkingEdge], Prediction]


class PredictResult(NamedTuple):
    """The tables: one row per cell and law, and one row per cell."""

    predictions: pa.Table
    passivity: pa.Table


def predict(plan: PredictPlan, progress: Progress = lambda _done, _total: None) -> PredictResult:
    """Evaluate every law in every cell; ``progress`` is told of the cells.

    Raises `ComputationError`, and `UsageError` for a sweep that is not there.
    """
    all_laws: dict[str, Law] = {
        "quantum_period": partial(quantum_period, constant=plan.constant),
        "describing_function": describing_function,
        "energy_balance": energy_balance,
    }
    laws = {name: all_laws[name] for name in plan.laws}
    against = compare.Against(plan.against, list(plan.axes), cells_of(plan)) if plan.against else None
    predictions: list[dict[str, Any]] = []
    limits: list[dict[str, Any]] = []
    every = cells_of(plan)
    held = plan.scene.hand is not None
    for done, cell in enumerate(every):
        progress(done, len(every))
        try:
            edge = working_edge(scene_at(plan.scene, cell), cell)
            predictions += _prediction_rows(cell, edge, laws, against)
            limits.append({**cell, **_limit_columns(verdict(edge), held=held)})
        except ArithmeticError:
            message = f"at {cell[RATE]:g} Hz and {cell[COUNTS]} counts the scene's numbers overflow"
            raise ComputationError(message) from None
    axes = [axis_column(name, plan.units[name]) for name in plan.axes]
    compared = compare.COLUMNS if against else ()
    return PredictResult(
        predictions=build_table([*axes, *PREDICTIONS, *compared], predictions),
        passivity=build_table([*axes, *PASSIVITY, *(WITH_HAND if held else ())], limits),
    )


def _prediction_rows(
    cell: Cell, edge: WorkingEdge, laws: dict[str, Law], against: compare.Against | None
) -> Iterator[dict[str, Any]]:
    for name, law in laws.items():
        found = law(edge)
        p2p = found.p2p_rad
        yield {
            **cell,
            "law": name,
            "p2p_rad": p2p,
            "amplitude_rad": None if p2p is None else 0.5 * p2p,
            "frequency_hz": found.frequency_hz,
            "rms_rad": None if p2p is None else RMS_ARCS * p2p,
            "rms_sine_rad": None if p2p is None else RMS_SINE * p2p,
            "in_domain": found.in_domain,
            "reason": found.reason,
            **(against.columns(cell, p2p_rad=p2p, frequency_hz=found.frequency_hz) if against else {}),
        }


def _limit_columns(found: Verdict, *, held: bool) -> dict[str, Any]:
    """The columns of one cell, those with the hand's damping where a hand is ``held``."""
    limits = {name: found.limits[name] for name in (LIMITS if held else DEVICE)}
    loads = {f"{name}_load": limit.load for name, limit in limits.items()}
    columns = {
        "device_passive": found.passive,
        **{name: limit.holds for name, limit in limits.items()},
        **{name: load if isfinite(load) else None for name, load in loads.items()},
        "binding_limb": found.device.binding,
        "rate_needed_hz": found.device.rate_hz,
        "damping_needed_nm_s_per_rad": found.device.damping,
        "counts_needed": found.device.counts,
        "friction_needed_nm": found.device.friction,
    }
    if not held:
        return columns
    return {
        **columns,
        "binding_limb_with_hand": found.with_hand.binding,
        "rate_needed_with_hand_hz": found.with_hand.rate_hz,
        "damping_needed_with_hand_nm_s_per_rad": found.with_hand.damping,
    }


CRITERIA = (
    Column("criterion", _TEXT, "", "tsypkin, tsai_colgate, miller, love_book or llewellyn"),
    Column("holds", _FLAG, "", "whether the wall without counts satisfies it; null where it does not apply"),
    Column("load", _REAL, "1", "the wall's stiffness over stiffness_limit; null where there is none, or it is 0"),
    Column(
        "stiffness_limit_nm_per_rad",
        _REAL,
        "N*m/rad",
        "largest stiffness that satisfies it without counts; null where every stiffness does, or it does not apply",
    ),
    Column(
        "quantised_stiffness_limit_nm_per_rad",
        _REAL,
        "N*m/rad",
        "the same of the wall with the encoder's counts; null where it says nothing of counts, or every stiffness does",
    ),
    Column(
        "damping_least_nm_s_per_rad",
        _REAL,
        "N*m*s/rad",
        "love_book: least virtual damping that satisfies it at this stiffness; null where none does",
    ),
    Column(
        "damping_most_nm_s_per_rad",
        _REAL,
        "N*m*s/rad",
        "love_book: most virtual damping that satisfies it at this stiffness; null where none does",
    ),
    Column("in_domain", _FLAG, "", "whether the criterion's assumptions hold"),
    Column("reason", _TEXT, "", "the first assumption that does not hold; empty where all do"),
)
AGAINST = (Column("sweep_cycles", _FLAG, "", "whether any trial of the sweep cycles; null where it has no such cell"),)


def criteria_table(plan: PredictPlan) -> pa.Table:
    """Every criterion of a plan in every cell.

    Raises `ComputationError` for numbers that overflow, and `UsageError` for a sweep that is not there.
    """
    axes = [axis_column(name, plan.units[name]) for name in plan.axes]
    return build_table([*axes, *CRITERIA, *(AGAINST if plan.against else ())], list(_rows(plan)))


def _rows(plan: PredictPlan) -> Iterator[dict[str, Any]]:
    from hknob_cli.theory.criteria import case_of, judge

    every = cells_of(plan)
    against = compare.Against(plan.against, list(plan.axes), every) if plan.against else None
    for cell in every:
        scene = scene_at(plan.scene, cell)
        edge = working_edge(scene, cell)
        case = case_of(scene, edge)
        for name in plan.criteria:
            try:
                found = judge(name, case)
            except ArithmeticError:
                message = f"at {cell[RATE]:g} Hz and {cell[COUNTS]} counts the scene's numbers overflow"
                raise ComputationError(message) from None
            limit = found.stiffness
            yield {
                **cell,
                "criterion": name,
                "holds": found.holds,
                "load": edge.wall_stiffness / limit if limit else None,
                "stiffness_limit_nm_per_rad": _finite(limit),
                "quantised_stiffness_limit_nm_per_rad": _finite(found.quantised),
                "damping_least_nm_s_per_rad": _finite(found.least_damping),
                "damping_most_nm_s_per_rad": _finite(found.most_damping),
                "in_domain": found.in_domain,
                "reason": found.reason,
                **({"sweep_cycles": against.cycles(cell)} if against else {}),
            }


def _finite(value: float | None) -> float | None:
    return value if value is not None and isfinite(value) else None


class PredictWork(Work):
    """Closed laws over a grid."""

    def pictures(self, _job: Job) -> tuple[str, ...]:
        """One picture."""
        return ("predict.png",)

    def files(self, job: Job) -> tuple[str, ...]:
        """Predictions, stability limits, criteria if asked for, and differences from a sweep if there is one."""
        further = ["criteria.parquet"] if job.plan.criteria else []
        return "predict.parquet", "passivity.parquet", *further, *(["differences.parquet"] if job.plan.against else [])

    def stale_outputs(self, job: Job) -> tuple[str, ...]:
        """Differences, where there is no sweep to compare with, and criteria, where none is asked for."""
        return (
            *(() if job.plan.against else ("differences.parquet",)),
            *(() if job.plan.criteria else ("criteria.parquet",)),
        )

    def input_files(self, job: Job) -> tuple[Path, ...]:
        """The sweep it is compared with, and the known case that the constant is taken from, if any."""
        against = [Path(job.plan.against)] if job.plan.against else []
        return *super().input_files(job), *against, *([job.plan.case_file] if job.plan.case_file else [])

    def inputs(self, job: Job) -> dict[str, str]:
        """The sweep that the laws are compared with, and the known case, if any."""
        against = {"against_sha256": compare.digest(job.plan.against)} if job.plan.against else {}
        case = {"case_sha256": job.plan.case_sha256} if job.plan.case_sha256 else {}
        return {**against, **case}

    def compute(self, job: Job) -> Tables:
        """The tables of `files`."""
        if job.plan.against:
            compare_scenes(job)
        with progress_bar(len(cells_of(job.plan)), show=not job.quiet) as progress:
            predictions, passivity = predict(job.plan, progress)
        further = (criteria_table(job.plan),) if job.plan.criteria else ()
        if not job.plan.against:
            return predictions, passivity, *further
        rows = predictions.to_pylist()
        groups = {law: compare.summarise([row for row in rows if row["law"] == law]) for law in job.plan.laws}
        return predictions, passivity, *further, compare.statistics_table("law", groups)

    def draw(self, job: Job, tables: Tables, paths: list[Path]) -> list[Path]:
        """Every law over one axis or two; over more, or over a design, what matters most."""
        from hknob_cli.figures.plot import draw_predictions

        axes, name = list(job.plan.axes), job.plan.name
        drawn = draw_predictions(job.plan, tables[0], tables[1], path=paths[0])
        if not drawn:
            from hknob_cli.figures.what_matters import draw_by

            drawn = draw_by(tables[0], "law", axes, title=name, path=paths[0], stage=job.kind, points=job.plan.points)
        if not drawn:
            note(job, "no picture: more than two axes or a design, and too few cells to tell what matters")
        return paths if drawn else []

    def describe(self, job: Job, tables: Tables) -> dict[str, Any]:
        """Every prediction, the limits, and differences to a sweep over the grid."""
        predictions, passivity = (table.to_pylist() for table in tables[:2])
        laws = {law: [row for row in predictions if row["law"] == law] for law in job.plan.laws}
        return {
            **describe_predictions(laws, passivity, axes=list(job.plan.axes)),
            **({"against": job.plan.against} if job.plan.against else {}),
            **({"criteria": describe_criteria(tables[2].to_pylist())} if job.plan.criteria else {}),
            **overlap_of(job),
            **({"statistics": compare.grouped(tables[-1], "law")} if job.plan.against else {}),
        }

    def text(self, job: Job, summary: dict[str, Any]) -> str:
        """Matrices over two axes, a list otherwise; statistics; lines on the limits and criteria."""
        return predictions_text(summary, list(job.plan.axes))


WORK = PredictWork()
