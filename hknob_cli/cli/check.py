"""``hknob check``: validate specs, compute nothing."""

from math import prod
from pathlib import Path
from typing import Annotated

import typer

from hknob_cli.cli.console import reporting, say
from hknob_cli.cli.options import Sets
from hknob_cli.errors import ExitCode, UsageError


def check(
    specs: Annotated[list[Path], typer.Argument(metavar="SPEC.yaml...", help="Specs to validate.", show_default=False)],
    sets: Sets = None,
) -> None:
    """Validate specs only: one line per fault, FILE:LINE:COL first."""
    from hknob_cli.spec.load import load

    failed = False
    with reporting():
        for path in specs:
            try:
                plan = load(path, tuple(sets or ()))
            except UsageError as error:
                say(str(error))
                failed = True
                continue
            count = prod(len(values) for values in plan.axes.values())
            cells = "1 cell" if count == 1 else f"{count} cells"
            typer.echo(f"{path}: {plan.values['kind']} '{plan.name}', {cells}: good")
    if failed:
        raise typer.Exit(ExitCode.USAGE)
