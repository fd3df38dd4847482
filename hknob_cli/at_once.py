"""An interruption before there is any work, or when it is done: the process ends at once, and says so in one line.

What works takes over the signals for as long as it does (`terminal.reporting`). Loads nothing: it is the first that the
command does, and `signal` alone would take longer to load.
"""

import _signal  # type: ignore[import-not-found]  # a module of Python's own
import os

SAID = "interrupted; finished files are kept, run the same command again"
_SIGNALS = (_signal.SIGINT, _signal.SIGTERM)


def leave(_number: int, _frame: object) -> None:
    """Signal handler: end the process."""
    os.write(2, f"{SAID}\n".encode())
    os._exit(130)


def listen() -> None:
    """Let it be the handler from now on."""
    for one in _SIGNALS:
        _signal.signal(one, leave)
