"""Talking to the user: results on stdout, everything else on stderr, errors without tracebacks."""

import contextlib
import sys
from collections.abc import Callable, Iterator
from types import FrameType
from typing import NoReturn

from hknob_cli.errors import ExitCode, HknobError

_interrupted = False


def interrupt(_signal: int, _frame: FrameType | None) -> NoReturn:
    """Signal handler: interrupt, and remember it, for code that a library calls back may lose the exception."""
    global _interrupted
    _interrupted = True
    raise KeyboardInterrupt


def heed() -> None:
    """Raise `KeyboardInterrupt` if there was an interruption that has not been heard."""
    if _interrupted:
        raise KeyboardInterrupt


def say(text: str) -> None:
    """A message, on stderr."""
    print(text, file=sys.stderr)


@contextlib.contextmanager
def reporting() -> Iterator[None]:
    """Turn errors into one message and the exit code that stands for it."""
    try:
        yield
    except HknobError as error:
        say(str(error))
        sys.exit(error.exit_code)
    except KeyboardInterrupt:
        say("interrupted; finished files are kept, run the same command again")
        sys.exit(ExitCode.INTERRUPTED)
    except BrokenPipeError:  # nobody reads on
        sys.exit(ExitCode.FAILED)
    except OSError as error:
        say(f"{error.filename or 'output'}: {error.strerror or error}")
        sys.exit(ExitCode.FAILED)
    except MemoryError:
        say("out of memory; make the grid smaller or the phases fewer")
        sys.exit(ExitCode.FAILED)


@contextlib.contextmanager
def progress_bar(total: int, *, show: bool, what: str = "cells") -> Iterator[Callable[[int, int], None]]:
    """Progress on stderr while ``what`` are computed, if ``show`` and stderr is a terminal."""
    if not show or not sys.stderr.isatty():
        yield lambda _done, _total: heed()
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(what, total=total)

        def update(done: int, _total: int) -> None:
            heed()
            bar.update(task, completed=done)

        yield update
