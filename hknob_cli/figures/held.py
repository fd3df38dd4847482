"""A result in memory, which figures are drawn from as from one in a folder."""

from pathlib import Path
from typing import Any

import pyarrow as pa

from hknob_cli.results.result_set import Result, ResultSet


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
