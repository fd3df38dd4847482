"""What every stage does with a valid spec: compute or reuse, write, draw, print."""

import json
from pathlib import Path
from typing import Any, Protocol

import pyarrow as pa

from hknob_cli.cli.console import say
from hknob_cli.cli.job import Job
from hknob_cli.results import provenance, store

Tables = tuple[pa.Table, ...]


class Work(Protocol):
    """What differs between stages."""

    def pictures(self, job: Job) -> tuple[str, ...]:
        """Names of the pictures that `draw` may draw."""

    def files(self, job: Job) -> tuple[str, ...]:
        """Names of the result files, one a table."""

    def others(self, job: Job) -> tuple[str, ...]:
        """Names of files that this stage writes for other specs, and that would be stale beside these results."""

    def inputs(self, job: Job) -> dict[str, str]:
        """Digests of what the result depends on beside the spec, by name. Raises `UsageError`."""

    def compute(self, job: Job) -> Tables:
        """Result tables. Raises `ComputationError`."""

    def draw(self, job: Job, tables: Tables, paths: list[Path]) -> list[Path]:
        """Draw the pictures; those drawn, and a message where these results have none."""

    def describe(self, job: Job, tables: Tables) -> dict[str, Any]:
        """Summary as plain data."""

    def text(self, job: Job, summary: dict[str, Any]) -> str:
        """Summary as the table on the terminal."""


def run_stage(job: Job, work: Work) -> None:
    """Run a stage. Raises `RefusedError` or `ComputationError`."""
    name = job.plan.name
    stamp = provenance.describe(
        stage=job.kind, values=job.plan.values, overrides=job.overrides, inputs=work.inputs(job)
    )
    paths = [job.out / file for file in work.files(job)]
    pictures = [job.out / file for file in work.pictures(job)]
    others = [job.out / file for file in work.others(job)]
    ours = [*paths, *pictures, *others]
    store.refuse_foreign(ours, stage=job.kind, name=name)
    current = None if job.force else store.read_current(paths, stamp)
    if job.dry_run:
        _say_plan(job, paths, current=current is not None)
        return
    if current is not None and not job.plot and not store.leftovers(ours):
        tables: Tables = current
        drawn: list[Path] = []
    else:
        with store.hold(job.out, ours):
            # Once more: another run may have been here since.
            store.refuse_foreign(ours, stage=job.kind, name=name)
            tables = current or work.compute(job)
            if current is None:
                store.write(dict(zip(paths, tables, strict=True)), stamp)
                for stale in (*pictures, *others):
                    stale.unlink(missing_ok=True)  # it would show what the files no longer hold
            drawn = work.draw(job, tables, pictures) if job.plot else []
    files = [*paths, *drawn]
    status = "computed" if current is None else "up to date"
    summary = {
        "kind": job.kind,
        "name": name,
        "status": status,
        **work.describe(job, tables),
        "files": [str(path) for path in files],
    }
    if job.as_json:
        print(json.dumps(summary, allow_nan=False))
        return
    print(work.text(job, summary))
    print("\n" + "\n".join(f"wrote {path}" if current is None else str(path) for path in files))


def _say_plan(job: Job, paths: list[Path], *, current: bool) -> None:
    missing = [path.name for path in paths if not path.exists()]
    changed = "the spec or the program has changed since"
    why = "forced" if job.force else f"no {missing[0]} yet" if missing else changed
    if job.as_json:
        plan = {"kind": job.kind, "name": job.plan.name, "status": "up to date" if current else "would run"}
        print(json.dumps({**plan, **({} if current else {"why": why}), "files": [str(path) for path in paths]}))
        return
    if current:
        print(f"nothing would run: {job.out} is up to date")
        return
    print(f"{job.kind} would run, because: {why}; it would write {' and '.join(str(path) for path in paths)}")


def note(job: Job, text: str) -> None:
    """A message, unless they are unwanted."""
    if not job.quiet:
        say(text)
