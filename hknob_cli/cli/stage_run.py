"""Run a stage, and say what it found or would do."""

import json
from typing import Any

from hknob_cli.cli.run_done import after_stage
from hknob_cli.report.table import folded
from hknob_cli.stages.job import Job, work_of
from hknob_cli.stages.make import State, as_data, as_written, in_a_line, make, state_of, warn
from hknob_cli.stages.work import Work
from hknob_cli.terminal import tell


def run_stage(job: Job) -> None:
    """Run a stage; print what it found on stdout. Raises `RefusedError` or `ComputationError`."""
    work: Work = work_of(job.kind)
    if job.dry_run:
        warn(job)
        _say_plan(job, work, state_of(job, work))
        return
    tables, files, computed, changed = make(job, work)
    with as_written(job, computed=computed):
        summary = {
            "kind": job.kind,
            "name": job.plan.name,
            "status": "computed" if computed else "up to date",
            **({"changed": as_data(changed)} if computed and changed else {}),
            **work.describe(job, tables),
            "files": [str(path) for path in files],
        }
        text = json.dumps(summary, allow_nan=False) if job.as_json else work.text(job, summary)
    if job.as_json:
        print(text)
        return
    tell(folded(text))
    tell("\n" + "\n".join(f"wrote {path}" if computed else str(path) for path in files))
    if not job.quiet and (step := after_stage(job, work, summary)):
        tell(f"\nnext: {step}")


def _say_plan(job: Job, work: Work, state: State) -> None:
    paths, current = state.paths, state.current is not None
    missing = [path.name for path in paths if not path.exists()]
    changed = f"the spec or the program has changed since: {in_a_line(state.changed)}".removesuffix(": ")
    damaged = [f"{path} is not as it was written" for path in state.damaged]
    why = "forced" if job.force else f"no {missing[0]} yet" if missing else ", ".join(damaged) or changed
    there = work.finished(job) if not current and work.partial_results(job) else ""
    if job.as_json:
        reasons: dict[str, Any] = {"why": why, **({"finished": there} if there else {})}
        reasons |= {"changed": as_data(state.changed)} if state.changed else {}
        plan = {"kind": job.kind, "name": job.plan.name, "status": "up to date" if current else "would run"}
        print(json.dumps({**plan, **({} if current else reasons), "files": [str(path) for path in paths]}))
        return
    if current:
        tell(f"nothing would run: {job.out} is up to date")
        return
    on = f"; it would go on from {there}" if there else ""
    tell(f"{job.kind} would run, because: {why}{on}; it would write {' and '.join(str(path) for path in paths)}")
