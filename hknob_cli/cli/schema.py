"""``hknob schema``: the JSON Schema of a kind of spec, for editors."""

import json
from typing import Annotated

import typer

from hknob_cli.cli.console import reporting


def schema(
    kind: Annotated[
        str,
        typer.Argument(help="sysid, sweep, dfa, predict, hw-run, bench, report, pipeline, claims", show_default=False),
    ],
) -> None:
    """Print the JSON Schema of a kind of spec."""
    with reporting():
        from hknob_cli.spec.schema import json_schema, titled

        if kind == "claims":
            from hknob_cli.claims.ledger import Ledger

            found = titled(Ledger.model_json_schema(), "hknob ledger of claims")
        else:
            found = json_schema(kind)
        typer.echo(json.dumps(found, indent=2))
