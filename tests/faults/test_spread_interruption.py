"""A sweep spread over processes here, disturbed at any instant: nothing lost, no process left, the same bytes."""

import os
import random
import re
import signal
import subprocess
import time
from pathlib import Path

import pytest

from tests.faults.spread_runs import SLOW, SWEEP, finish, left, pieces, run, start, wait_until
from tests.faults.test_every_step import INTERRUPTED

pytestmark = pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="looks for processes in /proc")


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, bytes]]:
    """The spec, and what a run of it leaves."""
    folder = tmp_path_factory.mktemp("undisturbed")
    spec = folder / "spec.yaml"
    spec.write_text(SWEEP)
    assert run(spec, folder / "out") == (0, "")
    return spec, left(folder / "out")


def members(group: int) -> list[int]:
    """Processes of a group that are not dead."""
    found = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            state, _, its = path.read_text().rpartition(")")[2].split()[:3]
        except (FileNotFoundError, ProcessLookupError):
            continue
        if int(its) == group and state not in "ZX":
            found.append(int(path.parent.name))
    return found


def workers(process: subprocess.Popen[str]) -> list[int]:
    """The processes that a run has begun."""
    return [pid for pid in members(process.pid) if pid != process.pid]


@pytest.mark.long
def test_workers_killed_at_random_instants(undisturbed, tmp_path: Path) -> None:
    spec, wanted = undisturbed
    chance = random.Random(1)
    out = tmp_path / "out"
    process = start(spec, out, fault=SLOW)
    killed = 0
    wait_until(lambda: pieces(out) > 0, "a piece is there")
    while process.poll() is None:
        time.sleep(chance.uniform(0.0, 1.0))
        if found := workers(process):
            os.kill(chance.choice(found), signal.SIGKILL)
            killed += 1
    assert finish(process) == (0, "")
    assert killed >= 5
    assert left(out) == wanted


def test_a_dry_run_says_how_much_is_there(undisturbed, tmp_path: Path) -> None:
    spec, _ = undisturbed
    process = start(spec, tmp_path / "out", fault=SLOW)
    wait_until(lambda: pieces(tmp_path / "out") > 0, "a piece is there")
    process.kill()
    finish(process)
    before = left(tmp_path / "out")
    said, _ = start(spec, tmp_path / "out", "--dry-run").communicate()
    assert re.search(r"no cells\.parquet yet; it would go on from [1-9]\d* of 24 cells; it would write ", said)
    assert left(tmp_path / "out") == before


def test_no_process_outlives_a_killed_parent_and_the_next_run_need_not_wait(undisturbed, tmp_path: Path) -> None:
    spec, wanted = undisturbed
    out = tmp_path / "out"
    process = start(spec, out, fault=f"{SLOW}; slow_worker.SECONDS = 600")
    wait_until(lambda: len(workers(process)) == 2 and (out / ".hknob.lock").exists(), "workers are at work")
    time.sleep(0.2)
    process.kill()
    process.wait()
    code, errors = run(spec, out)  # not refused: what is left of the first run holds nothing
    assert (code, errors) == (0, "")
    wait_until(lambda: not members(process.pid), "all processes are gone")
    finish(process)
    assert left(out) == wanted


@pytest.mark.long
@pytest.mark.parametrize("kind", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_signals_to_all_at_random_instants(undisturbed, tmp_path: Path, kind: signal.Signals) -> None:
    spec, wanted = undisturbed
    chance = random.Random(int(kind))
    out = tmp_path / "out"
    ended = 0
    for _ in range(5):
        process = start(spec, out, fault=SLOW)
        time.sleep(chance.uniform(0.3, 1.5))
        os.killpg(process.pid, kind)
        code, errors = finish(process)
        wait_until(lambda group=process.pid: not members(group), "all processes are gone")
        if kind is signal.SIGKILL:
            assert code == -kind
        elif code:
            lines = errors.splitlines(keepends=True)
            assert (code, lines[-1:]) == (130, [INTERRUPTED])
            assert all("cells are there from an earlier run" in line for line in lines[:-1]), errors
        ended += code != 0
    assert ended >= 2
    code, _ = run(spec, out)
    assert (code, left(out) == wanted) == (0, True)
    stamps = {path: path.stat().st_mtime_ns for path in out.rglob("part-*")}
    assert run(spec, out) == (0, "")
    assert {path: path.stat().st_mtime_ns for path in out.rglob("part-*")} == stamps


@pytest.mark.one_in(2)
@pytest.mark.parametrize("kind", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_while_workers_begin(undisturbed, tmp_path: Path, kind: signal.Signals) -> None:
    """A worker that is just forked would answer as its parent does, with the traceback of an interruption."""
    spec, _ = undisturbed
    out = tmp_path / "out"
    late = (
        "import time; from hknob_cli.spread import processes; plain = processes.begin_worker\n"
        "processes.begin_worker = lambda: (time.sleep(1), plain())"
    )
    process = start(spec, out, fault=late)
    wait_until(lambda: len(workers(process)) == 2 and list(out.glob(".hknob.partial-*/orbits")) != [], "workers begin")
    os.killpg(process.pid, kind)
    assert finish(process) == (130, INTERRUPTED)
    wait_until(lambda: not members(process.pid), "all processes are gone")


@pytest.mark.long
def test_two_runs_on_one_folder(undisturbed, tmp_path: Path) -> None:
    spec, wanted = undisturbed
    out = tmp_path / "out"
    process = start(spec, out, fault=SLOW)
    wait_until(lambda: pieces(out) > 0, "a piece is there")
    code, errors = run(spec, out)
    assert (code, errors.count("\n")) == (3, 1)
    assert "another run is writing here; wait for it, or choose another --out" in errors
    assert finish(process) == (0, "")
    assert left(out) == wanted


MEMORY = (
    "from hknob_cli.stages.sweep import assembly; plain = assembly.find_piece\n"
    "def find_piece(stage, start, stop):\n"
    "    if stop - start > 1: {too_much}\n"
    "    return plain(stage, start, stop)\n"
    "assembly.find_piece = find_piece"
)
TOO_MUCH = {
    "said so": "raise MemoryError",
    "over a limit": ("import resource; resource.setrlimit(resource.RLIMIT_AS, (3 << 30, 3 << 30)); bytearray(4 << 30)"),
    "killed for it": "import os; os.kill(os.getpid(), 9)",
}


@pytest.mark.one_in(3)
@pytest.mark.parametrize("how", TOO_MUCH)
def test_pieces_that_are_too_much_for_the_memory_are_done_in_halves(undisturbed, tmp_path: Path, how: str) -> None:
    spec, wanted = undisturbed
    assert run(spec, tmp_path / "out", fault=MEMORY.format(too_much=TOO_MUCH[how])) == (0, "")
    assert left(tmp_path / "out") == wanted


def test_a_cell_that_nobody_survives_is_named_and_all_else_is_kept(undisturbed, tmp_path: Path) -> None:
    spec, wanted = undisturbed
    out = tmp_path / "out"
    deadly = MEMORY.format(too_much="pass").replace(
        "if stop - start > 1: pass", "if start <= 17 < stop: os.kill(os.getpid(), 9)"
    )
    code, errors = run(spec, out, "-j", 1, fault=f"import os\n{deadly}")
    assert (code, errors) == (
        1,
        "cell 17, sample_rate_hz = 2000, counts_per_rev = 1024: the process that computed this died 8 times "
        "(out of memory?); all else that is finished is kept, run the same command again\n",
    )
    assert pieces(out) >= 8
    code, errors = run(spec, out)
    assert (code, "of 24 cells are there from an earlier run" in errors) == (0, True)
    assert left(out) == wanted


def test_a_wall_clock_that_jumps_changes_nothing(undisturbed, tmp_path: Path) -> None:
    spec, wanted = undisturbed
    jumps = (
        "import time, itertools; steps = itertools.cycle([0.0, 4e9, -1e9, 1e5, -4e8])\n"
        "plain = time.time; time.time = lambda: plain() + next(steps)\n"
        "time.time_ns = lambda: int(1e9 * time.time())"
    )
    assert run(spec, tmp_path / "out", fault=jumps) == (0, "")
    assert left(tmp_path / "out") == wanted
