"""Parts of a page, many and independent of one another, made by several processes: its claims, and its figures."""

import pickle
from collections.abc import Callable
from typing import Any

from hknob_cli.spread.gather import Pace, Range, Ranges, gather

Progress = Callable[[int, int], None]


def by_processes(
    make: Callable[[int, int], bytes],
    total: int,
    *,
    jobs: int,
    first: int,
    most: int,
    name: Callable[[Range], str],
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
    from hknob_cli.spread.processes import Processes
    from hknob_cli.terminal import heed

    workers = Processes(make, min(jobs, total))
    gather(workers, Ranges(total), deliver, tick=heed, pace=Pace(first=first, most=most), name=name)
    return found
