"""``hknob verify``: whether the files of a results folder are as they were written; changes nothing."""

import json
from pathlib import Path
from typing import Annotated

import typer

from hknob_cli.cli.options import Json, Quiet
from hknob_cli.errors import ExitCode
from hknob_cli.terminal import reporting, say, tell


def verify(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A folder of results.", show_default=False)],
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Say of each file of a results folder whether it is as it was written."""
    with reporting():
        from hknob_cli.pipeline.verify import Verdict, verify_folder

        found = verify_folder(folder)
        counts = {verdict: sum(one.verdict is verdict for one in found) for verdict in Verdict}
        if as_json:
            files = [{"file": str(one.path), "verdict": one.verdict.value, "why": one.why} for one in found]
            print(json.dumps({"kind": "verify", "folder": str(folder), "files": files}))
        else:
            for one in found:
                if not quiet or one.verdict is Verdict.CHANGED:
                    tell(f"{one.path}: {one.verdict.value}" + (f": {one.why}" if one.why else ""))
        if counts[Verdict.CHANGED]:
            say(
                f"{folder}: {counts[Verdict.CHANGED]} of {len(found)} files are not as written; the command that made "
                "results makes them again; recordings of a device must be put back from a copy"
            )
            raise typer.Exit(ExitCode.FAILED)
        if not as_json:
            tell(f"{folder}: {counts[Verdict.WHOLE]} as written, {counts[Verdict.UNKNOWN]} not checked")
