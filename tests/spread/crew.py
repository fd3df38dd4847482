"""Workers that are drawn from a seed: which of them answers next, how, and who is lost; the same seed does it again.

Nothing runs beside: a piece is computed when its answer is due. Answers come in any order, late (when somebody else has
done the piece), from workers that die, that have no memory left, or that are cut off; and well-formed answers that are
wrong: of other items, of a piece before, with a bit flipped, cut short. ``lies`` is the share of answers that are wrong
from the begin, with a digest that fits: nothing but computing some of them again tells.
"""

import contextlib
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import Future
from random import Random
from typing import Any

from hknob_cli.spread import gather
from hknob_cli.spread.processes import DiedError, Done, Work, digest_of, timed

WEIGHTS = {
    "right": 24,
    "dies": 3,
    "no memory": 2,
    "cut off": 2,
    "other items": 2,
    "before": 2,
    "flipped": 2,
    "short": 1,
}
MOST = 4  # workers


class Crew:
    """`gather.Workers` that do ``work``; ``happened`` counts what they did."""

    lost: tuple[type[BaseException], ...] = (ConnectionError,)
    deadly: tuple[type[BaseException], ...] = (MemoryError, DiedError)

    def __init__(self, work: Work, seed: object, *, most_faults: int = 10**6, lies: float = 0.0) -> None:
        """After ``most_faults`` they answer in any order, and rightly except for ``lies``."""
        self._lies, self.done = lies, 0
        self._work, self._dice, self._most_faults = work, Random(str(seed)), most_faults
        self.count = self._dice.randint(1, MOST)
        self.happened: Counter[str] = Counter()
        self.faults: Counter[int] = Counter()  # by item
        self.closed = False
        self._due: dict[Future[Done], tuple[int, int]] = {}
        self._forgotten: dict[Future[Done], tuple[int, int]] = {}
        self._before: Done | None = None
        self._cut = False

    @property
    def _in_trouble(self) -> bool:
        return self._most_faults > 0

    def reachable(self) -> bool:
        """Not if they have been cut off."""
        return not self._cut

    def submit(self, start: int, stop: int) -> "Future[Done]":
        """Hand out items."""
        if self._cut or (self._in_trouble and self._dice.random() < 0.02):
            self._cut = True
            self.happened["cut off"] += 1
            raise ConnectionError
        self._due[future := Future()] = start, stop
        return future

    def renew(self) -> None:
        """Others, while those before may still answer."""
        self._forgotten |= self._due
        self._due = {}
        self._cut = False
        self.count = self._dice.randint(0, MOST)

    def close(self, *, now: bool = False) -> None:
        """Let them go."""
        assert now or not self._due
        self.closed = True

    def wait(self, pending: Any, timeout: float | None = None, return_when: str = "") -> tuple[list[Any], Any]:
        """In place of `concurrent.futures.wait`: something happens, or nothing."""
        if self._in_trouble and self._dice.random() < 0.1:
            self.count = self._dice.randint(0, MOST)  # some come, some go
        self.count = self.count or (self._dice.random() < 0.5)
        for future in [one for one in self._forgotten if self._dice.random() < 0.3]:
            self.happened["late"] += 1  # of a piece that has been handed out again
            future.set_result(timed(self._work, *self._forgotten.pop(future)))
        due = [future for future in self._due if future in pending]
        answered = self._dice.sample(due, self._dice.randint(0, len(due))) if timeout else []
        for future in answered:
            self._answer(future, *self._due.pop(future))
        return answered, set(pending) - set(answered)

    def _answer(self, future: "Future[Done]", start: int, stop: int) -> None:
        (how,) = self._dice.choices(list(WEIGHTS), WEIGHTS.values()) if self._in_trouble else ("right",)
        if how in ("other items", "before") and self._before is None:
            how = "right"
        self.happened[how] += 1
        if how != "right":
            self._most_faults -= 1
        if how not in ("right", "cut off"):
            self.faults.update(range(start, stop))
        match how:
            case "dies":
                future.set_exception(DiedError())
            case "no memory":
                future.set_exception(MemoryError())
            case "cut off":
                self._cut = True
                future.set_exception(ConnectionError())
            case _:
                future.set_result(self._said(how, start, stop))

    def _said(self, how: str, start: int, stop: int) -> Done:
        self.done += stop - start
        right = timed(self._work, start, stop)._replace(seconds=self._dice.expovariate(1.0))
        if self._dice.random() < self._lies:
            wrong = bytes(one ^ 1 for one in right.results)
            return right._replace(results=wrong, digest=digest_of(start, stop, wrong))
        before, self._before = self._before, right
        match how:
            case "other items":
                assert before is not None
                return right if before[2:4] == (start, stop) else before
            case "before":  # the results of the piece before, in the place of these
                assert before is not None
                return right._replace(results=before.results)
            case "flipped" if right.results:
                at, results = self._dice.randrange(len(right.results)), bytearray(right.results)
                results[at] ^= 1 << self._dice.randrange(8)
                return right._replace(results=bytes(results))
            case "short":
                return right._replace(results=right.results[:-1])
        return right


@contextlib.contextmanager
def at_work(crew: Crew) -> Iterator[Crew]:
    """Nobody waits for a clock."""
    plain = gather.wait, gather._SOON
    gather.wait, gather._SOON = crew.wait, 0.0  # type: ignore[assignment]
    try:
        yield crew
    finally:
        gather.wait, gather._SOON = plain
