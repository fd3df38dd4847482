"""A function a stage: what its command does, with the same results and provenance; and what it found, from Python."""

import base64
import contextlib
import html
import io
import json
import shutil
import tempfile
import weakref
from collections.abc import Callable, Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from hknob_cli.specs.plan import Plan


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


Spec = str | Path | Mapping[str, Any]
Progress = Callable[[int, int, str], object]
HERE = "<spec>"  # in faults, in place of a file name, where a spec is a mapping


def load(
    spec: Spec, overrides: Mapping[str, Any] | None = None, *, kind: str | None = None, name: str = HERE
) -> "Plan":
    """What a spec says, validated, with its defaults. Raises `SpecError` with every fault, `UsageError`.

    Args:
        spec: path of a YAML file, or what such a file says as a mapping; paths in a mapping are relative to here.
            Its values may be numpy's, and a `Scene`.
        overrides: values by dotted key, as ``--set`` has them.
        kind: the kind that it must be; None: any.
        name: what stands for the file of a mapping in faults.
    """
    from hknob_cli.specs import load as specs

    if isinstance(spec, Mapping):
        return specs.load_text(json.dumps(plain(spec), indent=1), name, _texts(overrides), kind=kind)
    return specs.load(Path(spec), _texts(overrides), kind=kind)


def run(
    spec: Spec,
    overrides: Mapping[str, Any] | None = None,
    *,
    out: str | Path | None = None,
    jobs: int | None = None,
    progress: Progress | None = None,
    kind: str | None = None,
) -> Results:
    """Run one stage, as its command does. Raises `SpecError`, `UsageError`, `RefusedError`, `ComputationError`.

    Args:
        spec: as of `load`.
        overrides: as of `load`.
        out: folder of the results, where they are as the command leaves them, and found up to date by a later run;
            None: a temporary one, which lasts as long as the results.
        jobs: processes or threads; None: all cores. Results do not depend on it.
        progress: is called while there is work, with how much is done, of how much (0: not known), and of what, as
            ``progress(3, 49, "cells")``. What it raises ends the work.
        kind: as of `load`.
    """
    from hknob_cli.report.table import folded
    from hknob_cli.stages.job import Job, work_of
    from hknob_cli.stages.make import make
    from hknob_cli.terminal import listening

    plan = load(spec, overrides, kind=kind)
    folder = Path(out or tempfile.mkdtemp(prefix="hknob-"))
    stage = plan.values["kind"] if kind is None else kind
    job = Job(kind=stage, plan=plan, out=folder, overrides=_texts(overrides), jobs=jobs, quiet=True)
    work = work_of(stage)
    try:
        with listening(progress) if progress else contextlib.nullcontext():
            made = make(job, work)
    except BaseException:
        if not out:
            shutil.rmtree(folder, ignore_errors=True)
        raise
    status = "computed" if made.computed else "up to date"
    summary = {"kind": stage, "name": plan.name, "status": status, **work.describe(job, made.tables)}
    text = folded(work.text(job, summary))
    return Results(folder, {**summary, "files": [str(path) for path in made.files]}, text, temporary=not out)


def sweep(
    spec: Spec,
    overrides: Mapping[str, Any] | None = None,
    *,
    out: str | Path | None = None,
    jobs: int | None = None,
    progress: Progress | None = None,
) -> Results:
    """Limit cycles of every cell of a grid: tables ``cells`` and ``orbits``. Arguments and errors as of `run`."""
    return run(spec, overrides, out=out, jobs=jobs, progress=progress, kind="sweep")


def dfa(
    spec: Spec,
    overrides: Mapping[str, Any] | None = None,
    *,
    out: str | Path | None = None,
    jobs: int | None = None,
    progress: Progress | None = None,
) -> Results:
    """Describing-function analysis: table ``dfa``. Arguments and errors as of `run`."""
    return run(spec, overrides, out=out, jobs=jobs, progress=progress, kind="dfa")


def predict(
    spec: Spec,
    overrides: Mapping[str, Any] | None = None,
    *,
    out: str | Path | None = None,
    jobs: int | None = None,
    progress: Progress | None = None,
) -> Results:
    """Formulas and stability limits: tables ``predict``, ``passivity``. Arguments and errors as of `run`."""
    return run(spec, overrides, out=out, jobs=jobs, progress=progress, kind="predict")


def remedies(
    spec: Spec,
    overrides: Mapping[str, Any] | None = None,
    *,
    out: str | Path | None = None,
    jobs: int | None = None,
    progress: Progress | None = None,
) -> Results:
    """Changes against the buzz, tried: tables ``remedies`` and ``cases``. Arguments and errors as of `run`."""
    return run(spec, overrides, out=out, jobs=jobs, progress=progress, kind="remedies")


def design(
    spec: Spec,
    overrides: Mapping[str, Any] | None = None,
    *,
    out: str | Path | None = None,
    jobs: int | None = None,
    progress: Progress | None = None,
) -> Results:
    """The cheapest design that meets every limit: table ``design``. Arguments and errors as of `run`."""
    return run(spec, overrides, out=out, jobs=jobs, progress=progress, kind="design")


def sysid(
    spec: Spec,
    overrides: Mapping[str, Any] | None = None,
    *,
    out: str | Path | None = None,
    jobs: int | None = None,
    progress: Progress | None = None,
) -> Results:
    """Parameters of hands from recordings: tables ``trials``, ``conditions``. Arguments and errors as of `run`."""
    return run(spec, overrides, out=out, jobs=jobs, progress=progress, kind="sysid")


def _texts(overrides: Mapping[str, Any] | None) -> tuple[str, ...]:
    return tuple(f"{key}={json.dumps(plain(value))}" for key, value in (overrides or {}).items())


def plain(value: Any) -> Any:
    """A value of a spec as YAML has it: mappings, lists, numbers and text; numpy's and paths among them."""
    if isinstance(value, Mapping):
        return {key: plain(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple | range):
        return [plain(inner) for inner in value]
    if isinstance(value, Path):
        return str(value)
    return value.tolist() if hasattr(value, "tolist") else value  # of numpy and pandas
