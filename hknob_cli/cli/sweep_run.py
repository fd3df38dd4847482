"""What ``hknob sweep`` does with a valid spec: compute or reuse, write, draw, print."""

import json
import time
from pathlib import Path

import pyarrow as pa

from hknob_cli.cli.console import progress_bar, say
from hknob_cli.cli.sweep_job import SweepJob
from hknob_cli.report.summary import describe_sweep, table_text
from hknob_cli.results import provenance, store
from hknob_cli.stages.sweep import SweepStage

FILES = ("cells.parquet", "orbits.parquet")
PICTURE = "grid.png"
SLOW = 50_000_000  # trial-samples worth a progress bar


def run_sweep(job: SweepJob) -> None:
    """Run a sweep. Raises `RefusedError` or `ComputationError`."""
    name = job.plan.name
    stamp = provenance.describe(stage="sweep", values=job.plan.values, overrides=job.overrides)
    paths = [job.out / file for file in FILES]
    store.refuse_foreign(paths, stage="sweep", name=name)
    current = None if job.force else store.read_current(paths, stamp)
    if job.dry_run:
        _say_plan(job, paths, current=current is not None)
        return
    if current is not None and not job.plot and not store.leftovers(job.out):
        tables, drawn = current, False
    else:
        with store.hold(job.out):
            tables = current or _compute(job)
            if current is None:
                store.write(dict(zip(paths, tables, strict=True)), stamp)
            drawn = job.plot and _draw(job, tables)
    files = [*paths, *([job.out / PICTURE] if drawn else [])]
    status = "computed" if current is None else "up to date"
    axes = list(job.plan.axes)
    summary = describe_sweep(*tables, axes=axes, name=name, status=status, files=files)
    print(json.dumps(summary, allow_nan=False) if job.as_json else table_text(summary, axes))


def _say_plan(job: SweepJob, paths: list[Path], *, current: bool) -> None:
    if current:
        print(f"nothing would run: {job.out} is up to date")
        return
    missing = [path.name for path in paths if not path.exists()]
    changed = "the spec or the program has changed since"
    why = "forced" if job.force else f"no {missing[0]} yet" if missing else changed
    print(f"sweep would run, because: {why}; it would write {' and '.join(str(path) for path in paths)}")


def _compute(job: SweepJob) -> tuple[pa.Table, pa.Table]:
    begin = time.perf_counter()
    stage = SweepStage(job.plan, jobs=job.jobs, notify=(lambda _text: None) if job.quiet else say)
    with progress_bar(stage.cell_count, show=not job.quiet and stage.expected > SLOW) as progress:
        result = stage.run(progress)
    if job.verbose and not job.quiet:
        seconds = time.perf_counter() - begin
        how = "compiled" if stage.compiled else "interpreted"
        say(f"{stage.cell_count} cells, {result.samples} trial-samples, {how}, {seconds:.2f} s")
    return result.cells, result.orbits


def _draw(job: SweepJob, tables: tuple[pa.Table, pa.Table]) -> bool:
    from hknob_cli.report.picture import draw_sweep

    cells, orbits = tables
    title = job.plan.name
    drawn = draw_sweep(cells, orbits, list(job.plan.axes), title=title, path=job.out / PICTURE)
    if not drawn and not job.quiet:
        say("no picture: more than two axes have several values")
    return drawn
