"""``hknob check``: validate specs, compute nothing."""

from math import prod
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hknob_cli.cli.console import reporting, say
from hknob_cli.cli.options import Sets
from hknob_cli.errors import ExitCode, UsageError

if TYPE_CHECKING:
    from hknob_cli.spec.plan import Plan


def _size(plan: "Plan") -> str:
    """How much there is to do."""
    from hknob_cli.spec.plan import BenchPlan

    if isinstance(plan, BenchPlan):
        count, what = len(plan.scenes), "scene"
    else:
        count, what = prod(len(values) for values in plan.axes.values()), "cell"
    return f"{count} {what}{'' if count == 1 else 's'}"


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
            typer.echo(f"{path}: {plan.values['kind']} '{plan.name}', {_size(plan)}: good")
    if failed:
        raise typer.Exit(ExitCode.USAGE)
