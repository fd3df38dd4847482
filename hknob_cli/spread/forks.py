"""The cores of this machine, and many items or tasks of one stage made by several processes, forked.

A fork does one task at a time, or some items of many that are independent of one another: claims, figures.
"""

import os
import pickle
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, Self, TypeVar

if TYPE_CHECKING:
    from concurrent.futures import ProcessPoolExecutor

    from hknob_cli.spread.gather import Range

T = TypeVar("T")
R = TypeVar("R")


def usable_cores() -> int:
    """Cores this process may run on."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class Forks:
    """``jobs`` processes, begun on entering; without that, and of one, tasks are done in this process."""

    def __init__(self, jobs: int) -> None:
        self.jobs = jobs
        self._pool: ProcessPoolExecutor | None = None

    def __enter__(self) -> "Forks":
        """Begin the processes, before this one has threads."""
        if self.jobs == 1:
            return self
        from concurrent.futures import ProcessPoolExecutor
        from multiprocessing import get_context

        from hknob_cli.spread.processes import begin_worker, beginning

        self._pool = ProcessPoolExecutor(self.jobs, get_context("fork"), begin_worker)
        with beginning():
            first = self._pool.submit(int)
        first.result()
        return self

    def __exit__(self, kind: object, *_: object) -> None:
        """End the processes: what has not begun never does, and after an interruption neither does what has."""
        if not self._pool:
            return
        from hknob_cli.spread.processes import end_children

        if kind:
            end_children()
        self._pool.shutdown(wait=True, cancel_futures=True)
        self._pool = None

    @property
    def begun(self) -> bool:
        """Whether there are processes."""
        return self._pool is not None

    def each(self, do: Callable[[T], R], items: Sequence[T]) -> Iterator[tuple[int, R]]:
        """What ``do``, which can be pickled, makes of each item: its number and that, as they are done."""
        if not self._pool:
            yield from ((number, do(item)) for number, item in enumerate(items))
            return
        from concurrent.futures import as_completed

        coming = {self._pool.submit(do, item): number for number, item in enumerate(items)}
        for future in as_completed(coming):
            yield coming[future], future.result()


class Forked:
    """What does its tasks in processes, begun on entering; without that, in this process."""

    _forks: Forks

    def __enter__(self) -> Self:
        """Begin the processes, before this one has threads."""
        self._forks.__enter__()
        return self

    def __exit__(self, kind: object, *_: object) -> None:
        """End the processes."""
        self._forks.__exit__(kind)


Progress = Callable[[int, int], None]


def by_processes(
    make: Callable[[int, int], bytes],
    total: int,
    *,
    jobs: int,
    first: int,
    most: int,
    name: "Callable[[Range], str]",
    progress: Progress = lambda _done, _total: None,
) -> list[Any]:
    """What ``make`` makes of items 0 to ``total``, in order; it pickles a list of what it makes of some of them.

    Args:
        make: takes the first item and the one after the last. What it raises is raised here.
        total: how many items there are.
        jobs: processes; with one, all is made in this one.
        first: items that a process is given at first.
        most: items that it is given at once.
        name: what to call items where a process dies of them.
        progress: told how many of how many are made.
    """
    found: list[Any] = [None] * total
    made = 0

    def deliver(start: int, stop: int, data: bytes) -> None:
        nonlocal made
        found[start:stop] = pickle.loads(data)
        made += stop - start
        progress(made, total)

    if min(jobs, total) <= 1:
        for number in range(total):
            deliver(number, number + 1, make(number, number + 1))
        return found
    from hknob_cli.spread.gather import Pace, Ranges, gather
    from hknob_cli.spread.processes import Processes
    from hknob_cli.terminal import heed

    workers = Processes(make, min(jobs, total))
    gather(workers, Ranges(total), deliver, tick=heed, pace=Pace(first=first, most=most), name=name)
    return found
