"""The ``hknob`` command and its subcommands, of which those of stages are called in one way.

A stage is told apart by its kind; ``hknob hw-run`` takes one option more.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from hknob_cli import __version__
from hknob_cli.cli.check import check, explain, schema, verify
from hknob_cli.cli.explore import explore
from hknob_cli.cli.handover import submit
from hknob_cli.cli.new import new
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
from hknob_cli.cli.run import run
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


class ByPurpose(TyperGroup):
    """Commands listed by what they are for."""

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """A section of the help for each panel, in the order of the first command of each."""
        panels: dict[str, list[tuple[str, str]]] = {}
        for name in self.list_commands(ctx):
            command: Any = self.get_command(ctx, name)
            panels.setdefault(command.rich_help_panel, []).append((name, command.help or ""))
        for panel, rows in panels.items():
            with formatter.section(panel):
                formatter.write_dl(rows)


app = typer.Typer(
    name="hknob",
    cls=ByPurpose,
    rich_markup_mode=None,  # its printer of boxes takes longer to load than all else
    help="Will this knob buzz against a virtual wall, how much, and at what pitch?",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
OTHERS: dict[str, tuple[Callable[..., None], ...]] = {
    "Find out": (explain, explore),
    "Automate": (new, run),
    "Check": (check, verify, schema),
}
for panel in ("Find out", "Fix", "Measure", "Automate", "Check"):
    for kind, stage in STAGES.items():
        if stage.panel == panel:
            app.command(kind, help=stage.summary, rich_help_panel=panel)(stage_command(kind))
    for command in OTHERS.get(panel, ()):
        app.command(rich_help_panel=panel)(command)


def _version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"hknob {__version__}")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version and exit.")
    ] = False,
) -> None:
    pass
