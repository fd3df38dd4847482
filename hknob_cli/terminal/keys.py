"""Keys pressed at a terminal, read without waiting for the end of a line."""

import contextlib
import os
import select
import sys
from collections.abc import Iterator


class Keys:
    """Keys as they are pressed; none where there is no terminal."""

    def __init__(self, descriptor: int | None) -> None:
        self._descriptor = descriptor

    def pressed(self, wait_s: float = 0.0) -> str:
        """The next key within a time, lower case; nothing if there is none.

        Raises `KeyboardInterrupt` where the terminal is gone, and with it whoever was there.
        """
        if self._descriptor is None:
            return ""
        ready, _, _ = select.select([self._descriptor], [], [], wait_s)
        if not ready:
            return ""
        try:
            found = os.read(self._descriptor, 1)
        except OSError:
            found = b""
        if not found:
            raise KeyboardInterrupt
        return found.decode("latin-1").lower()


@contextlib.contextmanager
def keys() -> Iterator[Keys]:
    """Keys of the terminal on stdin, which is as it was afterwards; Ctrl-C stays an interruption."""
    try:
        import termios
        import tty

        descriptor = sys.stdin.fileno()
        before = termios.tcgetattr(descriptor)
    except (ImportError, OSError, ValueError, AttributeError, termios.error):
        yield Keys(None)
        return
    try:
        tty.setcbreak(descriptor)
        yield Keys(descriptor)
    finally:
        termios.tcsetattr(descriptor, termios.TCSADRAIN, before)
