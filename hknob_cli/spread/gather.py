"""Handing out pieces of work, ranges of numbered items, and taking in their results until nothing is left.

How many items to hand out at once: by what the last ones took.

A sample of what was found is computed again, where the caller can tell what of a piece a part of it would be: a worker
that computes wrongly, in well-formed answers, is found by nothing else.

What is left to do of numbered items: ranges, from which work is cut in order.
"""

import time
from collections.abc import Callable, Iterable
from concurrent.futures import FIRST_COMPLETED, Future, wait
from math import ceil
from random import Random
from typing import Any, NamedTuple, Protocol

from hknob_cli.errors import ComputationError
from hknob_cli.spread.processes import Done

SECONDS = 6.0  # that a piece of work should take: long beside its handing over, short beside the whole
SHORTEST = 0.05  # s that its last pieces should take: beside that, what it costs to hand one over is still little
MOST = 65_536  # items in a piece, which bounds the memory that it takes
GROWTH = 4.0  # from one piece to the next, at most

DEATHS = 8  # of the worker that has an item, after which it is given up
# Of them, after which it is done with nothing beside it: it has all the memory then, and no other piece is blamed that
# was waiting at the same worker of a cluster.
SUSPECT = 2
# Items found, of which at most one is computed again: what that costs, as a share of the work.
SAMPLED = 64
_SOON = 0.05  # s between two looks at whether somebody has come
_TICK = 0.2  # s between two looks at whether there was an interruption


class Pace:
    """Sizes of pieces by measured cost."""

    def __init__(self, *, first: int = 8, most: int = MOST) -> None:
        self._size = float(first)
        self._most = most
        self._least = 0  # items that take the shortest time at the slowest rate so far, once a piece tells

    def learn(self, items: int, seconds: float) -> None:
        """A piece of so many items took so long."""
        rate = items / max(seconds, 1e-6)
        self._size = min(max(1.0, rate * SECONDS), GROWTH * max(self._size, 1.0), float(self._most))
        if seconds >= SHORTEST:
            least = max(1, int(rate * SHORTEST))
            self._least = min(self._least or least, least)

    def size(self, left: int, workers: int) -> int:
        """Items for the next piece: fewer towards the end, so that all workers end together."""
        return max(1, min(int(self._size), max(self._least, ceil(left / (2 * workers)))))


class Range(NamedTuple):
    """Items ``start`` to ``stop``; ``deaths``: how often the worker that had them was lost."""

    start: int
    stop: int
    deaths: int = 0

    @property
    def items(self) -> int:
        """How many they are."""
        return self.stop - self.start


class Ranges:
    """Ranges in order; no piece cut from them crosses a multiple of ``part``."""

    def __init__(self, total: int, *, done: Iterable[tuple[int, int]] = (), part: int | None = None) -> None:
        """All of ``total`` items but those that are ``done``."""
        self.part = part or max(1, total)
        self._left: list[Range] = []  # the lowest last
        begin = 0
        for start, stop in [*sorted(done), (total, total)]:
            if start > begin:
                self._left.append(Range(begin, start))
            begin = max(begin, stop)
        self._left.reverse()

    def __len__(self) -> int:
        """Number of items left."""
        return sum(one.items for one in self._left)

    @property
    def deaths(self) -> int:
        """How often workers that had the lowest items were lost; 0 if none are left."""
        return self._left[-1].deaths if self._left else 0

    def take(self, most: int) -> Range:
        """The lowest items, at most ``most`` of them, or twice as many where that leaves none of a part.

        Raises `IndexError` if none are left.
        """
        first = self._left.pop()
        stop = min(first.stop, (first.start // self.part + 1) * self.part)
        if 2 * most < stop - first.start:
            stop = first.start + max(1, most)
        if stop < first.stop:
            self._left.append(first._replace(start=stop))
        return first._replace(stop=stop)

    def put_back(self, gone: Iterable[Range]) -> None:
        """Items that nobody is at any more, for no fault of theirs."""
        self._left += gone
        self._left.sort(reverse=True)

    def give_back(self, lost: Iterable[Range]) -> None:
        """Items whose worker was lost, to be done again in halves: they may have been too many for its memory."""
        for one in lost:
            middle = one.start + (one.items + 1) // 2
            halves = [Range(one.start, middle, one.deaths + 1), Range(middle, one.stop, one.deaths + 1)]
            self._left += [half for half in halves if half.items]
        self._left.sort(reverse=True)


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


class Sample(NamedTuple):
    """How to compare: ``part_of`` says what the results of items say of some of them, ``same`` if that is the same."""

    part_of: Callable[[Range, bytes, Range], Any]
    same: Callable[[Any, Any], bool]


class Again:
    """A sample of the items that were found, computed once more and compared; where ``sample`` is None, none."""

    def __init__(self, workers: Workers, name: Callable[[Range], str], sample: Sample | None) -> None:
        self.pending: dict[Future[Done], tuple[Range, Any]] = {}
        self._workers, self._name, self._sample = workers, name, sample

    def ask(self, one: Range, results: bytes) -> None:
        """Hand out an item of a piece once more, where the piece's numbers draw one; the same of the same piece."""
        if self._sample is None:
            return
        dice = Random(f"{one.start} {one.stop}")
        if dice.random() * SAMPLED >= one.items:
            return
        first = one.start + dice.randrange(one.items)
        some = Range(first, first + 1)
        try:
            self.pending[self._workers.submit(some.start, some.stop)] = some, self._sample.part_of(one, results, some)
        except self._workers.lost:
            return  # as of a sample that nobody answers: it is one less

    def compare(self, future: "Future[Done]") -> None:
        """Compare an answer with what was found before. Raises `ComputationError` where it is another."""
        assert self._sample is not None
        some, before = self.pending.pop(future)
        try:
            answer = future.result()
        except (*self._workers.lost, *self._workers.deadly):
            return
        if not answer.is_of(some.start, some.stop):
            return
        if not self._sample.same(before, self._sample.part_of(some, answer.results, some)):
            raise ComputationError(
                f"{self._name(some)}: was computed twice, and the results differ: a processor or memory is at fault; "
                "nothing that this run has found can be trusted; find the worker, then run again with --force"
            )


def gather(
    workers: Workers,
    left: Ranges,
    deliver: Callable[[int, int, bytes], None],
    *,
    tick: Callable[[], None],
    name: Callable[[Range], str] = lambda one: f"items {one.start} to {one.stop - 1}",
    pace: Pace | None = None,
    sample: Sample | None = None,
) -> None:
    """Do all that is ``left``; ``deliver`` takes in the results of each piece, in any order.

    ``tick`` is called several times a second; ``name`` says what items are; with a ``sample`` some are computed
    again. What the work raises is raised here, once nothing more is handed out. Raises `ComputationError` where workers
    die on the same item over and over, and where one item was found twice, and not the same.
    """
    pace = pace or Pace()
    pending: dict[Future[Done], Range] = {}
    again = Again(workers, name, sample)
    try:
        while left or pending or again.pending:
            gone = _hand_out(workers, left, pending, pace)
            asked = [*pending, *again.pending]
            done, _ = wait(asked, timeout=0.0 if gone else _TICK, return_when=FIRST_COMPLETED)
            if not (asked or gone):
                time.sleep(_SOON)  # nobody is there yet
            tick()
            dead: list[Range] = []
            spoilt: list[Range] = []
            for future in done:
                if future in again.pending:
                    again.compare(future)
                    continue
                one = pending.pop(future)
                try:
                    answer = future.result()
                except workers.lost:
                    gone.append(one)
                except workers.deadly:
                    dead.append(one)
                else:
                    if not answer.is_of(one.start, one.stop):  # spoilt on the way, or the answer to something else
                        spoilt.append(one)
                        continue
                    pace.learn(one.items, answer.seconds)
                    deliver(one.start, one.stop, answer.results)
                    again.ask(one, answer.results)
            if gone or ((left or pending or again.pending) and not workers.reachable()):
                gone += pending.values()
                pending.clear()
                again.pending.clear()
                workers.renew()
            left.put_back(gone)
            _bury(dead, name, "the process that computed this died {} times (out of memory?)")
            _bury(spoilt, name, "this was computed {} times in vain, and the last answer was spoilt")
            left.give_back([*dead, *spoilt])
    except BaseException:
        workers.close(now=True)
        raise
    workers.close()


def _hand_out(workers: Workers, left: Ranges, pending: dict[Future[Done], Range], pace: Pace) -> list[Range]:
    """Hand out pieces until the workers have enough; the piece whose workers turn out to be lost comes back."""
    while left and len(pending) < 2 * workers.count and not (pending and _suspect(left, pending)):
        one = left.take(pace.size(len(left), workers.count))
        try:
            pending[workers.submit(one.start, one.stop)] = one
        except workers.lost:
            return [one]
    return []


def _suspect(left: Ranges, pending: dict[Future[Done], Range]) -> bool:
    """Whether what is handed out, or would be next, may be what kills workers."""
    return left.deaths >= SUSPECT or any(one.deaths >= SUSPECT for one in pending.values())


def _bury(dead: list[Range], name: Callable[[Range], str], why: str) -> None:
    """Raise `ComputationError` for what cost too many workers and cannot be halved any more."""
    for one in dead:
        if one.deaths + 1 >= DEATHS and one.items == 1:
            raise ComputationError(
                f"{name(one)}: {why.format(one.deaths + 1)}; all else that is finished is kept, run the same command "
                "again"
            )
