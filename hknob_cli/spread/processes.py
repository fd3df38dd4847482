"""Processes on this machine that do pieces of work, as a `concurrent.futures` executor."""

import contextlib
import os
import signal
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Future, ProcessPoolExecutor
from multiprocessing import active_children, get_context, parent_process
from threading import Thread

Work = Callable[[int, int], bytes]  # items start to stop, to their results
Done = tuple[float, bytes]  # seconds, results

_BOTH = {signal.SIGINT, signal.SIGTERM}
_work: Work | None = None


@contextlib.contextmanager
def beginning() -> Iterator[None]:
    """While processes are begun: signals wait until each knows what to do with them (`begin_worker`)."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, _BOTH)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def begin_worker() -> None:
    """Leave an interruption to the parent to answer, and end when it has been killed: nobody else would say so."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, _BOTH)
    parent = parent_process()
    assert parent is not None

    def follow() -> None:
        parent.join()
        os._exit(1)

    Thread(target=follow, daemon=True).start()


def start_method() -> str:
    """How to begin a process: forked it has all libraries and compiled code loaded; not where that is unsafe."""
    return "fork" if sys.platform == "linux" else "spawn"


def timed(work: Work, start: int, stop: int) -> Done:
    """Do a piece of work, and say how long it took."""
    begin = time.monotonic()
    found = work(start, stop)
    return time.monotonic() - begin, found


def end_children() -> None:
    """End this machine's processes where they stand."""
    for child in active_children():
        child.terminate()


class Processes:
    """``count`` processes that do ``work``, one piece at a time each.

    Threads of libraries are held to one a process from the start of the program (`cli.main`).
    """

    fragile = True
    lost: tuple[type[BaseException], ...] = (BrokenExecutor,)
    deadly: tuple[type[BaseException], ...] = (MemoryError,)

    def __init__(self, work: Work, count: int) -> None:
        """Begin them."""
        self.count = count
        self._given = work
        self._executor = self._open()

    def _open(self) -> ProcessPoolExecutor:
        return ProcessPoolExecutor(self.count, get_context(start_method()), _begin, (self._given,))

    def reachable(self) -> bool:
        """They are: what is lost says so."""
        return True

    def submit(self, start: int, stop: int) -> "Future[Done]":
        """Hand out a piece of work."""
        with beginning():
            return self._executor.submit(_do, start, stop)

    def renew(self) -> None:
        """Begin other processes, after some were lost."""
        self.close()
        self._executor = self._open()

    def close(self, *, now: bool = False) -> None:
        """End them; ``now``: in the middle of their work."""
        if now:
            children = active_children()
            end_children()
            for child in children:
                child.join(1.0)
        # One that ended as it sent a result has left the thread that reads it waiting for the rest, for ever.
        self._executor.shutdown(wait=not now, cancel_futures=True)


def _begin(work: Work) -> None:
    global _work
    begin_worker()
    _work = work


def _do(start: int, stop: int) -> Done:
    assert _work is not None
    return timed(_work, start, stop)
