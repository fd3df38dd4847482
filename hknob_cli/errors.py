"""What can go wrong, and the exit code that says so.

Every error a user can meet is an `HknobError`; the command line prints its message, without a traceback, and exits with
its code.
"""

import errno
from collections.abc import Sequence
from enum import IntEnum
from typing import NamedTuple


class ExitCode(IntEnum):
    """Exit codes of every command."""

    DONE = 0
    FAILED = 1
    USAGE = 2
    REFUSED = 3
    DEVICE = 4
    INTERRUPTED = 130


MOST_FAULTS = 200  # of a spec that are said
# What Python raises where a table, or an argument, is of another shape than what works with it takes for granted.
MISSHAPEN = (TypeError, ValueError, LookupError, AttributeError, ArithmeticError, NotImplementedError, StopIteration)


class HknobError(Exception):
    """Base of all errors shown to the user; the message is complete as it stands."""

    exit_code = ExitCode.FAILED


class ComputationError(HknobError):
    """The computation or a check failed."""


def unwritable(place: object, error: OSError, *, kept: bool = False) -> ComputationError:
    """What to say, and to do, where a file cannot be written; ``kept``: what the run has finished so far is."""
    full = error.errno in (errno.ENOSPC, errno.EDQUOT)
    advice = ["what is finished is kept"] if kept else []
    if full or kept:
        advice.append("make room there, and run the same command again" if full else "run the same command again")
    return ComputationError("; ".join([f"{place}: cannot be written: {error.strerror or error}", *advice]))


class UsageError(HknobError):
    """The command line, or a file it names, cannot be used."""

    exit_code = ExitCode.USAGE


class DeviceError(HknobError):
    """A device does not answer, refuses, or has tripped; its torque is off, or off by its own watchdog."""

    exit_code = ExitCode.DEVICE


class RefusedError(HknobError):
    """The output belongs to another run, or to something else."""

    exit_code = ExitCode.REFUSED


def printable(text: str) -> str:
    """A text in one line, as a terminal may be sent it: what would steer or mislead one is replaced by ``?``."""
    return text if text.isprintable() else "".join(c if c.isprintable() else "?" for c in text)


class Fault(NamedTuple):
    """One fault of a spec: where (``FILE:LINE:COL`` or the option that set it), which key, and what is wrong."""

    where: str
    line: int
    column: int
    key: str
    message: str

    def __str__(self) -> str:
        place = f"{self.where}:{self.line}:{self.column}" if self.line else self.where
        return printable(f"{place}: {self.key}: {self.message}" if self.key else f"{place}: {self.message}")


class SpecError(UsageError):
    """A spec with faults, one line each; the first are said."""

    def __init__(self, faults: Sequence[Fault]) -> None:
        self.faults = tuple(sorted(set(faults)))
        lines = [str(fault) for fault in self.faults[:MOST_FAULTS]]
        more = len(self.faults) - len(lines)
        super().__init__("\n".join([*lines, *([f"... and {more} more faults"] if more else [])]))

    def __reduce__(self) -> "tuple[type[SpecError], tuple[tuple[Fault, ...]]]":
        """From one process to another."""
        return type(self), (self.faults,)
