"""Faults of recordings: file, row, column, what is wrong, the value, what is allowed."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from hknob_cli.errors import UsageError

MOST = 20


class RowFault(NamedTuple):
    """One fault; ``row`` counts from 1 below the header, 0 for the file as a whole."""

    file: str
    row: int
    column: str
    message: str

    def __str__(self) -> str:
        row = f"row {self.row}" if self.row else ""
        return ": ".join(part for part in (self.file, row, self.column, self.message) if part)


class RecordingError(UsageError):
    """Recordings with faults, one line each; at most 20 are listed, by file and row."""

    def __init__(self, faults: Sequence[RowFault]) -> None:
        self.faults = tuple(faults[:MOST])
        lines = [str(fault) for fault in self.faults]
        if len(faults) > MOST:
            lines.append(f"only the first {MOST} faults are listed")
        super().__init__("\n".join(lines))


class Faults:
    """Collects the faults of one file, in the order of its rows."""

    def __init__(self, file: str, sources: Mapping[str, str] | None = None) -> None:
        """``sources``: names of columns in the file, where they differ."""
        self.file = file
        self.sources = {} if sources is None else sources
        self.absent: set[str] = set()  # keys that are no columns of the file
        self.warnings: list[RowFault] = []
        self._found: list[RowFault] = []
        self._of_rows: list[RowFault] = []
        self._said: set[tuple[str, str]] = set()

    def add(self, row: int, column: str, message: str) -> None:
        """Note a fault."""
        self._found.append(RowFault(self.file, row, self._shown(column), message))

    def warn(self, row: int, column: str, message: str) -> None:
        """Note what is read all the same; only the first of a column."""
        if ("warning", column) not in self._said:
            self._said.add(("warning", column))
            self.warnings.append(RowFault(self.file, row, self._shown(column), message))

    def _shown(self, column: str) -> str:
        there = self.sources.get(column, column)
        return column if there == column else f"{column} (column '{there}')"

    def add_row(self, row: int, message: str) -> None:
        """Note a fault of a row as a whole, ``row`` as the file counts it."""
        self._of_rows.append(RowFault(self.file, row, "", message))

    def add_once(self, rule: str, row: int, column: str, message: str) -> None:
        """Note a fault that one mistake makes in every row, such as a wrong unit: only the first of a column."""
        if (rule, column) not in self._said:
            self._said.add((rule, column))
            self.add(row, column, message)

    def has(self, column: str) -> bool:
        """Whether a fault of ``column`` was noted."""
        return any(fault.column in (column, self._shown(column)) for fault in self._found)

    @property
    def full(self) -> bool:
        """Whether there are more than are listed; reading on tells nothing."""
        return len(self._found) > MOST

    def listed(self, lost: Sequence[int] = ()) -> list[RowFault]:
        """All faults by row, where the rows ``lost`` (as the file counts them) were left out in counting the others."""
        found = [fault._replace(row=_in_file(fault.row, lost)) for fault in self._found]
        found += self._of_rows
        return sorted(found, key=lambda fault: fault.row)

    def __bool__(self) -> bool:
        return bool(self._found or self._of_rows)


def _in_file(row: int, lost: Sequence[int]) -> int:
    """Row as the file counts it."""
    for gone in sorted(lost):
        if 0 < gone <= row:
            row += 1
    return row
