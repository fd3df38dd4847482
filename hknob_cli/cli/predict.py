"""``hknob predict``: closed laws and stability limits over a grid."""

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


def predict(
    spec: SpecFile,
    out: Out = None,
    sets: Sets = None,
    plot: Annotated[bool, typer.Option("--plot", help="Draw every law into predict.png beside the results.")] = False,
    jobs: Jobs = None,
    executor: Executor = ExecutorName.local,
    scheduler: Scheduler = None,
    force: Force = False,
    dry_run: DryRun = False,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Estimate limit cycles of a grid by closed laws, say how far to trust them, and which stability limit binds."""
    with reporting():
        if executor is ExecutorName.dask or scheduler:
            raise UsageError("--executor: dask is not in this version; local is")
        from hknob_cli.cli.job import Job
        from hknob_cli.spec.load import load

        plan = load(spec, tuple(sets or ()), kind="predict")
        job = Job(
            kind="predict",
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
