"""Commands that lose their power in `crashes.py`: what each is run on, what it begins and reports as done, and where.

Pieces of the sweep come from workers of a seed (`tests/spread/crew.py`), so that they come in any order, twice and
wrongly, too.
"""

import hashlib
import re
from collections.abc import Callable
from contextlib import ExitStack
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from tests.conftest import SPEC
from tests.faults.recorder import Recorder
from tests.faults.small_pieces import shrink
from tests.hardware.campaigns import SPEC as CAMPAIGN
from tests.hardware.campaigns import Faulty, campaign
from tests.spread.crew import Crew, at_work

SIX = SPEC.replace("[1000]", "[1000, 1500]").replace("[1024]", "[512, 1024, 2048]").replace("phases: 8", "phases: 2")
PIPELINE = """\
kind: pipeline
name: p
stages:
  grid: {spec: spec.yaml}
  laws: {spec: laws.yaml, set: {against: {from: grid}}}
  page: {spec: page.yaml, set: {results: {from: [grid]}}}
"""
LAWS = re.sub(r"starts: .*\n", "", SPEC.replace("kind: sweep", "kind: predict"))
PAGE = "kind: report\nname: page\nresults: {grid: grid}\n"
REMEDIES = (Path(__file__).parents[1] / "fuzz" / "corpus" / "remedies_small.yaml").read_text()
TRIALS = CAMPAIGN.replace("buzz: [0.1, 0.2]", "buzz: [0.1, 0.1]").replace("[256, 512]", "[256]")
FAILS_AT = 30  # block of the device
FIRST = 0  # seed of the run whose changes are written down first; others have lower ones


class Told:
    """What a run has begun, and what it has said is done."""

    def __init__(self) -> None:
        self.begun: list[str] = []
        self.recorder: Recorder | None = None
        self.crew: Any = None

    def done(self, what: str) -> None:
        """Something is on the disk, as far as the user is told."""
        if self.recorder:
            self.recorder.mark(what)


class Case(NamedTuple):
    """``run`` in a folder, by a seed, gives an exit code; ``listen`` tells what it begins and has done.

    ``apart``: paths that need not be the same after every run; ``prepare``: what is there before; ``ends``: with which
    exit codes the first run ends.
    """

    name: str
    specs: dict[str, str]
    run: Callable[[Path, int, Told], int]
    listen: Callable[[Told], None]
    apart: re.Pattern[str] = re.compile(r"(^|/)\.hknob\.lock$")
    prepare: Callable[[Path, Told], None] | None = None
    ends: Callable[[int], bool] = lambda code: code == 0


def hear(owner: Any, name: str, told: Callable[..., Callable[[Any], None]]) -> None:
    """Let a function tell: ``told`` gets its arguments before, and returns what gets its result."""
    plain = getattr(owner, name)

    def both(*args: Any, **kwargs: Any) -> Any:
        then = told(*args)
        found = plain(*args, **kwargs)
        then(found)
        return found

    setattr(owner, name, both)


@cache
def command() -> Any:
    """What ``hknob`` calls, with stages run in this process."""
    from typer.main import get_command

    from hknob_cli.cli import app as commands
    from hknob_cli.cli.app import app
    from hknob_cli.cli.stage_run import run_stage

    commands.submit = run_stage  # type: ignore[attr-defined]
    return get_command(app)


def ended(act: Callable[[], Any]) -> int:
    """The exit code of what is run as the program runs it."""
    from hknob_cli.terminal import reporting

    try:
        with reporting():
            act()
    except SystemExit as leaving:
        return int(leaving.code or 0)
    return 0


def commanded(*words: str) -> Callable[[Path, int, Told], int]:
    """Run a command."""

    def run(out: Path, seed: int, told: Told) -> int:
        told.crew = seed
        return ended(lambda: command()([*words, "-o", str(out), "-q"], prog_name="hknob"))

    return run


def hear_results(told: Told) -> None:
    """A stage's results."""
    from hknob_cli.cli import stage_run

    def made(*_: Any) -> Callable[[Any], None]:
        def then(found: Any) -> None:
            told.begun += ["results"] * found.computed
            told.done("results")

        return then

    hear(stage_run, "make", made)


def hear_cells(told: Told) -> None:
    """Cells of a sweep, and from whom they come."""
    shrink()
    from hknob_cli.spread import gather as gathering
    from hknob_cli.stages.sweep import assembly
    from hknob_cli.stages.sweep.assembly import Assembly

    hear_results(told)

    def take(_self: Any, start: int, stop: int, _data: bytes) -> Callable[[Any], None]:
        cells = [f"cell {cell}" for cell in range(start, stop)]
        told.begun += cells
        return lambda _found: [told.done(cell) for cell in cells]  # type: ignore[func-returns-value,return-value]

    hear(Assembly, "take", take)
    plain = gathering.gather

    def gather(crew: Crew, *args: Any, **kwargs: Any) -> None:
        with at_work(crew):
            plain(crew, *args, **kwargs)

    gathering.gather = gather  # type: ignore[assignment]
    found: dict[tuple[bytes, int, int], bytes] = {}  # what a piece is does not depend on the disk

    def workers(_job: Any, _stage: Any, finder: Any, _notify: Any) -> Crew:
        def find(start: int, stop: int) -> bytes:
            key = finder.parting.provenance, start, stop
            if key not in found:
                found[key] = finder(start, stop)
            return found[key]

        return Crew(find, told.crew, most_faults=5)

    assembly._workers = workers  # type: ignore[assignment]


def hear_trials(told: Told) -> None:
    """Trials of a campaign."""
    from hknob_cli.hardware.archive import Archive

    hear_results(told)

    def begin(_self: Any, trial: Any, *_: Any) -> Callable[[Any], None]:
        told.begun.append(f"trial {trial.label}")
        return lambda _found: None

    hear(Archive, "begin", begin)
    hear(Archive, "finish", lambda _self, recorded: lambda _found: told.done(f"trial {recorded.trial.label}"))


def hear_recordings(told: Told) -> None:
    """Trials on a device, and what is set aside of those that were broken off."""
    from hknob_cli.hardware.archive import Archive

    hear_trials(told)

    def aside(*_: Any) -> Callable[[Any], None]:
        return lambda path: told.done(f"kept {digest(path)} {path.name}") if path else None

    hear(Archive, "set_aside", aside)


def hear_stages(told: Told) -> None:
    """Stages of a pipeline."""
    from hknob_cli.pipeline import steps

    def made(job: Any, _work: Any) -> Callable[[Any], None]:
        def then(found: Any) -> None:
            told.begun += [job.out.name] * found.computed
            told.done(job.out.name)

        return then

    hear(steps, "make", made)


def hear_tasks(told: Told) -> None:
    """Tasks of a stage that keeps what each has found; it writes at once, not once a second."""
    from hknob_cli.stages import make

    hear_results(told)
    make.EVERY_S = -1.0

    def put(_self: Any, number: int, _found: Any) -> Callable[[Any], None]:
        told.begun.append(f"task {number}")
        return lambda _none: told.done(f"task {number}")

    hear(make.Kept, "put", put)


def record(out: Path, seed: int, told: Told) -> int:
    """A campaign on a device, which fails on the way in the first run that is to lose its power."""
    from hknob_cli.results.store import hold

    begins = told.recorder is not None and seed <= FIRST

    def act() -> None:
        with hold(out, []):
            campaign(out, Faulty(FAILS_AT - 9 * seed if begins else None), is_source=True).run()

    return ended(act)


def prepare_recordings(out: Path, _told: Told) -> None:
    """A campaign on a device that is done."""
    from hknob_cli.results.store import hold

    with hold(out, []), ExitStack():
        campaign(out, Faulty(), is_source=True).run()


def prepare_others(out: Path, told: Told) -> None:
    """Results of another spec, in parts."""
    assert commanded("sweep", "other.yaml")(out, 1, told) == 0


def begin_anew(out: Path, _seed: int, told: Told) -> int:
    """What ``--force`` does with recordings of a device."""
    from hknob_cli.hardware.journal import move_to_earlier
    from hknob_cli.results.store import hold

    def act() -> None:
        if told.recorder:
            for path in sorted(out.rglob("*.parquet")):
                told.done(f"kept {digest(path)} {path.name}")
        with hold(out, []):
            move_to_earlier(out)

    return ended(act)


def digest(path: Path) -> str:
    """Of a file's content."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


LOCK = r"(^|/)\.hknob\.lock$"
PYTASK = r"(^|/)(\.pytask.*|pytask\.lock.*)$"
CASES = {
    case.name: case
    for case in (
        Case("sweep", {"spec.yaml": SIX}, commanded("sweep", "spec.yaml"), hear_cells),
        Case(
            "replaced",
            {"spec.yaml": SIX, "other.yaml": SIX.replace("phases: 2", "phases: 3")},
            commanded("sweep", "spec.yaml"),
            hear_cells,
            prepare=prepare_others,
        ),
        Case("hw-run", {"spec.yaml": TRIALS}, commanded("hw-run", "spec.yaml"), hear_trials),
        Case(
            "run",
            {"spec.yaml": SPEC.replace("phases: 8", "phases: 2"), "laws.yaml": LAWS, "page.yaml": PAGE,
             "run.yaml": PIPELINE},
            commanded("run", "run.yaml", "-j", "1"),  # what other processes write is not written down
            hear_stages,
            apart=re.compile(f"{LOCK}|{PYTASK}"),
        ),
        Case("remedies", {"spec.yaml": REMEDIES}, commanded("remedies", "spec.yaml", "-j", "1"), hear_tasks),
        Case(
            "device",
            {},
            record,
            hear_recordings,
            apart=re.compile(f"{LOCK}|/aborted(/|$)"),
            ends=lambda code: code in (0, 4),
        ),
        Case(
            "earlier", {}, begin_anew, lambda _told: None, apart=re.compile("results"), prepare=prepare_recordings
        ),
    )
}  # fmt: skip
