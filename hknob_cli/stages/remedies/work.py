"""The work of ``hknob remedies``."""

from functools import partial
from pathlib import Path
from typing import Any

from hknob_cli.engine.compiling import tell_compiling, working_clock
from hknob_cli.report.remedies import most_of
from hknob_cli.stages.job import Job
from hknob_cli.stages.lag_domain import domain_warning
from hknob_cli.stages.make import KeepingWork, keeping
from hknob_cli.stages.remedies.run import RemediesStage
from hknob_cli.stages.remedies.text import describe_trial, trial_text
from hknob_cli.stages.work import Tables, counted, note
from hknob_cli.terminal import progress_bar


class RemediesWork(KeepingWork):
    """Remedies against the buzz, tried over a grid, hands and cases."""

    def size(self, plan: Any) -> str:
        """Remedies to try."""
        return counted(len(plan.remedies), "remedy", "remedies")

    def files(self, job: Job) -> tuple[str, ...]:
        """The grid, and the cases."""
        del job
        return "remedies.parquet", "cases.parquet"

    def pictures(self, job: Job) -> tuple[str, ...]:
        """The cases, and how much each remedy helps over each further axis of the grid."""
        cases = ("remedies.png",) if job.plan.cases or not job.plan.varied else ()
        return (*cases, *(f"remedies_{axis.replace('.', '_')}.png" for axis in job.plan.varied))

    def compute(self, job: Job) -> Tables:
        """The tables of `files`."""
        for one in job.plan.remedies:
            for sweep in () if one.tuned else (one.grid, *one.cases[:1]):
                if warning := domain_warning(sweep, one.name):
                    note(job, warning)
                    break
        stage = RemediesStage(job.plan, jobs=job.jobs)
        if stage.jobs == 1:
            tell_compiling(partial(note, job))
        bar = progress_bar(len(stage.tasks), show=not job.quiet, what="sweeps", name=job.plan.name, clock=working_clock)
        with stage, keeping(job, self) as kept, bar as progress:
            return stage.run(progress, kept)

    def draw(self, job: Job, tables: Tables, paths: list[Path]) -> list[Path]:
        """The pictures that there are."""
        from hknob_cli.figures.plot import draw_trial
        from hknob_cli.figures.remedies import draw_over

        further = list(job.plan.varied.items())
        drawn = []
        for path, (axis, unit) in zip(paths[len(paths) - len(further) :], further, strict=True):
            draw_over(tables[0].to_pylist(), axis, unit, title=job.plan.name, path=path)
            drawn.append(path)
        if len(paths) > len(further) and draw_trial(tables[1].to_pylist(), title=job.plan.name, path=paths[0]):
            drawn.insert(0, paths[0])
        if not drawn:
            note(job, "no picture: no cases are given, and no further axis")
        return drawn

    def describe(self, job: Job, tables: Tables) -> dict[str, Any]:
        """Every remedy at every case, over the grid, and over its further axes."""
        return describe_trial(tables[0], tables[1], list(job.plan.varied), job.plan.values["remedies"])

    def take_along(self, job: Job, summary: dict[str, Any]) -> tuple[str, str] | None:
        """A sweep of the knob with the remedy that does most, of those that are not tuned cell by cell."""
        fixed = {one.name for one in job.plan.remedies if not one.tuned}
        best = most_of({name: row for name, row in summary["grid"].items() if name in fixed}, summary["costs"])
        return ("sweep", best) if best else None

    def text(self, _job: Job, summary: dict[str, Any]) -> str:
        """A table of each case."""
        return trial_text(summary)


WORK = RemediesWork()
