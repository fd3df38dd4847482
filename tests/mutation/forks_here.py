"""The command in forks of this very process: what is changed in it is changed in the command, too."""

import json
import os
import select
import signal
import subprocess
import sys
import warnings
from collections.abc import Callable, Iterable
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any, NoReturn

from tests.forked import become, load

QUIET = (DeprecationWarning, PendingDeprecationWarning, ImportWarning, ResourceWarning)


class ForksHere:
    """As `tests.forked.Forks`; what runs notes in ``sys._mutation_calls`` comes back."""

    longest_s = float("inf")  # that a command may take

    def __init__(self, forget: Callable[[], None]) -> None:
        """``forget``: what a new process would not remember."""
        self._forget = forget
        load()

    def run(self, words: Iterable[str], *, cwd: Path, env: dict[str, str], timeout: float) -> tuple[int, str, str]:
        """Exit code, standard output and standard error. Raises `subprocess.TimeoutExpired`."""
        words = list(words)
        with TemporaryFile() as out, TemporaryFile() as err, TemporaryFile() as notes:
            child = os.fork()
            if child == 0:
                self._run(words, cwd, env, os.dup(out.fileno()), os.dup(err.fileno()), notes)
            ended = os.pidfd_open(child)
            if not select.select([ended], [], [], min(timeout, self.longest_s))[0]:
                os.kill(child, signal.SIGKILL)
            os.close(ended)
            status = os.waitpid(child, 0)[1]
            if status == signal.SIGKILL:
                raise subprocess.TimeoutExpired(words, timeout)
            for file in (out, err, notes):
                file.seek(0)
            for line in notes:
                for path, places in json.loads(line).items():
                    sys._mutation_calls[path].update(map(tuple, places))  # type: ignore[attr-defined]
            return os.waitstatus_to_exitcode(status), out.read().decode(), err.read().decode()

    def _run(self, words: list[str], cwd: Path, env: dict[str, str], out: int, err: int, notes: Any) -> NoReturn:
        leave = os._exit

        def note_and_leave(code: int) -> None:
            found = {path: sorted(places) for path, places in getattr(sys, "_mutation_calls", {}).items()}
            os.write(notes.fileno(), f"{json.dumps(found)}\n".encode())
            leave(code)

        code = 70
        try:
            for places in getattr(sys, "_mutation_calls", {}).values():
                places.clear()
            os._exit = note_and_leave  # type: ignore[assignment]
            nothing = os.open(os.devnull, os.O_RDONLY)
            os.dup2(nothing, 0)
            sys.stdin = open(0, closefd=False)  # noqa: SIM115
            sys.stdout, sys.stderr = (open(number, "w", closefd=False) for number in (1, 2))  # noqa: SIM115
            warnings.resetwarnings()
            for kind in QUIET:
                warnings.simplefilter("ignore", kind)
            self._forget()
            become(words, os.fspath(cwd), env, out, err)
        except SystemExit as leaving:
            code = leaving.code if isinstance(leaving.code, int) else 1
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(code)

    def end(self) -> None:
        """Nothing is left running."""
