"""What is being compiled of the engine, how far it is, and how long it took: told as it goes, never where it is kept.

Numba compiles a function, and before it all that it calls, when it is first called and not in the cache.
"""

from collections.abc import Callable
from time import monotonic
from typing import Any

# Processor seconds that compiling a group of `engine.jit` takes (two cores, 2026): a rough guide.
COMPILING_S = {
    "plain": 7.0,
    "cells": 8.0,
    "arc_cells": 10.0,
    "bounces": 1.0,
    "general": 14.0,
    "clocks": 3.0,
    "laws": 19.0,
    "sets": 9.0,
    "general sets": 20.0,
    "friction sets": 28.0,
    "friction arcs": 25.0,
    "cogging sets": 35.0,
    "unsampled": 5.0,
    "pulse": 2.0,
}
EVERY_S = 10.0  # between two lines on how far it is

_told: list[Callable[[str], None]] = []
_heard: list["_Compiling"] = []  # one, where anybody listens


def tell_compiling(notify: Callable[[str], None]) -> None:
    """Let ``notify`` be told, instead of whoever was before."""
    _told[:] = [notify]


def tell(text: str) -> None:
    """Tell whoever is told."""
    for notify in _told:
        notify(text)


def listen() -> None:
    """Hear what numba compiles from now on."""
    if _heard:
        return
    from numba.core import event

    heard = _Compiling()

    class Listener(event.Listener):
        def on_start(self, event: Any) -> None:
            if _is_ours(event.data["dispatcher"]):
                heard.start(event.data["dispatcher"])

        def on_end(self, event: Any) -> None:
            if _is_ours(event.data["dispatcher"]):
                heard.end(event.data["dispatcher"])

    event.register("numba:compile", Listener())  # type: ignore[no-untyped-call]
    _heard.append(heard)


def compiling_s() -> float:
    """Seconds that this process has spent compiling so far, what is being compiled included."""
    return _heard[0].seconds if _heard else 0.0


def working_clock() -> float:
    """Seconds on a clock that stands still while the engine is compiled."""
    return monotonic() - compiling_s()


def _is_ours(dispatcher: Any) -> bool:
    return str(dispatcher.py_func.__module__).startswith("hknob_cli.engine.")


def left_to_compile(dispatcher: Any) -> int:
    """Functions of the engine that are compiled with this one, itself included: those that are not compiled yet."""
    seen: dict[int, Any] = {}
    waiting = [dispatcher]
    while waiting:
        one = waiting.pop()
        if id(one) in seen or one.signatures:
            continue
        seen[id(one)] = one
        called = (one.py_func.__globals__.get(name) for name in one.py_func.__code__.co_names)
        waiting += [other for other in called if hasattr(other, "signatures")]
    return len(seen)


class _Compiling:
    """Hears where the compilation of a function begins and ends."""

    def __init__(self) -> None:
        self.depth, self.all = 0, 0
        self.done: set[int] = set()  # a function may be compiled more than once, for other types
        self.begun = self.spoken = self.before = 0.0

    @property
    def seconds(self) -> float:
        """Of all that was compiled."""
        return self.before + (monotonic() - self.begun if self.depth else 0.0)

    def start(self, dispatcher: Any) -> None:
        """A function begins to be compiled."""
        if self.depth == 0:
            self.done, self.all = set(), left_to_compile(dispatcher)
            self.begun = self.spoken = monotonic()
            tell(f"compiling the engine for this machine: {_functions(self.all)}")
        self.depth += 1

    def end(self, dispatcher: Any) -> None:
        """A function is compiled."""
        self.depth -= 1
        self.done.add(id(dispatcher))
        now = monotonic()
        if self.depth == 0:
            self.before += now - self.begun
            tell(f"compiled {_functions(len(self.done))} in {now - self.begun:.1f} s")
        elif now - self.spoken > EVERY_S:
            # Some functions are called by address, and not foreseen.
            self.spoken, self.all = now, max(self.all, len(self.done) + 1)
            tell(f"compiling: {len(self.done)} of {_functions(self.all)}, {now - self.begun:.0f} s")


def _functions(count: int) -> str:
    return f"{count} function{'' if count == 1 else 's'}"
