"""From the plan of a pipeline to its steps, and what each stage has found."""

import contextlib
import copy
import json
import re
import time
from collections import Counter
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hknob_cli.errors import Fault, HknobError, SpecError, UsageError
from hknob_cli.pipeline.build import Step
from hknob_cli.pipeline.fresh import spec_digest
from hknob_cli.pipeline.side_by_side import SideBySide, Task
from hknob_cli.results.files import refuse_link
from hknob_cli.specs.load import load
from hknob_cli.specs.messages import unknown
from hknob_cli.specs.named_file import as_typed, is_stdin, open_named
from hknob_cli.specs.plan import Plan
from hknob_cli.specs.stage_plans import PipelinePlan, ReportPlan, StagePlan
from hknob_cli.stages.job import Job, work_of
from hknob_cli.stages.make import make
from hknob_cli.stages.work import Work, hand_files

if TYPE_CHECKING:
    from hknob_cli.results.result_set import Result

_MOST = 2  # sentences
_BETWEEN = re.compile(r"(?<=\.) (?=[A-Z])")


def done(stage: str, folder: Path, begin: float) -> str:
    """That a stage was computed, in how long since ``begin`` (s of `time.perf_counter`), and what it has found."""
    took = f"computed in {time.perf_counter() - begin:.2g} s"
    found = found_in(stage, folder)
    return f"{took}. {found}" if found else took


def found_in(stage: str, folder: Path) -> str:
    """The answer of the results in a folder, or its first sentences; empty if there is none.

    Results that cannot be read have none: they are written, and whoever needs them says what is wrong.
    """
    from hknob_cli.page.answers import checked
    from hknob_cli.results.result_set import Result

    result = Result(stage, folder)
    with contextlib.suppress(HknobError):
        if not result.files:
            return ""
        if result.stage == "report":
            return _judged(result)
        answers = checked(result)
        if result.stage == "dfa":
            answers = answers[-1:]  # the exact method, where it was asked for
        return " ".join(_BETWEEN.split(" ".join(answers[:1]))[:_MOST])
    return ""


def _judged(result: "Result") -> str:
    """How many claims of a text have which verdict."""
    from hknob_cli.page.claims.verdict import VERDICTS

    counts = Counter(row["verdict"] for row in result.rows("claims"))
    said = ", ".join(f"{counts[verdict]} {verdict}" for verdict in VERDICTS if counts[verdict])
    return f"Of {sum(counts.values())} claims: {said}."


_MANY = "results"  # of a report: results by name, also where there is one
_RECORDED = "recordings"  # of an identification: begin at the folder of its spec


def chosen(plan: PipelinePlan, wanted: Sequence[str] | None = None) -> list[StagePlan]:
    """The stages to run, each after those it needs; with ``wanted`` only these and what they need.

    Raises `UsageError` for a stage that is not in the pipeline.
    """
    for name in wanted or ():
        if name not in plan.stages:
            raise UsageError(f"--until: {unknown('stage', name, list(plan.stages))}")
    order: dict[str, StagePlan] = {}

    def add(name: str) -> None:
        if name not in order:
            for needed in plan.stages[name].needs:
                add(needed)
            order[name] = plan.stages[name]

    for name in plan.stages if wanted is None else wanted:
        add(name)
    return list(order.values())


def jobs_of(stages: list[StagePlan], root: Path, **options: Any) -> dict[str, Job]:
    """A job for each stage that has a spec, its results in a folder of its name in ``root``.

    ``options`` are those of a `Job`. Raises `SpecError` with the faults of all specs, `RefusedError`
    where such a folder is a link.
    """
    folders = {stage.name: stage.folder or root / stage.name for stage in stages}
    jobs: dict[str, Job] = {}
    faults: list[Fault] = []
    for stage in stages:
        if stage.folder is not None:
            try:
                found = any(stage.folder.glob("*.parquet"))
            except OSError as error:  # a name that is too long
                faults.append(Fault(stage.where, 0, 0, "", f"{stage.folder}: {error.strerror or error}"))
                continue
            if not found:
                faults.append(Fault(stage.where, 0, 0, "", f"no results in {stage.folder}"))
            continue
        refuse_link(folders[stage.name])
        try:
            jobs[stage.name] = _job(stage, folders, _made_here(stages, folders), **options)
        except SpecError as error:
            faults += error.faults
        except UsageError as error:
            faults.append(Fault(stage.where, 0, 0, "", str(error)))
    if faults:
        raise SpecError(faults)
    return jobs


def steps_of(stages: list[StagePlan], jobs: dict[str, Job], root: Path, makers: SideBySide) -> list[Step]:
    """A step for each stage that has a spec, in order, made by ``makers``, which are told of each.

    ``root`` is the folder of the pipeline's results.
    """
    steps: list[Step] = []
    files: dict[str, tuple[Path, ...]] = {}
    folders = {stage.name: stage.folder or root / stage.name for stage in stages}
    for stage in stages:
        if stage.folder is not None:
            files[stage.name] = (stage.folder,)
            continue
        steps.append(_step(stage, jobs[stage.name], folders, files, makers, root=root))
        files[stage.name] = steps[-1].writes
    return steps


def _made_here(stages: list[StagePlan], places: dict[str, Path]) -> frozenset[str]:
    """Folders that the pipeline fills: what a hand from them is, is known when their stages have run."""
    return frozenset(_as_hand(places[stage.name]) for stage in stages if stage.folder is None)


def _as_hand(folder: Path) -> str:
    """A folder as hands and recordings name it, for which a spec's own folder is where paths begin."""
    return str(folder.absolute())


def _is_hand(path: str) -> bool:
    """Whether a path in a spec says where a hand, or a population of them, is from."""
    return path.endswith(("hand.from", "population.from", "people.from"))


def plan_of(stage: StagePlan, places: dict[str, Path], waiting: frozenset[str]) -> Plan:
    """The stage's spec, its inputs the folders of other stages; ``waiting``: those whose results are yet to be made."""
    folders: dict[str, Any] = {
        path: {
            name: _as_hand(places[name]) if path == _RECORDED else str(places[name])
            for name in ([found] if isinstance(found, str) else found)
        }
        if path == _MANY or not isinstance(found, str)
        else _as_hand(places[found])
        if _is_hand(path)
        else str(places[found])
        for path, found in stage.inputs.items()
    }
    linked = tuple(f"{path}={json.dumps(value)}" for path, value in folders.items())
    assert stage.spec is not None
    with contextlib.nullcontext() if is_stdin(stage.spec) else open_named(stage.spec):
        plan = load(stage.spec, (*stage.settings, *linked), label=f"{stage.where}: set ", waiting=waiting)
    if isinstance(plan, ReportPlan) and "rerun" not in plan.values:
        plan = plan._replace(rerun=(f"hknob run {as_typed(Path(stage.where.split(':')[0]).name)}",))
    return plan._replace(values=_replaced(plan.values, _names(stage)))


def _names(stage: StagePlan) -> dict[str, dict[str, Any]]:
    """Inputs by path as results name them: which stage an input is from, not where it happens to lie."""
    return {path: {"from": found if isinstance(found, str) else list(found)} for path, found in stage.inputs.items()}


def _job(stage: StagePlan, places: dict[str, Path], waiting: frozenset[str], **options: Any) -> Job:
    """The stage as it would be asked for on the command line, its inputs the folders of other stages."""
    plan = plan_of(stage, places, waiting)
    linked = tuple(f"{path}={json.dumps(name)}" for path, name in _names(stage).items())
    return Job(
        kind=str(plan.values["kind"]),
        plan=plan,
        out=places[stage.name],
        overrides=(*stage.settings, *linked),
        **options,
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


def _step(
    stage: StagePlan,
    job: Job,
    folders: dict[str, Path],
    files: dict[str, tuple[Path, ...]],
    makers: SideBySide,
    *,
    root: Path,
) -> Step:
    work: Work = work_of(job.kind)
    linked = {root / name for name in stage.needs}
    writes = tuple(job.out / file for file in (*work.files(job), *work.texts(job), *work.folders(job)))

    def run(jobs: int | None) -> tuple[bool, str]:
        begin = time.perf_counter()
        now = job._replace(plan=plan_of(stage, folders, frozenset())) if any(map(_is_hand, stage.inputs)) else job
        computed = make(now._replace(jobs=jobs), work).computed
        return computed, "as it was" if job.quiet or not computed else done(stage.name, job.out, begin)

    makers.tasks[stage.name] = Task(
        needs=frozenset(stage.needs) & makers.tasks.keys(),  # others are given
        run=run,
        missing=lambda: job.force or not all(path.exists() for path in writes),
        alone=work.is_alone(job),
    )
    needs = tuple(path for name in stage.needs for path in files[name])
    stages = {path.absolute() for path in needs}
    measured = [file for file in hand_files(job.plan) if file.absolute() not in stages]
    return Step(
        stage.name,
        reads=(
            *((stage.spec,) if stage.spec and not is_stdin(stage.spec) else ()),
            *(path for path in work.input_files(job) if path not in linked),
            *measured,
        ),
        needs=needs,
        writes=writes,
        values={
            **({"spec": spec_digest(stage.spec)} if stage.spec and is_stdin(stage.spec) else {}),
            "settings": json.dumps(job.overrides),
            "program": json.dumps({**work.versions(job), **work.surroundings()}, sort_keys=True),
        },
        root=root,
        run=partial(makers.make, stage.name),
    )
