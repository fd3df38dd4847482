"""What a command says in the end: what ``hknob run`` has done, and the command that a user would want next.

A run that has nothing to do is told here, before the command line is parsed. Typer loads pydantic to convert a
parameter, which takes longer than to look whether a pipeline is up to date. So the command line that make repeats,
``run PIPELINE --out DIR``, is read here first. Any other one is left to typer, and so is every fault.
"""

import json
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hknob_cli.errors import UsageError
from hknob_cli.specs.named_file import is_stdin
from hknob_cli.terminal import reporting, tell

if TYPE_CHECKING:
    from hknob_cli.stages.job import Job
    from hknob_cli.stages.work import Work

_LONGEST = 200  # of a file's name; a spec's name may be longer


def after_stage(job: "Job", work: "Work", summary: dict[str, Any]) -> str:
    """The command line; empty if there is none, as of a job that no command named.

    The page of the results, else a page to play with the one knob of a sweep, else a spec of the best of what was
    tried, else the picture, else the next spec. Nothing is named that is there already. A knob that does not buzz needs
    no remedies.
    """
    if not job.spec or is_stdin(Path(job.spec)):
        return ""
    if pages := [name for name in work.texts(job) if name.endswith(".html")]:
        return _show(job.out / pages[0])
    if _can_be_played_with(job):
        return shlex.join(["hknob", "explore", job.spec, *settings(job.overrides)])
    if along := work.take_along(job, summary):
        kind, remedy = along
        if (same := _from(job, kind, remedy)) and (step := _new(kind, job.plan.name, same)):
            return step
    if work.pictures(job) and not job.plot:
        out = _out(job.out, job.plan.name)
        return shlex.join(["hknob", job.kind, job.spec, "--plot", *out, *settings(job.overrides)])
    then = work.then(job)
    if not then or not summary.get("orbits", {"cycle": 1})["cycle"]:
        return ""
    return _new(then, job.plan.name, _from(job, then))


def _from(job: "Job", then: str, remedy: str | None = None) -> list[str]:
    """Options that give a spec of a kind the knob of a job; none if it cannot have that, as a design that of a grid."""
    from hknob_cli.stages.begin_from import FROM, KINDS, begin_from

    if job.kind not in FROM or then not in KINDS:
        return []
    try:
        begin_from(then, Path(job.spec), "", Path(), job.overrides, remedy)
    except UsageError:
        return []
    return ["--from", job.spec, *settings(job.overrides), *([] if remedy is None else ["--remedy", remedy])]


def after_pipeline(
    spec: Path, root: Path, overrides: Sequence[str], name: str, until: str | None, files: Sequence[str]
) -> str:
    """The command line after all stages that were asked for are done; ``files`` are their results.

    What is left of the pipeline, else its page, else a spec of a page.
    """
    if until and not is_stdin(spec):
        return shlex.join(["hknob", "run", str(spec), *_out(root, name), *settings(overrides)])
    pages = [file for file in files if file.endswith(".html")]
    return _show(Path(pages[-1])) if pages else _new("report", name)


def _can_be_played_with(job: "Job") -> bool:
    """Whether a sweep has one knob, which the page of ``hknob explore`` follows, and there is no such page yet."""
    from hknob_cli.specs.cells import cells_of

    if job.kind != "sweep" or job.plot or len(cells_of(job.plan)) != 1:
        return False
    from hknob_cli.page.explore import faults_of, page_of

    return not page_of(job.plan.name).exists() and not faults_of(job.plan)


def _show(page: Path) -> str:
    return shlex.join(["python3", "-m", "webbrowser", str(page)])


def _new(kind: str, name: str, same: Sequence[str] = ()) -> str:
    """``same``: options that give it the knob of another spec."""
    file = f"{name}-{kind}.yaml"
    if len(file) > _LONGEST or Path(file).exists():
        return ""
    return shlex.join(["hknob", "new", kind, *same, "--out", file])


def _out(folder: Path, name: str) -> list[str]:
    return [] if folder == Path("results") / name else ["--out", str(folder)]


def settings(overrides: Sequence[str]) -> list[str]:
    """The same settings, as words of a command line."""
    return [word for one in overrides for word in ("--set", one)]


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
