"""The ``hknob`` command and its subcommands."""

from collections.abc import Callable
from typing import Annotated

import typer

from hknob_cli import __version__
from hknob_cli.cli.check import check, schema
from hknob_cli.cli.explain import explain
from hknob_cli.cli.explore import explore
from hknob_cli.cli.new import new
from hknob_cli.cli.run import run
from hknob_cli.cli.stages import stage_command
from hknob_cli.cli.verify import verify
from hknob_cli.stage_table import STAGES

app = typer.Typer(
    name="hknob",
    help="Will this knob buzz against a virtual wall, how much, and at what pitch?",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
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
