"""Finished results by name, and their rows: what figures are drawn from and claims are checked against.

Rows by what is asked of their columns: a value as printed, one of several, or bounds.

A result in memory, which figures are drawn from as from one in a folder.
"""

import errno
import json
from collections.abc import Callable, Iterator, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

import pyarrow as pa

from hknob_cli.errors import ComputationError, HknobError, UsageError
from hknob_cli.results.campaign_files import NEEDED, campaign_cells
from hknob_cli.results.columns import PEOPLE
from hknob_cli.results.parted import Parted, read_parted, read_result, result_schema
from hknob_cli.results.provenance import DESIGN, axes_in, record_of
from hknob_cli.specs.campaign import PLAIN
from hknob_cli.specs.parquet import why_unreadable
from hknob_cli.specs.plan import COUNTS, PERSON, RATE, Hand, Scene
from hknob_cli.specs.pulses import PULSES

Where = dict[str, Any]

SAME = 5e-3  # texts round: 2154 Hz is 2154.43
_BOUNDS: dict[str, Callable[[float, float], bool]] = {
    "at_least": lambda value, bound: value >= bound * (1.0 - 1e-9),
    "at_most": lambda value, bound: value <= bound * (1.0 + 1e-9),
    "above": lambda value, bound: value > bound * (1.0 + 1e-9),
    "below": lambda value, bound: value < bound * (1.0 - 1e-9),
}

_ABSENT = (errno.ENOENT, errno.ENOTDIR, errno.ENAMETOOLONG)
Rows = list[dict[str, Any]]
CAMPAIGN = "hw-run"


def matching(rows: list[dict[str, Any]], asked: Where) -> list[dict[str, Any]]:
    """Those of the rows that have what is asked. Raises `UsageError` for an unknown bound."""
    return [row for row in rows if all(_is(row[name], value) for name, value in asked.items())]


def _is(value: Any, asked: Any) -> bool:
    if isinstance(asked, list):
        return any(_is(value, one) for one in asked)
    if isinstance(asked, dict):
        if unknown := sorted(set(asked) - set(_BOUNDS)):
            raise UsageError(f"where: unknown {', '.join(unknown)}; there are {', '.join(_BOUNDS)}")
        return value is not None and all(_BOUNDS[name](value, bound) for name, bound in asked.items())
    if isinstance(asked, str | bool) or value is None:
        return bool(value == asked)
    return bool(abs(value - asked) <= SAME * abs(asked))


class MissingError(UsageError):
    """There is no such result, or not that part of it: what depends on it is left out, and says so."""


class Result:
    """One results folder: its tables, read once, and how they were made."""

    def __init__(self, name: str, folder: Path) -> None:
        """``name`` is what figures and claims call it."""
        self.name = name
        self.folder = folder
        self._tables: dict[str, pa.Table] = {}
        self._schemas: dict[str, pa.Schema] = {}

    def table(self, file: str) -> pa.Table:
        """A table, by file name with or without ``.parquet``. Raises `MissingError`.

        A campaign on a knob has ``cells``, too, which are made of its trials.
        """
        file = f"{file.removesuffix('.parquet')}.parquet"
        if file not in self._tables:
            if file == "cells.parquet" and file not in self.files and self.stage == CAMPAIGN:
                self._tables[file] = self._cells_of_trials()
                return self._tables[file]
            try:
                self._tables[file] = read_result(self.folder / file)
            except (OSError, pa.ArrowException) as error:
                raise self._unreadable(file, error) from None
        return self._tables[file]

    def parted(self, file: str) -> Parted | None:
        """A table that is too large to be read as a whole without need; None for any other."""
        folder = self.folder / f"{file}.parquet"
        return read_parted(folder) if folder.is_dir() else None

    def tables(self, file: str, columns: Sequence[str]) -> Iterator[pa.Table]:
        """A table, part by part where it has parts: those of the ``columns`` that there are. Raises `MissingError`."""
        if large := self.parted(file):
            there = large.column_names
            yield from large.tables([name for name in columns if name in there])
        else:
            table = self.table(file)
            yield table.select([name for name in columns if name in table.column_names])

    def _cells_of_trials(self) -> pa.Table:
        trials = self.table("trials")
        if lacking := sorted(set(NEEDED) - set(trials.column_names)):
            raise MissingError(f"no column {', '.join(lacking)} in trials of '{self.name}'")
        return campaign_cells(trials.to_pylist())

    def rows(self, file: str) -> Rows:
        """The same as a list of rows. Raises `MissingError`."""
        rows: Rows = self.table(file).to_pylist()
        return rows

    @cached_property
    def files(self) -> tuple[str, ...]:
        """Names of the tables in the folder."""
        return tuple(sorted(path.name for path in self.folder.glob("*.parquet")))

    @cached_property
    def provenance(self) -> dict[str, Any]:
        """Stage, spec as run, inputs and versions. Raises `MissingError` where the folder has no result."""
        for file in self.files:
            if record := record_of(self._schema(file).metadata):
                return record
        raise MissingError(f"no result '{self.name}' in {self.folder}")

    @property
    def stage(self) -> str:
        """Kind of the stage that made it. Raises `MissingError`."""
        return str(self.provenance["stage"])

    @property
    def has_remedies(self) -> bool:
        """Whether it is a campaign that tried remedies. Raises `MissingError`."""
        return self.stage == CAMPAIGN and bool(self.provenance["spec"].get("remedies"))

    @property
    def has_pulses(self) -> bool:
        """Whether it is a campaign of pulses, which has no cells. Raises `MissingError`."""
        return self.stage == CAMPAIGN and self.provenance["spec"].get("what") == PULSES

    @property
    def reference(self) -> str:
        """The remedy that the others of a campaign are compared with. Raises `MissingError`."""
        return str(self.provenance["spec"].get("reference", PLAIN))

    @property
    def axes(self) -> list[str]:
        """Names of its grid axes, in the order of the columns. Raises `MissingError`."""
        if self.has_pulses:
            return []
        if self.stage == CAMPAIGN:
            return [RATE, COUNTS]  # whether its spec says so, or leaves them to their defaults
        axes = axes_in(self.provenance["spec"])
        columns = {name for file in self.files for name in self._schema(file).names}
        if lacking := [axis for axis in axes if axis not in columns]:
            raise MissingError(f"'{self.name}' has no column {', '.join(lacking)}, which its spec has as an axis")
        return axes

    def columns(self, file: str) -> list[str]:
        """Names of a table's columns. Raises `MissingError`."""
        return list(self.schema(file).names)

    def schema(self, file: str) -> pa.Schema:
        """A table's columns with their units and meanings. Raises `MissingError`."""
        return self._schema(f"{file}.parquet")

    def _schema(self, file: str) -> pa.Schema:
        """Columns of a table, and what it says of itself. Raises `MissingError`."""
        if file not in self._schemas:
            try:
                self._schemas[file] = result_schema(self.folder / file)
            except (OSError, pa.ArrowException) as error:
                raise self._unreadable(file, error) from None
        return self._schemas[file]

    def _unreadable(self, file: str, error: Exception) -> HknobError:
        """That there is no such table, or a damaged one; where the disk fails an error after which no page is made."""
        there = file in self.files
        if there and isinstance(error, OSError) and error.errno not in (None, *_ABSENT):
            why = error.strerror or error
            return ComputationError(f"{self.folder / file}: cannot be read: {why}; run the same command again")
        text = f"{file} of '{self.name}' in {self.folder}"
        return MissingError(f"{text} {why_unreadable(error)}" if there else f"no {text}")

    @property
    def is_design(self) -> bool:
        """Whether its cells are the points of a design, not every combination of axis values. Raises `MissingError`."""
        return self.stage != CAMPAIGN and bool((self.provenance["spec"].get("grid") or {}).get(DESIGN))

    @property
    def scales(self) -> dict[str, str]:
        """Whether an axis that is a range is one by factors, "log", or by steps, "lin". Raises `MissingError`."""
        grid = self.provenance["spec"].get("grid") or {}
        ranges = {axis: kind for axis, value in grid.items() if isinstance(value, dict) for kind in value}
        return {axis: kind for axis, kind in ranges.items() if kind in ("log", "lin")}

    @cached_property
    def scene(self) -> Scene:
        """The scene it was computed for, in SI numbers. Raises `MissingError` where its stage has none."""
        scene = self.provenance["spec"].get("scene")
        if scene is None:
            raise MissingError(f"'{self.name}' has no scene")
        from hknob_cli.specs.scene import SceneSpec

        hand = self._hand(scene)
        if hand is not None:
            scene = {key: value for key, value in scene.items() if key != "hand"}
        spec: SceneSpec = SceneSpec.model_validate(scene)
        return spec.plain()._replace(hand=hand) if hand is not None else spec.plain()

    def _hand(self, scene: dict[str, Any]) -> Hand | None:
        """The hand that a file gave the scene, or the hands of a population; None where the spec has its numbers."""
        if self.provenance["spec"].get("population"):
            people = {row[PERSON]: Hand(*(row[column.name] for column in PEOPLE)) for row in self.rows("cells")}
            return Hand(by_person=tuple(people[person] for person in sorted(people)))
        if not (scene.get("hand") or {}).get("from"):
            return None
        numbers = json.loads(self.provenance["inputs"]["hand"])
        by_grip = tuple((float(grip), Hand(*one)) for grip, one in numbers.pop("by_grip", {}).items())
        return Hand(**numbers, by_grip=by_grip)


class ResultSet:
    """Results by name."""

    def __init__(self, folders: dict[str, Path]) -> None:
        """``folders`` by name; they need not exist."""
        self._results = {name: Result(name, folder) for name, folder in folders.items()}

    def __getitem__(self, name: str) -> Result:
        """A result. Raises `MissingError` if none has that name, or its folder is empty."""
        if name not in self._results or not self._results[name].files:
            raise MissingError(f"no result '{name}'{self._hint(name)}")
        return self._results[name]

    def _hint(self, name: str) -> str:
        """The nearest name of those there are, for one that nobody has given."""
        from hknob_cli.specs.messages import closest

        close = None if name in self._results else closest(name, list(self._results))
        return f"; did you mean '{close}'?" if close else ""

    def __contains__(self, name: object) -> bool:
        """Whether a result is there."""
        return name in self._results and bool(self._results[str(name)].files)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the results that are there."""
        return tuple(name for name in self._results if name in self)


class Held(Result):
    """Tables of a stage, by file name without ``.parquet``, over these axes; ``spec``: what else of it figures read."""

    def __init__(
        self, name: str, stage: str, tables: dict[str, pa.Table], axes: list[str], spec: dict[str, Any] | None = None
    ) -> None:
        """``name`` is what the figures call it."""
        super().__init__(name, Path())
        self._tables = {f"{file}.parquet": table for file, table in tables.items()}
        self.files = tuple(sorted(self._tables))
        self.provenance = {"stage": stage, "spec": {"grid": dict.fromkeys(axes), **(spec or {})}}

    def _schema(self, file: str) -> pa.Schema:
        return self._tables[file].schema if file in self._tables else super()._schema(file)


class One(ResultSet):
    """One result that is at hand."""

    def __init__(self, result: Result) -> None:
        """The set of this alone."""
        self._results = {result.name: result}
