"""``hknob sweep``: simulate a grid to its proven limit cycles."""

import json
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hknob_cli.cli.console import progress_bar, reporting, say
from hknob_cli.cli.options import (
    DryRun,
    Executor,
    ExecutorName,
    Force,
    Jobs,
    Json,
    Out,
    Quiet,
    Scheduler,
    Sets,
    SpecFile,
    Verbose,
)
from hknob_cli.errors import UsageError

if TYPE_CHECKING:
    import pyarrow as pa

    from hknob_cli.spec.load import Loaded

FILES = ("cells.parquet", "orbits.parquet")
PICTURE = "grid.png"
SLOW = 50_000_000  # trial-samples worth a progress bar


def sweep(
    spec: SpecFile,
    out: Out = None,
    sets: Sets = None,
    plot: Annotated[bool, typer.Option("--plot", help=f"Draw the grid into {PICTURE} beside the results.")] = False,
    jobs: Jobs = None,
    executor: Executor = ExecutorName.local,
    scheduler: Scheduler = None,
    force: Force = False,
    dry_run: DryRun = False,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Find every limit cycle of a grid of sample rates and encoder resolutions, with its size, pitch and share."""
    with reporting():
        if executor is ExecutorName.dask or scheduler:
            raise UsageError("--executor: dask is not in this version; local is")
        from hknob_cli.spec.load import load

        loaded = load(spec, tuple(sets or ()), kind="sweep")
        _sweep(
            loaded,
            out=out or Path("results") / loaded.spec.name,
            overrides=tuple(sets or ()),
            plot=plot,
            jobs=jobs,
            force=force,
            dry_run=dry_run,
            as_json=as_json,
            quiet=quiet,
            verbose=verbose,
        )


def _sweep(
    loaded: "Loaded",
    *,
    out: Path,
    overrides: tuple[str, ...],
    plot: bool,
    jobs: int | None,
    force: bool,
    dry_run: bool,
    as_json: bool,
    quiet: bool,
    verbose: bool,
) -> None:
    from hknob_cli.report.summary import describe_sweep, table_text
    from hknob_cli.results import provenance, store

    name = loaded.spec.name
    stamp = provenance.describe(stage="sweep", values=loaded.values, overrides=overrides)
    paths = [out / file for file in FILES]
    store.refuse_foreign(paths, stage="sweep", name=name)
    current = None if force else store.read_current(paths, stamp)
    if dry_run:
        _say_plan(paths, force=force, current=current is not None)
        return
    if current is not None and not plot:
        (cells, orbits), status = current, "up to date"
    else:
        with store.hold(out):
            if current is None:
                cells, orbits = _compute(loaded, jobs=jobs, quiet=quiet, verbose=verbose)
                store.write(dict(zip(paths, (cells, orbits), strict=True)), stamp)
                status = "computed"
            else:
                (cells, orbits), status = current, "up to date"
            if plot:
                from hknob_cli.report.picture import draw_sweep

                if not draw_sweep(cells, orbits, list(loaded.axes), title=name, path=out / PICTURE):
                    say("no picture: more than two axes have several values")
                    plot = False
    files = [*paths, *([out / PICTURE] if plot else [])]
    summary = describe_sweep(cells, orbits, list(loaded.axes), name=name, status=status, files=files)
    if as_json:
        typer.echo(json.dumps(summary, allow_nan=False))
    else:
        typer.echo(table_text(summary, list(loaded.axes)))


def _say_plan(paths: list[Path], *, force: bool, current: bool) -> None:
    if current:
        typer.echo(f"nothing would run: {paths[0].parent} is up to date")
        return
    missing = [path.name for path in paths if not path.exists()]
    why = "forced" if force else f"no {missing[0]} yet" if missing else "the spec or the program has changed since"
    typer.echo(f"sweep would run, because: {why}; it would write {' and '.join(str(path) for path in paths)}")


def _compute(loaded: "Loaded", *, jobs: int | None, quiet: bool, verbose: bool) -> "tuple[pa.Table, pa.Table]":
    from hknob_cli.stages.sweep import SweepStage

    begin = time.perf_counter()
    stage = SweepStage(loaded, jobs=jobs)
    with progress_bar(stage.cell_count, show=not quiet and stage.expected > SLOW) as progress:
        result = stage.run(progress)
    if verbose and not quiet:
        seconds = time.perf_counter() - begin
        how = "compiled" if stage.compiled else "interpreted"
        say(f"{stage.cell_count} cells, {result.samples} trial-samples, {how}, {seconds:.2f} s")
    return result.cells, result.orbits
