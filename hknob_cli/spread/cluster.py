"""Workers of a Dask cluster, behind the interface of `concurrent.futures`."""

import json
import logging
import pickle
import time
import warnings
from collections.abc import Callable
from concurrent.futures import CancelledError, Future
from functools import lru_cache
from pathlib import Path
from typing import Any

from hknob_cli.errors import ComputationError, UsageError
from hknob_cli.spread.processes import Done, Work, timed

PATIENCE = 60.0  # s to look for a scheduler that was there before
FIRST = 10.0  # s to look for one that was not
_LOOK = 2.0  # s between two looks at how many workers there are


class Cluster:
    """The workers of the scheduler at ``address``, or in that JSON file of it; each has this program of this version.

    A piece whose worker dies is done again by the scheduler, on another; a scheduler that goes and comes back costs
    what was handed out.
    """

    fragile = False

    def __init__(self, work: Work, address: str, notify: Callable[[str], None], *, patience: float = PATIENCE) -> None:
        """Connect. Raises `UsageError` without the library, `ComputationError` if there is no scheduler."""
        try:
            from distributed import KilledWorker
            from distributed.comm.core import CommClosedError
        except ImportError:
            raise UsageError("--executor dask: needs hknob[dask]: pip install 'hknob[dask]'") from None
        _hush()
        self.deadly: tuple[type[BaseException], ...] = (MemoryError, KilledWorker)
        self.lost: tuple[type[BaseException], ...] = (CancelledError, CommClosedError, TimeoutError)
        self._work = pickle.dumps(work)
        self._address = address
        self._notify = notify
        self._patience = patience
        self._looked = -_LOOK
        self._count = 1
        self._lonely = False
        self._client: Any = None
        self._connect(FIRST)

    @property
    def count(self) -> int:
        """Threads of all workers; 1 where there are none yet."""
        if time.monotonic() - self._looked > _LOOK:
            self._looked = time.monotonic()
            try:
                found = sum(self._client.nthreads().values())
            except Exception:  # the connection is about to be given up; `submit` will say so
                found = self._count
            if not found and not self._lonely:
                self._notify(f"no worker at {self._address} yet; waiting")
            self._lonely = not found
            self._count = max(1, found)
        return self._count

    def submit(self, start: int, stop: int) -> "Future[Done]":
        """Hand out items ``start`` to ``stop``. Raises `CancelledError` if the scheduler is gone."""
        if self._client.status != "running":
            raise CancelledError
        future: Future[Done] = self._executor.submit(_do, self._work, start, stop)
        return future

    def renew(self) -> None:
        """Connect again. Raises `ComputationError` if the scheduler does not come back."""
        self._notify(f"lost the scheduler at {self._address}; looking for it")
        self.close()
        self._connect(self._patience)
        self._notify("found it again")

    def close(self, *, now: bool = False) -> None:  # noqa: ARG002
        """Let the workers go; what is handed out is cancelled, but for a piece that a worker is at."""
        client, self._client = self._client, None
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
        from distributed import Client

        end = time.monotonic() + patience
        while True:
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")  # of other versions: each worker checks its own
                    self._client = Client(self._place(), timeout=5, set_as_default=False)  # type: ignore[no-untyped-call]
                self._executor = self._client.get_executor(pure=False)
            except (OSError, TimeoutError, ValueError) as error:
                self.close()
                if isinstance(error, ValueError):
                    raise UsageError(f"--scheduler: must be an address like tcp://HOST:8786; {error}") from None
                if time.monotonic() > end:
                    raise ComputationError(
                        f"no Dask scheduler at {self._address}; what is finished is kept, run the same command again"
                    ) from None
                time.sleep(0.5)
            else:
                return


def _hush() -> None:
    """Say nothing of what libraries log; what matters is said here. Some of their loggers have levels of their own."""
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
