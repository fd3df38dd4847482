"""A spec on standard input, where a command names ``-`` in place of a file. Loads nothing.

It is read once, and kept: a spec's kind is asked before the spec is loaded, and a stream cannot be read again. Paths in
such a spec begin at the working folder.
"""

import sys
from functools import cache
from pathlib import Path

from hknob_cli.errors import UsageError
from hknob_cli.terminal import say

STDIN = "<stdin>"  # in faults, in place of a file's name


def named(path: Path | None) -> Path | None:
    """The file that a command names, if any; that of standard input for ``-``."""
    return Path(STDIN) if str(path) == "-" else path


def all_named(paths: list[Path]) -> list[Path]:
    """The files that a command names."""
    return [named(path) or path for path in paths]


def is_stdin(path: Path) -> bool:
    """Whether a command named standard input."""
    return str(path) == STDIN


def as_typed(path: Path | str) -> str:
    """A file as a command names it."""
    return "-" if str(path) == STDIN else str(path)


@cache
def given(most: int) -> bytes:
    """What is on standard input, one byte more than the ``most`` that may be there. Raises `UsageError` if closed."""
    if sys.stdin is None or sys.stdin.closed:
        raise UsageError(f"{STDIN}: is closed; give a spec on it, or name a file")
    if sys.stdin.isatty():
        say("reading a spec from the terminal; end it with Ctrl-D on a line of its own")
    return sys.stdin.buffer.read(most + 1)
