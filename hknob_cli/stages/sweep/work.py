"""The work of ``hknob sweep``."""

import time
from functools import partial
from pathlib import Path
from typing import Any

from hknob_cli.engine.compiling import working_clock
from hknob_cli.results.files import Staging, clear_staged, staged
from hknob_cli.results.parted import Parted
from hknob_cli.specs.plan import COUNTS, PERSON, is_unpushed, knob_counts, scene_at
from hknob_cli.stages.job import Job
from hknob_cli.stages.make import stamp_of
from hknob_cli.stages.sweep.completeness_text import completeness_text, describe_completeness
from hknob_cli.stages.sweep.run import Engines, SweepStage
from hknob_cli.stages.sweep.text import describe_sweep, table_text
from hknob_cli.stages.work import PerceivingWork, Tables, Work, note
from hknob_cli.terminal import progress_bar

LIMITED = (
    "a limit ends each cell that takes longer, and says what is known by then: --set limits.seconds_per_cell=20"
    " (results then depend on the machine)"
)
UNPUSHED = "the knob is not pushed into the wall (no bias is given); where it rests, it may buzz under a push"


class SweepWork(PerceivingWork):
    """Limit cycles over a grid."""

    def pictures(self, job: Job) -> tuple[str, ...]:
        """The grid, and recordings or maps of basins where there are any."""
        more = {"trajectories.png": job.plan.record, "basins.png": job.plan.basins}
        return "grid.png", *(name for name, asked in more.items() if asked)

    def files(self, job: Job) -> tuple[str, ...]:
        """Cells, the orbits in them, and recordings or maps of basins where they are asked for."""
        more = {"trajectories.parquet": job.plan.record, "basins.parquet": job.plan.basins}
        return "cells.parquet", "orbits.parquet", *(name for name, asked in more.items() if asked)

    def stale_outputs(self, job: Job) -> tuple[str, ...]:
        """Recordings and maps of basins, where none are asked for."""
        recorded = () if job.plan.record else ("trajectories.parquet", "trajectories.png")
        return *recorded, *(() if job.plan.basins else ("basins.parquet", "basins.png"))

    def compute(self, job: Job) -> Tables:
        """Cells and orbits."""
        begin = time.perf_counter()
        _say_what_goes(job, self)
        _warn_of_lag(job)
        stage = SweepStage(job.plan, jobs=job.jobs, engines=Engines(notify=partial(note, job)))
        if stage.spreads or job.scheduler:
            from hknob_cli.stages.sweep.assembly import spread_sweep

            return (*spread_sweep(job, stage, stamp_of(job, self), partial(note, job)), *_recorded(job))
        hint = "" if job.plan.seconds_per_cell else LIMITED
        bar = progress_bar(
            stage.cell_count,
            show=not job.quiet,
            long=stage.long,
            name=job.plan.name,
            hint=hint,
            clock=working_clock,
        )
        with bar as progress:
            result = stage.run(progress)
        if job.verbose:
            seconds = time.perf_counter() - begin
            how = "compiled" if stage.compiled else "interpreted"
            note(job, f"{stage.cell_count} cells, {result.samples} trial-samples, {how}, {seconds:.2f} s")
        return result.cells, result.orbits, *_recorded(job)

    def partial_results(self, job: Job) -> list[Path]:
        """Finished pieces and parts."""
        return staged(job.out)

    def finished(self, job: Job) -> str:
        """Cells of a long sweep."""
        from hknob_cli.results.parted import Parting
        from hknob_cli.specs.cells import cells_of
        from hknob_cli.stages.sweep.assembly import finished

        stamp, total = stamp_of(job, self), len(cells_of(job.plan))
        there = 0 if job.force else finished(Staging(job.out, stamp), Parting(total, stamp))
        return f"{there} of {total} cells" if there else ""

    def clear_partial(self, job: Job) -> None:
        """Remove what this run, or one of another spec that was cut short, had finished."""
        clear_staged(job.out)

    def draw(self, job: Job, tables: Tables, paths: list[Path]) -> list[Path]:
        """The grid, over one axis or two, and the recordings."""
        cells, orbits = tables[:2]
        drawn = []
        if _draw_grid(job, cells, orbits, paths[0]):
            drawn.append(paths[0])
        else:
            why = (
                "more than two axes or a design, and too few cells to tell what matters"
                if job.plan.axes
                else "the grid has no axis"
            )
            note(job, f"no {paths[0].name}: {why}")
        if job.plan.record:
            from hknob_cli.figures.panel import draw_trajectories

            stiffness = job.plan.scene.wall.stiffness
            draw_trajectories(tables[2], list(job.plan.axes), stiffness, title=job.plan.name, path=paths[1])
            drawn.append(paths[1])
        if job.plan.basins:
            from hknob_cli.figures.plot import draw_basins

            draw_basins(tables[2], orbits, list(job.plan.axes), title=job.plan.name, path=paths[1])
            drawn.append(paths[1])
        return drawn

    def describe(self, job: Job, tables: Tables) -> dict[str, Any]:
        """Counts of outcomes, and every cell."""
        cells, orbits = tables[:2]
        if isinstance(cells, Parted):
            from hknob_cli.report.large import describe_large

            found = describe_large(
                cells,
                orbits,
                axes=job.plan.axes,
                ranges=job.plan.points.scales if job.plan.points else (),
                trials=_trials(job),
            )
            return {**found, **_unpushed(job, found["at_rest_fraction"] > 0.0)}
        found = describe_sweep(cells, orbits, axes=list(job.plan.axes), trials=_trials(job))
        rests = any(row["at_rest_fraction"] for row in found["cells"])
        return {**found, **_completeness(job, found["cells"]), **_unpushed(job, rests)}

    def text(self, job: Job, summary: dict[str, Any]) -> str:
        """Matrices over two axes, a list otherwise."""
        if "cell_count" in summary:
            from hknob_cli.report.large import large_text

            text = large_text(summary)
        else:
            text = table_text(summary, list(job.plan.axes))
        if "completeness" in summary:
            buzzes = summary["orbits"]["cycle"] > 0
            text = "\n".join([text, "", *completeness_text(summary["completeness"], buzzes=buzzes)])
        return "\n".join([text, *summary.get("notes", [])])


def _warn_of_lag(job: Job) -> None:
    """Say where a bounded lag may make the buzz larger."""
    if job.plan.scene.controller:
        from hknob_cli.stages.lag_domain import domain_warning

        if warning := domain_warning(job.plan, job.plan.name):
            note(job, warning)


def _say_what_goes(job: Job, work: Work) -> None:
    """Say so where another run was cut short in this folder: what it had finished goes when this one is done."""
    if (found := staged(job.out)) and found != [Staging(job.out, stamp_of(job, work)).folder]:
        note(
            job, f"{job.out}: what a run of another spec, --set or version had finished here goes when this one is done"
        )


def _trials(job: Job) -> int:
    """Trials of a cell: without a sample clock there are no phases of it."""
    if job.plan.starts.many:
        from hknob_cli.engine.sets.search import SAMPLED

        return min(job.plan.starts.random or SAMPLED, SAMPLED)
    return int(job.plan.starts.phases) if job.plan.scene.sampled else 1


def _completeness(job: Job, cells: list[dict[str, Any]]) -> dict[str, Any]:
    """Where all starts are meant, of how many cells the list of attractors is complete, as part of the summary."""
    if job.plan.starts.sampled or not job.plan.scene.sampled:
        return {}
    from hknob_cli.stages.sweep.cell import shares_areas

    return {"completeness": describe_completeness(cells, job.plan.starts, areas=shares_areas(job.plan))}


def _unpushed(job: Job, rests: bool) -> dict[str, Any]:
    """A note where trials rest and nothing pushes the knob into the wall, as part of the summary."""
    scene = job.plan.scene
    return {"notes": [UNPUSHED]} if rests and scene.sampled and is_unpushed(scene, job.plan.axes) else {}


def _recorded(job: Job) -> Tables:
    """Trajectories, or maps of basins, where they are asked for: never both, a recording begins at one start."""
    if job.plan.record:
        from hknob_cli.stages.sweep.record import record_sweep

        return (record_sweep(job.plan),)
    if job.plan.basins:
        from hknob_cli.stages.sweep.starts import map_basins

        return (map_basins(job.plan),)
    return ()


def _draw_grid(job: Job, cells: Any, orbits: Any, path: Path) -> bool:
    """The grid; of a population the people; of more than two axes, a design, or too many cells, what matters most."""
    axes = list(job.plan.axes)
    if isinstance(cells, Parted):
        from hknob_cli.report.large import matters_at_large

        names, columns = matters_at_large(cells, axes)
        return _draw_matters(job, columns, names, path, total=cells.num_rows)
    if cells.num_rows == 1 and PERSON not in axes and job.plan.growth_s is None:
        _draw_one(job, cells, orbits, path)
        return True
    if PERSON in axes:
        from hknob_cli.figures.cell_dots import draw_population

        drawn = draw_population(cells.to_pylist(), axes, title=job.plan.name, path=path)
    else:
        from hknob_cli.figures.plot import draw_sweep

        drawn = draw_sweep(cells, orbits, axes, title=job.plan.name, path=path)
    if drawn or not axes:
        return drawn
    from hknob_cli.report.what_matters import axes_that_matter, columns_of
    from hknob_cli.results.columns import WORST

    names = axes_that_matter(axes, cells.column_names)
    return _draw_matters(job, columns_of(cells, [*names, *WORST, "at_rest_fraction"]), names, path)


def _draw_one(job: Job, cells: Any, orbits: Any, path: Path) -> None:
    """The motion of the one cell on its orbits."""
    from math import pi

    from hknob_cli.figures.attractors import PERIODS, draw_one_cell
    from hknob_cli.stages.sweep.record import record_one

    rows = orbits.to_pylist()
    cell = cells.to_pylist()[0]
    at = {name: cell[name] for name in job.plan.axes}
    counts = knob_counts(scene_at(job.plan.scene, at), at) if COUNTS in at else None
    recorded = record_one(job.plan, rows, last=PERIODS)
    draw_one_cell(recorded, rows, 2.0 * pi / counts if counts else None, title=job.plan.name, path=path)


def _draw_matters(job: Job, columns: Any, axes: list[str], path: Path, *, total: int | None = None) -> bool:
    from hknob_cli.figures.what_matters import draw_matters

    scales = job.plan.points.scales if job.plan.points else {}
    return draw_matters({"": columns}, axes, title=job.plan.name, path=path, stage="sweep", scales=scales, total=total)


WORK = SweepWork()
