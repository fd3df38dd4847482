"""The stage commands: one way to be called, told apart by kind, and ``hknob hw-run``, which takes one option more."""

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer

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
    unspreadable,
)
from hknob_cli.errors import UsageError
from hknob_cli.stage_table import STAGES, loaded
from hknob_cli.terminal import reporting

STAGE = STAGES["hw-run"]
UNATTENDED = "Nobody is there: no keys, trials begin at once. Always so without a terminal, and in simulation."
JOBS = "As for every stage; without effect, for trials follow one another."
FORCE = "Begin anew even where results are up to date; recordings of a device are moved to DIR/earlier."


def submit_stage(
    kind: str, spec: Path, out: Path | None, sets: list[str] | None, *, refuse: str, **options: Any
) -> None:
    """Read a spec and submit its job, with ``options`` of `Job`; ``refuse``: why it cannot be spread so."""
    with reporting():
        if refuse:
            raise UsageError(refuse)
        from hknob_cli.specs.load import load
        from hknob_cli.stages.job import Job

        plan = load(spec, tuple(sets or ()), kind=kind)
        where = out or Path("results") / plan.name
        submit(Job(kind=kind, plan=plan, out=where, overrides=tuple(sets or ()), spec=str(spec), **options))


def stage_command(kind: str) -> Callable[..., None]:
    """The command of one kind of stage."""
    stage = STAGES[kind]
    if stage.command:
        own: Callable[..., None] = loaded(stage.command)
        return own

    def command(
        spec: SpecFile,
        out: Out = None,
        sets: Sets = None,
        plot: Annotated[bool, typer.Option("--plot", help=stage.picture)] = False,
        jobs: Jobs = None,
        executor: Executor = ExecutorName.local,
        scheduler: Scheduler = None,
        force: Force = False,
        dry_run: DryRun = False,
        as_json: Json = False,
        quiet: Quiet = False,
        verbose: Verbose = False,
    ) -> None:
        submit_stage(
            kind,
            spec,
            out,
            sets,
            refuse=unspreadable(kind, executor, scheduler),
            plot=plot,
            jobs=jobs,
            scheduler=scheduler,
            force=force,
            dry_run=dry_run,
            as_json=as_json,
            quiet=quiet,
            verbose=verbose,
        )

    return command


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
