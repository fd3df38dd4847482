"""One command in this process, as the installed program runs it, and what about it must not be."""

import contextlib
import io
import os
import pickle
import signal
import sys
import time
import traceback
from collections.abc import Iterator
from functools import cache
from types import FrameType
from typing import Any, NamedTuple

from hknob_cli.errors import ExitCode
from tests.fuzz.arena import Arena
from tests.fuzz.watch import outside

LIMIT_S = 10.0  # of a processor
IDLE_LIMIT_S = 40.0  # of waiting for one, or for what never comes
MOST_COMPILING = 12
COMPILING = "still compiling"  # the engine, once for this machine; tried again, it goes on where it was


class Hang(BaseException):
    """The time is up. Not an `Exception`, which code may take for its own."""


class Attempt(NamedTuple):
    """A command, what it gave, and its ``breaches``: (rule, detail) of what must not be."""

    command: tuple[str, ...]
    code: int | None
    out: str
    err: str
    seconds: float
    breaches: tuple[tuple[str, str], ...]


def attempt(arena: Arena, *command: str, may_write: bool = False) -> Attempt:
    """Run a command of ``hknob``; ``may_write``: into the arena's ``out``, where nothing stays after a usage error."""
    out, err = _Stream(), _Stream()
    breaches: list[tuple[str, str]] = []
    code: int | None = None
    begin, worked = time.perf_counter(), time.process_time()
    with arena.watch.listening() as heard, contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            with _limited():
                code = _run(list(command))
        except Hang as hang:
            breaches.append((COMPILING if _is_compiling(hang) else "hang", _place(hang)))
        except Exception as error:
            late = time.process_time() - worked > LIMIT_S and _is_compiling(error)  # the compiler may lose a `Hang`
            what = f"{type(error).__name__} at {_place(error)}: {error}"[:500]
            breaches.append((COMPILING if late else "traceback", what))
    seconds, worked = time.perf_counter() - begin, time.process_time() - worked
    said = out.text(), err.text()
    if code is not None:
        breaches += _of_streams(code, *said)
    if worked > LIMIT_S and not any(rule in ("hang", COMPILING) for rule, _ in breaches):
        breaches.append(("hang", f"{worked:.1f} s"))
    places = (*arena.caches, *([arena.out] if may_write else []))
    breaches += [("write", path) for path in outside(heard, places)[:3]]
    breaches += [("left", name) for name in arena.left()[:3]]
    if code == ExitCode.USAGE and arena.out.exists():
        breaches.append(("left", "the folder of results, after a usage error"))
    return Attempt(command, code, *said, seconds, tuple(breaches))


def settled(arena: Arena, *command: str, may_write: bool = False) -> Attempt:
    """The attempt; once more, as often as it takes, while the engine is being compiled for this machine."""
    done = attempt(arena, *command, may_write=may_write)
    for _ in range(MOST_COMPILING):
        if not any(rule == COMPILING for rule, _ in done.breaches):
            break
        arena.clear_out()
        done = attempt(arena, *command, may_write=may_write)
    return done


class _Stream(io.TextIOWrapper):
    """Standard output or error, kept."""

    def __init__(self) -> None:
        super().__init__(io.BytesIO(), encoding="utf-8", errors="backslashreplace", write_through=True)

    def text(self) -> str:
        """What was written."""
        self.flush()
        return self.buffer.getvalue().decode()  # type: ignore[attr-defined]


def _run(arguments: list[str]) -> int:
    """The command's exit code; a job goes through a pickle, as from the process that parses to the one that works."""
    from hknob_cli.cli import app as commands
    from hknob_cli.cli.stage_run import run_stage
    from hknob_cli.terminal import reporting

    def submit(job: Any) -> None:
        run_stage(pickle.loads(pickle.dumps(job)))

    before, commands.submit = commands.submit, submit  # type: ignore[attr-defined]
    try:
        with reporting():
            _command()(arguments, prog_name="hknob")
    except SystemExit as leaving:
        if leaving.code is None or isinstance(leaving.code, int):
            return int(leaving.code or 0)
        print(leaving.code, file=sys.stderr)
        return 1
    finally:
        commands.submit = before  # type: ignore[attr-defined]
    return 0


@cache
def _command() -> Any:
    """What ``hknob`` calls, built once: that takes longer than to check a spec."""
    from typer.main import get_command

    from hknob_cli.cli.app import app

    return get_command(app)


@contextlib.contextmanager
def _limited() -> Iterator[None]:
    begin, worked = time.monotonic(), time.process_time()

    def ring(_signal: int, _frame: FrameType | None) -> None:
        # On a machine with more to do, the time counts that it would have taken alone.
        if time.process_time() - worked > LIMIT_S or time.monotonic() - begin > IDLE_LIMIT_S:
            raise Hang

    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, LIMIT_S, 1.0)  # again, for what loses the first
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def _of_streams(code: int, out: str, err: str) -> Iterator[tuple[str, str]]:
    if code not in {int(one) for one in ExitCode}:
        yield "exit code", str(code)
    if "Traceback (most recent" in out + err:
        yield "traceback", "printed"
    for name, text in (("stdout", out), ("stderr", err)):
        odd = next((letter for letter in text if not (letter.isprintable() or letter == "\n")), None)
        if odd is not None:
            at = text.index(odd)
            yield "unprintable", f"{name}: {text[max(0, at - 60) : at + 20]!r}"
    if code == ExitCode.USAGE and (out or not err.strip()):
        yield "silent or torn", f"exit {code} with {out[:80]!r} on stdout, {err[:80]!r} on stderr"


def _is_compiling(error: BaseException) -> bool:
    return any(f"{os.sep}numba{os.sep}" in frame.filename for frame in traceback.extract_tb(error.__traceback__))


def _place(error: BaseException) -> str:
    """The innermost line of this package that an error went through, and the function."""
    frames = traceback.extract_tb(error.__traceback__)
    ours = [frame for frame in frames if f"{os.sep}hknob_cli{os.sep}" in frame.filename]
    frame = (ours or frames)[-1]
    return f"{frame.filename.rpartition('hknob_cli' + os.sep)[2]}:{frame.lineno} in {frame.name}"
