"""A function a stage: what its command does, with the same results and provenance."""

import contextlib
import json
import shutil
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hknob_cli.api.results import Results

if TYPE_CHECKING:
    from hknob_cli.specs.plan import Plan

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
