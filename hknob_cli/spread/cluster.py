"""Workers of a Dask cluster, behind the interface of `concurrent.futures`."""

import asyncio
import json
import logging
import pickle
import time
import warnings
from collections.abc import Callable
from concurrent.futures import CancelledError, Future
from functools import lru_cache
from pathlib import Path
from threading import Event, Thread
from typing import Any

from hknob_cli import __version__
from hknob_cli.errors import ComputationError, HknobError, UsageError
from hknob_cli.spread.processes import Done, Work, timed

PATIENCE = 60.0  # s to look for a scheduler that was there before
FIRST = 10.0  # s to look for one that was not
SILENCE = 30.0  # s without an answer, after which a scheduler is taken to be gone: a cut cable closes no connection
_ANSWER = 5.0  # s for a scheduler to answer
_VERSION = "__import__('hknob_cli').__version__"
_LOOK = 2.0  # s between two questions of how many workers there are


class Cluster:
    """The workers of the scheduler at ``address``, or in that JSON file of it; each has this program of this version.

    A piece whose worker dies is done again by the scheduler, on another; a scheduler that goes and comes back costs
    what was handed out.
    """

    def __init__(self, work: Work, address: str, notify: Callable[[str], None], *, patience: float = PATIENCE) -> None:
        """Connect. Raises `UsageError` without the library, `ComputationError` if there is no scheduler."""
        try:
            from distributed import KilledWorker
            from distributed.comm.core import CommClosedError
        except ImportError:
            raise UsageError(
                "--executor dask: needs Dask: pip install '.[dask]' in a copy of hknob's repository"
            ) from None
        _hush()
        self.deadly: tuple[type[BaseException], ...] = (MemoryError, KilledWorker)
        self.lost: tuple[type[BaseException], ...] = (CancelledError, CommClosedError, TimeoutError)
        self._work = pickle.dumps(work)
        self._address = address
        self._notify = notify
        self._patience = patience
        self._asked: Future[dict[str, int]] | None = None
        self._probed: Future[dict[str, Any]] | None = None
        self._threads: dict[str, int] = {}
        self._fit: set[str] = set()
        self._heard = 0.0
        self._lonely = False
        self._client: Any = None
        self._connect(FIRST)

    @property
    def count(self) -> int:
        """Threads of all workers, as last heard, that are known to have this program."""
        return sum(threads for worker, threads in self._threads.items() if worker in self._fit)

    def reachable(self) -> bool:
        """Whether the scheduler answers; it is asked now and then, without waiting, what workers it has.

        Raises `ComputationError` for a worker that does not have this program, which a piece would end at once.
        """
        now = time.monotonic()
        if self._asked is None and now - self._heard > _LOOK:
            self._asked = self._ask(self._client.scheduler.ncores())
        if self._asked is not None and self._asked.done():
            asked, self._asked = self._asked, None
            if (found := _answer(asked)) is not None:
                self._heard = now
                self._threads = found
                if not self._threads and not self._lonely:
                    self._notify(f"no worker at {self._address} yet; waiting")
                self._lonely = not self._threads
        self._probe()
        return self._client.status == "running" and now - self._heard < SILENCE

    def _probe(self) -> None:
        """Ask workers that are new what version they have. Raises `ComputationError` where it is none, or another."""
        if self._probed is None and (new := self._threads.keys() - self._fit):
            self._probed = self._ask(self._client._run(eval, _VERSION, workers=list(new), on_error="return"))
        if self._probed is not None and self._probed.done():
            probed, self._probed = self._probed, None
            for worker, answer in (_answer(probed) or {}).items():
                if isinstance(answer, ImportError) or (isinstance(answer, str) and answer != __version__):
                    has = f"has hknob {answer}, not {__version__}" if isinstance(answer, str) else "does not have hknob"
                    raise ComputationError(
                        f"the worker at {worker} {has}; install hknob {__version__} there, and run the same command "
                        "again; what is finished is kept"
                    )
                if isinstance(answer, str):
                    self._fit.add(worker)

    def _ask(self, question: Any) -> "Future[Any]":
        return asyncio.run_coroutine_threadsafe(question, self._client.loop.asyncio_loop)

    def submit(self, start: int, stop: int) -> "Future[Done]":
        """Hand out items ``start`` to ``stop``. Raises `CancelledError` if the scheduler is gone."""
        if self._client.status != "running":
            raise CancelledError
        future: Future[Done] = Future()
        piece = self._client.submit(_do, self._work, start, stop, pure=False)
        self._ask(_awaited(piece)).add_done_callback(lambda answer: self._hear(answer, future))
        return future

    def _hear(self, answer: "Future[Done]", future: "Future[Done]") -> None:
        """Take in how a piece has ended; what a worker cannot so much as begin is put into words."""
        try:
            future.set_result(answer.result())
        except BaseException as error:
            if isinstance(error, (HknobError, *self.deadly, *self.lost)):
                future.set_exception(error)
                return
            said = f"{type(error).__name__}: {next(iter(str(error).splitlines()), '')}"
            future.set_exception(
                ComputationError(
                    f"the cluster at {self._address} cannot do this work: {said}; its scheduler and workers need hknob "
                    f"{__version__}, as here; what is finished is kept, run the same command again"
                )
            )

    def renew(self) -> None:
        """Connect again. Raises `ComputationError` if the scheduler does not come back."""
        self._notify(f"lost the scheduler at {self._address}; looking for it")
        self.close()
        self._connect(self._patience)
        self._notify("found it again")

    def close(self, *, now: bool = False) -> None:  # noqa: ARG002
        """Let the workers go; what is handed out is cancelled, except for a piece that a worker is at."""
        client, self._client, self._asked, self._probed = self._client, None, None, None
        self._threads, self._fit = {}, set()
        if client is None:
            return
        try:
            client.close(timeout=2)
        except Exception:  # it is gone already, however
            return

    def _place(self) -> str:
        """The address itself, which a file may hold. Raises `OSError` or `ValueError`."""
        if not self._address.endswith(".json"):
            return self._address
        found = json.loads(Path(self._address).read_text(encoding="utf-8"))
        return str(found["address"] if isinstance(found, dict) and "address" in found else found)

    def _connect(self, patience: float) -> None:
        end = time.monotonic() + patience
        while True:
            try:
                self._client = _client(self._place())
                self._heard = time.monotonic() - _LOOK
            except ValueError as error:
                raise UsageError(f"--scheduler: must be an address like tcp://HOST:8786; {error}") from None
            except Exception:  # whatever answers there, or does not
                self.close()
                if time.monotonic() > end:
                    raise ComputationError(
                        f"no Dask scheduler at {self._address}; what is finished is kept, run the same command again"
                    ) from None
                time.sleep(0.5)
            else:
                return


async def _awaited(piece: Any) -> Done:
    """The result of a piece, raising what it raised.

    Not by the library's own executor: it asks how a piece has ended after its result has come, and if a worker leaves
    in between, takes the result for an error.
    """
    done: Done = await piece
    return done


def _answer(asked: "Future[dict[str, Any]]") -> dict[str, Any] | None:
    """What was answered; None if the connection was lost."""
    return None if asked.cancelled() or asked.exception() is not None else asked.result()


def _client(address: str) -> Any:
    """A client of the scheduler. Raises `TimeoutError` where one takes the call and says nothing.

    The library's own time-out ends with the first answer, so that it is left to wait in a thread.
    """
    from distributed import Client

    made: list[Any] = []
    given_up = Event()

    def make() -> None:
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # of other versions: each worker checks its own
                made.append(Client(address, timeout=_ANSWER, set_as_default=False))  # type: ignore[no-untyped-call]
        except BaseException as error:
            made.append(error)
        if given_up.is_set() and isinstance(made[0], Client):
            made[0].close(timeout=2)  # type: ignore[no-untyped-call]

    thread = Thread(target=make, daemon=True)
    thread.start()
    thread.join(2 * _ANSWER)
    if not made:
        given_up.set()
        raise TimeoutError
    if isinstance(made[0], BaseException):
        raise made[0]
    return made[0]


def _hush() -> None:
    """Say nothing of what libraries log; what matters is said here. Some of their loggers have levels of their own.

    Nor of a question that an interruption leaves unasked: the loop that would have asked it has ended.
    """
    warnings.filterwarnings("ignore", message="coroutine .* was never awaited", category=RuntimeWarning)
    mains = ("distributed", "tornado", "asyncio")
    for name in [*mains, *(name for name in logging.root.manager.loggerDict if name.startswith(mains))]:
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)


@lru_cache(maxsize=2)
def _recalled(work: bytes) -> Work:
    """The work as this worker knows it from the pieces before."""
    found: Work = pickle.loads(work)
    return found


def _do(work: bytes, start: int, stop: int) -> Done:
    return timed(_recalled(work), start, stop)
