"""A Dask cluster on the loopback: a scheduler and workers as processes, to be killed and begun again."""

import os
import random
import signal
import socket
import subprocess
import sys
from contextlib import ExitStack
from pathlib import Path

ROOT = Path(__file__).parents[2]
SLOW = Path(__file__).with_name("slow_worker.py")


def free_port() -> int:
    """A port that nothing listens at."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


class LocalCluster:
    """A scheduler at ``address``, and workers of one thread each."""

    def __init__(self, log: Path) -> None:
        self.port = free_port()
        self.address = f"tcp://127.0.0.1:{self.port}"
        self.log = log
        self.scheduler: subprocess.Popen[bytes] | None = None
        self.workers: list[subprocess.Popen[bytes]] = []
        self.odd: list[subprocess.Popen[bytes]] = []  # those that a test has begun in another way

    def __enter__(self) -> "LocalCluster":
        return self

    def __exit__(self, *_: object) -> None:
        for process in [*self.workers, *self.odd, self.scheduler]:
            self.end(process)

    @staticmethod
    def end(process: subprocess.Popen[bytes] | None) -> None:
        """Kill a process, and what it has begun."""
        if process is not None:
            with ExitStack() as stack:
                stack.callback(process.wait)
                try:
                    os.killpg(process.pid, signal.SIGKILL)
                except ProcessLookupError:
                    return

    def begin_scheduler(self, **env: str) -> None:
        """Begin the scheduler, at the same address each time."""
        options = ("--host", "127.0.0.1", "--port", self.port, "--no-dashboard")
        self.scheduler = self._start("scheduler", *options, **env)

    def begin_worker(self, *, slow: bool = True, **env: str) -> subprocess.Popen[bytes]:
        """Begin a worker; without a nanny, so that a kill leaves nothing."""
        options = ("--nthreads", 1, "--no-nanny", "--no-dashboard", *(("--preload", SLOW) if slow else ()))
        return self._start("worker", self.address, *options, **env)

    def begin_odd_worker(self, *, slow: bool = False, **env: str) -> None:
        """Begin one of another kind, which `mend` ends."""
        self.odd.append(self.begin_worker(slow=slow, **env))

    def mend(self, workers: int, **env: str) -> None:
        """Make sure of a scheduler, and of as many workers; others are ended."""
        for process in self.odd:
            self.end(process)
        self.odd.clear()
        if self.scheduler is None or self.scheduler.poll() is not None:
            self.begin_scheduler()
        alive = [worker for worker in self.workers if worker.poll() is None]
        for worker in alive[workers:]:
            self.end(worker)
        self.workers = alive[:workers]
        while len(self.workers) < workers:
            self.workers.append(self.begin_worker(**env))

    def kill_a_worker(self, chance: random.Random) -> None:
        """Kill any of the workers."""
        self.workers = [worker for worker in self.workers if worker.poll() is None]
        if self.workers:
            self.end(self.workers.pop(chance.randrange(len(self.workers))))

    def busy(self) -> bool:
        """Whether the scheduler knows of any work."""
        from distributed import Client

        with Client(self.address, set_as_default=False) as client:
            return any(client.processing().values())

    def _start(self, what: str, *options: object, **env: str) -> subprocess.Popen[bytes]:
        with self.log.open("ab") as log:
            return subprocess.Popen(
                [sys.executable, "-m", "dask", what, *map(str, options)],
                stdout=log,
                stderr=log,
                stdin=subprocess.DEVNULL,
                start_new_session=True,
                cwd=self.log.parent,
                env={**os.environ, "PYTHONPATH": str(ROOT), "DASK_DISTRIBUTED__WORKER__DAEMON": "True", **env},
            )
