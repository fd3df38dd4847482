"""A spec through the commands that read it: check, a dry run, and where its plan is cheap the stage itself."""

import re
from collections.abc import Iterator

from hknob_cli.errors import ExitCode
from tests.fuzz.arena import Arena
from tests.fuzz.attempt import Attempt, settled
from tests.fuzz.seeds import CASE, CLAIMS
from tests.fuzz.spec_case import SpecCase

PIPELINE = "pipeline"


def attempts(case: SpecCase, arena: Arena) -> list[Attempt]:
    """Every command that was tried, the first one that broke a rule the last."""
    with arena.entered():
        arena.clear()
        tried: list[Attempt] = []
        for command, may_write in _commands(case, arena):
            done = settled(arena, *command, may_write=may_write)
            tried.append(done._replace(breaches=(*done.breaches, *_of_faults(done), *_of_codes(tried, done))))
            if tried[-1].breaches:
                break
        return tried


def _commands(case: SpecCase, arena: Arena) -> Iterator[tuple[tuple[str, ...], bool]]:
    sets = tuple(word for one in case.sets for word in ("--set", one))
    out = ("--out", str(arena.out))
    arena.spec.write_bytes(case.data)
    if case.kind == CASE:
        yield ("predict", "predict.yaml", *out, "--dry-run", "--set", "constant.case=spec.yaml"), False
        return
    if case.kind == CLAIMS:
        yield ("check", "spec.yaml", *sets), False
        yield ("report", "report.yaml", *out, "--dry-run", "--set", "claims=spec.yaml"), False
        return
    yield ("check", "spec.yaml", *sets), False
    command = "run" if case.kind == PIPELINE else case.kind
    yield (command, "spec.yaml", *sets, *out, "--dry-run"), False
    if case.run is not None:
        from tests.fuzz.cheap import is_cheap

        if is_cheap(arena.spec, case.sets):
            yield (command, "spec.yaml", *sets, *out, "--jobs", "1", *case.run), True


# Where a fault is: a place in a file, the option that made it, or the file as a whole; and what else there is.
PLACE = re.compile(r"^([^:]+:\d+:\d+: |--set |spec\.yaml: larger than |\.\.\. and \d+ more faults$)")


def _of_faults(done: Attempt) -> Iterator[tuple[str, str]]:
    """A bad spec has a place for each of its faults."""
    if done.code == ExitCode.USAGE and done.command[0] == "check":
        for line in done.err.splitlines():
            if not PLACE.match(line):
                yield "no place", line[:200]


def _of_codes(before: list[Attempt], done: Attempt) -> Iterator[tuple[str, str]]:
    """What only looks ends well or with a fault of the spec; what is good to a stage is good to the check."""
    if done.code is None or "--jobs" in done.command:
        return
    if done.code not in (ExitCode.DONE, ExitCode.USAGE):
        yield "exit code", f"{done.code} where nothing is computed"
    if before and before[0].code == ExitCode.USAGE and done.code == ExitCode.DONE and "spec.yaml" in done.command:
        yield "check disagrees", "what it refuses would be run"
