"""Fixtures shared by all tests: specs as text, and sweeps of the main grid, run once."""

import gc
import os

# As the command does, before anything loads numpy: matrices are small, and idle threads of linear algebra would only
# spin beside the other tests.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import re
import signal
import subprocess
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, settings

from hknob_cli.engine.jit import is_kept
from hknob_cli.errors import SpecError
from hknob_cli.specs.load import load, validate
from hknob_cli.specs.plan import SweepPlan
from hknob_cli.specs.source import parse
from hknob_cli.stages.sweep.run import SweepStage
from hknob_cli.stages.sweep.tables import SweepTables
from tests.drawn import REST, Draw
from tests.either_end import from_either_end
from tests.forked import HKNOB, Forks

ROOT = Path(__file__).parent.parent
EXPERIMENTS = ROOT / "experiments"
# Folders of tests that take longest come first, so that no worker is left alone with one at the end.
FIRST = ("verification", "cli", "docs", "engine", "crosscheck", "faults", "stages", "hardware", "page", "figures")
LONGEST_S = 600  # that a command may take; compiling for a new machine may take minutes

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # begun in the background: what is run here would ignore it, too
    signal.signal(signal.SIGINT, signal.default_int_handler)

# A busy machine is no fault of an input. Where CI is set, hypothesis tries the same inputs each time.
settings.register_profile("patient", settings.default, deadline=None, suppress_health_check=[HealthCheck.too_slow])
if settings.get_current_profile_name() in ("default", "ci"):  # of which no other was chosen
    settings.load_profile("patient")

SPEC = """\
kind: sweep
name: small
scene:
  knob: {inertia: 1.9e-6}
  hand: {inertia: 3.0e-7, damping: 3.45e-4, stiffness: 0.04}
  wall: {stiffness: 0.27}
  bias: {torque: 0.001}
grid:
  sample_rate_hz: [1000]
  counts_per_rev: [1024]
starts: {angle: 0.02, phases: 8}
"""


def pytest_addoption(parser: pytest.Parser) -> None:
    """Options that `make test` and `make long` give."""
    parser.addoption("--draw", metavar="WORD", help="of like long tests, only some, drawn by this: see tests/drawn.py")
    parser.addoption(
        "--compiled", action="store_true", help="begin with compiling what the tests take, each worker a share"
    )


def pytest_configure(config: pytest.Config) -> None:
    """Draw, where that is asked for."""
    if by := config.getoption("--draw", default=None):
        config.pluginmanager.register(Draw(by), "drawn")


def pytest_sessionstart(session: pytest.Session) -> None:
    """Compile, where that is asked for."""
    if session.config.getoption("--compiled", default=False):
        from tests.compiled_first import compile_share

        compile_share(EXPERIMENTS / "hand_on_knob.yaml", long=session.config.getoption("-m") != "not long")


@pytest.hookimpl(wrapper=True)
def pytest_collection(session: pytest.Session) -> Iterator[object]:
    """Collect from this worker's end, and no garbage: what is collected stays, and is not looked at again."""
    session.config.args = from_either_end(session.config.args, session.config.invocation_params.dir)
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


@pytest.fixture
def drawn(request: pytest.FixtureRequest) -> bool:
    """Whether only some of the long tests run, so that a series is to be short."""
    return request.config.pluginmanager.has_plugin("drawn")


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Order tests by how long those of their folder take; of a test with ``one_in(n)`` one case in n is not long.

    The order is the same from whichever end they were collected.
    """
    before: Counter[str] = Counter()
    for item in items:
        one_in = item.get_closest_marker("one_in")
        if one_in is not None:
            test = item.nodeid.partition("[")[0]
            if before[test] % one_in.args[0] != 0:
                item.add_marker(pytest.mark.long)
                item.add_marker(pytest.mark.drawn(REST))
            before[test] += 1

    def place(item: pytest.Item) -> tuple[int, Path]:
        folder = item.path.relative_to(ROOT / "tests").parts[0]
        return FIRST.index(folder) if folder in FIRST else len(FIRST), item.path

    items.sort(key=place)


def loaded(text: str = SPEC) -> SweepPlan:
    """Validated spec from text."""
    return validate(parse(text, "spec.yaml"))


def faults_of(text: str) -> str:
    """What is said of a spec with faults, a line each."""
    with pytest.raises(SpecError) as caught:
        loaded(text)
    return str(caught.value)


def swept(path: Path, *overrides: str) -> SweepTables:
    """Result of a spec file with overrides."""
    return SweepStage(load(path, overrides)).run()


@pytest.fixture
def spec_file(tmp_path: Path) -> Callable[..., Path]:
    """Writes a spec into a temporary folder; keyword arguments are replacements ``old=new`` done in order."""

    def write(text: str = SPEC, name: str = "spec.yaml") -> Path:
        path = tmp_path / name
        path.write_text(text)
        return path

    return write


@pytest.fixture
def loop_not_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    """Sweeps take the general loop for not compiled: of few trials, it is interpreted."""
    engines = "hknob_cli.stages.sweep.run"
    monkeypatch.setattr(f"{engines}.is_kept", lambda group="plain": group != "general" and is_kept(group))
    monkeypatch.setattr(f"{engines}.interpreted_s", lambda _group="plain": 0.0)
    monkeypatch.setattr(f"{engines}.note_interpreted", lambda _group, _seconds: None)


@pytest.fixture(scope="session")
def main_grid() -> dict[str, list[dict[str, Any]]]:
    """Cells and orbits of the four readings of the 7x7 grid, by experiment name."""
    names = ("", "_half_quantum", "_stiffer", "_stiffer_half_quantum")
    results = {name: swept(EXPERIMENTS / f"hand_on_knob{name}.yaml") for name in names}
    return {
        f"{name or '_printed'}:{table}"[1:]: getattr(result, table).to_pylist()
        for name, result in results.items()
        for table in ("cells", "orbits")
    }


# What the first run on a machine says besides, whichever test that is, and what a slow machine does.
BESIDES = re.compile(
    r"^(the engine is compiled once .*|compiling( the engine for this machine)?: .*|compiled \d+ .*"
    r"|(\S+: )?\d+( of \d+)? \w+, \d+ s|a limit ends each cell that takes longer, .*)\n",
    re.MULTILINE,
)


class Command:
    """The installed command, run in a folder: see `tests.forked`; from its start where its environment is another.

    ``given`` is on its standard input. The width of a terminal is read by each run.
    """

    def __init__(self, forks: Forks, folder: Path) -> None:
        self._forks, self._folder = forks, folder

    def __call__(
        self, *args: object, given: bytes = b"", columns: int = 120, **env: str
    ) -> subprocess.CompletedProcess[str]:
        if env:
            return self.anew(*args, **env)
        words = [str(arg) for arg in args]
        here = {**os.environ, "COLUMNS": str(columns)}
        code, out, err = self._forks.run(words, cwd=self._folder, env=here, timeout=LONGEST_S, given=given)
        return subprocess.CompletedProcess([HKNOB, *words], code, out, BESIDES.sub("", err))

    def anew(self, *args: object, **env: str) -> subprocess.CompletedProcess[str]:
        """From its start, as a user runs it."""
        return subprocess.run(
            [HKNOB, *map(str, args)],
            cwd=self._folder,
            capture_output=True,
            text=True,
            check=False,
            timeout=LONGEST_S,
            env={**os.environ, "COLUMNS": "120", **env},
        )


@pytest.fixture(scope="session")
def forks() -> Iterator[Forks]:
    """The command, loaded once for all tests of a process."""
    forks = Forks()
    yield forks
    forks.end()


@pytest.fixture
def hknob(tmp_path: Path, forks: Forks) -> Command:
    """Runs ``hknob`` in a temporary folder."""
    return Command(forks, tmp_path)
