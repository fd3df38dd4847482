"""A long sweep, spread over processes or a cluster: kept piece by piece, so that it can be cut short at any time."""

from collections.abc import Callable
from typing import Any

from hknob_cli.errors import unwritable
from hknob_cli.report.table import short
from hknob_cli.results.parted import Parting
from hknob_cli.results.staging import Staging
from hknob_cli.results.versions import grid_versions
from hknob_cli.specs.cells import cells_of
from hknob_cli.spread.cores import usable_cores
from hknob_cli.spread.gather import Range, Ranges, Sample, Workers, gather
from hknob_cli.stages.job import Job
from hknob_cli.stages.sweep.assembly import Assembly, PieceFinder
from hknob_cli.stages.sweep.run import SweepStage
from hknob_cli.stages.sweep.sampled_rows import Rows, nearly_same, rows_of, same
from hknob_cli.terminal import heed, spread_progress


def spread_sweep(job: Job, stage: SweepStage, stamp: bytes, notify: Callable[[str], None]) -> tuple[Any, ...]:
    """Cells and orbits of a sweep whose results will have the provenance ``stamp``. Raises `ComputationError`."""
    total, staging = stage.cell_count, Staging(job.out, stamp)
    parting = Parting(total, stamp)
    try:
        assembly = Assembly(staging, parting)
        done = assembly.begin(afresh=job.force)
        left = Ranges(total, done=done, part=parting.items)
        if done and left:
            notify(f"{total - len(left)} of {total} cells are there from an earlier run")
        if left:
            _gather(job, stage, assembly, left, notify)
        return assembly.tables()
    except OSError as error:
        raise unwritable(job.out, error, kept=True) from None
    finally:
        staging.leave()


def _gather(job: Job, stage: SweepStage, assembly: Assembly, left: Ranges, notify: Callable[[str], None]) -> None:
    parting = assembly.parting
    finder = PieceFinder(job.plan, parting, grid_versions(job.plan.points))
    with spread_progress(parting.total, show=not job.quiet, done=parting.total - len(left)) as progress:

        def deliver(start: int, stop: int, data: bytes) -> None:
            assembly.take(start, stop, data)
            progress(stop - start)

        def tick() -> None:
            heed()
            progress(0)

        def part_of(one: Range, data: bytes, some: Range) -> Rows:
            return rows_of(data, some.start - one.start, cells_of(job.plan).run(some.start, some.stop))

        sample = Sample(part_of, nearly_same if job.scheduler else same)
        workers = _workers(job, stage, finder, notify)
        gather(workers, left, deliver, tick=tick, name=lambda one: _named(job.plan, one), sample=sample)


def _workers(job: Job, stage: SweepStage, finder: PieceFinder, notify: Callable[[str], None]) -> Workers:
    if job.scheduler:
        from hknob_cli.spread.cluster import Cluster

        return Cluster(finder, job.scheduler, notify)
    from hknob_cli.spread.processes import Processes, keep_memory

    keep_memory()
    stage.compile()
    finder.prepare(stage)
    return Processes(finder, job.jobs or usable_cores())


def _named(plan: Any, one: Range) -> str:
    """Cells by number, and the first by its values."""
    cell = next(cells_of(plan).run(one.start, one.start + 1))
    values = ", ".join(f"{name} = {short(value)}" for name, value in cell.items())
    which = f"cell {one.start}," if one.items == 1 else f"cells {one.start} to {one.stop - 1}, from"
    return f"{which} {values}"
