"""``hknob explore``: write a page on which a knob can be played with, and open it where a person is looking."""

import json
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hknob_cli.cli.options import Json, Quiet, Sets
from hknob_cli.errors import RefusedError, UsageError, unwritable
from hknob_cli.specs.named_file import named
from hknob_cli.terminal import reporting, say, tell

if TYPE_CHECKING:
    from hknob_cli.specs.plan import SweepPlan

EXAMPLE = "the example"  # how the spec is called that is taken without one


def explore(
    spec: Annotated[
        Path | None,
        typer.Argument(
            callback=named,
            metavar="[SPEC.yaml]",
            help="A sweep to begin with; - is standard input. Without one, a light knob against a wall.",
            show_default=False,
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            "-o",
            metavar="FILE",
            help="The page to write.  [default: results/NAME-explore.html]",
            show_default=False,
        ),
    ] = None,
    sets: Sets = None,
    open_it: Annotated[
        bool | None,
        typer.Option(
            "--open/--no-open",
            help="Open the page in a browser.  [default: only at a terminal with a screen]",
            show_default=False,
        ),
    ] = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Write a page to play with a knob: sliders, the exact motion, its sound, and a remedy beside it."""
    with reporting():
        from hknob_cli.page.explore import knobs_of, page_of, sheet
        from hknob_cli.report.table import folded
        from hknob_cli.stages.work import counted

        called = str(spec) if spec else EXAMPLE
        knobs = knobs_of(_plan(spec, tuple(sets or ())), called)
        path = out or page_of(knobs.name)
        _write(path, sheet(knobs))
        if as_json:
            print(json.dumps({"kind": "explore", "name": knobs.name, "cells": len(knobs.cells), "files": [str(path)]}))
        else:
            tell(folded(f"{knobs.name}: {counted(len(knobs.cells), 'knob')} of {called} to change, see and hear"))
            tell(f"\nwrote {path}")
            for note in () if quiet else knobs.notes:
                say(note)
        wanted = _is_watched() if open_it is None else open_it
        if wanted and not _shown(path):
            say(f"no browser was found; open {path} in one")
        elif not wanted and not (as_json or quiet):
            tell(f"next: open {path} in a browser")


def _plan(spec: Path | None, sets: tuple[str, ...]) -> "SweepPlan":
    """The sweep to begin with. Raises `UsageError` for a spec of another kind."""
    from hknob_cli.specs.load import load, load_text
    from hknob_cli.specs.plan import SweepPlan
    from hknob_cli.specs.starter import starter

    plan = load(spec, sets, kind="sweep") if spec else load_text(starter("sweep"), EXAMPLE, sets, kind="sweep")
    assert isinstance(plan, SweepPlan)
    return plan


def _write(path: Path, text: str) -> None:
    """Write the page, whole or not at all.

    Raises `RefusedError` where another file is in its place, `ComputationError` where it cannot be written.
    """
    from hknob_cli.page.explore import MARK
    from hknob_cli.results.files import create, make_folders, put_in_place

    half = path.with_name(f".{path.name}.part")
    try:
        if path.is_dir():
            raise UsageError(f"--out: {path} is a folder; must name a file")
        if path.exists() and MARK.encode() not in path.read_bytes()[:200]:
            raise RefusedError(f"{path}: is there already and was not written by explore; name another file with --out")
        make_folders(path.parent)
        try:
            with create(half) as file:
                file.write(text.encode())
            put_in_place(half, path)
        finally:
            half.unlink(missing_ok=True)
    except OSError as error:
        raise unwritable(path, error) from None


def _is_watched() -> bool:
    """Whether a person sits at a terminal of this machine, with a screen: never in a script or a remote shell."""
    if not (sys.stdout.isatty() and sys.stdin.isatty()) or os.environ.get("SSH_CONNECTION"):
        return False
    return sys.platform in ("darwin", "win32") or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def _shown(path: Path) -> bool:
    """Whether a browser has been told to open the page."""
    import webbrowser

    return webbrowser.open(path.resolve().as_uri())
