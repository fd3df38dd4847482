"""``hknob sweep``: simulate a grid to its proven limit cycles."""

from pathlib import Path
from typing import Annotated

import typer

from hknob_cli.cli.console import reporting
from hknob_cli.cli.handover import submit
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


def sweep(
    spec: SpecFile,
    out: Out = None,
    sets: Sets = None,
    plot: Annotated[bool, typer.Option("--plot", help="Draw the grid into grid.png beside the results.")] = False,
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
        from hknob_cli.cli.job import Job
        from hknob_cli.spec.load import load

        plan = load(spec, tuple(sets or ()), kind="sweep")
        job = Job(
            kind="sweep",
            plan=plan,
            out=out or Path("results") / plan.name,
            overrides=tuple(sets or ()),
            plot=plot,
            jobs=jobs,
            force=force,
            dry_run=dry_run,
            as_json=as_json,
            quiet=quiet,
            verbose=verbose,
        )
        submit(job)
