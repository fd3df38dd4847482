"""Running the steps. Order, what is out of date, and the journal are pytask's; here it is asked, its answer read.

The classes follow pytask's protocols (``PNode``, ``PTask``) without importing it, so that whether anything has changed
can be said before it is loaded.
"""

import contextlib
import hashlib
import io
import os
import shutil
import tempfile
from collections.abc import Callable, Iterator, Sequence
from enum import Enum
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

from hknob_cli.errors import ComputationError
from hknob_cli.pipeline.fresh import LOCK
from hknob_cli.results.files import create, read_digest
from hknob_cli.terminal import heed


class FileNode:
    """A file, or a folder of results, that a step reads or writes.

    It is named from the folder of the record, and its state is the digest of its content.
    """

    def __init__(self, path: Path, root: Path) -> None:
        self.file = path.absolute()
        self.shown = str(path)
        self.name = Path(os.path.relpath(path, root)).as_posix()
        self.attributes: dict[Any, Any] = {}

    @property
    def signature(self) -> str:
        """What tells nodes apart."""
        return f"file {self.file}"

    def state(self) -> str | None:
        """Digest of the content; None if there is no file. Raises `ComputationError` if it cannot be read."""
        try:
            return read_digest(self.file)
        except OSError as error:
            raise ComputationError(f"{self.shown}: cannot be read: {error.strerror or error}") from None

    def load(self, is_product: bool = False) -> Path:  # noqa: ARG002
        """The path."""
        return self.file

    def save(self, value: Any) -> None:
        """Steps write their files themselves."""
        raise NotImplementedError


class ValueNode:
    """Something a step depends on that is no file: settings, the version of the program."""

    def __init__(self, name: str, value: str) -> None:
        self.name = name
        self.value = value
        self.attributes: dict[Any, Any] = {}

    @property
    def signature(self) -> str:
        """What tells nodes apart."""
        return f"value {self.name}"

    def state(self) -> str:
        """Digest of the value."""
        return hashlib.sha256(self.value.encode()).hexdigest()

    def load(self, is_product: bool = False) -> str:  # noqa: ARG002
        """The value."""
        return self.value

    def save(self, value: Any) -> None:
        """Values are not written."""
        raise NotImplementedError


class Step:
    """One stage to run: what it ``reads``, what it ``writes``, the ``values`` it depends on by name, and how to run it.

    ``needs`` are the files of other steps; ``root`` is the folder of the record. ``run`` says whether anything had to
    be computed, which ``computed`` keeps, and raises `HknobError`.
    """

    def __init__(
        self,
        name: str,
        *,
        reads: tuple[Path, ...],
        needs: tuple[Path, ...],
        writes: tuple[Path, ...],
        values: dict[str, str],
        root: Path,
        run: Callable[[], bool],
    ) -> None:
        self.name = name
        self.reads = reads
        self.needs = needs
        self.writes = writes
        self.run = run
        self.values = values
        self.root = root
        self.markers: list[Any] = []
        self.report_sections: list[tuple[str, str, str]] = []
        self.attributes: dict[Any, Any] = {}
        self.function = run
        self.computed = False

    @cached_property
    def depends_on(self) -> dict[str, Any]:
        """Nodes that it waits for."""
        files = [FileNode(path, self.root) for path in dict.fromkeys((*self.reads, *self.needs))]
        values = [ValueNode(f"{self.name}: {name}", value) for name, value in self.values.items()]
        return {"inputs": [*files, *values]}

    @cached_property
    def produces(self) -> dict[str, Any]:
        """Nodes that it makes."""
        return {"outputs": [FileNode(path, self.root) for path in self.writes]}

    @property
    def signature(self) -> str:
        """What tells steps apart."""
        return f"step {self.name}"

    def state(self) -> str:
        """What it depends on is in its inputs."""
        return "1"

    def execute(self, **_inputs: Any) -> None:
        """Run it."""
        self.computed = self.run()


_CONFIG = ".pytask.toml"
_WIDE = 10_000  # letters, so that no path is cut by the end of a line
_VALUES = {
    "spec": "the spec on standard input",
    "settings": "what the pipeline sets in the spec",
    "program": "the program",
}


class Fate(Enum):
    """What became of a step."""

    COMPUTED = "computed"
    UP_TO_DATE = "up to date"
    WOULD_RUN = "would run"
    FAILED = "failed"
    NOT_REACHED = "not reached"


class Outcome(NamedTuple):
    """A step, what became of it, why it ran or would run, and the error it failed with."""

    name: str
    fate: Fate
    why: tuple[str, ...] = ()
    error: BaseException | None = None


def build(steps: Sequence[Step], root: Path, *, force: bool = False, dry: bool = False) -> list[Outcome]:
    """Run what is out of date, in order, and say what became of each step; with ``dry`` say what would run, and why.

    What was done is kept in ``root`` (``pytask.lock``, and beside it a journal while it runs), step by step, so that an
    interruption at any instant loses no finished step. Raises `ComputationError` where that record cannot be used.
    """
    import pytask

    tasks: Any = list(steps)
    with _place(root, dry=dry) as place, _silence() as said:
        _drop_links(place)
        _drop_unusable(place / LOCK)
        config = place / _CONFIG
        with create(config) as stream:
            stream.write(b"[tool.pytask.ini_options]\n")
        session = pytask.build(
            tasks=tasks,
            config=config,  # its folder is where the record is
            database_url="sqlite://",  # in memory; the lock file is the record
            capture="no",
            verbose=0,
            force=force,
            explain=dry,
            show_traceback=False,
            show_locals=False,
        )
    reports = {report.task.name: report for report in session.execution_reports}
    if not reports and steps:
        raise ComputationError(f"{root}: the record of what was run cannot be used: {_last_line(said.getvalue())}")
    if len(reports) < len(steps) and not any(report.outcome == pytask.TaskOutcome.FAIL for report in reports.values()):
        heed()
        raise ComputationError(
            f"{root}: the record of what was run cannot be kept: {_last_line(said.getvalue())}; what is finished is "
            "kept, run the same command again"
        )
    return [_outcome(step, reports.get(step.name), force=force) for step in steps]


@contextlib.contextmanager
def _place(root: Path, *, dry: bool) -> Iterator[Path]:
    """Where pytask keeps its record; for a plan, which writes nothing, a copy of it."""
    if not dry:
        yield root
        return
    with tempfile.TemporaryDirectory() as copy:
        for name in (LOCK, f"{LOCK}.journal"):
            with contextlib.suppress(OSError):
                shutil.copyfile(root / name, Path(copy) / name)
        yield Path(copy)


def _drop_links(place: Path) -> None:
    """Remove links where pytask writes its record: it would write to what they lead to."""
    for name in (LOCK, f"{LOCK}.journal", f"{LOCK}.tmp", ".pytask"):
        if (place / name).is_symlink():
            (place / name).unlink()


def _drop_unusable(lock: Path) -> None:
    """Remove a record that is torn or of another version; the steps then find their own results as they are."""
    from _pytask.lockfile import LockfileState

    journal = lock.with_name(f"{lock.name}.journal")
    try:
        LockfileState.from_path(lock, lock.parent)
    except Exception:  # whatever it is that cannot be read
        lock.unlink(missing_ok=True)
        journal.unlink(missing_ok=True)
    if journal.exists() and not journal.stat().st_size:
        journal.unlink()


def _outcome(step: Step, report: Any, *, force: bool) -> Outcome:
    import pytask

    if report is None:
        return Outcome(step.name, Fate.NOT_REACHED)
    error = report.exc_info[1] if report.exc_info else None
    kinds = pytask.TaskOutcome
    if report.outcome == kinds.SUCCESS:
        return Outcome(step.name, Fate.COMPUTED if step.computed else Fate.UP_TO_DATE)
    if report.outcome in (kinds.SKIP_UNCHANGED, kinds.PERSISTENCE):
        return Outcome(step.name, Fate.UP_TO_DATE)
    if report.outcome == kinds.WOULD_BE_EXECUTED:
        return Outcome(step.name, Fate.WOULD_RUN, ("forced",) if force else tuple(_reasons(step)))
    if report.outcome == kinds.FAIL:
        if isinstance(error, MemoryError):  # which says nothing by itself
            error = ComputationError("out of memory; run the same command again")
        return Outcome(step.name, Fate.FAILED, error=error)
    return Outcome(step.name, Fate.NOT_REACHED)


def _reasons(step: Step) -> Iterator[str]:
    """Why a step would run, in words."""
    explanation = step.attributes.get("explanation")
    files = {node.name: node.shown for node in step.depends_on["inputs"] if isinstance(node, FileNode)}
    missing = 0
    for reason in explanation.reasons if explanation else ():
        name = reason.node_name
        name = files.get(name) or _VALUES.get(name.removeprefix(f"{step.name}: "), name)
        if reason.reason == "cascade":
            yield f"{name} would run"
        elif reason.node_type == "product" and reason.reason in ("missing", "not_in_db"):
            missing += 1
        elif reason.reason == "not_in_db":
            continue  # said by what is missing
        elif reason.node_type == "product":
            yield f"{name} is not as it was written"
        else:
            yield f"{name} has changed"
    if missing:
        gone = [node.file.name for node in step.produces["outputs"] if isinstance(node, FileNode) and not node.state()]
        yield f"no {gone[0]} yet" if gone else "no record of a finished run"


@contextlib.contextmanager
def _silence() -> Iterator[io.StringIO]:
    """Keep pytask's own account of the run from standard output."""
    from _pytask.console import console

    said = io.StringIO()
    before, width = console.file, console.width
    console.file, console.width = said, _WIDE
    try:
        yield said
    finally:
        console.file, console.width = before, width


def _last_line(text: str) -> str:
    lines = [line.strip(" │╭╰─╮╯") for line in text.splitlines()]
    return next((line for line in reversed(lines) if line), "no reason given")
