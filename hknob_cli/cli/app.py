"""The ``hknob`` command: its subcommands, each in a file of its own."""

import gc
import os
import sys
from typing import Annotated, NoReturn

# Start-up: pydantic would open the metadata of every installed package to look for plugins, and the collector would
# walk the modules as they load.
os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
gc.disable()

import typer

from hknob_cli import __version__
from hknob_cli.cli.check import check
from hknob_cli.cli.schema import schema
from hknob_cli.cli.sweep import sweep
from hknob_cli.errors import ExitCode

app = typer.Typer(
    name="hknob",
    help="Will this knob buzz against a virtual wall, how much, and at what pitch?",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.command()(sweep)
app.command()(check)
app.command()(schema)


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


def main() -> NoReturn:
    """Run the command line, and leave without tearing down: freeing every module takes as long as a small sweep."""
    code: object = ExitCode.DONE
    try:
        app()
    except SystemExit as leaving:
        code = leaving.code
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code if isinstance(code, int) else ExitCode.DONE if code is None else ExitCode.FAILED)
