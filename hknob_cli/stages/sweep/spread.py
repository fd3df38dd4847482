"""A long sweep, spread over processes or a cluster: kept piece by piece, and sampled cells computed twice."""

from collections.abc import Callable, Iterable, Mapping
from math import isclose
from typing import Any

from hknob_cli.errors import unwritable
from hknob_cli.report.table import short
from hknob_cli.results.parted import Parting
from hknob_cli.results.staging import Staging
from hknob_cli.results.versions import grid_versions
from hknob_cli.specs.cells import cells_of
from hknob_cli.spread.forks import usable_cores
from hknob_cli.spread.gather import Range, Ranges, Sample, Workers, gather
from hknob_cli.stages.job import Job
from hknob_cli.stages.sweep.assembly import Assembly, PieceFinder, decode
from hknob_cli.stages.sweep.run import SweepStage
from hknob_cli.terminal import heed, spread_progress

# Of numbers from processors whose C libraries round `exp` and `sin` differently: what a fault changes is seldom less.
NEAR, NOTHING = 1e-6, 1e-9  # relative; and absolute, in SI units

Rows = list[dict[str, Any]]


def rows_of(data: bytes, place: int, some: Iterable[Mapping[str, Any]]) -> Rows:
    """Rows that a piece has of ``some`` of its cells, the first at ``place``, and of their orbits.

    Cells are given by their axes.
    """
    cells, orbits = decode(data)
    wanted = list(some)
    rows: Rows = cells.slice(place, len(wanted)).to_pylist()
    names = [name for name in wanted[0] if name in orbits.schema.names]
    keys = zip(*(orbits[name].to_pylist() for name in names), strict=True)
    there = {tuple(row[name] for name in names) for row in rows}
    return rows + [orbits.slice(i, 1).to_pylist()[0] for i, key in enumerate(keys) if key in there]


def same(one: Rows, other: Rows) -> bool:
    """Whether all rows are the same to the last bit, as workers of one machine find them."""
    return repr(one) == repr(other)


def nearly_same(one: Rows, other: Rows) -> bool:
    """Whether they are, apart from the last digits of real numbers, as workers of several machines find them."""
    return len(one) == len(other) and all(
        a.keys() == b.keys() and all(_near(a[name], b[name]) for name in a) for a, b in zip(one, other, strict=True)
    )


def _near(one: Any, other: Any) -> bool:
    if isinstance(one, float) and isinstance(other, float):
        return isclose(one, other, rel_tol=NEAR, abs_tol=NOTHING) or (one != one and other != other)
    return bool(one == other)


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
