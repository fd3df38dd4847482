"""``hknob check``, ``explain``, ``schema`` and ``verify``: what specs say and may say, and whether results are sound.

Nothing is computed or changed. ``hknob explain``: what a spec describes, in words. ``hknob schema``: the JSON Schema of
a kind of spec, for editors. ``hknob verify``: whether the files of a results folder are as they were written.
"""

import json
import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hknob_cli.cli.options import Json, Quiet, Sets
from hknob_cli.errors import ExitCode, UsageError
from hknob_cli.specs.named_file import all_named, as_typed, named
from hknob_cli.stage_table import CLAIMS, PIPELINE, SCHEMAS
from hknob_cli.stages.job import Job
from hknob_cli.terminal import reporting, say, tell

if TYPE_CHECKING:
    from hknob_cli.report.scene_words import Explained


def schema(
    kind: Annotated[
        str,
        typer.Argument(
            help=", ".join(SCHEMAS),
            show_default=False,
            metavar="KIND",
            autocompletion=lambda incomplete: [kind for kind in SCHEMAS if kind.startswith(incomplete)],
        ),
    ],
) -> None:
    """Print the JSON Schema of a kind of spec."""
    with reporting():
        from hknob_cli.specs.generated import json_schema, titled

        if kind == CLAIMS:
            from hknob_cli.page.claims.ledger import Ledger

            found = titled(Ledger.model_json_schema(), "hknob ledger of claims")
        else:
            found = json_schema(kind)
        typer.echo(json.dumps(found, indent=2))


def _checked(path: Path, sets: tuple[str, ...], *, quiet: bool) -> str:
    """What a valid spec says, in a few words. Raises `UsageError`."""
    from hknob_cli.specs.load import is_ledger, kind_of, load, load_pipeline
    from hknob_cli.specs.plan import SweepPlan
    from hknob_cli.specs.remarks import not_proven
    from hknob_cli.stages.job import work_of
    from hknob_cli.stages.work import counted

    kind = kind_of(path)
    if kind == PIPELINE:
        from hknob_cli.pipeline.steps import chosen, jobs_of

        pipeline = load_pipeline(path, sets)
        for job in jobs_of(chosen(pipeline), Path("results") / pipeline.name, quiet=quiet).values():
            work_of(job.kind).verify(job)
            _warn(path, job)
        return f"pipeline '{pipeline.name}', {counted(len(pipeline.stages), 'stage')}"
    if kind is None and is_ledger(path):
        from hknob_cli.page.claims.ledger import load_ledger

        return f"ledger, {counted(len(load_ledger(path).claims), 'claim')}"
    plan = load(path, sets)
    kind = str(plan.values["kind"])  # as set on the command line, where it is
    job = Job(kind=kind, plan=plan, out=Path("results") / plan.name, quiet=quiet)
    work = work_of(kind)
    work.verify(job)
    _warn(path, job)
    if isinstance(plan, SweepPlan) and not quiet:
        for text in not_proven(plan):
            say(f"{path}: {text}")
    return f"{kind} '{plan.name}', {work.size(plan)}"


def _warn(path: Path, job: Job) -> None:
    """Say of a plan what preset it is from, with the sources of its values, and what is unusual in it."""
    from hknob_cli.specs.remarks import unusual

    preset = getattr(job.plan, "preset", None)
    for text in () if job.quiet else [*(preset.lines if preset else ()), *unusual(job.plan)]:
        say(f"{path}: {text}")


def check(
    specs: Annotated[
        list[Path],
        typer.Argument(
            callback=all_named,
            metavar="SPEC.yaml...",
            help="Specs to validate; - is standard input.",
            show_default=False,
        ),
    ],
    sets: Sets = None,
    quiet: Quiet = False,
) -> None:
    """Validate specs only: one line per fault, FILE:LINE:COL first."""
    failed = False
    with reporting():
        for path in specs:
            try:
                found = _checked(path, tuple(sets or ()), quiet=quiet)
            except UsageError as error:
                say(str(error))
                failed = True
                continue
            tell(f"{path}: {found}: good")
    if failed:
        raise typer.Exit(ExitCode.USAGE)


def verify(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A folder of results.", show_default=False)],
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Say of each file of a results folder whether it is as it was written."""
    with reporting():
        from hknob_cli.pipeline.verify import Verdict, verify_folder

        found = verify_folder(folder)
        counts = {verdict: sum(one.verdict is verdict for one in found) for verdict in Verdict}
        if as_json:
            files = [{"file": str(one.path), "verdict": one.verdict.value, "why": one.why} for one in found]
            print(json.dumps({"kind": "verify", "folder": str(folder), "files": files}))
        else:
            for one in found:
                if not quiet or one.verdict is Verdict.CHANGED:
                    tell(f"{one.path}: {one.verdict.value}" + (f": {one.why}" if one.why else ""))
        if counts[Verdict.CHANGED]:
            say(
                f"{folder}: {counts[Verdict.CHANGED]} of {len(found)} files are not as written; the command that made "
                "results makes them again; recordings of a device must be put back from a copy"
            )
            raise typer.Exit(ExitCode.FAILED)
        if not as_json:
            tell(f"{folder}: {counts[Verdict.WHOLE]} as written, {counts[Verdict.UNKNOWN]} not checked")


def explain(
    spec: Annotated[
        Path,
        typer.Argument(
            callback=named, metavar="SPEC.yaml", help="The spec to explain; - is standard input.", show_default=False
        ),
    ],
    sets: Sets = None,
    as_json: Json = False,
) -> None:
    """Say in words what a spec describes, what follows from its numbers, and what is not proven."""
    with reporting():
        from hknob_cli.report.scene_words import as_data, explained_text

        found = _explained(spec, tuple(sets or ()))
        if as_json:
            print(json.dumps(as_data(found), allow_nan=False))
        else:
            tell(explained_text(found))


def _explained(path: Path, sets: tuple[str, ...]) -> "Explained":
    """What a spec of any kind describes, or a ledger of claims. Raises `UsageError`."""
    from hknob_cli.errors import ComputationError
    from hknob_cli.specs.load import is_ledger, kind_of, load
    from hknob_cli.stage_table import PIPELINE
    from hknob_cli.stages.explain import explain as explain_stage

    kind = kind_of(path)
    if kind == PIPELINE:
        return _pipeline(path, sets)
    if kind is None and is_ledger(path):
        return _ledger(path)
    plan = load(path, sets)
    kind = str(plan.values["kind"])
    try:
        return explain_stage(kind, plan, _command(kind, path, sets))
    except ArithmeticError:
        raise ComputationError(f"{path}: the scene's numbers overflow") from None


def _pipeline(path: Path, sets: tuple[str, ...]) -> "Explained":
    from hknob_cli.report.scene_words import Explained
    from hknob_cli.specs.load import load_pipeline
    from hknob_cli.stages.work import counted

    plan = load_pipeline(path, sets)
    lines = []
    for name, stage in plan.stages.items():
        after = f", after {', '.join(stage.needs)}" if stage.needs else ""
        with_ = f", with {', '.join(text.partition('=')[0] for text in stage.settings)} set" if stage.settings else ""
        lines.append(f"{name}: {stage.spec or f'results taken from {stage.folder}'}{with_}{after}.")
    answer = (
        f"{counted(len(plan.stages), 'stage')} run in the order of their inputs, each only if something has changed."
    )
    return Explained("pipeline", plan.name, answer, {"stages": lines}, [], _command("run", path, sets))


def _command(name: str, path: Path, overrides: tuple[str, ...]) -> str:
    """What runs that which is explained, with the same settings."""
    from hknob_cli.cli.run_done import settings

    return " ".join(["hknob", name, as_typed(path), *map(shlex.quote, settings(overrides))])


def _ledger(path: Path) -> "Explained":
    from hknob_cli.page.claims.ledger import load_ledger
    from hknob_cli.report.scene_words import Explained
    from hknob_cli.stages.work import counted

    claims = load_ledger(path).claims
    checks = {one.check for one in claims if one.check}
    answer = (
        f"A ledger of {counted(len(claims), 'claim')} of a text, judged by {counted(len(checks), 'kind')} of check."
    )
    return Explained("claims", path.stem, answer, {}, [], "hknob report, with a spec that names this file under claims")
