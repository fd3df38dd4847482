"""``hknob schema``: the JSON Schema of a kind of spec, for editors."""

import json
from typing import Annotated

import typer

from hknob_cli.cli.console import reporting


def schema(
    kind: Annotated[
        str, typer.Argument(help="Kind of spec: sweep, dfa, predict, bench, report, pipeline.", show_default=False)
    ],
) -> None:
    """Print the JSON Schema of a kind of spec."""
    with reporting():
        from hknob_cli.spec.schema import json_schema

        typer.echo(json.dumps(json_schema(kind), indent=2))
