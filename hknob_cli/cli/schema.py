"""``hknob schema``: the JSON Schema of a kind of spec, for editors."""

import json
from typing import Annotated

import typer

from hknob_cli.stage_table import CLAIMS, SCHEMAS
from hknob_cli.terminal.console import reporting


def schema(
    kind: Annotated[
        str,
        typer.Argument(
            help=", ".join(SCHEMAS),
            show_default=False,
            metavar="KIND",
            autocompletion=lambda incomplete: [kind for kind in SCHEMAS if kind.startswith(incomplete)],
        ),
    ],
) -> None:
    """Print the JSON Schema of a kind of spec."""
    with reporting():
        from hknob_cli.specs.schema import json_schema, titled

        if kind == CLAIMS:
            from hknob_cli.page.claims.ledger import Ledger

            found = titled(Ledger.model_json_schema(), "hknob ledger of claims")
        else:
            found = json_schema(kind)
        typer.echo(json.dumps(found, indent=2))
