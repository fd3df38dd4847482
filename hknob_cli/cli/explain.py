"""``hknob explain``: what a spec describes, in words; computes no results and writes nothing."""

import json
import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hknob_cli.cli.options import Json, Sets
from hknob_cli.specs.standard_input import as_typed, named
from hknob_cli.terminal import reporting, tell

if TYPE_CHECKING:
    from hknob_cli.report.scene_words import Explained


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
    from hknob_cli.cli.next_step import settings

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
