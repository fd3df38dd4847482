"""Options that every stage takes."""

from enum import Enum
from pathlib import Path
from typing import Annotated

import typer

from hknob_cli.specs.named_file import named
from hknob_cli.stage_table import STAGES


class ExecutorName(str, Enum):
    """How work is spread."""

    local = "local"
    dask = "dask"


SpecFile = Annotated[
    Path,
    typer.Argument(
        callback=named, metavar="SPEC.yaml", help="The spec to run; - is standard input.", show_default=False
    ),
]


def _folder(text: str) -> Path:
    """The folder that an option names."""
    if not text.strip():
        raise typer.BadParameter("is empty; must name a folder ('.' is the working folder)")
    return Path(text)


Out = Annotated[
    Path | None,
    typer.Option(
        "--out",
        "-o",
        parser=_folder,
        metavar="DIR",
        help="Where results go.  [default: results/NAME]",
        show_default=False,
    ),
]
Sets = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY.PATH=VALUE", help="Override one value of the spec; repeatable."),
]
Jobs = Annotated[
    int | None,
    typer.Option(
        "--jobs",
        "-j",
        min=1,
        metavar="N",
        help="Processes that do long work.  [default: all cores]",
        show_default=False,
    ),
]
Executor = Annotated[
    ExecutorName, typer.Option("--executor", help="Who does long work: processes here, or a Dask cluster.")
]
Scheduler = Annotated[
    str | None,
    typer.Option(
        "--scheduler", metavar="ADDRESS", help="The address of a Dask cluster: tcp://HOST:PORT, or its JSON file."
    ),
]
Force = Annotated[bool, typer.Option("--force", help="Recompute even where results are up to date.")]
DryRun = Annotated[bool, typer.Option("--dry-run", help="Say what would run, and why; write nothing.")]
Json = Annotated[bool, typer.Option("--json", help="Print the summary as one JSON object instead of a table.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No progress and no messages, only results and errors.")]
Verbose = Annotated[bool, typer.Option("--verbose", "-v", help="Say how the work was done.")]

# Commands whose work a cluster can do; of a pipeline those stages.
SPREAD = (*(stage.name for stage in STAGES.values() if stage.spread), "run")


def unspreadable(kind: str, executor: ExecutorName, scheduler: str | None) -> str:
    """Why the work cannot be spread as asked for; empty if it can."""
    if executor is ExecutorName.local:
        return "--scheduler: needs --executor dask" if scheduler else ""
    if kind not in SPREAD:
        return f"--executor: {kind} is not spread; dask is for {' and '.join(SPREAD)}"
    return "" if scheduler else "--executor dask: needs --scheduler, an address like tcp://HOST:8786"
