"""Changes every comparison, coefficient and condition of the proofs, one at a time; some test must fail each time.

`python tests/mutation/campaign.py rest.py sets/ball.py` tries these files of the engine, without names all of them.
One process collects the tests and runs them once; for each change it forks, gives the function its changed code, and
runs the quickest tests that call it until one fails. Nothing is written. A change that hangs counts as found. What is
allowed to survive is listed in `accepted.toml`, with the reason. Exit code 1 if any other change survives.
"""

import argparse
import os
import resource
import select
import signal
import sys
import time
import types
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

sys.path.insert(0, str(Path(__file__).parents[2]))

from tests.mutation.accepted import Accepted
from tests.mutation.mutate import Mutant, mutants
from tests.mutation.table import LEFT_OUT, ROOT, WATCHED, path_of, watchers_of

SLOWEST_S = 40.0  # a test that takes longer does not run, and cannot watch over anything
MEMORY_BYTES = 8 * 2**30  # of a changed program that fills its memory


def module_of(path: Path) -> types.ModuleType:
    """The engine's module, which the tests have loaded."""
    return sys.modules[".".join(path.relative_to(ROOT).with_suffix("").parts)]


def functions_of(module: types.ModuleType) -> Iterator[tuple[str, types.FunctionType]]:
    """Functions that a module holds, and the methods of its own classes, by name."""
    for name, value in vars(module).items():
        if isinstance(value, types.FunctionType):
            yield name, value
        elif isinstance(value, type) and value.__module__ == module.__name__:
            for method, one in vars(value).items():
                if isinstance(one, types.FunctionType):
                    yield f"{name}.{method}", one


def put_in_place(mutant: Mutant) -> None:
    """Change the running program: a function's code, or a constant wherever it has been imported."""
    module = module_of(mutant.path)
    if mutant.function is not None:
        dict(functions_of(module))[mutant.function].__code__ = mutant.code()
        return
    old, new = getattr(module, mutant.name), mutant.value()
    for one in list(sys.modules.values()):
        if one.__name__.startswith("hknob_cli.") and getattr(one, mutant.name, None) is old:
            setattr(one, mutant.name, new)


class Campaign:
    """A plugin of pytest that runs the collected tests once as they are, and then against every change."""

    def __init__(self, chosen: list[Mutant], accepted: Accepted) -> None:
        self.chosen, self.accepted = chosen, accepted
        self.failed: list[str] = []
        self.took: dict[str, float] = {}
        self.calls: dict[tuple[Path, str], set[str]] = defaultdict(set)  # tests by function
        self.killers: dict[str, list[str]] = defaultdict(list)  # of a function's changes, the last first
        self.survived: list[Mutant] = []
        self.killed = 0

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Note what fails, and how long it took."""
        self.took[report.nodeid] = self.took.get(report.nodeid, 0.0) + report.duration
        if report.failed:
            self.failed.append(f"{report.nodeid}\n{report.longreprtext}")

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        """Note files that cannot be collected."""
        if report.failed:
            self.failed.append(f"{report.nodeid}\n{report.longreprtext}")

    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        """Run all tests, then all changes."""
        if self.failed:
            return True
        self._run_unchanged(session)
        if self.failed:
            return True
        items = {item.nodeid: item for item in session.items if self.took[item.nodeid] <= SLOWEST_S}
        for nodeid in self.took.keys() - items.keys():
            print(f"too slow to run each time: {nodeid} ({self.took[nodeid]:.1f} s)", flush=True)
        for mutant in self.chosen:
            if self._survives(mutant, items):
                reason = self.accepted.take(mutant)
                if reason is None:
                    self.survived.append(mutant)
                    print(f"survived: {mutant}", flush=True)
            else:
                self.killed += 1
                self.accepted.note_killed(mutant)
        return True

    def _run_unchanged(self, session: pytest.Session) -> None:
        watched = {m.path for m in self.chosen}
        codes = {value.__code__: (path, name) for path in watched for name, value in functions_of(module_of(path))}
        for item, following in zip(session.items, [*session.items[1:], None], strict=True):
            with called(codes) as found:
                item.config.hook.pytest_runtest_protocol(item=item, nextitem=following)
            for one in found:
                self.calls[one].add(item.nodeid)

    def _survives(self, mutant: Mutant, items: dict[str, pytest.Item]) -> bool:
        called_by = set(items) if mutant.function is None else self.calls[mutant.path, mutant.function]
        names = called_by & items.keys()
        recent = self.killers[mutant.name]
        order = [one for one in recent if one in names]
        order += sorted(names - set(order), key=lambda one: (self.took[one], one))
        limit = 10.0 + 4.0 * sum(self.took[one] for one in order)
        read, write = os.pipe()
        child = os.fork()
        if child == 0:
            os.close(read)
            self._try(mutant, [items[one] for one in order], write)
        os.close(write)
        heard = b""
        if select.select([read], [], [], limit)[0]:
            heard = os.read(read, 4096)
        else:
            os.kill(child, signal.SIGKILL)
            heard = b"hangs"
        os.close(read)
        os.waitpid(child, 0)
        killer = heard.decode()
        if killer in names:
            recent[:] = [killer, *(one for one in recent if one != killer)][:8]
        return killer == "survives"

    def _try(self, mutant: Mutant, items: list[pytest.Item], write: int) -> None:
        """In a child of its own: change the program, run the tests until one fails, and say which."""
        nothing = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nothing, 1)
        os.dup2(nothing, 2)
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))
        heard = "crashed"
        try:
            put_in_place(mutant)
            heard = "survives"
            for item, following in zip(items, [*items[1:], None], strict=True):
                item.config.hook.pytest_runtest_protocol(item=item, nextitem=following)
                if self.failed:
                    heard = item.nodeid
                    break
        finally:
            os.write(write, heard.encode())
            os._exit(0)


@contextmanager
def called(codes: dict[types.CodeType, tuple[Path, str]]) -> Iterator[set[tuple[Path, str]]]:
    """Which of these functions are called meanwhile."""
    found: set[tuple[Path, str]] = set()

    def note(frame: types.FrameType, event: str, _: Any) -> None:
        if event == "call" and frame.f_code in codes:
            found.add(codes[frame.f_code])

    sys.setprofile(note)
    try:
        yield found
    finally:
        sys.setprofile(None)


def run(chosen: list[Mutant], accepted: Accepted) -> Campaign:
    """Run the tests of the changed files against every change."""
    from hypothesis import HealthCheck, Phase, settings

    # The same examples for every change; a failing one need not be made small; time is not judged.
    settings.register_profile(
        "mutation",
        derandomize=True,
        database=None,
        deadline=None,
        phases=(Phase.explicit, Phase.generate),
        suppress_health_check=list(HealthCheck),
    )
    settings.load_profile("mutation")
    files = list(
        dict.fromkeys(str(test) for path in dict.fromkeys(m.path for m in chosen) for test in watchers_of(path))
    )
    campaign = Campaign(chosen, accepted)
    options = ["-o", "addopts=", "--import-mode=importlib", "-p", "no:cacheprovider", "-p", "no:terminal"]
    options += [option for name in LEFT_OUT for option in ("--deselect", name)]
    options += ["-W", "ignore::pytest.PytestAssertRewriteWarning"]
    pytest.main([*options, "-p", "no:xdist", "-p", "no:logging", "--rootdir", str(ROOT), *files], plugins=[campaign])
    return campaign


def main() -> int:
    """Run it, and print what came of it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="*", default=list(WATCHED), help="as in table.py; all by default")
    parser.add_argument("--function", help="this one alone")
    options = parser.parse_args()
    code = 0
    for name in options.files:
        path = path_of(name)
        chosen = [one for one in mutants(path) if options.function in (None, one.name)]
        accepted = Accepted(path, options.function)
        begin = time.monotonic()
        found = run(chosen, accepted)
        for failure in found.failed:
            print(f"fails without any change: {failure}")
        for line in accepted.stale():
            print(f"listed, but not a change that survives: {line}")
        counts = ", ".join(f"{count} {kind}" for kind, count in sorted(accepted.counts.items()))
        print(
            f"{name}: {len(chosen)} changes, {found.killed} killed, {counts or '0 accepted'}, "
            f"{len(found.survived)} survived; {time.monotonic() - begin:.0f} s",
            flush=True,
        )
        code |= bool(found.failed or found.survived or accepted.stale())
    return code


if __name__ == "__main__":
    sys.exit(main())
