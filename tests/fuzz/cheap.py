"""Whether a stage may be run among many: what its plan says of the work must be next to nothing."""

from pathlib import Path
from typing import Any

from hknob_cli.errors import HknobError
from hknob_cli.specs.cells import cells_of

SAMPLES = 150_000  # of a sweep's plain loop
TRIALS = 24  # with a controller, or of an identification
ROWS = 3000  # of a recording
SIMULATED = 100_000  # samples of a campaign


def is_cheap(path: Path, sets: tuple[str, ...]) -> bool:
    """Whether the spec in a file is good, and its stage over soon, as far as its plan tells."""
    from hknob_cli.specs.load import kind_of, load

    try:
        kind = str(kind_of(path))
        return kind in COST and bool(COST[kind](load(path, sets)))
    except HknobError:
        return False


def _sweep(plan: Any) -> bool:
    from hknob_cli.stages.sweep.run import SweepStage, work_of

    stage = SweepStage(plan, jobs=1)
    if stage.cell_count > 9 or _rows(plan) > ROWS:
        return False
    if plan.scene.controller:
        return stage.cell_count * plan.starts.phases <= TRIALS
    return work_of(stage.expected) <= SAMPLES


def _rows(plan: Any) -> float:
    if plan.record is None:
        return 0.0
    rates = plan.axes.get("sample_rate_hz", [0.0])
    motions = plan.record.trials * max(1, len(plan.record.angles)) * len(cells_of(plan))
    return motions * plan.record.duration * (max(rates) + 1.0 / plan.record.interval)


def _cells(plan: Any) -> bool:
    return len(cells_of(plan)) <= 12


def _sysid(plan: Any) -> bool:
    if plan.study is not None:
        bias, hidden = plan.study
        levels = 0 if bias is None else bias.repeats * len(bias.grips_n) * sum(map(len, bias.nuisances.values()))
        return levels <= TRIALS and (hidden is None or len(hidden.ratios) <= TRIALS) and not (bias and not levels)
    if plan.virtual is None:
        return True
    made = plan.virtual
    each = (made.subjects or 9) * made.blocks * made.trials * len(made.grips or range(6))
    fits = sum(12 if name == "fourth_order" else 1 for name in plan.estimators)  # one takes as long as so many
    return len(made.experiments) * each * fits <= TRIALS


def _remedies(plan: Any) -> bool:
    sweeps = [one for remedy in plan.remedies for one in (remedy.grid, *remedy.cases)]
    return sum(len(cells_of(one)) * one.starts.phases for one in sweeps) <= 2 * TRIALS and all(
        plan.duration * rate <= ROWS for one in sweeps for rate in one.axes["sample_rate_hz"]
    )


def _design(plan: Any) -> bool:
    return plan.size * plan.people * max(one.sweep.starts.phases for one in plan.candidates) <= 2 * TRIALS


def _hw_run(plan: Any) -> bool:
    if plan.device.driver == "serial":
        return False
    course = plan.course
    samples = sum(rate * (course.zero + course.longest) for rate in plan.axes["sample_rate_hz"])
    return samples * len(plan.axes["counts_per_rev"]) * plan.repeats * len(plan.tries) <= SIMULATED


def _bench(plan: Any) -> bool:
    from hknob_cli.stages.bench.timed import LEAST_PATIENCE_S, PATIENCE

    runs = 2 * (len(plan.tolerances) + 1 + len(plan.substeps)) * len(plan.methods)
    work = sum(one.samples * (20 if one.reference == "digits60" else 1) for one in plan.scenes)
    patience = max(PATIENCE * plan.seconds_per_run, LEAST_PATIENCE_S)
    return work <= 2000 and (plan.seconds_per_run * runs + patience) * len(plan.scenes) <= 5.0


def _report(plan: Any) -> bool:
    return sum(len(chapter.figures) for chapter in plan.chapters) <= 3


COST = {
    "sweep": _sweep,
    "dfa": _cells,
    "predict": _cells,
    "sysid": _sysid,
    "remedies": _remedies,
    "design": _design,
    "hw-run": _hw_run,
    "bench": _bench,
    "report": _report,
}
