"""The ``hknob`` command and its subcommands."""

from collections.abc import Callable
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from hknob_cli import __version__
from hknob_cli.cli.check import check, schema, verify
from hknob_cli.cli.explain import explain
from hknob_cli.cli.explore import explore
from hknob_cli.cli.new import new
from hknob_cli.cli.run import run
from hknob_cli.cli.stages import stage_command
from hknob_cli.stage_table import STAGES


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
