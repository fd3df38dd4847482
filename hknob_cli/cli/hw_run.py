"""``hknob hw-run``: trials on a knob, real or simulated, recorded and measured."""

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

PICTURE = "Draw the grid, the grip and the motions into hw_run.png, and the sample clock into timing.png."
UNATTENDED = "Nobody is there: no keys, trials begin at once. Always so without a terminal, and in simulation."


def hw_run(
    spec: SpecFile,
    out: Out = None,
    sets: Sets = None,
    unattended: Annotated[bool, typer.Option("--unattended", help=UNATTENDED)] = False,
    plot: Annotated[bool, typer.Option("--plot", help=PICTURE)] = False,
    jobs: Jobs = None,
    executor: Executor = ExecutorName.local,
    scheduler: Scheduler = None,
    force: Force = False,
    dry_run: DryRun = False,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Run trials over a grid on a knob, real or simulated: record them, and measure how it buzzes."""
    with reporting():
        if executor is ExecutorName.dask or scheduler:
            raise UsageError("--executor: there is one knob, and its trials follow one another; local is")
        from hknob_cli.cli.job import Job
        from hknob_cli.spec.load import load

        plan = load(spec, tuple(sets or ()), kind="hw-run")
        job = Job(
            kind="hw-run",
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
            unattended=unattended,
        )
        submit(job)
