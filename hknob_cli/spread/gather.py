"""Handing out pieces of work, and taking in their results, until nothing is left; lost workers cost time only."""

import time
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, Future, wait
from typing import Protocol

from hknob_cli.errors import ComputationError
from hknob_cli.spread.pace import Pace
from hknob_cli.spread.processes import Done
from hknob_cli.spread.ranges import Range, Ranges

DEATHS = 8  # of the worker that has an item, after which it is given up
# Of them, after which it is done with nothing beside it: it has all the memory then, and no other piece is blamed that
# was waiting at the same worker of a cluster.
SUSPECT = 2
_SOON = 0.05  # s between two looks at whether somebody has come
_TICK = 0.2  # s between two looks at whether there was an interruption


class Workers(Protocol):
    """Who does the work: processes here, or on a cluster.

    ``lost``: what a piece raises when they are gone; ``deadly``: when it was too much for the one that had it.
    """

    lost: tuple[type[BaseException], ...]
    deadly: tuple[type[BaseException], ...]

    @property
    def count(self) -> int:
        """Pieces that they do at the same time; 0 while nobody is there."""

    def reachable(self) -> bool:
        """Whether they are still there, as far as can be told; asked several times a second."""

    def submit(self, start: int, stop: int) -> "Future[Done]":
        """Hand out items ``start`` to ``stop``. Raises one of ``lost``."""

    def renew(self) -> None:
        """Find other workers. Raises `ComputationError` if there are none."""

    def close(self, *, now: bool = False) -> None:
        """Let them go; ``now``: in the middle of their work."""


def gather(
    workers: Workers,
    left: Ranges,
    deliver: Callable[[int, int, bytes], None],
    *,
    tick: Callable[[], None],
    name: Callable[[Range], str] = lambda one: f"items {one.start} to {one.stop - 1}",
    pace: Pace | None = None,
) -> None:
    """Do all that is ``left``; ``deliver`` takes in the results of each piece, in any order.

    ``tick`` is called several times a second; ``name`` says what items are. What the work raises is raised here, once
    nothing more is handed out. Raises `ComputationError` where workers die on the same item over and over.
    """
    pace = pace or Pace()
    pending: dict[Future[Done], Range] = {}
    try:
        while left or pending:
            gone: list[Range] = []
            while left and not gone and len(pending) < 2 * workers.count and not (pending and _suspect(left, pending)):
                one = left.take(pace.size(len(left), workers.count))
                try:
                    pending[workers.submit(one.start, one.stop)] = one
                except workers.lost:
                    gone.append(one)
            done, _ = wait(pending, timeout=0.0 if gone else _TICK, return_when=FIRST_COMPLETED)
            if not (pending or gone):
                time.sleep(_SOON)  # nobody is there yet
            tick()
            dead = []
            for future in done:
                one = pending.pop(future)
                try:
                    seconds, found = future.result()
                except workers.lost:
                    gone.append(one)
                except workers.deadly:
                    dead.append(one)
                else:
                    pace.learn(one.items, seconds)
                    deliver(one.start, one.stop, found)
            if gone or ((left or pending) and not workers.reachable()):
                gone += pending.values()
                pending.clear()
                workers.renew()
            left.put_back(gone)
            _bury(dead, name, left.unit)
            left.give_back(dead)
    except BaseException:
        workers.close(now=True)
        raise
    workers.close()


def _suspect(left: Ranges, pending: dict[Future[Done], Range]) -> bool:
    """Whether what is handed out, or would be next, may be what kills workers."""
    return left.deaths >= SUSPECT or any(one.deaths >= SUSPECT for one in pending.values())


def _bury(dead: list[Range], name: Callable[[Range], str], unit: int) -> None:
    """Raise `ComputationError` for what cost too many workers and cannot be halved any more."""
    for one in dead:
        if one.deaths + 1 >= DEATHS and one.items <= unit:
            raise ComputationError(
                f"{name(one)}: the process that computed this died {one.deaths + 1} times (out of memory?); all else "
                "that is finished is kept, run the same command again"
            )
