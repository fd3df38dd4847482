"""The work of ``hknob predict``."""

from pathlib import Path
from typing import Any

from hknob_cli.specs.cells import cells_of
from hknob_cli.stages import compare
from hknob_cli.stages.job import Job
from hknob_cli.stages.predict.run import criteria_table, predict
from hknob_cli.stages.predict.text import describe_criteria, describe_predictions, predictions_text
from hknob_cli.stages.work import Tables, Work, compare_scenes, note, overlap_of
from hknob_cli.terminal import progress_bar


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
