"""From the parsed command line to the work, in two processes at once.

Parsing and validating a spec loads one half of the libraries (typer, pydantic, ruamel.yaml), the work the other (numpy,
pyarrow, the engine), and for a small grid loading is most of the time. So a child parses while this process loads; the
child then hands the job over, or prints what is wrong and ends. On one core, or where processes cannot fork, the job is
simply run where it was parsed.
"""

import os
import signal
import sys
from collections.abc import Callable
from importlib import import_module
from typing import BinaryIO, Protocol

# What the work of a subcommand needs, to be loaded ahead.
AHEAD = {
    kind: (f"hknob_cli.cli.{kind}_work", "hknob_cli.cli.stage_run", "filelock") for kind in ("sweep", "dfa", "predict")
}

_pipe: BinaryIO | None = None


class Runnable(Protocol):
    """A validated piece of work, which can be pickled."""

    def run(self) -> None:
        """Do it; print results on stdout. Raises `HknobError`."""


def submit(job: Runnable) -> None:
    """Run a job: here, or in the process that waits for it."""
    if _pipe is None:
        job.run()
        return
    import pickle

    with _pipe:
        pickle.dump(job, _pipe)
    os._exit(0)


def pays(arguments: list[str]) -> bool:
    """Whether this command line is worth two processes."""
    if not arguments or arguments[0] not in AHEAD or not hasattr(os, "fork"):
        return False
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return cores > 1 and not {"-h", "--help"} & set(arguments)


def parse_and_run(parse: Callable[[], object], command: str) -> int:
    """Let a child ``parse`` while this process loads what ``command`` needs, then run the job; the exit code.

    The child is this process's own copy: its pickle is as trustworthy as a variable.
    """
    global _pipe
    read, write = os.pipe()
    child = os.fork()
    if child == 0:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # the waiting process speaks for both
        os.close(read)
        _pipe = os.fdopen(write, "wb")
        parse()
        raise AssertionError("parsing always ends the process")
    os.close(write)
    from hknob_cli.cli.console import reporting

    try:
        with reporting():
            handed = _load_and_wait(AHEAD[command], read)
            if not handed:
                _, status = os.waitpid(child, 0)
                return os.waitstatus_to_exitcode(status)
            _unpickled(handed).run()
    except SystemExit as leaving:
        return int(leaving.code or 0)
    except BrokenPipeError:
        sys.stdout = open(os.devnull, "w")  # noqa: SIM115, PTH123  # nobody reads on; let the last flush succeed
        return 1
    return 0


def _load_and_wait(modules: tuple[str, ...], read: int) -> bytes:
    """Load what the work needs, then read what the child hands over; nothing if it found no work."""
    for module in modules:
        import_module(module)
    with os.fdopen(read, "rb") as pipe:
        return pipe.read()


def _unpickled(handed: bytes) -> Runnable:
    import pickle

    job: Runnable = pickle.loads(handed)
    return job
