"""A stage as asked for on the command line: small enough to hand from one process to another."""

from pathlib import Path
from typing import Any, NamedTuple

from hknob_cli.stage_table import STAGES, loaded


def work_of(kind: str) -> Any:
    """The `stage_run.Work` of a kind; loads it."""
    return loaded(STAGES[kind].work)


class Job(NamedTuple):
    """One stage to run: its kind, plan, and the options every stage takes."""

    kind: str
    plan: Any  # the kind's plan, of `Plan`
    out: Path
    overrides: tuple[str, ...] = ()
    plot: bool = False
    jobs: int | None = None
    force: bool = False
    dry_run: bool = False
    as_json: bool = False
    quiet: bool = False
    verbose: bool = False
    unattended: bool = False  # nobody is there to press keys
    scheduler: str | None = None  # of a Dask cluster that does the work
    spec: str = ""  # the file as it was named on the command line, where it was
