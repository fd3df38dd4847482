"""Files that are read, and standard input in place of one: only where they are files, and no larger than a spec can be.

Standard input (``-``) is read once, and kept: a spec's kind is asked before the spec is loaded, and a stream cannot be
read again. Paths in such a spec begin at the working folder.
"""

import contextlib
import os
import stat
import sys
from collections.abc import Iterator
from functools import cache
from io import BufferedReader
from pathlib import Path
from typing import NamedTuple

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


def is_endless(path: Path) -> bool:
    """Whether there is something at ``path`` that is neither file nor folder: a device, a pipe, a socket."""
    try:
        mode = path.stat().st_mode
    except (OSError, ValueError):
        return False  # whoever opens it will say what is wrong
    return not (stat.S_ISREG(mode) or stat.S_ISDIR(mode))


@contextlib.contextmanager
def open_named(path: Path) -> Iterator[BufferedReader]:
    """A file, to be read. Raises `UsageError` where it is none, or cannot be read."""
    try:
        if is_endless(path) or path.is_dir():
            raise UsageError(f"{path}: is not a file")
        with path.open("rb") as stream:
            yield stream
    except FileNotFoundError as error:
        raise UsageError(f"{path}: {error.strerror}{_from_here(path)}") from None
    except OSError as error:  # a name that is too long is one, too
        raise UsageError(f"{path}: {error.strerror or error}") from None


def _from_here(path: Path) -> str:
    """Where a path that begins at the spec's folder was meant from the working folder: what is there; else nothing."""
    ends = (Path(*path.parts[first:]) for first in range(1, len(path.parts)))
    there = next((end for end in ends if not end.is_absolute() and end.exists()), None)
    return f"; a path in a spec begins at the folder of the spec, and {there} is in the working folder" if there else ""


def read_named(path: Path) -> bytes:
    """What is in a file. Raises as `open_named`."""
    with open_named(path) as stream:
        return stream.read()


def digest_of(path: Path) -> str:
    """SHA-256 of a file. Raises as `open_named`."""
    import hashlib

    with open_named(path) as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def inside(path: Path, name: str) -> Path:
    """The file of that name where ``path`` is a folder, else ``path`` itself. Raises `UsageError`."""
    try:
        return path / name if path.is_dir() else path
    except OSError as error:  # a name that is too long
        raise UsageError(f"{path}: {error.strerror or error}") from None


VARIABLE = "HKNOB_SPEC_LIMIT"
MAX_DEPTH = 50  # of keys within keys; specs need 8
_MEGABYTES = 1
_VALUES = 100_000
_KEYS = 1000
_MOST = 1000


class SizeLimit(NamedTuple):
    """What a file may have, ``times`` the usual: bytes, keys and values with aliases expanded, keys of one mapping."""

    bytes: int
    values: int
    keys: int
    times: int

    @property
    def too_many(self) -> str:
        """What is said of more keys and values."""
        return f"more than {self.values} keys and values, aliases expanded; {self.advice}"

    @property
    def advice(self) -> str:
        """How to allow more, in words."""
        more = min(_MOST, 10 * self.times)
        return (
            f"{VARIABLE}={more} in the environment allows {more} times the usual {_MEGABYTES} MB and {_VALUES} values"
        )


def size_limit() -> SizeLimit:
    """The limit, as many times the usual one as the environment says. Raises `UsageError` if it says no such number."""
    text = os.environ.get(VARIABLE) or "1"
    if not (text.isascii() and text.isdecimal() and len(text) < 5 and 1 <= int(text) <= _MOST):
        raise UsageError(f"{VARIABLE}: must be a whole number from 1 to {_MOST}, got {text[:40]!r}")
    times = int(text)
    return SizeLimit(times * _MEGABYTES * 1_000_000, times * _VALUES, times * _KEYS, times)
