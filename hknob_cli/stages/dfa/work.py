"""The work of ``hknob dfa``."""

from functools import partial
from pathlib import Path
from typing import Any

from hknob_cli.report.theory import describe_dfa, dfa_text, nearest_cycles
from hknob_cli.specs.cells import cells_of
from hknob_cli.stages import compare
from hknob_cli.stages.dfa.run import DfaStage, digest_of_lists
from hknob_cli.stages.job import Job
from hknob_cli.stages.work import Tables, Work, compare_scenes, note, overlap_of
from hknob_cli.terminal import progress_bar


class DfaWork(Work):
    """Describing functions over a grid."""

    def pictures(self, _job: Job) -> tuple[str, ...]:
        """One picture."""
        return ("dfa.png",)

    def files(self, job: Job) -> tuple[str, ...]:
        """Cycles by method, and their differences from a sweep where there is one."""
        return "dfa.parquet", *(["differences.parquet"] if job.plan.against else [])

    def stale_outputs(self, job: Job) -> tuple[str, ...]:
        """Differences, where there is no sweep to compare with."""
        return () if job.plan.against else ("differences.parquet",)

    def input_files(self, job: Job) -> tuple[Path, ...]:
        """The sweep it is compared with, if any."""
        return *super().input_files(job), *([Path(job.plan.against)] if job.plan.against else [])

    def inputs(self, job: Job) -> dict[str, str]:
        """The sweep it is compared with, if any."""
        if not job.plan.against:
            return {}
        found = {"against_sha256": compare.digest(job.plan.against)}
        orbits = digest_of_lists(job.plan.against) if "sampled" in job.plan.methods else None
        return {**found, **({"against_orbits_sha256": orbits} if orbits else {})}

    def compute(self, job: Job) -> Tables:
        """The tables of `files`."""
        if job.plan.against:
            compare_scenes(job)
        with progress_bar(len(cells_of(job.plan)), show=not job.quiet) as progress:
            table = DfaStage(job.plan, notify=partial(note, job)).run(progress)
        if not job.plan.against:
            return (table,)
        rows, axes = table.to_pylist(), list(job.plan.axes)
        groups = {
            method: compare.summarise(nearest_cycles([row for row in rows if row["method"] == method], axes))
            for method in job.plan.methods
        }
        return table, compare.statistics_table("method", groups)

    def draw(self, job: Job, tables: Tables, paths: list[Path]) -> list[Path]:
        """Nyquist curves with the relay's rays, and sizes over the grid; over many axes what matters most."""
        from hknob_cli.figures.plot import draw_dfa

        drawn = draw_dfa(job.plan, tables[0].to_pylist(), path=paths[0])
        if not drawn:
            from hknob_cli.figures.what_matters import draw_by

            axes, name = list(job.plan.axes), job.plan.name
            drawn = draw_by(
                tables[0], "method", axes, title=name, path=paths[0], stage=job.kind, points=job.plan.points
            )
        if not drawn:
            note(job, "no picture: more than two axes or a design, and too few cells to tell what matters")
        return paths if drawn else []

    def describe(self, job: Job, tables: Tables) -> dict[str, Any]:
        """Every row, and statistics by method where there is a sweep to compare with."""
        statistics = compare.grouped(tables[1], "method") if job.plan.against else None
        return {**describe_dfa(tables[0], axes=list(job.plan.axes), statistics=statistics), **overlap_of(job)}

    def text(self, _job: Job, summary: dict[str, Any]) -> str:
        """Matrices by method."""
        return dfa_text(summary)


WORK = DfaWork()
