"""From the plan of a pipeline to its steps: each stage's spec loaded and checked, its files known, ready to run."""

import copy
import json
import time
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

from hknob_cli.cli.job import WORK, Job
from hknob_cli.cli.stage_run import Work, make
from hknob_cli.errors import Fault, SpecError, UsageError
from hknob_cli.pipeline.step import Step
from hknob_cli.spec.load import load
from hknob_cli.spec.plan import PipelinePlan, StagePlan

Said = Callable[[str, str], None]


def chosen(plan: PipelinePlan, until: str | None) -> list[StagePlan]:
    """The stages to run, each after those it needs; with ``until`` only that one and what it needs.

    Raises `UsageError` for a stage that is not in the pipeline.
    """
    if until is not None and until not in plan.stages:
        raise UsageError(f"--until: must be a stage of '{plan.name}': {', '.join(plan.stages)}; got '{until}'")
    order: dict[str, StagePlan] = {}

    def add(name: str) -> None:
        if name not in order:
            for needed in plan.stages[name].needs:
                add(needed)
            order[name] = plan.stages[name]

    for name in [until] if until is not None else plan.stages:
        add(name)
    return list(order.values())


def jobs_of(stages: list[StagePlan], root: Path, **options: Any) -> dict[str, Job]:
    """A job for each stage, its results in a folder of its name in ``root``; ``options`` are those of a `Job`.

    Raises `SpecError` with the faults of all specs.
    """
    jobs: dict[str, Job] = {}
    faults: list[Fault] = []
    for stage in stages:
        try:
            jobs[stage.name] = _job(stage, root, **options)
        except SpecError as error:
            faults += error.faults
        except UsageError as error:
            faults.append(Fault(stage.where, 0, 0, "", str(error)))
    if faults:
        raise SpecError(faults)
    return jobs


def steps_of(stages: list[StagePlan], jobs: dict[str, Job], said: Said) -> list[Step]:
    """A step for each stage, in order; ``said`` is told of a stage and what became of it."""
    steps: dict[str, Step] = {}
    for stage in stages:
        steps[stage.name] = _step(stage, jobs[stage.name], steps, said)
    return list(steps.values())


def _job(stage: StagePlan, root: Path, **options: Any) -> Job:
    """The stage as it would be asked for on the command line, its inputs the folders of other stages."""
    folders: dict[str, Any] = {
        path: str(root / found) if isinstance(found, str) else {name: str(root / name) for name in found}
        for path, found in stage.inputs.items()
    }
    linked = tuple(f"{path}={json.dumps(value)}" for path, value in folders.items())
    plan = load(stage.spec, (*stage.settings, *linked), label=f"{stage.where}: set ")
    if linked:
        # Results say which stage an input is from, not where it happens to lie.
        names = {
            path: {"from": found if isinstance(found, str) else list(found)} for path, found in stage.inputs.items()
        }
        plan = plan._replace(values=_replaced(plan.values, names))
        linked = tuple(f"{path}={json.dumps(name)}" for path, name in names.items())
    return Job(
        kind=str(plan.values["kind"]), plan=plan, out=root / stage.name, overrides=(*stage.settings, *linked), **options
    )


def _replaced(values: dict[str, Any], links: dict[str, Any]) -> dict[str, Any]:
    values = copy.deepcopy(values)
    for path, value in links.items():
        *parents, last = path.split(".")
        target = values
        for part in parents:
            target = target[part]
        target[last] = value
    return values


def _step(stage: StagePlan, job: Job, before: dict[str, Step], said: Said) -> Step:
    work: Work = import_module(WORK[job.kind]).WORK

    def run() -> None:
        begin = time.perf_counter()
        said(stage.name, "")
        _, _, computed = make(job, work)
        said(stage.name, f"computed in {time.perf_counter() - begin:.1f} s" if computed else "as it was")

    return Step(
        stage.name,
        reads=(stage.spec, *work.reads(job)),
        needs=tuple(path for name in stage.needs for path in before[name].writes),
        writes=tuple(job.out / file for file in (*work.files(job), *work.texts(job))),
        values={"settings": json.dumps(job.overrides), "program": json.dumps(work.versions(), sort_keys=True)},
        run=run,
    )
