"""From the parsed command line to the work, in two processes at once.

Parsing and validating a spec loads one half of the libraries (typer, pydantic, ruamel.yaml), the work the other (numpy,
pyarrow, the engine), and for a small grid loading is most of the time. So a child parses while this process loads; the
child then hands the job over, or prints what is wrong and ends. On one core, or where processes cannot fork, the job is
simply run where it was parsed.
"""

import contextlib
import os
import signal
import sys
from collections.abc import Callable
from importlib import import_module
from typing import TYPE_CHECKING, BinaryIO

from hknob_cli.stage_table import STAGES

if TYPE_CHECKING:
    from hknob_cli.stages.job import Job

# What the work of every stage needs beside its own module.
_ALSO = ("hknob_cli.cli.stage_run", "filelock", "numpy.ma")  # the last is what pyarrow loads to make an array

_pipe: BinaryIO | None = None


def submit(job: "Job") -> None:
    """Run a job: here, or in the process that waits for it."""
    if _pipe is None:
        from hknob_cli.cli.stage_run import run_stage

        run_stage(job)
        return
    import pickle

    with _pipe:
        pickle.dump(job, _pipe)
    os._exit(0)


def pays(arguments: list[str]) -> bool:
    """Whether this command line is worth two processes."""
    if not arguments or arguments[0] not in STAGES or not hasattr(os, "fork"):
        return False
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return cores > 1 and not {"-h", "--help"} & set(arguments)


def parse_and_run(parse: Callable[[], object], command: str) -> int:
    """Let a child ``parse`` while this process loads what ``command`` needs, then run the job; the exit code.

    The child is this process's own copy: its pickle is as trustworthy as a variable.
    """
    from hknob_cli.terminal import reporting

    try:
        with reporting():
            child, read = _fork(parse)
            try:
                handed = _load_and_wait((STAGES[command].work.partition(":")[0], *_ALSO), read)
                if not handed:
                    _, status = os.waitpid(child, 0)
                    child = 0
                    return _ended(os.waitstatus_to_exitcode(status))
            finally:
                _end(child)
            _run(handed)
    except SystemExit as leaving:
        return int(leaving.code or 0)
    return 0


def _fork(parse: Callable[[], object]) -> tuple[int, int]:
    """Start the parsing child: its process, and the end of the pipe that it hands the job to.

    Signals wait until both sides know what to do with them: the child leaves an interruption to this process.
    """
    global _pipe
    both = {signal.SIGINT, signal.SIGTERM}
    read, write = os.pipe()
    signal.pthread_sigmask(signal.SIG_BLOCK, both)
    child = os.fork()
    if child == 0:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, both)
        os.close(read)
        _pipe = os.fdopen(write, "wb")
        try:
            parse()
        finally:  # a fault of the program; it must not go on as if it were the other process
            sys.excepthook(*sys.exc_info())
            os._exit(1)
    os.close(write)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, both)
    return child, read


def _end(child: int) -> None:
    """Make sure that the child is gone, and says nothing after this process has spoken."""
    if child:
        with contextlib.suppress(ProcessLookupError, ChildProcessError):
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)


def _ended(code: int) -> int:
    """The exit code of a child that found no work, if it has one.

    Raises `KeyboardInterrupt` where it, or this process, was told to stop (of a signal to both it may hear first, and
    an import may lose this one's), and `ComputationError` where it was ended otherwise.
    """
    from hknob_cli.errors import ComputationError
    from hknob_cli.terminal import heed

    heed()
    if code == -signal.SIGTERM:
        raise KeyboardInterrupt
    if code < 0:
        raise ComputationError(
            f"the process that reads the command line was ended by signal {-code}; run the same command again"
        )
    return code


def _load_and_wait(modules: tuple[str, ...], read: int) -> bytes:
    """Load what the work needs, then read what the child hands over; nothing if it found no work."""
    from hknob_cli.terminal import uninterrupted

    for module in modules:
        with uninterrupted():
            import_module(module)
    from hknob_cli.results.versions import computing_versions

    computing_versions()  # is kept: any stage asks for it, when nothing can be done beside it
    with os.fdopen(read, "rb") as pipe:
        return pipe.read()


def _run(handed: bytes) -> None:
    import pickle

    from hknob_cli.cli.stage_run import run_stage

    run_stage(pickle.loads(handed))
