"""Signals that wait until the torque is off."""

import contextlib
import signal
import threading
from collections.abc import Iterator

_INTERRUPTING = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))


@contextlib.contextmanager
def undisturbed() -> Iterator[None]:
    """Put off what interrupts, where this thread would hear it.

    By handlers: a mask is this thread's alone, and another, of a driver or a library, would take the signal for it.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    heard: list[int] = []
    before = {kind: signal.signal(kind, lambda number, _frame: heard.append(number)) for kind in _INTERRUPTING}
    try:
        yield
    finally:
        for kind, handler in before.items():
            signal.signal(kind, signal.SIG_DFL if handler is None else handler)
        for number in dict.fromkeys(heard):
            signal.raise_signal(number)
