"""Changes every comparison, coefficient and condition of the proofs, one at a time; some test must fail each time.

`python tests/mutation/campaign.py rest.py sets/ball.py` tries these files of the engine, without names all of them.
One process collects the tests and runs them once; for each change it forks, gives the function its changed code, and
runs the tests that reach the changed statement, the quickest first, until one fails.
Nothing is written, except the counts with `--note`. A change that
hangs counts as found. What is allowed to survive is listed in `accepted.toml`, with the reason. Exit code 1 if any
other change survives.
"""

import argparse
import gc
import importlib
import inspect
import os
import resource
import select
import signal
import sys
import time
import types
from collections import defaultdict
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path
from typing import NamedTuple, NoReturn

import pytest

sys.path.insert(0, str(Path(__file__).parents[2]))

from tests import forked
from tests.mutation.accepted import Accepted
from tests.mutation.forks_here import ForksHere
from tests.mutation.mutate import Mutant, mutants, noting
from tests.mutation.table import LEFT_OUT, ROOT, WATCHED, path_of, watchers_of
from tests.mutation.whole import note

SLOWEST_S = 40.0  # a test that takes longer does not run, and cannot watch over anything
MEMORY_BYTES = 8 * 2**30  # of a changed program that fills its memory
COMPILED = ("hknob_cli.engine.", "hknob_cli.controllers.")
# What may come of a change beside a test that fails. The first two count as killed.
HANGS, CRASHED = "hangs", "crashed"
SURVIVES = "survives"
OUT_OF_TIME = "out of time"  # no test failed within the budget
NOT_CALLED = "not called"  # by any quick test in this process: compiled code and commands run elsewhere
NOT_PLACED = "not placed"  # the changed code cannot be given to a function that runs


# A statement that may be changed: its file, its function, and its first line; 0 for the function as a whole.
Place = tuple[Path, str, int]


class Budget(NamedTuple):
    """Seconds of a core: ``slowest_s`` that a test may take to be run against each change, ``in_all_s`` for one change.

    ``whole``: whether a test that fails without any change ends it all; else it is left out.
    """

    slowest_s: float = SLOWEST_S
    in_all_s: float = float("inf")
    whole: bool = True


def module_of(path: Path) -> types.ModuleType:
    """The module of a file."""
    return importlib.import_module(".".join(path.relative_to(ROOT).with_suffix("").parts))


def functions_of(module: types.ModuleType) -> Iterator[tuple[str, types.FunctionType]]:
    """Functions that a module holds, those inside a decorator too, and the methods of its own classes, by name."""
    for name, value in vars(module).items():
        inner = inspect.unwrap(value) if callable(value) and not isinstance(value, type) else value
        if isinstance(inner, types.FunctionType):
            yield name, inner
        elif isinstance(value, type) and value.__module__ == module.__name__:
            for method, one in vars(value).items():
                if isinstance(one, types.FunctionType):
                    yield f"{name}.{method}", one


def ours() -> list[types.ModuleType]:
    """Modules of the program that are loaded."""
    return [one for name, one in list(sys.modules.items()) if name.startswith("hknob_cli.")]


def users_of(mutant: Mutant) -> set[Place]:
    """Functions that may look up a constant when they run."""
    value = getattr(module_of(mutant.path), mutant.name)
    return {
        (Path(module.__file__), name, 0)
        for module in ours()
        if getattr(module, mutant.name, None) is value and module.__file__ is not None
        for name, function in functions_of(module)
        if function.__module__ == module.__name__ and mutant.name in names_in(function.__code__)
    }


def names_in(code: types.CodeType) -> set[str]:
    """Names that a function looks up, with what is defined in it."""
    inner = (names_in(one) for one in code.co_consts if isinstance(one, types.CodeType))
    return set(code.co_names).union(*inner)


def put_in_place(mutant: Mutant) -> None:
    """Change the running program: a function's code, or a constant wherever it has been imported.

    What functions remember of calls before the change is forgotten. Raises `KeyError` or `ValueError` where the code
    cannot be given to a function that runs.
    """
    module = module_of(mutant.path)
    if mutant.function is not None:
        dict(functions_of(module))[mutant.function].__code__ = mutant.code()
    else:
        old, new = getattr(module, mutant.name), mutant.value()
        for one in ours():
            if getattr(one, mutant.name, None) is old:
                setattr(one, mutant.name, new)
    forget()


def forget() -> None:
    """Forget what functions remember of earlier calls; compiled code, and the kinds that it is of, stay."""
    for one in ours():
        if one.__name__ in ("hknob_cli.engine.jit", "hknob_cli.engine.linking"):
            continue
        for value in list(vars(one).values()):
            if hasattr(value, "cache_clear") and callable(value):
                value.cache_clear()


def core_time() -> float:
    """Seconds of a core that this process and those begun by it have taken, however busy the machine is."""
    return sum(os.times()[:4])


class Campaign:
    """A plugin of pytest that runs the collected tests once as they are, and then against every change."""

    def __init__(self, chosen: list[Mutant], hear: Callable[[Mutant, str], None], budget: Budget) -> None:
        """``hear`` is told of each change what came of it: a test that fails, or one of `VERDICTS`."""
        self.chosen, self.hear, self.budget = chosen, hear, budget
        self.failed: list[str] = []
        self.took: dict[str, float] = {}
        self.slow: list[str] = []
        self.reached: dict[Place, set[str]] = defaultdict(set)  # tests by what they reach
        self.found = Called({})
        self.shared: dict[str, set[Place]] = {}  # what a fixture of many tests reaches
        self.killers: dict[str, list[str]] = defaultdict(list)  # of a function's changes, the last first

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Note what fails."""
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
        if self.failed and self.budget.whole:
            return True
        for failure in self.failed:
            print(f"left out, fails without any change: {failure.splitlines()[0]}", flush=True)
            self.took[failure.splitlines()[0]] = float("inf")
        self.failed.clear()
        items = {one.nodeid: one for one in session.items if self.took[one.nodeid] <= self.budget.slowest_s}
        self.slow = sorted(self.took.keys() - items.keys())
        for nodeid in self.slow:
            print(f"too slow to run each time: {nodeid} ({self.took[nodeid]:.1f} s)", flush=True)
        gc.collect()
        gc.freeze()  # a child that collected garbage would copy all of it
        for mutant in self.chosen:
            self.hear(mutant, self._judged(mutant, items))
        return True

    def _run_unchanged(self, session: pytest.Session) -> None:
        for path in {m.path for m in self.chosen}:
            module_of(path)
        uses = {one for m in self.chosen if m.function is None for one in users_of(m)}
        with called({m.path for m in self.chosen} | {path for path, _, _ in uses}) as self.found:
            for item, following in zip(session.items, [*session.items[1:], None], strict=True):
                forget()
                self.found.clear()
                failed = len(self.failed)
                begin = core_time()
                with stopped_after(self.budget.slowest_s):
                    item.config.hook.pytest_runtest_protocol(item=item, nextitem=following)
                self.took[item.nodeid] = core_time() - begin
                if self.took[item.nodeid] > self.budget.slowest_s:
                    del self.failed[failed:]  # if it was stopped
                fixtures = (self.shared.get(name, set()) for name in getattr(item, "fixturenames", ()))
                for one in set(self.found).union(*fixtures):
                    self.reached[one].add(item.nodeid)

    @pytest.hookimpl(wrapper=True)
    def pytest_fixture_setup(self, fixturedef: pytest.FixtureDef[object]) -> Generator[None, object, object]:
        """Note what a fixture reaches that is made once for many tests: each of them may fail by it."""
        before = set(self.found)
        self.found.clear()
        try:
            return (yield)
        finally:
            if fixturedef.scope != "function":
                self.shared.setdefault(fixturedef.argname, set()).update(self.found)
            self.found.add(before)

    def _names(self, mutant: Mutant) -> set[str]:
        """Tests that reach what is changed."""
        if mutant.function is None:
            return {name for place in users_of(mutant) for name in self.reached.get(place, ())}
        return self.reached.get((mutant.path, mutant.function, mutant.statement), set())

    def _judged(self, mutant: Mutant, items: dict[str, pytest.Item]) -> str:
        names = self._names(mutant) & items.keys()
        if not names:
            return NOT_CALLED
        recent = self.killers[mutant.name]
        order = [one for one in recent if one in names]
        order += sorted(names - set(order), key=lambda one: (self.took[one], one))
        limit = 10.0 + 10.0 * min(sum(self.took[one] for one in order), self.budget.in_all_s)
        read, write = os.pipe()
        child = os.fork()
        if child == 0:
            os.setpgrp()
            os.close(read)
            self._try(mutant, [items[one] for one in order], write)
        os.close(write)
        heard = b""
        if select.select([read], [], [], limit)[0]:
            heard = os.read(read, 4096)
        else:
            os.kill(child, signal.SIGKILL)
            heard = HANGS.encode()
        with suppress(ProcessLookupError):  # what the tests have left running
            os.killpg(child, signal.SIGKILL)
        os.close(read)
        os.waitpid(child, 0)
        killer = heard.decode() or CRASHED
        if killer in names:
            recent[:] = [killer, *(one for one in recent if one != killer)][:8]
        return killer

    def _try(self, mutant: Mutant, items: list[pytest.Item], write: int) -> None:
        """In a child of its own: change the program, run the tests until one fails, and say which."""
        nothing = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nothing, 1)
        os.dup2(nothing, 2)
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))
        heard, begin = NOT_PLACED, core_time()
        try:
            put_in_place(mutant)
            heard = CRASHED
            for item, following in zip(items, [*items[1:], None], strict=True):
                if core_time() - begin > self.budget.in_all_s:
                    heard = OUT_OF_TIME
                    break
                item.config.hook.pytest_runtest_protocol(item=item, nextitem=following)
                if self.failed:
                    heard = item.nodeid
                    break
            else:
                heard = SURVIVES
        finally:
            try:
                os.write(write, heard.encode())
            finally:
                os._exit(0)  # whatever becomes of who began it


@contextmanager
def nothing_compiled() -> Iterator[None]:
    """Skip tests that compile: numba would keep a changed function's code where that of these sources belongs."""
    from hknob_cli.engine import jit

    def skip(*_: object) -> NoReturn:
        pytest.skip("compiled code is not changed")

    before = jit._compilable, jit.is_kept
    jit._compilable, jit.is_kept = skip, lambda group="plain": False  # type: ignore[assignment]
    jit.compiled.cache_clear()
    try:
        yield
    finally:
        jit._compilable, jit.is_kept = before


@contextmanager
def stopped_after(seconds: float) -> Iterator[None]:
    """Skip what takes more of a core than that: it is too slow to be run each time. A compiler is let end."""

    def stop(_: int, frame: types.FrameType | None) -> None:
        while frame is not None:
            if "llvmlite" in frame.f_code.co_filename:  # an exception in there ends the process
                signal.setitimer(signal.ITIMER_PROF, 0.1)
                return
            frame = frame.f_back
        pytest.skip("too slow")

    before = signal.signal(signal.SIGPROF, stop)
    if seconds < float("inf"):
        signal.setitimer(signal.ITIMER_PROF, seconds + 0.1)
    try:
        yield
    except pytest.skip.Exception:  # between two steps of a test
        pass
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


@contextmanager
def called(watched: set[Path]) -> Iterator["Called"]:
    """Which statements of these files are reached meanwhile: each notes that itself."""
    found: dict[str, set[tuple[str, int]]] = {str(path): set() for path in watched}
    sys._mutation_calls = found  # type: ignore[attr-defined]
    before = []
    for path in watched:
        functions = dict(functions_of(module_of(path)))
        note = f"__import__('sys')._mutation_calls[{str(path)!r}].add(('{{name}}', {{line}}))"
        for name, code in noting(path, note):
            plain = functions.get(name)
            if plain is not None and plain.__code__.co_freevars == code.co_freevars:
                before.append((plain, plain.__code__))
                plain.__code__ = code
    try:
        yield Called(found)
    finally:
        for plain, old in before:
            plain.__code__ = old


class Called:
    """Statements by their file, as they are noted."""

    def __init__(self, by_file: dict[str, set[tuple[str, int]]]) -> None:
        self._by_file = by_file

    def clear(self) -> None:
        """Begin anew."""
        for places in self._by_file.values():
            places.clear()

    def add(self, places: set[Place]) -> None:
        """Note these, too."""
        for path, name, line in places:
            self._by_file[str(path)].add((name, line))

    def __iter__(self) -> Iterator[Place]:
        """Files, functions and lines."""
        for path, places in self._by_file.items():
            yield from ((Path(path), name, line) for name, line in sorted(places))


def run(
    chosen: list[Mutant],
    hear: Callable[[Mutant, str], None],
    budget: Budget,
    *,
    tests: Iterable[Path] = (),
    left_out: Iterable[str] = LEFT_OUT,
) -> Campaign:
    """Run tests, by default those of the changed files, against every change; see `Campaign`."""
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
    watching = tests or (test for path in dict.fromkeys(m.path for m in chosen) for test in watchers_of(path))
    files = list(dict.fromkeys(map(str, watching)))
    ForksHere.longest_s = 4.0 * budget.slowest_s
    forked.Forks = lambda: ForksHere(forget)  # type: ignore[assignment, misc]
    engine = any(module_of(path).__name__.startswith(COMPILED) for path in {m.path for m in chosen})
    campaign = Campaign(chosen, hear, budget)
    options = ["-o", "addopts=", "--import-mode=importlib", "-p", "no:cacheprovider", "-p", "no:terminal"]
    options += [option for name in left_out for option in ("--deselect", name)]
    options += ["-W", "ignore::pytest.PytestAssertRewriteWarning"]
    options += ["-p", "no:xdist", "-p", "no:logging", "--rootdir", str(ROOT)]
    with nothing_compiled() if engine else nullcontext():
        pytest.main([*options, *files], plugins=[campaign])
    return campaign


def main() -> int:
    """Run it, and print what came of it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="*", default=list(WATCHED), help="as in table.py; all by default")
    parser.add_argument("--function", help="this one alone")
    parser.add_argument("--note", action="store_true", help="put the counts of whole files into scores.md")
    options = parser.parse_args()
    code = 0
    for name in options.files:
        path = path_of(name)
        chosen = [one for one in mutants(path) if options.function in (None, one.name)]
        accepted = Accepted(path, options.function)
        begin = time.monotonic()
        survived: list[Mutant] = []
        killed: list[Mutant] = []

        def hear(
            mutant: Mutant,
            verdict: str,
            accepted: Accepted = accepted,
            survived: list[Mutant] = survived,
            killed: list[Mutant] = killed,
        ) -> None:
            if verdict not in (SURVIVES, NOT_CALLED, NOT_PLACED):
                killed.append(mutant)
                accepted.note_killed(mutant)
            elif accepted.take(mutant) is None:
                survived.append(mutant)
                print(f"survived ({verdict}): {mutant}", flush=True)

        found = run(chosen, hear, Budget())
        for failure in found.failed:
            print(f"fails without any change: {failure}")
        for line in accepted.stale():
            print(f"listed, but not a change that survives: {line}")
        counts = ", ".join(f"{count} {kind}" for kind, count in sorted(accepted.counts.items()))
        print(
            f"{name}: {len(chosen)} changes, {len(killed)} killed, "
            f"{counts or '0 accepted'}, {len(survived)} survived; {time.monotonic() - begin:.0f} s",
            flush=True,
        )
        if options.note and options.function is None and not found.failed:
            explained = accepted.counts.total()
            note(name, changes=len(chosen), killed=len(killed), explained=explained, survived=len(survived))
        code |= bool(found.failed or survived or accepted.stale())
    return code


if __name__ == "__main__":
    sys.exit(main())
