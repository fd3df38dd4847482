"""The work of ``hknob design``."""

import time
from functools import partial
from pathlib import Path
from typing import Any

from hknob_cli.report.design import describe_design, design_text
from hknob_cli.stages.design.run import DesignStage
from hknob_cli.stages.job import Job
from hknob_cli.stages.lag_domain import domain_warning
from hknob_cli.stages.make import KeepingWork, keeping
from hknob_cli.stages.work import Tables, counted, note
from hknob_cli.terminal import progress_bar


class DesignWork(KeepingWork):
    """The cheapest design whose limit cycles nobody minds."""

    def size(self, plan: Any) -> str:
        """Designs to choose from."""
        return counted(plan.size, "design")

    def files(self, job: Job) -> tuple[str, ...]:
        """Every design that was evaluated."""
        del job
        return ("design.parquet",)

    def pictures(self, _job: Job) -> tuple[str, ...]:
        """Cost against level."""
        return ("design.png",)

    def compute(self, job: Job) -> Tables:
        """The table of `files`."""
        begin = time.perf_counter()
        for one in job.plan.candidates:
            if warning := domain_warning(one.sweep, one.name):
                note(job, warning)
        stage = DesignStage(job.plan, jobs=job.jobs, notify=partial(note, job))
        bar = progress_bar(job.plan.size, show=not job.quiet, what="designs")
        with stage, keeping(job, self) as kept, bar as progress:
            table = stage.run(progress, kept)
        if job.verbose:
            note(job, f"{table.num_rows} designs, {job.plan.people} people, {time.perf_counter() - begin:.2f} s")
        return (table,)

    def draw(self, job: Job, tables: Tables, paths: list[Path]) -> list[Path]:
        """Cost against what is felt, and the grid of plain walls."""
        from hknob_cli.figures.design_picture import draw_design

        draw_design(job.plan, tables[0].to_pylist(), path=paths[0])
        return paths

    def describe(self, job: Job, tables: Tables) -> dict[str, Any]:
        """The answer, what binds, what less would cost, the front, and the notional surface."""
        return describe_design(job.plan, tables[0])

    def text(self, job: Job, summary: dict[str, Any]) -> str:
        """The answer in lines, and the front as a table."""
        return design_text(job.plan, summary)


WORK = DesignWork()
