"""``hknob hw-run``: trials on a knob, real or simulated, recorded and measured."""

from typing import Annotated

import typer

from hknob_cli.cli.options import (
    DryRun,
    Executor,
    ExecutorName,
    Json,
    Out,
    Quiet,
    Scheduler,
    Sets,
    SpecFile,
    Verbose,
)
from hknob_cli.cli.stages import submit_stage
from hknob_cli.stage_table import STAGES

STAGE = STAGES["hw-run"]
UNATTENDED = "Nobody is there: no keys, trials begin at once. Always so without a terminal, and in simulation."

JOBS = "As for every stage; without effect, for trials follow one another."
FORCE = "Begin anew even where results are up to date; recordings of a device are moved to DIR/earlier."


def hw_run(
    spec: SpecFile,
    out: Out = None,
    sets: Sets = None,
    unattended: Annotated[bool, typer.Option("--unattended", help=UNATTENDED)] = False,
    plot: Annotated[bool, typer.Option("--plot", help=STAGE.picture)] = False,
    jobs: Annotated[int | None, typer.Option("--jobs", "-j", min=1, metavar="N", help=JOBS)] = None,
    executor: Executor = ExecutorName.local,
    scheduler: Scheduler = None,
    force: Annotated[bool, typer.Option("--force", help=FORCE)] = False,
    dry_run: DryRun = False,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Submit the trials; ``unattended``: nobody is there."""
    spread = executor is ExecutorName.dask or bool(scheduler)
    submit_stage(
        STAGE.name,
        spec,
        out,
        sets,
        refuse="--executor: there is one knob, and its trials follow one another; local is" if spread else "",
        plot=plot,
        jobs=jobs,
        force=force,
        dry_run=dry_run,
        as_json=as_json,
        quiet=quiet,
        verbose=verbose,
        unattended=unattended,
    )
