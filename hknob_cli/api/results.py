"""What a command found, from Python: its tables as data frames, its answer in words, its figures."""

import base64
import html
import io
import shutil
import weakref
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure


class Results:
    """What a command found: its tables as data frames, its answer in words, its figure. A notebook shows both.

    Every table of the results is an attribute, e.g. ``cells`` and ``orbits`` of a sweep; ``tables`` has their names.
    ``kind``, ``name``; ``folder``: where the files are; ``summary``: what ``--json`` prints.
    """

    def __init__(self, folder: Path, summary: dict[str, Any], text: str, *, temporary: bool = False) -> None:
        """Results in ``folder``, which goes with them if it is ``temporary``."""
        self.folder = folder
        self.summary = summary
        self.kind: str = summary["kind"]
        self.name: str = summary["name"]
        self._text = text
        self._frames: dict[str, pd.DataFrame] = {}
        if temporary:
            weakref.finalize(self, shutil.rmtree, folder, ignore_errors=True)

    @cached_property
    def tables(self) -> tuple[str, ...]:
        """Names of the tables."""
        return tuple(sorted(path.stem for path in self.folder.glob("*.parquet")))

    def __getattr__(self, name: str) -> "pd.DataFrame":
        """A table, read once. Its ``attrs`` have ``units`` and ``meanings`` of the columns, and the ``provenance``."""
        if name.startswith("_") or name not in self.tables:
            raise AttributeError(f"{self.kind} '{self.name}' has no table '{name}'")
        if name not in self._frames:
            from hknob_cli.results.provenance import record_of
            from hknob_cli.results.result_set import Result

            table = Result(self.name, self.folder).table(name)
            told = {field.name: field.metadata or {} for field in table.schema}
            frame = table.to_pandas()
            for key, entry in (("units", b"unit"), ("meanings", b"meaning")):
                frame.attrs[key] = {column: said[entry].decode() for column, said in told.items() if entry in said}
            frame.attrs["provenance"] = record_of(table.schema.metadata)
            self._frames[name] = frame
        return self._frames[name]

    def __dir__(self) -> list[str]:
        """Attributes, the tables among them."""
        return [*super().__dir__(), *self.tables]

    def figure(self) -> "Figure":
        """What ``--plot`` and a page show of these results, on one sheet. Raises `MissingError` if it is nothing."""
        from hknob_cli.figures.defaults import figures_of
        from hknob_cli.figures.sheet import sheet_of
        from hknob_cli.figures.theme import library_defaults
        from hknob_cli.results.result_set import MissingError, Result

        result = Result(self.name, self.folder)
        with library_defaults():
            figure = sheet_of(result, figures_of(result))
        if figure is None:
            raise MissingError(f"{self.kind} '{self.name}' has no figure")
        return figure

    def __str__(self) -> str:
        """The answer in words, as the command prints it."""
        return self._text

    __repr__ = __str__

    def _repr_html_(self) -> str:
        from hknob_cli.figures.sheet import DPI
        from hknob_cli.results.result_set import MissingError

        shown = f"<pre>{html.escape(self._text)}</pre>"
        try:
            stream = io.BytesIO()
            self.figure().savefig(stream, format="png", dpi=DPI)
        except MissingError:
            return shown
        source = f"data:image/png;base64,{base64.b64encode(stream.getvalue()).decode()}"
        return f'{shown}<img style="max-width: 100%" alt="{html.escape(self.name)}" src="{source}">'
