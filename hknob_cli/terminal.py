"""Talking to the user: results on stdout, everything else on stderr, errors without tracebacks."""

import contextlib
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextvars import ContextVar
from types import FrameType

from hknob_cli import at_once
from hknob_cli.errors import ExitCode, HknobError, printable

LINE_EVERY = 30.0  # s between lines of progress where there is no terminal
LOOK_EVERY = 1.0  # s between looks at whether there has been a word
SILENT = 15.0  # s without a word, after which a line says how far the work is

Heard = Callable[[int, int, str], object]  # how much is done, of how much, of what
_listener: ContextVar[Heard | None] = ContextVar("listener", default=None)

_interrupted = False
_waiting = False
_spoken = 0.0  # when the last message was said
_speaker: Callable[[str], object] | None = None  # who says what this process has to say
_speaking_for = ""  # a name for what is done here


def interrupt(_signal: int, _frame: FrameType | None) -> None:
    """Signal handler: interrupt, and remember it, because code that a library calls back may lose the exception."""
    global _interrupted
    _interrupted = True
    if not _waiting:
        raise KeyboardInterrupt


@contextlib.contextmanager
def uninterrupted() -> Iterator[None]:
    """Let an interruption wait until the end of the block: for imports, which print or wrap what is raised in them."""
    global _waiting
    _waiting = True
    try:
        yield
    finally:
        _waiting = False
    heed()


def _say_unraisable(lost: "sys.UnraisableHookArgs") -> None:
    """What Python does with an exception that nobody can be told of; an interruption is remembered anyway."""
    if lost.exc_type is not KeyboardInterrupt:
        sys.__unraisablehook__(lost)


def heed() -> None:
    """Raise `KeyboardInterrupt` if there was an interruption that has not been heard."""
    if _interrupted:
        raise KeyboardInterrupt


def say(text: str) -> None:
    """A message, on stderr; as `tell`. In one write, so that lines of several processes do not mix."""
    global _spoken
    _spoken = time.monotonic()
    if _speaker is not None:
        _speaker(text)
        return
    print(f"{plain(text)}\n", end="", file=sys.stderr)


@contextlib.contextmanager
def speaking_for(name: str, speaker: Callable[[str], object]) -> Iterator[None]:
    """Let another process say what is said here, by ``speaker``: lines, with this name where they have none."""
    global _speaker, _speaking_for
    _speaker, _speaking_for = speaker, name
    try:
        yield
    finally:
        _speaker, _speaking_for = None, ""


def _has_bar() -> bool:
    """Whether there is a terminal that this process alone writes to."""
    return _speaker is None and sys.stderr.isatty()


def tell(text: str) -> None:
    """Results in words, on stdout."""
    print(plain(text))


def plain(text: str) -> str:
    """A text whose lines stay lines, and in which nothing steers a terminal: names may be from anywhere."""
    return "\n".join(map(printable, text.split("\n")))


@contextlib.contextmanager
def reporting() -> Iterator[None]:
    """Turn errors into one message and the exit code that stands for it.

    In the command's own process an interruption is then answered here; before and after, the process just ends.
    """
    ours = signal.getsignal(signal.SIGINT) is at_once.leave
    try:
        if ours:
            for one in (signal.SIGINT, signal.SIGTERM):
                signal.signal(one, interrupt)
            sys.unraisablehook = _say_unraisable
        yield
        heed()
    except HknobError as error:
        say(str(error))
        sys.exit(error.exit_code)
    except KeyboardInterrupt:
        if ours:
            at_once.listen()  # nobody asks for it twice because it was slow
        say(at_once.SAID)
        sys.exit(ExitCode.INTERRUPTED)
    except BrokenPipeError:  # nobody reads on
        sys.exit(ExitCode.FAILED)
    except OSError as error:
        say(f"{error.filename or 'output'}: {error.strerror or error}")
        sys.exit(ExitCode.FAILED)
    except MemoryError:
        say("out of memory; make the grid smaller or the phases fewer")
        sys.exit(ExitCode.FAILED)
    except Exception:
        if not _interrupted:
            raise
        say(at_once.SAID)  # code that a library called back lost the interruption, and then the library failed
        sys.exit(ExitCode.INTERRUPTED)
    finally:
        if ours:
            at_once.listen()


@contextlib.contextmanager
def listening(heard: Heard) -> Iterator[None]:
    """Let progress be told to ``heard``, wherever it would be shown or not: how much is done, of how much, of what."""
    before = _listener.set(heard)
    try:
        yield
    finally:
        _listener.reset(before)


@contextlib.contextmanager
def progress_bar(
    total: int,
    *,
    show: bool,
    what: str = "cells",
    long: bool = True,
    name: str = "",
    hint: str = "",
    clock: Callable[[], float] = time.monotonic,
) -> Iterator[Callable[[int, int], None]]:
    """Progress on stderr while ``what`` are computed, if ``show``: on a terminal a bar if the work is ``long``.

    Elsewhere a line where there has been no word for a while: how far the work of this ``name`` is, and once the
    ``hint``, if nothing more is done by the next such line. ``clock``: seconds, without those that are told of.
    """
    if heard := _listener.get():
        told = (0, total)
        heard(*told, what)

        def pass_on(done: int, total: int) -> None:
            nonlocal told
            told = (done, total)
            heard(*told, what)

        yield pass_on
        if told[0] < told[1]:
            heard(told[1], told[1], what)
        return
    if not show:
        yield lambda _done, _total: heed()
        return
    if not (long and _has_bar()):
        with _Murmur(total, what, name, hint, clock) as murmur:
            yield murmur.update
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(what, total=total)

        def update(done: int, total: int) -> None:
            heed()
            bar.update(task, completed=done, total=total)

        yield update


def _named(name: str = "") -> str:
    """How a line of progress begins."""
    name = name or _speaking_for
    return f"{name}: " if name else ""


class _Murmur:
    """Says how far some work is where nothing else has been said for a while; from a thread, for work is silent."""

    def __init__(self, total: int, what: str, name: str, hint: str, clock: Callable[[], float]) -> None:
        self._done, self._total, self._what = 0, total, what
        self._name, self._hint, self._clock = _named(name), hint, clock
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._murmur, daemon=True)

    def __enter__(self) -> "_Murmur":
        self._thread.start()
        return self

    def __exit__(self, *_error: object) -> None:
        self._ended.set()

    def update(self, done: int, total: int) -> None:
        """So much is done."""
        heed()
        self._done, self._total = done, total

    def _murmur(self) -> None:
        begin = mark = self._clock()
        heard, silent, before = _spoken, SILENT, -1
        while not self._ended.wait(LOOK_EVERY):
            now = self._clock()
            if heard != _spoken:
                heard, mark = _spoken, now
            if now - mark < silent:
                continue
            done = self._done
            of = f" of {self._total}" if self._total else ""
            say(f"{self._name}{done}{of} {self._what}, {now - begin:.0f} s")
            if self._hint and done == before:
                say(self._hint)
                self._hint = ""
            heard, silent, before, mark = _spoken, LINE_EVERY, done, now


@contextlib.contextmanager
def spread_progress(total: int, *, show: bool, done: int = 0, what: str = "cells") -> Iterator[Callable[[int], None]]:
    """Progress of long work, told how many more of ``what`` are there: with their rate, and the time left.

    On a terminal a bar; elsewhere a line now and then.
    """
    if heard := _listener.get():
        there = done
        heard(there, total, what)

        def hear(more: int) -> None:
            nonlocal there
            there += more
            heard(there, total, what)

        yield hear
        return
    if show and _has_bar():
        from rich.console import Console
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

        columns = (TextColumn(what), BarColumn(), MofNCompleteColumn(), TextColumn("{task.fields[pace]}"))
        with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
            task = bar.add_task(what, total=total, completed=done, pace="")
            rate = Rate(total, done)

            def update(more: int) -> None:
                rate.add(more)
                bar.update(task, completed=rate.done, pace=rate.text(what))

            yield update
        return
    rate = Rate(total, done)
    spoken = time.monotonic()

    def now_and_then(more: int) -> None:
        nonlocal spoken
        rate.add(more)
        if show and rate.done < total and time.monotonic() - spoken > LINE_EVERY:
            spoken = time.monotonic()
            say(_named() + ", ".join(filter(None, (f"{rate.done} of {total} {what}", rate.text(what)))))

    yield now_and_then


class Rate:
    """How fast work goes on, over the last minute or so, and how long the rest will take at that."""

    def __init__(self, total: int, done: int) -> None:
        self.total = total
        self.done = done
        self._marks = [(time.monotonic(), done)]

    def add(self, more: int) -> None:
        """So many more are done."""
        self.done += more
        now = time.monotonic()
        if now - self._marks[-1][0] > 1.0:
            self._marks = [*self._marks[-60:], (now, self.done)]

    def text(self, what: str) -> str:
        """The rate, and the time left."""
        begin, before = self._marks[0]
        seconds = time.monotonic() - begin
        if seconds < 1.0 or self.done == before:
            return ""
        rate = (self.done - before) / seconds
        left = round((self.total - self.done) / rate)
        hours, minutes = divmod(left // 60, 60)
        clock = f"{hours}:{minutes:02d}:{left % 60:02d}" if hours else f"{minutes}:{left % 60:02d}"
        return f"{rate:,.4g} {what}/s, {clock} left" if rate < 1000 else f"{rate:,.0f} {what}/s, {clock} left"
