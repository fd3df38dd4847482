"""``hknob check``: validate specs, compute nothing."""

from math import prod
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hknob_cli.cli.console import reporting, say, tell
from hknob_cli.cli.job import Job
from hknob_cli.cli.options import Quiet, Sets
from hknob_cli.errors import ExitCode, UsageError

if TYPE_CHECKING:
    from hknob_cli.specs.plan import Plan


def _size(plan: "Plan") -> str:
    """How much there is to do."""
    from hknob_cli.specs.campaign import HwRunPlan
    from hknob_cli.specs.cells import cells_of
    from hknob_cli.specs.design_plan import DesignPlan
    from hknob_cli.specs.identification import SysidPlan
    from hknob_cli.specs.page_plan import ReportPlan
    from hknob_cli.specs.plan import BenchPlan
    from hknob_cli.specs.remedies_plan import RemediesPlan

    if isinstance(plan, BenchPlan):
        return _counted(len(plan.scenes), "scene")
    if isinstance(plan, SysidPlan):
        return "study" if plan.study else plan.what.replace("_", " ")
    if isinstance(plan, ReportPlan):
        return _counted(len(plan.results), "result")
    if isinstance(plan, HwRunPlan):
        return _counted(prod(len(values) for values in plan.axes.values()) * plan.repeats, "trial")
    if isinstance(plan, RemediesPlan):
        return _counted(len(plan.remedies), "remedy", "remedies")
    if isinstance(plan, DesignPlan):
        return _counted(plan.size, "design")
    return _counted(len(cells_of(plan)), "cell")


def _counted(count: int, what: str, many: str = "") -> str:
    return f"{count} {what if count == 1 else many or what + 's'}"


def _checked(path: Path, sets: tuple[str, ...], *, quiet: bool) -> str:
    """What a valid spec says, in a few words. Raises `UsageError`."""
    from hknob_cli.cli.job import work_of
    from hknob_cli.specs.kinds import PIPELINE
    from hknob_cli.specs.load import is_ledger, kind_of, load, load_pipeline
    from hknob_cli.specs.plan import SweepPlan
    from hknob_cli.specs.promise import not_proven

    kind = kind_of(path)
    if kind == PIPELINE:
        from hknob_cli.cli.pipeline_steps import chosen, jobs_of

        pipeline = load_pipeline(path, sets)
        for job in jobs_of(chosen(pipeline, None), Path("results") / pipeline.name, quiet=quiet).values():
            work_of(job.kind).verify(job)
            _warn(path, job)
        return f"pipeline '{pipeline.name}', {_counted(len(pipeline.stages), 'stage')}"
    if kind is None and is_ledger(path):
        from hknob_cli.page.claims.ledger import load_ledger

        return f"ledger, {_counted(len(load_ledger(path).claims), 'claim')}"
    plan = load(path, sets)
    kind = str(plan.values["kind"])  # as set on the command line, where it is
    job = Job(kind=kind, plan=plan, out=Path("results") / plan.name, quiet=quiet)
    work_of(kind).verify(job)
    _warn(path, job)
    if isinstance(plan, SweepPlan) and not quiet:
        for text in not_proven(plan):
            say(f"{path}: {text}")
    return f"{kind} '{plan.name}', {_size(plan)}"


def _warn(path: Path, job: Job) -> None:
    from hknob_cli.specs.usual import unusual

    for text in unusual(job.plan) if not job.quiet else ():
        say(f"{path}: {text}")


def check(
    specs: Annotated[list[Path], typer.Argument(metavar="SPEC.yaml...", help="Specs to validate.", show_default=False)],
    sets: Sets = None,
    quiet: Quiet = False,
) -> None:
    """Validate specs only: one line per fault, FILE:LINE:COL first."""
    failed = False
    with reporting():
        for path in specs:
            try:
                found = _checked(path, tuple(sets or ()), quiet=quiet)
            except UsageError as error:
                say(str(error))
                failed = True
                continue
            tell(f"{path}: {found}: good")
    if failed:
        raise typer.Exit(ExitCode.USAGE)
