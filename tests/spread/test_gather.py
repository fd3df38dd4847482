"""Gathering: all results, whoever dies on the way; what the work raises; what nobody survives.

Ranges: every item is handed out once, in pieces that respect the parts, whatever is lost on the way.
"""

import errno
import os
import signal
import struct
import time
from collections.abc import Callable
from concurrent.futures import Future
from itertools import pairwise
from multiprocessing import active_children
from multiprocessing.connection import Connection
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hknob_cli.errors import ComputationError
from hknob_cli.spread import processes
from hknob_cli.spread.gather import GROWTH, MOST, SECONDS, SHORTEST, Pace, Range, Ranges, gather
from hknob_cli.spread.processes import Done, Processes, Work, timed


@pytest.mark.long
@given(st.integers(0, 200), st.integers(1, 250), st.data())
def test_every_item_once(total: int, part: int, data: st.DataObject) -> None:
    cuts = sorted(data.draw(st.sets(st.integers(0, total), max_size=6)))
    done = [pair for i, pair in enumerate(pairwise(cuts)) if i % 2 == 0]
    left = Ranges(total, done=done, part=part)
    assert len(left) == total - sum(stop - start for start, stop in done)
    seen: list[int] = []
    lost = 0
    while len(left):
        asked = data.draw(st.integers(1, 60))
        one = left.take(asked)
        assert 0 < one.items <= 2 * asked
        assert one.start // part == (one.stop - 1) // part
        if lost < 5 and data.draw(st.booleans()):
            lost += 1
            left.give_back([one])
            continue
        seen += range(one.start, one.stop)
    assert sorted(seen) == [i for i in range(total) if not any(start <= i < stop for start, stop in done)]


def test_lost_items_come_back_first_and_in_halves() -> None:
    left = Ranges(10)
    first = left.take(4)
    left.give_back([first])
    assert left.take(10) == Range(0, 2, 1)
    assert left.take(10) == Range(2, 4, 1)
    assert left.take(10) == Range(4, 10, 0)
    with pytest.raises(IndexError):
        left.take(1)


def test_what_nobody_is_at_comes_back_as_it_was() -> None:
    left = Ranges(10)
    one, other = left.take(3), left.take(3)
    left.put_back([one, other])
    assert left.deaths == 0
    assert [left.take(5), left.take(5), left.take(9)] == [one, other, Range(6, 10)]
    assert left.deaths == 0


def test_the_lowest_items_come_first_whatever_came_back_before() -> None:
    left = Ranges(20)
    one, other = left.take(4), left.take(4)
    left.give_back([one])
    left.put_back([other])
    assert left.deaths == 1
    assert [left.take(4) for _ in range(4)] == [Range(0, 2, 1), Range(2, 4, 1), other, Range(8, 12)]


def test_what_is_nearly_all_of_a_part_is_taken_whole() -> None:
    left = Ranges(26, part=10)
    found = [left.take(most) for most in (5, 4, 2, 2)]
    assert found == [Range(0, 10), Range(10, 14), Range(14, 16), Range(16, 20)]
    assert left.take(3) == Range(20, 26)


def run(work: Work, total: int, *, count: int = 2, tick=lambda: None) -> list[int]:
    found: list[int] = []

    def deliver(start: int, stop: int, data: bytes) -> None:
        assert data == bytes(range(start, stop))
        found.extend(data)

    gather(Processes(work, count), Ranges(total), deliver, tick=tick)
    return sorted(found)


def plain(start: int, stop: int) -> bytes:
    return bytes(range(start, stop))


def test_all_items_arrive() -> None:
    assert run(plain, 200) == list(range(200))
    assert run(plain, 0) == []
    assert not active_children()


def test_a_worker_that_is_killed_costs_no_item(tmp_path: Path) -> None:
    def work(start: int, stop: int) -> bytes:
        mark = tmp_path / str(start)
        if start % 3 == 0 and not mark.exists():
            mark.touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return plain(start, stop)

    assert run(work, 100) == list(range(100))
    assert len(list(tmp_path.iterdir())) > 3


def confuse(monkeypatch: pytest.MonkeyPatch, answer: Callable[[Work, int, int], Done]) -> None:
    """Let processes answer otherwise; they are forked later."""
    monkeypatch.setattr(processes, "timed", answer)


@pytest.mark.parametrize("how", ["of other items", "of a piece before", "spoilt", "cut short"])
def test_a_wrong_answer_is_not_taken(how: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def answer(work: Work, start: int, stop: int) -> Done:
        mark, right = tmp_path / str(start), timed(work, start, stop)
        if start % 3 or mark.exists():
            return right
        mark.touch()
        match how:
            case "of other items":
                return timed(work, start + 1, stop + 1)
            case "of a piece before":
                return right._replace(results=work(0, stop - start) if start else b"\1")
            case "spoilt":
                return right._replace(results=bytes([right.results[0] ^ 8]) + right.results[1:])
        return right._replace(results=right.results[:-1])

    confuse(monkeypatch, answer)
    assert run(plain, 100) == list(range(100))
    assert len(list(tmp_path.iterdir())) > 3
    assert not active_children()


def test_items_that_are_answered_wrongly_over_and_over_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    def answer(work: Work, start: int, stop: int) -> Done:
        return timed(work, start, stop)._replace(results=b"") if start <= 17 < stop else timed(work, start, stop)

    confuse(monkeypatch, answer)
    with pytest.raises(ComputationError, match=r"items 17 to 17: .* computed 8 times in vain, .* kept"):
        run(plain, 30)
    assert not active_children()


def in_mid_answer(then: Callable[[], None]) -> None:
    """Let this process say half of its next answer, and ``then`` do something."""

    def half(self: Connection, data: bytes) -> None:
        assert len(data) > 10**6
        os.write(self.fileno(), struct.pack("!i", len(data)) + data[: len(data) // 2])
        then()

    Connection.send_bytes = half


@pytest.mark.one_in(2)
@pytest.mark.parametrize("count", [1, 3])
def test_a_worker_that_is_killed_in_mid_answer_costs_no_item(tmp_path: Path, count: int) -> None:
    def work(start: int, stop: int) -> bytes:
        mark = tmp_path / str(start)
        if start % 3 == 0 and not mark.exists():
            mark.touch()
            in_mid_answer(lambda: os.kill(os.getpid(), signal.SIGKILL))
        return plain(start, stop) + bytes(2 * 10**6)

    found: list[int] = []
    gather(
        Processes(work, count),
        Ranges(50),
        lambda start, stop, data: found.extend(data[: stop - start]),
        tick=lambda: None,
        pace=Pace(first=1, most=1),
    )
    assert sorted(found) == list(range(50))
    assert len(list(tmp_path.iterdir())) > 3
    assert not active_children()


def test_an_interruption_in_mid_answer(tmp_path: Path) -> None:
    """Whoever waits for the rest of it is not waited for."""

    def work(start: int, stop: int) -> bytes:
        in_mid_answer(lambda: ((tmp_path / str(start)).touch(), time.sleep(600)))
        return bytes(2 * 10**6)

    def tick() -> None:
        if len(list(tmp_path.iterdir())) == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(work, 10, tick=tick)
    assert not active_children()


def kill_all() -> None:
    for child in active_children():
        child.kill()
        child.join()


def all_done(workers: Processes, count: int) -> list[Future]:
    """So many items, an item a piece."""
    pieces = [workers.submit(start, start + 1) for start in range(count)]
    while not all(piece.done() for piece in pieces):
        assert workers.reachable()
    return pieces


def test_a_worker_that_dies_with_nothing_to_do_is_not_blamed_for_what_comes_next() -> None:
    workers = Processes(plain, 2)
    kill_all()
    assert [piece.result()[1] for piece in all_done(workers, 5)] == [bytes([start]) for start in range(5)]
    workers.close()
    assert not active_children()


@pytest.mark.parametrize("death", ["kill", "memory"])
def test_too_many_items_for_the_memory_are_done_in_halves(death: str) -> None:
    def work(start: int, stop: int) -> bytes:
        if stop - start > 3:
            if death == "memory":
                raise MemoryError
            os.kill(os.getpid(), signal.SIGKILL)
        return plain(start, stop)

    assert run(work, 40) == list(range(40))


def test_items_that_kill_every_worker_are_named() -> None:
    def work(start: int, stop: int) -> bytes:
        if start <= 17 < stop:
            os.kill(os.getpid(), signal.SIGKILL)
        return plain(start, stop)

    with pytest.raises(ComputationError, match=r"items 17 to 17: .* died 8 times"):
        run(work, 30)
    assert not active_children()


def test_all_that_is_handed_out_ends_with_the_workers() -> None:
    def work(start: int, stop: int) -> bytes:
        time.sleep(600)
        return b""

    workers = Processes(work, 2)
    pieces = [workers.submit(start, start + 1) for start in range(30)]
    workers.close(now=True)
    assert all(piece.done() for piece in pieces)
    assert not active_children()


def test_more_processes_than_there_may_be(monkeypatch: pytest.MonkeyPatch) -> None:
    plain_fork, begun = os.fork, []

    def fork() -> int:
        if len(begun) == 3:
            raise BlockingIOError(errno.EAGAIN, "Resource temporarily unavailable")
        begun.append(True)
        return plain_fork()

    monkeypatch.setattr(os, "fork", fork)
    with pytest.raises(ComputationError, match=r"only 3 of 8 processes can be begun: Resource temporarily .* --jobs"):
        run(plain, 10, count=8)
    assert not active_children()


def test_what_the_work_raises_is_raised() -> None:
    def work(start: int, stop: int) -> bytes:
        if start <= 17 < stop:
            raise ComputationError("at 17 it overflows")
        return plain(start, stop)

    with pytest.raises(ComputationError, match="at 17"):
        run(work, 30)


def test_where_the_work_failed_is_said_where_nobody_expected_it() -> None:
    def fails_here(start: int) -> None:
        raise LookupError(f"at {start}")

    def work(start: int, stop: int) -> bytes:
        fails_here(start)
        return b""

    with pytest.raises(LookupError, match="at 0") as raised:
        run(work, 1)
    assert "in fails_here" in "".join(raised.value.__notes__)


def test_workers_that_died_leave_no_pipe_open() -> None:
    workers = Processes(plain, 2)
    before = len(list(Path("/proc/self/fd").iterdir()))
    for _ in range(5):
        kill_all()
        all_done(workers, 4)
        assert len(list(Path("/proc/self/fd").iterdir())) <= before
    workers.close()


def test_an_interruption_ends_the_workers_in_the_middle_of_their_work() -> None:
    def work(start: int, stop: int) -> bytes:
        time.sleep(600)
        return b""

    def tick() -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(work, 10, tick=tick)
    assert not active_children()


def test_pieces_grow_to_their_time_and_shrink_at_the_end() -> None:
    pace = Pace(first=8)
    sizes = []
    for _ in range(10):
        sizes.append(pace.size(10**6, 2))
        pace.learn(sizes[-1], sizes[-1] * SECONDS / 1000)  # a thousand items a piece
    assert sizes[:2] == [8, int(8 * GROWTH)]
    assert sizes[-1] == 1000
    assert pace.size(100, 2) == 25
    shortest = int(1000 / SECONDS * SHORTEST)
    assert 1 < shortest == pace.size(4 * shortest - 4, 2) == pace.size(1, 2)
    pace.learn(1, 100 * SECONDS)
    assert pace.size(10**6, 2) == 1
    pace.learn(10**6, 1e-9)
    pace.learn(10**6, 1e-9)
    for _ in range(20):
        pace.learn(10**6, 1e-9)
    assert pace.size(10**9, 2) == MOST


def test_no_other_item_is_blamed() -> None:
    """Others are at work whenever a worker dies, and take longer than the one that kills it."""

    def work(start: int, stop: int) -> bytes:
        time.sleep(0.02)
        if start <= 17 < stop:
            os.kill(os.getpid(), signal.SIGKILL)
        time.sleep(0.2)
        return plain(start, stop)

    with pytest.raises(ComputationError, match=r"items 17 to 17: "):
        run(work, 20, count=4)


def test_a_large_piece_is_halved_until_one_item_is_left_to_blame() -> None:
    def work(start: int, stop: int) -> bytes:
        if start <= 100 < stop:
            raise MemoryError
        return b""

    with pytest.raises(ComputationError, match=r"items 100 to 100: .* died 1[0-9] times"):
        gather(Processes(work, 1), Ranges(2048), lambda *_: None, tick=lambda: None, pace=Pace(first=1024, most=1024))


class Queueing(Processes):
    """A worker at which other pieces wait, which are lost with it, as on a cluster."""

    def __init__(self, work: Work) -> None:
        super().__init__(work, 1)
        self.count = 4
        self.waiting: list[Future] = []

    def submit(self, start: int, stop: int) -> Future:
        mine: Future = Future()
        self.waiting.append(mine)
        super().submit(start, stop).add_done_callback(lambda theirs: self._hear(theirs, mine))
        return mine

    def _hear(self, theirs: Future, mine: Future) -> None:
        if theirs.exception():
            for one in [one for one in self.waiting if not one.done()]:
                one.set_exception(theirs.exception())
        elif not mine.done():
            mine.set_result(theirs.result())


def test_what_waits_at_a_worker_that_dies_is_not_blamed(tmp_path: Path) -> None:
    """Two items next to one another kill their worker five times each: neither is given up for both."""

    def work(start: int, stop: int) -> bytes:
        time.sleep(0.02)
        deaths = len(list(tmp_path.glob(f"{start}-*")))
        if start in (17, 18) and deaths < 5:
            (tmp_path / f"{start}-{deaths}").touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return plain(start, stop)

    found: list[int] = []
    left, pace = Ranges(30), Pace(first=1, most=1)
    gather(Queueing(work), left, lambda _start, _stop, data: found.extend(data), tick=lambda: None, pace=pace)
    assert sorted(found) == list(range(30))
    assert len(list(tmp_path.iterdir())) == 10


class Absent(Processes):
    """Workers that are gone again and again, for no fault of what they were at."""

    lost = (ConnectionError,)
    sent = 0

    def submit(self, start: int, stop: int):
        self.sent += 1
        if self.sent % 5 == 0:
            raise ConnectionError
        return super().submit(start, stop)


def test_a_connection_that_is_lost_is_nobodys_fault() -> None:
    found: list[int] = []
    left = Ranges(60)
    gather(Absent(plain, 1), left, lambda start, stop, _: found.extend(range(start, stop)), tick=lambda: None)
    assert sorted(found) == list(range(60))


class Forgetful(Processes):
    """Workers that cannot be reached any more once nothing is left to do."""

    finished = False
    renewed = 0

    def reachable(self) -> bool:
        return not self.finished

    def renew(self) -> None:
        self.renewed += 1
        super().renew()


def test_nobody_is_looked_for_once_all_is_done() -> None:
    workers = Forgetful(plain, 1)
    found: list[int] = []

    def deliver(start: int, stop: int, _: bytes) -> None:
        found.extend(range(start, stop))
        workers.finished = len(found) == 40

    gather(workers, Ranges(40), deliver, tick=lambda: None)
    assert (sorted(found), workers.renewed) == (list(range(40)), 0)
