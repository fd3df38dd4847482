"""``hknob run``: a pipeline of stages, of which only what is out of date runs."""

import json
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hknob_cli.cli.options import (
    DryRun,
    Executor,
    ExecutorName,
    Force,
    Jobs,
    Json,
    Out,
    Quiet,
    Scheduler,
    Sets,
    Verbose,
    unspreadable,
)
from hknob_cli.errors import ComputationError, ExitCode, HknobError, UsageError
from hknob_cli.specs.named_file import named
from hknob_cli.terminal import heed, reporting, say, tell

if TYPE_CHECKING:
    from hknob_cli.cli.run_done import Stage
    from hknob_cli.pipeline.build import Outcome, Step
    from hknob_cli.pipeline.one_claim import OneClaim
    from hknob_cli.specs.stage_plans import PipelinePlan
    from hknob_cli.stages.job import Job
    from hknob_cli.stages.make import Change


def run(
    pipeline: Annotated[
        Path,
        typer.Argument(
            callback=named,
            metavar="PIPELINE.yaml",
            help="The pipeline, or a spec alone; - is standard input.",
            show_default=False,
        ),
    ],
    out: Out = None,
    sets: Sets = None,
    until: Annotated[
        str | None, typer.Option("--until", metavar="STAGE", help="Run this stage and what it needs, nothing else.")
    ] = None,
    claim: Annotated[
        str | None,
        typer.Option(
            "--claim",
            metavar="ID",
            help="Judge one claim of the pipeline's page, and run only what it needs. A place or words will do.",
        ),
    ] = None,
    jobs: Jobs = None,
    executor: Executor = ExecutorName.local,
    scheduler: Scheduler = None,
    force: Force = False,
    dry_run: DryRun = False,
    explain: Annotated[bool, typer.Option("--explain", help="Say what would run, and every reason why.")] = False,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Run a pipeline of stages, skipping all that is up to date."""
    with reporting():
        if why := unspreadable("run", executor, scheduler):
            raise UsageError(why)
        if claim is not None and until is not None:
            raise UsageError("--claim: names the stages to run itself; leave --until out")
        from hknob_cli.cli.run_done import report
        from hknob_cli.pipeline import fresh

        overrides = tuple(sets or ())
        root = out or _root(pipeline, overrides)
        request = fresh.asked(pipeline, root, fresh.options(overrides, until))
        done_with = partial(report, pipeline, root, sets=overrides, until=until, as_json=as_json, quiet=quiet)
        if not (force or dry_run or explain or claim is not None):
            done = fresh.finished(root, request)
            if done is not None:
                done_with(done["name"], done["stages"])
                return
        from hknob_cli.pipeline.build import build
        from hknob_cli.pipeline.side_by_side import SideBySide
        from hknob_cli.pipeline.steps import chosen, jobs_of, steps_of
        from hknob_cli.results import store
        from hknob_cli.specs.load import load_pipeline

        plan = load_pipeline(pipeline, overrides)
        one = _find_claim(plan, root, claim, quiet=quiet) if claim is not None else None
        wanted = one.stages(plan) if one else None if until is None else [until]
        stages = chosen(plan, wanted)
        work = jobs_of(
            stages, root, jobs=jobs, force=force, quiet=quiet, verbose=verbose, unattended=True, scheduler=scheduler
        )
        makers = SideBySide(jobs, partial(_say_of, quiet=quiet, verbose=verbose), spread=scheduler is None)
        steps = steps_of(stages, work, root, makers)
        if dry_run or explain:
            outcomes = build(steps, root, force=force, dry=True)
            changed = _changed(outcomes, work)
            _say_plan(plan.name, outcomes, changed, explain=explain, as_json=as_json)
            return
        with store.hold(root, []), makers:
            outcomes = build(steps, root, force=force)
            heed()
            table = _table_of(steps, work, outcomes)
            done_all = _is_all_done(outcomes)
            if done_all and not one:
                fresh.write_record(root, plan.name, request, _up_to_date(table, root))
        if one and done_all:
            from hknob_cli.cli.run_done import after_pipeline

            step = "" if quiet else after_pipeline(pipeline, root, overrides, plan.name, claim, [])
            _say_verdict(one, plan.name, table, step, as_json=as_json)
        else:
            done_with(plan.name, table)
        _fail(outcomes)


def _root(path: Path, overrides: tuple[str, ...]) -> Path:
    """Where results go if nothing is said."""
    from hknob_cli.specs.load import load_pipeline

    return Path("results") / load_pipeline(path, overrides).name


def _say_of(stage: str, text: str, *, quiet: bool, verbose: bool) -> None:
    """What a stage has to say while it runs; an empty text is its start."""
    if (text or verbose) and not quiet:
        say(f"{stage}: {text or 'started'}")


def _table_of(steps: "list[Step]", work: "dict[str, Job]", outcomes: "list[Outcome]") -> "list[Stage]":
    """What became of each stage, and the files it has."""
    return [
        {
            "name": step.name,
            "kind": work[step.name].kind,
            "status": outcome.fate.value,
            "files": [str(path) for path in step.writes],
        }
        for step, outcome in zip(steps, outcomes, strict=True)
    ]


def _is_all_done(outcomes: "list[Outcome]") -> bool:
    """Whether all stages have their results."""
    from hknob_cli.pipeline.build import Fate

    return all(outcome.fate in (Fate.COMPUTED, Fate.UP_TO_DATE) for outcome in outcomes)


def _up_to_date(table: "list[Stage]", root: Path) -> "list[Stage]":
    """Stages that are done as the next run finds them, with their files from the results' folder."""
    from hknob_cli.pipeline import fresh
    from hknob_cli.pipeline.build import Fate

    return [
        {
            **row,
            "status": Fate.UP_TO_DATE.value,
            "files": [fresh.relative(Path(file), root) for file in row["files"]],
        }
        for row in table
    ]


def _find_claim(plan: "PipelinePlan", root: Path, asked: str, *, quiet: bool) -> "OneClaim":
    """The claim that was asked for; says what it needs."""
    from hknob_cli.pipeline.one_claim import find_claim

    found = find_claim(plan, root, asked)
    if not quiet:
        needs = ", ".join(found.results)
        say(f"{found.claim.id}: {f'needs {needs}' if needs else 'needs no results'}")
    return found


def _say_verdict(one: "OneClaim", name: str, stages: "list[Stage]", step: str, *, as_json: bool) -> None:
    """The verdict of a claim, where its results are, and the next ``step``."""
    row, text = one.judge()
    if as_json:
        print(json.dumps({"kind": "pipeline", "name": name, "stages": stages, "claim": row}))
        return
    lines = [text, "", *(f"results: {one.folders[result]}" for result in one.results)]
    tell("\n".join([*lines, *([f"next: {step}"] if step else [])]))


def _changed(outcomes: "list[Outcome]", work: "dict[str, Job]") -> "dict[str, list[Change]]":
    """By stage that would run, what in its spec and of the program has changed since its results were made."""
    from hknob_cli.pipeline.build import Fate
    from hknob_cli.stages.job import work_of
    from hknob_cli.stages.make import changes_in_spec

    jobs = {one.name: work[one.name] for one in outcomes if one.fate is Fate.WOULD_RUN}
    return {name: changes_in_spec(job, work_of(job.kind)) for name, job in jobs.items()}


def _say_plan(
    name: str, outcomes: "list[Outcome]", changed: "dict[str, list[Change]]", *, explain: bool, as_json: bool
) -> None:
    if as_json:
        stages = [
            {
                "name": one.name,
                "status": one.fate.value,
                "why": list(one.why),
                **({"changed": [change._asdict() for change in changed[one.name]]} if changed.get(one.name) else {}),
            }
            for one in outcomes
        ]
        print(json.dumps({"kind": "pipeline", "name": name, "stages": stages}))
        return
    for one in outcomes:
        if explain and one.why:
            values = [f"    {change}" for change in changed.get(one.name, ())]
            reasons = [f"  {reason}" for reason in one.why]
            tell("\n".join([f"{one.name}: {one.fate.value}, because", *reasons, *values]))
        else:
            more = f" (and {len(one.why) - 1} more reasons; --explain)" if len(one.why) > 1 else ""
            tell(f"{one.name}: {one.fate.value}" + (f", because {one.why[0]}{more}" if one.why else ""))


def _is_of_pytask(error: BaseException | None) -> bool:
    """Whether pytask itself found the fault: a file that a step needs, or should have made, is not there."""
    return type(error).__module__.startswith(("pytask", "_pytask"))


def _fail(outcomes: "list[Outcome]") -> None:
    """Say which stages failed and why, and raise for the first."""
    from hknob_cli.pipeline.build import Fate

    failed = [one for one in outcomes if one.fate is Fate.FAILED]
    for one in failed:
        say(f"{one.name}: failed: {one.error}")
        expected = isinstance(one.error, (HknobError, OSError, MemoryError)) or _is_of_pytask(one.error)
        if one.error is not None and not expected:
            raise one.error
    waiting = [one.name for one in outcomes if one.fate is Fate.NOT_REACHED]
    if waiting:
        say(f"not reached: {', '.join(waiting)}")
    if failed:
        error = failed[0].error
        raise typer.Exit(error.exit_code if isinstance(error, HknobError) else ExitCode.FAILED)
    if waiting:
        raise ComputationError("not all stages were reached")
