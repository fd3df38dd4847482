"""What ``hknob run`` says in the end, and a run that has nothing to do, told before the command line is parsed.

Typer loads pydantic to convert a parameter, which takes longer than to look whether a pipeline is up to date. So the
command line that make repeats, ``run PIPELINE --out DIR``, is read here first. Any other one is left to typer, and so
is every fault.
"""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from hknob_cli.cli.next_step import after_pipeline
from hknob_cli.terminal import reporting, tell

Stage = dict[str, Any]
DONE = ("computed", "up to date")


def already_done(arguments: Sequence[str]) -> bool:
    """Whether a command line asks for a pipeline that is up to date; if so, that has been said.

    Raises `SystemExit` where it was interrupted, or what it has to say cannot be written.
    """
    match arguments:
        case ["run", spec, "--out" | "-o", out] if not (spec.startswith("-") or out.startswith("-")) and out.strip():
            pipeline, root = Path(spec), Path(out)
        case _:
            return False
    if not pipeline.is_file():
        return False
    with reporting():
        from hknob_cli.pipeline import fresh

        done = fresh.finished(root, fresh.asked(pipeline, root, fresh.options()))
        if done is not None:
            report(pipeline, root, done["name"], done["stages"])
    return done is not None


def report(
    pipeline: Path,
    root: Path,
    name: str,
    stages: list[Stage],
    *,
    sets: Sequence[str] = (),
    until: str | None = None,
    as_json: bool = False,
    quiet: bool = False,
) -> None:
    """Say what became of the stages, where the pages are, and the next command if all is done."""
    if as_json:
        print(json.dumps({"kind": "pipeline", "name": name, "stages": stages}))
        return
    counts: dict[str, int] = {}
    for stage in stages:
        counts[stage["status"]] = counts.get(stage["status"], 0) + 1
    said = ", ".join(f"{count} {status}" for status, count in counts.items())
    if stages:
        tell(f"{name}: {len(stages)} stage{'s' if len(stages) > 1 else ''}, {said}")
        tell(f"results: {root}")
    else:
        tell(f"{name}: no stage to run")
    done = [stage for stage in stages if stage["status"] in DONE]
    files = [file for stage in done for file in stage["files"]]
    for file in files:
        if file.endswith(".html"):
            tell(f"page: {file}")
    if not quiet and len(done) == len(stages) and (step := after_pipeline(pipeline, root, sets, name, until, files)):
        tell(f"next: {step}")
