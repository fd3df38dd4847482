"""A run hit at every step by which it changes its folder: killed there, interrupted, or without room on the disk.

`python every_step.py SPEC FAULT WORK PART [BEFORE]` runs the spec in ``WORK``, in parts of ``PART`` cells, once for
each such step, each time from what the folder ``BEFORE`` holds, and again without a fault; the runs are copies of this
process, which has everything loaded. It prints a line of JSON for each step: what the step was, how the run with the
fault ended and what it said, what it left, how the run after it ended and what steps it took, and whether the folder is
then as an undisturbed run leaves it.
"""

import builtins
import contextlib
import errno
import gc
import io
import json
import os
import shutil
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tests.faults.small_pieces import shrink

CHANGES = ("mkdir", "rename", "replace", "unlink", "rmdir")
BLOCKS = 16
NEED_ROOM = ("mkdir", "rename", "replace", "open", "write")


def kill(_name: str) -> None:
    """End this process where it stands."""
    os.kill(os.getpid(), signal.SIGKILL)


def interrupt(_name: str) -> None:
    """As Ctrl-C does."""
    os.kill(os.getpid(), signal.SIGINT)


def full(name: str) -> None:
    """No room, from here on."""
    if name in NEED_ROOM:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


FAULTS = {"kill": (kill, False), "interrupt": (interrupt, False), "full": (full, True)}


class Steps:
    """Counts the steps of this process, and does ``fault`` before number ``at``, or all from there on."""

    def __init__(self, out: Path, at: int, report: Path, fault: Callable[[str], None], lasting: bool) -> None:
        self.out, self.at, self.report, self.fault, self.lasting = str(out), at, report, fault, lasting
        self.count = self.blocks = 0
        self.done: list[str] = []
        self.process = os.getpid()

    def take(self, name: str, *about: object) -> None:
        """A step is about to be taken; of the blocks of a journal, which are all alike, some count."""
        if os.getpid() != self.process:
            return
        if name == "write" and str(about[0]).endswith(".part"):
            self.blocks += 1
            if self.blocks % BLOCKS:
                return
        self.count += 1
        self.done.append(" ".join([name, *(os.path.basename(str(one)) for one in about)]))  # noqa: PTH119
        if self.count == self.at:
            with plain_open(self.report, "w") as stream:
                stream.write(self.done[-1])
        if self.count == self.at or (self.lasting and self.count > self.at):
            self.fault(name)

    def watch(self) -> None:
        """Count from now on."""
        for name in CHANGES:
            setattr(os, name, self._counted(name, getattr(os, name)))
        steps = self

        class Raw(io.FileIO):
            def write(self, data: Any) -> int:
                steps.take("write", self.name)
                return super().write(data)

        def opened(path: Any, mode: str = "r", *args: Any, **kwargs: Any) -> Any:
            if not (
                isinstance(path, (str, os.PathLike)) and os.fspath(path).startswith(self.out) and set(mode) & set("wxa")
            ):
                return plain_open(path, mode, *args, **kwargs)
            self.take("open", path)
            raw = Raw(path, mode.replace("b", "").replace("t", ""))
            if (args and args[0] == 0) or kwargs.get("buffering") == 0:
                return raw
            stream = io.BufferedWriter(raw)
            return stream if "b" in mode else io.TextIOWrapper(stream, encoding="utf-8")

        io.open = builtins.open = opened  # type: ignore[assignment]

    def _counted(self, name: str, plain: Callable[..., Any]) -> Callable[..., Any]:
        def counted(*args: Any, **kwargs: Any) -> Any:
            if kwargs.get("dir_fd") is not None or str(args[0]).startswith(self.out):
                self.take(name, *args[:2])
            return plain(*args, **kwargs)

        return counted


plain_open = io.open


def run(job: Any, said: Path, steps: Steps | None = None) -> int:
    """Run a job in a copy of this process; its exit code, negative for a signal. What it says is in ``said``."""
    child = os.fork()
    if child == 0:
        from hknob_cli import terminal
        from hknob_cli.cli.stage_run import run_stage

        signal.signal(signal.SIGINT, terminal.interrupt)
        signal.signal(signal.SIGTERM, terminal.interrupt)
        stream = os.open(said, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        os.dup2(stream, 1)
        os.dup2(stream, 2)
        if steps:
            steps.process = os.getpid()
            steps.watch()
        code = 0
        try:
            with terminal.reporting():
                run_stage(job)
        except SystemExit as leaving:
            code = int(leaving.code or 0)
        except BaseException:
            sys.excepthook(*sys.exc_info())
            code = 70
        sys.stdout.flush()
        if steps and not steps.at:
            steps.report.write_text("\n".join(steps.done))
        os._exit(code)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def files(out: Path) -> dict[str, bytes]:
    """All that is in a folder but its lock."""
    found = {path.relative_to(out).as_posix(): path for path in out.rglob("*")} if out.exists() else {}
    return {
        name: path.read_bytes() if path.is_file() else b"folder"
        for name, path in found.items()
        if path.name != ".hknob.lock"
    }


def main() -> None:
    """Run for each step."""
    spec, kind, work = Path(sys.argv[1]), sys.argv[2], Path(sys.argv[3])
    before = Path(sys.argv[5]) if len(sys.argv) > 5 else None
    fault, lasting = FAULTS[kind]
    shrink(int(sys.argv[4]))
    from hknob_cli.cli.stage_run import run_stage
    from hknob_cli.specs.load import load
    from hknob_cli.stages.job import Job

    gc.disable()  # as the command line does
    plan = load(spec)
    undisturbed = Job(kind=plan.values["kind"], plan=plan, out=work / "undisturbed", jobs=1)
    said, report = work / "said", work / "report"
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        run_stage(undisturbed)  # in this process, so that all it needs is loaded and compiled in the copies
    wanted = files(undisturbed.out)
    at = 0
    while True:
        at += 1
        out = work / "out"
        if before:
            shutil.copytree(before, out)
        report.unlink(missing_ok=True)
        job = undisturbed._replace(out=out)
        code = run(job, said, Steps(out, at, report, fault, lasting))
        if not report.exists():
            assert code == 0, said.read_text()
            print(json.dumps({"step": "none", "whole": files(out) == wanted}))
            return
        line = {"step": report.read_text(), "code": code, "said": said.read_text(), "left": sorted(files(out))}
        line["again"] = run(job, said, Steps(out, 0, report, fault, lasting=False))
        line["steps_again"] = report.read_text().splitlines()
        line["again_said"] = said.read_text()
        now = files(out)
        line["more"], line["less"] = sorted(now.keys() - wanted.keys()), sorted(wanted.keys() - now.keys())
        line["whole"] = now == wanted
        print(json.dumps(line), flush=True)
        with contextlib.suppress(FileNotFoundError):
            shutil.rmtree(out)


if __name__ == "__main__":
    main()
