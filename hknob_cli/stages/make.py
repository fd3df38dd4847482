"""Results of a stage: computed, task by task where a run was cut short, or as they are; written, and drawn.

What a run of tasks has found so far is kept, so that the next run goes on from there. It is written once a second, and
when the run is cut short: a run of less than that writes nothing. Where results are made again, what has changed of
spec, inputs and program is told by key: old and new.
"""

import contextlib
import json
import time
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pyarrow as pa

from hknob_cli.errors import MISSHAPEN, ComputationError, unwritable
from hknob_cli.results import provenance, store
from hknob_cli.results.files import Staging, clear_staged, make_folder, staged
from hknob_cli.results.parted import result_schema
from hknob_cli.results.provenance import mark, record_of
from hknob_cli.results.store import refuse_mixed
from hknob_cli.specs.remarks import unusual
from hknob_cli.stages.job import Job
from hknob_cli.stages.work import PerceivingWork, Tables, Work, hand_inputs, hand_notes, note, preset_inputs

ABSENT = "not given"
_MOST = 6  # changes that are said in one line
_LONGEST = 60  # characters of a value
_DIGEST = "_sha256"


class Change(NamedTuple):
    """A key of the spec, an input or a version; its old and its new value as text, empty where these are digests."""

    key: str
    old: str
    new: str

    def __str__(self) -> str:
        return f"{self.key} {self.old} -> {self.new}" if self.old else f"{self.key} has changed"


def record_at(path: Path) -> dict[str, Any] | None:
    """What the result at ``path`` says of where it comes from; None if there is none that says so."""
    try:
        return record_of(result_schema(path).metadata)
    except (OSError, pa.ArrowException):
        return None


def changes(
    old: dict[str, Any], spec: dict[str, Any], versions: dict[str, str], inputs: dict[str, str] | None = None
) -> list[Change]:
    """What has changed since the record ``old``: of the spec, of ``inputs`` if given, of ``versions``."""
    found = _differences(_flat(old["spec"]), _flat(spec))
    if inputs is not None:
        found += [
            Change(_named(one.key), "", "") if one.key.endswith(_DIGEST) else one
            for one in _differences(old["inputs"], inputs)
            if one.key != "spec_sha256"
        ]
    before = old.get("versions")
    for one in _differences(before if isinstance(before, dict) else {}, versions):
        found.append(Change("the program", "", "") if one.key.startswith("hknob_") else one)
    return list(dict.fromkeys(found))


def in_a_line(found: Iterable[Change]) -> str:
    """The changes, the first of many."""
    texts = [str(one) for one in found]
    more = [f"and {len(texts) - _MOST} more"] if len(texts) > _MOST else []
    return ", ".join([*texts[:_MOST], *more])


def as_data(found: Iterable[Change]) -> list[dict[str, str]]:
    """The changes as plain data."""
    return [one._asdict() for one in found]


def _named(key: str) -> str:
    return key.removesuffix(_DIGEST).replace("_", " ")


def _flat(values: Any, path: str = "") -> dict[str, Any]:
    """Values of nested mappings by dotted path; a list is one value."""
    if not isinstance(values, dict) or not values:
        return {path: values}
    found: dict[str, Any] = {}
    for key, value in values.items():
        found |= _flat(value, f"{path}.{key}" if path else str(key))
    return found


def _differences(old: dict[str, Any], new: dict[str, Any]) -> list[Change]:
    keys = [*new, *(key for key in old if key not in new)]
    return [
        Change(key, _shown(old, key), _shown(new, key))
        for key in keys
        if (key in old) != (key in new) or old[key] != new[key]
    ]


def _shown(values: dict[str, Any], key: str) -> str:
    if key not in values:
        return ABSENT
    value = values[key]
    text = value if isinstance(value, str) else json.dumps(value)
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 3]}..."


class Made(NamedTuple):
    """Results of a stage: tables, files, whether they were computed, and what had changed since those they replace."""

    tables: Tables
    files: list[Path]
    computed: bool
    changed: list[Change]


def make(job: Job, work: Work) -> Made:
    """Results of a stage, computed or as they are. Raises `RefusedError` or `ComputationError`."""
    stamp, paths, current, changed, damaged = state_of(job, work)
    name = job.plan.name
    for path in damaged:
        note(job, f"{path}: is not as it was written: damaged, or changed; it is made again")
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
        with as_written(job, computed=current is None):
            drawn = _draw(job, work, tables, pictures) if job.plot else []
    return Made(tables, [*paths, *drawn], computed=current is None, changed=changed)


def _draw(job: Job, work: Work, tables: Tables, pictures: list[Path]) -> list[Path]:
    from hknob_cli.figures.theme import library_defaults

    with library_defaults():
        return work.draw(job, tables, pictures)


def stamp_of(job: Job, work: Work) -> bytes:
    """Provenance of a stage's results."""
    return provenance.describe(
        stage=job.kind,
        values=job.plan.values,
        overrides=job.overrides,
        inputs={**preset_inputs(job.plan), **hand_inputs(job.plan), **work.inputs(job)},
        versions=work.versions(job),
    )


class State(NamedTuple):
    """Provenance of a stage's results, their files, the tables if they are current, else what has changed.

    ``damaged``: files that are not as they were written.
    """

    stamp: bytes
    paths: list[Path]
    current: Tables | None
    changed: list[Change]
    damaged: list[Path]


def state_of(job: Job, work: Work) -> State:
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
    damaged = store.changed_files([*tables, *texts]) if current is None else []
    return State(stamp, [*tables, *texts], current, changed, damaged)


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


@contextlib.contextmanager
def as_written(job: Job, *, computed: bool) -> Iterator[None]:
    """What fails with an earlier run's tables: they are not as it wrote them. Raises `ComputationError`."""
    try:
        yield
    except MISSHAPEN as error:
        if computed:
            raise
        text = f"{job.out}: its tables are not as {job.kind} writes them: {error}; run again with --force"
        raise ComputationError(text) from error


def warn(job: Job) -> None:
    """Say which quantities of a spec are far from usual, unless messages are unwanted."""
    for text in unusual(job.plan):
        note(job, f"{job.plan.name}: {text}")


EVERY_S = 1.0  # between two times that it is written


class Kept:
    """What tasks have found, by the number of the task: plain data, as JSON has it. Raises `OSError`."""

    def __init__(self, staging: Staging, *, afresh: bool) -> None:
        """Of an earlier run, too, unless ``afresh``."""
        self._staging = staging
        self._afresh = afresh
        self._begun = False
        self._waiting: dict[int, bytes] = {}
        self._written = time.monotonic()
        self._there = {} if afresh else dict(_earlier(staging))

    def get(self, number: int) -> Any:
        """What a task has found; None where it is not done."""
        return self._there.get(number)

    def put(self, number: int, found: Any) -> None:
        """Keep what a task has found; not what JSON would not give back as it is."""
        text = json.dumps(found, default=str)
        if repr(json.loads(text)) == repr(found):
            self._waiting[number] = text.encode()
        if time.monotonic() - self._written > EVERY_S:
            self.write()

    def write(self) -> None:
        """Write what has been found since the last time."""
        if self._waiting and not self._begun:
            self._staging.begin(afresh=self._afresh)
            self._begun = True
        for number, text in self._waiting.items():
            self._staging.put(number, number + 1, text)
        self._waiting.clear()
        self._written = time.monotonic()


def _earlier(staging: Staging) -> Iterator[tuple[int, Any]]:
    if staging.folder in staged(staging.folder.parent):
        for start, stop in staging.pieces():
            with contextlib.suppress(ValueError):
                yield start, json.loads(staging.get(start, stop))


@contextlib.contextmanager
def keeping(job: Job, work: Work) -> Iterator[Kept]:
    """What the tasks of a job find is kept if it is cut short. Raises `ComputationError` where it cannot be written."""
    staging = Staging(job.out, stamp_of(job, work), kind=job.kind)
    try:
        kept = Kept(staging, afresh=job.force)
        try:
            yield kept
        except BaseException:
            kept.write()
            raise
    except OSError as error:
        raise unwritable(job.out, error, kept=True) from None


class KeepingWork(PerceivingWork):
    """Work whose finished tasks are kept."""

    def partial_results(self, job: Job) -> list[Path]:
        """Finished tasks."""
        return staged(job.out)

    def finished(self, job: Job) -> str:
        """How many tasks."""
        staging = Staging(job.out, stamp_of(job, self), kind=job.kind)
        there = 0 if job.force else len(staging.names())
        return f"{there} finished tasks" if there else ""

    def clear_partial(self, job: Job) -> None:
        """Remove what was kept of them, and of those of another spec."""
        clear_staged(job.out)
