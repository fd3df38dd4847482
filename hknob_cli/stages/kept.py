"""What a run of tasks has found so far, kept so that the next run goes on from there, task by task.

It is written once a second, and when the run is cut short: a run of less than that writes nothing.
"""

import contextlib
import json
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from hknob_cli.errors import unwritable
from hknob_cli.results.staging import Staging, clear_staged, staged
from hknob_cli.stages.job import Job
from hknob_cli.stages.make import stamp_of
from hknob_cli.stages.work import PerceivingWork, Work

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
