"""The stage commands, ``hknob sweep`` and the others: one way to be called, told apart by kind."""

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
from hknob_cli.terminal.console import reporting


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
        submit(Job(kind=kind, plan=plan, out=where, overrides=tuple(sets or ()), **options))


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
