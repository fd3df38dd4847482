"""Stages of a pipeline side by side: those that need nothing of one another, each by one of a few processes.

pytask asks for one stage after another. While it waits for one, others are made too, if they have to be made anyway: a
result of theirs is missing, and all that they need is there. What was made before pytask asks is then at hand. A stage
that nothing can be made beside is made in this process, and so is one that must have the machine for itself.
"""

import contextlib
import pickle
import signal
import sys
import traceback
from collections.abc import Callable, Iterable
from math import ceil
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from threading import Lock
from types import FrameType
from typing import Any, NamedTuple

from hknob_cli import terminal
from hknob_cli.errors import ComputationError, HknobError
from hknob_cli.spread.forks import usable_cores
from hknob_cli.spread.processes import begin_worker, beginning

MOST = 8  # stages at the same time: each has libraries and results of its own in memory

Said = Callable[[str, str], None]


class Task(NamedTuple):
    """A stage to make: what it ``needs`` by name, and how it is made by so many processes.

    ``run`` says whether anything was computed, and what is to be said of it; ``missing``: whether it has to be made,
    whatever else is found; ``alone``: whether nothing may be made beside it.
    """

    needs: frozenset[str]
    run: Callable[[int | None], tuple[bool, str]]
    missing: Callable[[], bool]
    alone: bool


class _Worker(NamedTuple):
    process: BaseProcess
    pipe: "Connection[Any, Any]"


class SideBySide:
    """Makes tasks by ``jobs`` processes, as many as there are cores if None, at most `MOST`; ends them on leaving.

    ``said`` is told, of each stage, when it begins (an empty text) and what became of it.
    """

    def __init__(self, jobs: int | None, said: Said, *, spread: bool = True) -> None:
        """Make ready; without ``spread`` everything is made in this process."""
        self.tasks: dict[str, Task] = {}  # in the order in which they are begun where several can be
        self._jobs, self._said = jobs, said
        forks = sys.platform == "linux"  # elsewhere that is unsafe, and tasks cannot be handed to another process
        self._most = min(MOST, jobs or usable_cores()) if spread and forks else 1
        # Processes of a stage's own: twice its share of the cores, because one is often left without others beside it.
        self._share = ceil(2 * (jobs or usable_cores()) / self._most)
        self._asked: set[str] = set()
        self._begun: set[str] = set()
        self._made: dict[str, tuple[bool, BaseException | None]] = {}
        self._idle: list[_Worker] = []
        self._busy: dict[Connection[Any, Any], tuple[_Worker, str]] = {}

    def __enter__(self) -> "SideBySide":
        """Nothing is begun yet."""
        return self

    def __exit__(self, kind: object, *_: object) -> None:
        """End the processes, after an interruption in the middle of their work, of which they keep what they can."""
        working = [worker for worker, _ in self._busy.values()]
        for worker in working:
            worker.process.terminate()
        for worker in self._idle:
            with contextlib.suppress(OSError):  # it is gone
                worker.pipe.send(None)
        for worker in (*working, *self._idle):
            worker.process.join()
            worker.pipe.close()
        self._busy, self._idle = {}, []

    def make(self, name: str) -> bool:
        """Make a stage of which all that it needs is there, or take what was made: whether anything was computed.

        Raises what its work raises.
        """
        self._asked.add(name)
        while name not in self._made:
            terminal.heed()
            ready = [one for one in self.tasks if self._is_ready(one)]
            if not self._busy and name in ready and (self._most == 1 or self.tasks[name].alone or ready == [name]):
                return self._make_here(name)
            if not (name in ready and self.tasks[name].alone):
                self._begin(ready)
            self._take()
        computed, error = self._made[name]
        if error is not None:
            raise error
        return computed

    def _is_ready(self, name: str) -> bool:
        """Whether a stage can be begun, and has to be."""
        task = self.tasks[name]
        if name in self._begun:
            return False
        if name in self._asked:
            return True
        there = all(self._is_there(one) for one in task.needs)
        return there and not task.alone and task.missing()

    def _is_there(self, name: str) -> bool:
        """Whether a stage was made in this run, without an error."""
        return name in self._made and self._made[name][1] is None

    def _make_here(self, name: str) -> bool:
        self._begun.add(name)
        self._said(name, "")
        computed, text = self.tasks[name].run(self._jobs)
        self._made[name] = computed, None
        self._said(name, text)
        return computed

    def _begin(self, ready: Iterable[str]) -> None:
        """Hand out what can be begun, to processes that are idle."""
        for name in ready:
            if self.tasks[name].alone or len(self._busy) == self._most:
                continue
            worker = self._idle.pop() if self._idle else self._new()
            self._begun.add(name)
            self._said(name, "")
            self._busy[worker.pipe] = worker, name
            with contextlib.suppress(OSError):  # it died with nothing to do, which is seen where it should answer
                worker.pipe.send((name, self._share))

    def _new(self) -> _Worker:
        """Another process. Raises `ComputationError` where there may not be so many."""
        context = get_context("fork")
        here, there = context.Pipe()
        process = context.Process(target=_serve, args=(there, self.tasks))
        try:
            with beginning():
                process.start()
        except OSError as error:
            raise ComputationError(f"no process can be begun: {error.strerror or error}; try --jobs 1") from None
        there.close()
        return _Worker(process, here)

    def _take(self) -> None:
        """Wait until a process says something, and take it in."""
        for pipe in wait(list(self._busy)):
            assert isinstance(pipe, Connection)
            worker, name = self._busy[pipe]
            try:
                kind, answer = pickle.loads(pipe.recv_bytes())
            except (EOFError, OSError):
                del self._busy[pipe]
                worker.process.join()
                pipe.close()
                self._again(name)
                continue
            if kind == _SAYS:
                terminal.say(answer)
                continue
            del self._busy[pipe]
            self._idle.append(worker)
            if kind == _FAILED and isinstance(answer, MemoryError):
                self._again(name)
            elif kind == _FAILED:
                self._made[name] = False, answer
            else:
                computed, text = answer
                self._made[name] = computed, None
                self._said(name, text)

    def _again(self, name: str) -> None:
        """Let a stage that memory did not suffice for have it all: it is made here, when it is asked for."""
        self._begun.discard(name)
        self.tasks[name] = self.tasks[name]._replace(alone=True)


_SAYS, _FAILED, _MADE = range(3)


def _serve(pipe: "Connection[Any, Any]", tasks: dict[str, Task]) -> None:
    """In the process: make what comes, say what there is to say through the parent, and answer."""
    begin_worker()
    signal.signal(signal.SIGTERM, _interrupt)
    lock = Lock()  # a thread tells of progress

    def answer(kind: int, what: Any) -> None:
        with lock, contextlib.suppress(OSError):  # the parent is gone
            pipe.send_bytes(pickle.dumps((kind, what)))

    with contextlib.suppress(EOFError, OSError, KeyboardInterrupt):
        while asked := pipe.recv():
            name, jobs = asked
            try:
                with terminal.speaking_for(name, lambda text: answer(_SAYS, text)):
                    made = tasks[name].run(jobs)
            except Exception as error:  # whatever it is, it is the parent's to raise
                answer(_FAILED, _portable(error))
            else:
                answer(_MADE, made)


def _portable(error: Exception) -> Exception:
    """An error as another process can be told of it; of a fault of the program, with where it was."""
    if not isinstance(error, HknobError | MemoryError):
        error.add_note(traceback.format_exc())
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:  # one whose class wants more than it was given
        return ComputationError(f"{type(error).__name__}: {error}")
    return error


def _interrupt(number: int, frame: FrameType | None) -> None:
    """Signal handler: interrupt the stage, once."""
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    terminal.interrupt(number, frame)
