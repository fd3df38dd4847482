"""What every stage does with a valid spec: compute or reuse, write, draw, print."""

import contextlib
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from hknob_cli.cli.console import say, tell
from hknob_cli.cli.hand_origin import hand_inputs, hand_notes
from hknob_cli.cli.job import Job
from hknob_cli.errors import MISSHAPEN, ComputationError
from hknob_cli.report.table import folded
from hknob_cli.results import provenance, store
from hknob_cli.results.changes import Change, as_data, changes, in_a_line, record_at
from hknob_cli.results.folder import refuse_mixed
from hknob_cli.results.marked import mark
from hknob_cli.results.place import make_folder
from hknob_cli.results.versions import grid_versions
from hknob_cli.specs.usual import unusual

Tables = tuple[Any, ...]  # of pa.Table, or results.parted.Parted


def counted(count: int, what: str, many: str = "") -> str:
    """A number of things, as ``1 cell`` or ``2 cells``; ``many`` is another plural than with s."""
    return f"{count} {what if count == 1 else many or what + 's'}"


class Work:
    """What differs between stages. This is the base: a stage that has nothing but tables."""

    def verify(self, job: Job) -> None:
        """Look for what only the stage can tell is wrong with a plan. Raises `UsageError`."""

    def size(self, plan: Any) -> str:
        """How much there is to do, in a few words: here the cells of a grid."""
        from hknob_cli.specs.cells import cells_of

        return counted(len(cells_of(plan)), "cell")

    def files(self, job: Job) -> tuple[str, ...]:
        """Names of the result files, one a table."""
        raise NotImplementedError

    def texts(self, _job: Job) -> tuple[str, ...]:
        """Names of the pages and drawings that belong to the results."""
        return ()

    def pictures(self, _job: Job) -> tuple[str, ...]:
        """Names of the pictures that `draw` may draw."""
        return ()

    def stale_outputs(self, _job: Job) -> tuple[str, ...]:
        """Names of files that this stage writes for other specs, and that would be stale beside these results."""
        return ()

    def input_files(self, job: Job) -> tuple[Path, ...]:
        """Files, and folders of results, that the result depends on beside the spec."""
        return provenance.tables_of(job.plan.values)

    def surroundings(self) -> dict[str, str]:
        """What of this machine the result depends on beside `versions`, by name."""
        return {}

    def inputs(self, _job: Job) -> dict[str, str]:
        """Digests of what the result depends on beside the spec, by name. Raises `UsageError`."""
        return {}

    def versions(self, job: Job) -> dict[str, str]:
        """Versions that the result depends on."""
        return grid_versions(getattr(job.plan, "points", None))

    def refuse(self, job: Job) -> None:
        """Raise `RefusedError` where what is there must not be replaced by this job."""

    def compute(self, job: Job) -> Tables:
        """Result tables. Raises `ComputationError`."""
        raise NotImplementedError

    def partial_results(self, _job: Job) -> list[Path]:
        """What is there of that which is needed only until the results are in place."""
        return []

    def finished(self, _job: Job) -> str:
        """What an earlier run that was cut short has finished, from which the next goes on; empty if there is none."""
        return ""

    def clear_partial(self, job: Job) -> None:
        """Clear it away."""

    def folders(self, _job: Job) -> tuple[str, ...]:
        """Names of folders in which `compose` writes more than `texts`."""
        return ()

    def is_whole(self, _job: Job, _mark: str) -> bool:
        """Whether all is there that `compose` writes beside `texts`; those have this mark."""
        return True

    def compose(self, _job: Job, _tables: Tables, _stamp: bytes) -> dict[str, str]:
        """The texts by name; ``_stamp`` is the provenance of the results."""
        return {}

    def draw(self, _job: Job, _tables: Tables, _paths: list[Path]) -> list[Path]:
        """Draw the pictures; those drawn, and a message where these results have none."""
        return []

    def describe(self, job: Job, tables: Tables) -> dict[str, Any]:
        """Summary as plain data."""
        raise NotImplementedError

    def text(self, job: Job, summary: dict[str, Any]) -> str:
        """Summary as the table on the terminal."""
        raise NotImplementedError


def run_stage(job: Job, work: Work) -> None:
    """Run a stage and say what it found. Raises `RefusedError` or `ComputationError`."""
    if job.dry_run:
        warn(job)
        _say_plan(job, work, _state(job, work))
        return
    tables, files, computed, changed = make(job, work)
    with _as_written(job, computed=computed):
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


@contextlib.contextmanager
def _as_written(job: Job, *, computed: bool) -> Iterator[None]:
    """What fails with an earlier run's tables: they are not as it wrote them. Raises `ComputationError`."""
    try:
        yield
    except MISSHAPEN as error:
        if computed:
            raise
        text = f"{job.out}: its tables are not as {job.kind} writes them: {error}; run again with --force"
        raise ComputationError(text) from error


class Made(NamedTuple):
    """Results of a stage: tables, files, whether they were computed, and what had changed since those they replace."""

    tables: Tables
    files: list[Path]
    computed: bool
    changed: list[Change]


def make(job: Job, work: Work) -> Made:
    """Results of a stage, computed or as they are. Raises `RefusedError` or `ComputationError`."""
    stamp, paths, current, changed = _state(job, work)
    name = job.plan.name
    if changed:
        note(job, f"{job.out}: these results are replaced; changed since: {in_a_line(changed)}")
    warn(job)
    for text in hand_notes(job.plan):
        note(job, text)
    pictures = [job.out / file for file in work.pictures(job)]
    ours = [*paths, *pictures, *(job.out / file for file in work.stale_outputs(job))]
    if current is not None and not job.plot and not store.leftovers(ours) and not work.partial_results(job):
        return Made(current, paths, computed=False, changed=changed)
    with store.hold(job.out, ours):
        # Once more: another run may have been here since.
        store.refuse_foreign(ours, stage=job.kind, name=name)
        refuse_mixed(job.out, stage=job.kind, name=name)
        tables = work.compute(job) if current is None else current
        if current is None:
            composed = {job.out / file: text for file, text in work.compose(job, tables, stamp).items()}
            for folder in work.folders(job):
                make_folder(job.out / folder)
            for stale in set(ours[len(paths) :]) - set(composed):
                stale.unlink(missing_ok=True)  # it would show what the files no longer hold
            tables = store.write(dict(zip(paths, tables, strict=False)), stamp, composed)
        if current is None or work.partial_results(job):  # a run may have been killed just before it cleared up
            work.clear_partial(job)
        with _as_written(job, computed=current is None):
            drawn = work.draw(job, tables, pictures) if job.plot else []
    return Made(tables, [*paths, *drawn], computed=current is None, changed=changed)


def stamp_of(job: Job, work: Work) -> bytes:
    """Provenance of a stage's results."""
    return provenance.describe(
        stage=job.kind,
        values=job.plan.values,
        overrides=job.overrides,
        inputs={**hand_inputs(job.plan), **work.inputs(job)},
        versions=work.versions(job),
    )


class _State(NamedTuple):
    """Provenance of a stage's results, their files, the tables if they are current, else what has changed."""

    stamp: bytes
    paths: list[Path]
    current: Tables | None
    changed: list[Change]


def _state(job: Job, work: Work) -> _State:
    """What is there of a stage's results.

    Raises `RefusedError` where a file in the way is not ours, or the folder has results of another kind or name.
    """
    work.verify(job)
    stamp = stamp_of(job, work)
    tables = [job.out / file for file in work.files(job)]
    texts = [job.out / file for file in work.texts(job)]
    for_others = [job.out / file for file in (*work.pictures(job), *work.stale_outputs(job))]
    store.refuse_foreign([*tables, *texts, *for_others], stage=job.kind, name=job.plan.name)
    refuse_mixed(job.out, stage=job.kind, name=job.plan.name)
    work.refuse(job)
    current = None if job.force else store.read_current(tables, stamp)
    ours = mark(job.kind, job.plan.name, stamp)
    if current is not None and not (store.are_current(texts, ours) and work.is_whole(job, ours)):
        current = None
    changed = _changes(tables, stamp) if current is None else []
    return _State(stamp, [*tables, *texts], current, changed)


def changes_in_spec(job: Job, work: Work) -> list[Change]:
    """What in a job's spec and of the program has changed since its results were made; none where there are none."""
    there = _record([job.out / file for file in work.files(job)])
    return changes(there, job.plan.values, work.versions(job)) if there else []


def _changes(tables: list[Path], stamp: bytes) -> list[Change]:
    """What has changed since the results that are there."""
    there = _record(tables)
    new = json.loads(stamp)
    return changes(there, new["spec"], new["versions"], new["inputs"]) if there else []


def _record(tables: list[Path]) -> dict[str, Any] | None:
    return next(filter(None, map(record_at, tables)), None)


def _say_plan(job: Job, work: Work, state: _State) -> None:
    paths, current = state.paths, state.current is not None
    missing = [path.name for path in paths if not path.exists()]
    changed = f"the spec or the program has changed since: {in_a_line(state.changed)}".removesuffix(": ")
    why = "forced" if job.force else f"no {missing[0]} yet" if missing else changed
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


def note(job: Job, text: str) -> None:
    """A message, unless they are unwanted."""
    if not job.quiet:
        say(text)


def warn(job: Job) -> None:
    """Say which quantities of a spec are far from usual, unless messages are unwanted."""
    for text in unusual(job.plan):
        note(job, f"{job.plan.name}: {text}")


def compare_scenes(job: Job) -> None:
    """Say what a sweep that a job is compared with has different. Raises `UsageError`."""
    from hknob_cli.stages.compare import scene_differences

    if found := scene_differences(job.plan.against, job.plan.scene, job.plan.axes):
        note(job, f"{job.plan.name}: the sweep in {job.plan.against} is of another scene: {'; '.join(found)}")


def overlap_of(job: Job) -> dict[str, Any]:
    """How many cells of a job the sweep has that it is compared with, for its summary. Raises `UsageError`."""
    if not job.plan.against:
        return {}
    from hknob_cli.specs.cells import cells_of
    from hknob_cli.stages.compare import overlap

    return {"overlap": overlap(job.plan.against, job.plan.axes, cells_of(job.plan))}
