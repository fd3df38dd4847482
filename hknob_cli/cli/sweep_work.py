"""The work of ``hknob sweep``."""

import time
from functools import partial
from pathlib import Path
from typing import Any

from hknob_cli.cli.console import progress_bar
from hknob_cli.cli.job import Job
from hknob_cli.cli.stage_run import Tables, note
from hknob_cli.report.summary import describe_sweep, table_text
from hknob_cli.stages.sweep import SweepStage


class SweepWork:
    """See `stage_run.Work`."""

    picture = "grid.png"

    def files(self, _job: Job) -> tuple[str, ...]:
        """Cells, and the orbits in them."""
        return "cells.parquet", "orbits.parquet"

    def inputs(self, _job: Job) -> dict[str, str]:
        """A sweep depends on its spec alone."""
        return {}

    def compute(self, job: Job) -> Tables:
        """Cells and orbits."""
        begin = time.perf_counter()
        stage = SweepStage(job.plan, jobs=job.jobs, notify=partial(note, job))
        with progress_bar(stage.cell_count, show=not job.quiet and stage.long) as progress:
            result = stage.run(progress)
        if job.verbose:
            seconds = time.perf_counter() - begin
            how = "compiled" if stage.compiled else "interpreted"
            note(job, f"{stage.cell_count} cells, {result.samples} trial-samples, {how}, {seconds:.2f} s")
        return result.cells, result.orbits

    def draw(self, job: Job, tables: Tables, path: Path) -> bool:
        """The grid, over one axis or two."""
        from hknob_cli.report.picture import draw_sweep

        cells, orbits = tables
        drawn = draw_sweep(cells, orbits, list(job.plan.axes), title=job.plan.name, path=path)
        if not drawn:
            note(job, "no picture: more than two axes have several values")
        return drawn

    def describe(self, job: Job, tables: Tables) -> dict[str, Any]:
        """Counts of outcomes, and every cell."""
        cells, orbits = tables
        return describe_sweep(cells, orbits, axes=list(job.plan.axes))

    def text(self, job: Job, summary: dict[str, Any]) -> str:
        """Matrices over two axes, a list otherwise."""
        return table_text(summary, list(job.plan.axes))


WORK = SweepWork()
