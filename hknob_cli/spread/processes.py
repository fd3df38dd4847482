"""Processes on this machine that do pieces of work.

Memory of a long run: what one piece of work gives back is kept for the next, which takes as much.
"""

import contextlib
import ctypes
import hashlib
import os
import pickle
import signal
import sys
import time
import traceback
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from multiprocessing import active_children, get_context, parent_process
from multiprocessing.connection import Connection
from multiprocessing.context import ForkContext, SpawnContext
from multiprocessing.process import BaseProcess
from queue import SimpleQueue
from threading import Thread
from typing import Any, NamedTuple

import pyarrow as pa

from hknob_cli.errors import ComputationError, HknobError

# Of the C library's `mallopt`, and bytes: only a larger array has pages of its own, which are given back when it is
# (the largest bound that there may be); memory is given back when so much lies free; and taken so much at a time.
_M_MMAP_THRESHOLD, _M_TRIM_THRESHOLD, _M_TOP_PAD = -3, -1, -2
_SETTINGS = {_M_MMAP_THRESHOLD: 32 << 20, _M_TRIM_THRESHOLD: 256 << 20, _M_TOP_PAD: 16 << 20}

Work = Callable[[int, int], bytes]  # items start to stop, to their results
_BOTH = {signal.SIGINT, signal.SIGTERM}
_END = b""  # in place of a piece of work: there is no more


def keep_memory() -> None:
    """From now on, in this process and those that it forks; nothing where the C library is not GNU's.

    To get fresh pages costs the system a second of a core in a million cells, more than half of what it does at all.
    """
    try:
        mallopt = ctypes.CDLL(None).mallopt
    except (OSError, TypeError, AttributeError):
        return
    for what, size in _SETTINGS.items():
        mallopt(what, size)
    pa.set_memory_pool(pa.system_memory_pool())  # the same memory, for tables


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


def _context() -> ForkContext | SpawnContext:
    """How to begin a process: forked it has all libraries and compiled code loaded; not where that is unsafe."""
    return get_context("fork") if sys.platform == "linux" else get_context("spawn")


class Done(NamedTuple):
    """The answer to a piece of work: how long it took, its results, what it was asked for, and a digest of both."""

    seconds: float
    results: bytes
    start: int
    stop: int
    digest: bytes

    def is_of(self, start: int, stop: int) -> bool:
        """Whether this is the answer to that question, whole."""
        return (self.start, self.stop, self.digest) == (start, stop, digest_of(start, stop, self.results))


def digest_of(start: int, stop: int, results: bytes) -> bytes:
    """SHA-256 of results together with which items they are of."""
    whole = hashlib.sha256(f"{start} {stop} ".encode())
    whole.update(results)
    return whole.digest()


def timed(work: Work, start: int, stop: int) -> Done:
    """Do a piece of work, and say how long it took."""
    begin = time.monotonic()
    found = work(start, stop)
    return Done(time.monotonic() - begin, found, start, stop, digest_of(start, stop, found))


def end_children() -> None:
    """End this machine's processes where they stand."""
    for child in active_children():
        child.terminate()


class DiedError(Exception):
    """A process ended before it had answered."""


class Worker(NamedTuple):
    """A process, and the pipe to it. Nobody else has its other end, which its death closes, in mid-answer too."""

    process: BaseProcess
    pipe: "Connection[Any, Any]"


class Processes:
    """``count`` processes that do ``work``, one piece at a time each; for one that dies another is begun.

    A thread each waits for their answers. Threads of libraries are held to one a process from the start of the program
    (`cli.main`).
    """

    lost: tuple[type[BaseException], ...] = ()
    deadly: tuple[type[BaseException], ...] = (MemoryError, DiedError)

    def __init__(self, work: Work, count: int) -> None:
        """Begin them. Raises `ComputationError` where there may not be so many."""
        self.count = count
        self._work = work
        self._open()

    def _open(self) -> None:
        self._alive: list[Worker] = []
        self._dead: list[Worker] = []
        self._idle: SimpleQueue[Worker | None] = SimpleQueue()
        self._waiting = ThreadPoolExecutor(self.count)
        self._replace()

    def reachable(self) -> bool:
        """They are, for those that died are replaced. Raises as the class."""
        self._replace()
        return True

    def _replace(self) -> None:
        while self._dead:
            worker = self._dead.pop()
            self._alive.remove(worker)
            _end(worker, now=True)
            _release(worker)
        while len(self._alive) < self.count:
            try:
                with beginning():
                    self._alive.append(_begin(self._work))
            except OSError as error:
                self.close(now=True)
                why = error.strerror or error
                raise ComputationError(
                    f"only {len(self._alive)} of {self.count} processes can be begun: {why}; try fewer, with --jobs"
                ) from None
            self._idle.put(self._alive[-1])

    def submit(self, start: int, stop: int) -> "Future[Done]":
        """Hand out a piece of work."""
        return self._waiting.submit(self._do, start, stop)

    def _do(self, start: int, stop: int) -> Done:
        """Let one that is idle do a piece. Raises `DiedError`, and what the work raises."""
        while (worker := self._idle.get()) is not None:
            try:
                worker.pipe.send_bytes(pickle.dumps((start, stop)))
            except OSError:  # it died with nothing to do
                self._dead.append(worker)
                continue
            try:
                answer = pickle.loads(worker.pipe.recv_bytes())
            except (EOFError, OSError):
                self._dead.append(worker)
                raise DiedError from None
            if isinstance(answer, BaseException):
                self._idle.put(worker)
                raise answer
            done: Done = answer
            if done.is_of(start, stop):
                self._idle.put(worker)
            else:
                self._dead.append(worker)  # its next answer would be wrong, too
            return done
        self._idle.put(None)  # nobody is left, for whoever asks next either
        raise DiedError

    def renew(self) -> None:
        """Begin others."""
        self.close()
        self._open()

    def close(self, *, now: bool = False) -> None:
        """End them; ``now``: in the middle of their work."""
        for worker in self._alive:
            _end(worker, now=now)
        self._idle.put(None)
        self._waiting.shutdown(cancel_futures=True)
        for worker in self._alive:
            _release(worker)


def _begin(work: Work) -> Worker:
    context = _context()
    here, there = context.Pipe()
    process = context.Process(target=_serve, args=(there, work), daemon=True)
    process.start()
    there.close()
    return Worker(process, here)


def _end(worker: Worker, *, now: bool) -> None:
    if now:
        worker.process.kill()
    else:
        with contextlib.suppress(OSError):  # it is gone
            worker.pipe.send_bytes(_END)
    worker.process.join()


def _release(worker: Worker) -> None:
    """Close what leads to one that has ended."""
    worker.pipe.close()
    worker.process.close()


def _serve(pipe: "Connection[Any, Any]", work: Work) -> None:
    """In the process: do what comes, and answer with what was found, or with what the work raised."""
    begin_worker()
    with contextlib.suppress(EOFError, OSError):  # the parent is gone
        while asked := pipe.recv_bytes():
            try:
                answer = pickle.dumps(timed(work, *pickle.loads(asked)))
            except Exception as error:  # whatever it is, it is the parent's to raise
                if not isinstance(error, HknobError | MemoryError):
                    error.add_note(traceback.format_exc())  # where it was, which a pickle leaves out
                answer = pickle.dumps(error)
            pipe.send_bytes(answer)
