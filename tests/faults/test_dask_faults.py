"""A sweep on a Dask cluster whose workers, scheduler and network fail: the same bytes in the end, or what to do."""

import os
import platform
import random
import shutil
import signal
import socketserver
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from hknob_cli import __version__
from hknob_cli.spread.cluster import Cluster
from hknob_cli.spread.gather import Ranges, gather
from tests.faults.dask_cluster import ROOT, LocalCluster
from tests.faults.proxy import Proxy
from tests.faults.spread_runs import IMPATIENT, SWEEP, finish, left, pieces, run, start, wait_until

pytestmark = pytest.mark.long

pytest.importorskip("distributed")


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, bytes]]:
    """The spec, and what a run on this machine leaves."""
    folder = tmp_path_factory.mktemp("undisturbed")
    spec = folder / "spec.yaml"
    spec.write_text(SWEEP)
    run(spec, folder / "first")  # compiles what is not compiled yet, and says so
    assert run(spec, folder / "out") == (0, "")
    return spec, left(folder / "out")


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LocalCluster]:
    """A cluster for all tests, since each of its processes takes a second to begin."""
    with LocalCluster(tmp_path_factory.mktemp("cluster") / "log") as cluster:
        yield cluster


@pytest.fixture
def cluster(shared: LocalCluster) -> LocalCluster:
    """That cluster, with two workers."""
    shared.mend(2)
    return shared


def on(cluster: LocalCluster) -> tuple[str, ...]:
    return "--executor", "dask", "--scheduler", cluster.address


def yet_to_come(cluster: LocalCluster) -> str:
    """What is told where the command is there before the cluster's workers."""
    return f"no worker at {cluster.address} yet; waiting"


def test_the_same_bytes_as_on_this_machine(cluster, undisturbed, tmp_path: Path) -> None:
    spec, wanted = undisturbed
    code, errors = run(spec, tmp_path / "out", *on(cluster))
    assert code == 0
    assert set(errors.splitlines()) <= {yet_to_come(cluster)}
    assert left(tmp_path / "out") == wanted


def test_workers_killed_at_random_instants(cluster, undisturbed, tmp_path: Path, drawn: bool) -> None:
    spec, wanted = undisturbed
    most = 8 if drawn else 20
    chance = random.Random(3)
    kills = runs = 0
    while kills < most:
        out = tmp_path / str(runs)
        runs += 1
        process = start(spec, out, *on(cluster))
        wait_until(lambda out=out: pieces(out) > 0, "a piece is there")
        while process.poll() is None and kills < most:
            time.sleep(chance.uniform(0.2, 0.8))
            cluster.kill_a_worker(chance)
            cluster.mend(2)
            kills += 1
        code, errors = finish(process)
        assert (code, "Traceback" in errors) == (0, False), errors
        assert set(errors.splitlines()) <= {yet_to_come(cluster)}
        assert left(out) == wanted


def test_a_scheduler_that_comes_back(cluster, undisturbed, tmp_path: Path) -> None:
    spec, wanted = undisturbed
    out = tmp_path / "out"
    process = start(spec, out, *on(cluster))
    wait_until(lambda: pieces(out) > 0, "a piece is there")
    cluster.end(cluster.scheduler)
    time.sleep(0.5)
    while process.poll() is None:  # workers end without a scheduler, and something begins them again
        cluster.mend(2)
        time.sleep(0.1)
    code, errors = finish(process)
    assert code == 0, errors
    lines = errors.splitlines()
    assert lines[:2] == [f"lost the scheduler at {cluster.address}; looking for it", "found it again"]
    assert set(lines[2:]) <= {yet_to_come(cluster)}
    assert left(out) == wanted


def test_a_scheduler_that_does_not_come_back(cluster, undisturbed, tmp_path: Path) -> None:
    spec, wanted = undisturbed
    out = tmp_path / "out"
    process = start(spec, out, *on(cluster), fault=IMPATIENT)
    wait_until(lambda: pieces(out) > 0, "a piece is there")
    cluster.end(cluster.scheduler)
    code, errors = finish(process)
    assert (code, errors.splitlines()) == (
        1,
        [
            f"lost the scheduler at {cluster.address}; looking for it",
            f"no Dask scheduler at {cluster.address}; what is finished is kept, run the same command again",
        ],
    )
    assert pieces(out) > 0
    code, errors = run(spec, out)
    assert (code, "cells are there from an earlier run" in errors) == (0, True)
    assert left(out) == wanted


def test_no_scheduler(undisturbed, tmp_path: Path) -> None:
    spec, _ = undisturbed
    code, errors = run(
        spec, tmp_path / "out", "--executor", "dask", "--scheduler", "tcp://127.0.0.1:9", fault=IMPATIENT
    )
    assert (code, errors.count("\n")) == (1, 1)
    assert errors.startswith("no Dask scheduler at tcp://127.0.0.1:9")


WORDS = {
    "a web server": b"HTTP/1.1 400 Bad Request\r\nContent-Length: 0\r\nConnection: close\r\n\r\n",
    "noise": random.Random(5).randbytes(4096),
    "a length of 2 ** 62": (2**62).to_bytes(8, "little") * 8,
    "nothing": b"",
}


@pytest.mark.parametrize("words", WORDS.values(), ids=WORDS)
def test_an_address_at_which_something_else_answers(undisturbed, tmp_path: Path, words: bytes) -> None:
    class Other(socketserver.BaseRequestHandler):
        def handle(self) -> None:
            self.request.sendall(words)

    spec, _ = undisturbed
    with socketserver.ThreadingTCPServer(("127.0.0.1", 0), Other) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        address = f"tcp://127.0.0.1:{server.server_address[1]}"
        code, errors = run(spec, tmp_path / "out", "--executor", "dask", "--scheduler", address, fault=IMPATIENT)
        server.shutdown()
    said = f"no Dask scheduler at {address}; what is finished is kept, run the same command again\n"
    assert (code, errors, (tmp_path / "out").exists()) == (1, said, False)


def test_workers_that_come_later(cluster, undisturbed, tmp_path: Path) -> None:
    spec, wanted = undisturbed
    cluster.mend(0)
    process = start(spec, tmp_path / "out", *on(cluster))
    time.sleep(3)
    assert process.poll() is None
    cluster.mend(1)
    assert finish(process) == (0, yet_to_come(cluster) + "\n")
    assert left(tmp_path / "out") == wanted


def test_a_worker_of_another_version(cluster, undisturbed, tmp_path: Path) -> None:
    spec, wanted = undisturbed
    shutil.copytree(ROOT / "hknob_cli", tmp_path / "other" / "hknob_cli", ignore=shutil.ignore_patterns("__pycache__"))
    (tmp_path / "other" / "hknob_cli" / "__init__.py").write_text('__version__ = "0.0.1"\n')
    cluster.mend(0)
    cluster.begin_odd_worker(PYTHONPATH=str(tmp_path / "other"))
    code, errors = run(spec, tmp_path / "out", *on(cluster), "-q")
    assert (code, errors.count("\n")) == (1, 1), errors
    assert errors.startswith("the worker at tcp://127.0.0.1:"), errors
    assert f" has hknob 0.0.1, not {__version__}; install hknob {__version__} there, and run the same command" in errors
    cluster.mend(0)
    cluster.mend(2)
    code, errors = run(spec, tmp_path / "out", *on(cluster), "-q")
    assert (code, errors) == (0, ""), errors
    assert left(tmp_path / "out") == wanted


def test_a_worker_that_leaves_as_its_answer_comes(cluster, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its answer is good, whatever the library says of it by then."""
    from distributed.client import Future

    its_result = Future._result

    async def result(self: Future, *given: bool, **named: bool) -> object:
        found = await its_result(self, *given, **named)
        self._state.lose()
        return found

    monkeypatch.setattr(Future, "_result", result)
    found: dict[int, bytes] = {}
    workers = Cluster(int.to_bytes, cluster.address, lambda _text: None)
    gather(workers, Ranges(20), lambda start, _stop, data: found.update({start: data}), tick=lambda: None)
    assert {int.from_bytes(data) for data in found.values()} == found.keys()
    assert sum(len(data) - start for start, data in found.items()) == 20


def test_a_worker_with_other_libraries(cluster, undisturbed, tmp_path: Path) -> None:
    """The same version, and yet its results could differ."""
    spec, _ = undisturbed
    shutil.copytree(ROOT / "hknob_cli", tmp_path / "other" / "hknob_cli", ignore=shutil.ignore_patterns("__pycache__"))
    with (tmp_path / "other" / "hknob_cli" / "engine" / "rest.py").open("a") as changed:
        changed.write("# changed\n")
    cluster.mend(0)
    cluster.begin_odd_worker(PYTHONPATH=str(tmp_path / "other"))
    code, errors = run(spec, tmp_path / "out", *on(cluster), "-q")
    assert (code, errors.count("\n")) == (1, 1), errors
    assert f"a worker, on {platform.node()}, has other versions, so its results would differ: " in errors
    assert errors.endswith("install the same there, and run the same command again\n")


def test_a_scheduler_without_this_program(shared, undisturbed, tmp_path: Path) -> None:
    spec, _ = undisturbed
    without(tmp_path)
    shared.mend(0)
    shared.end(shared.scheduler)
    shared.begin_scheduler(PYTHONPATH=str(tmp_path))
    shared.begin_odd_worker(slow=True)
    code, errors = run(spec, tmp_path / "out", *on(shared), "-q")
    shared.end(shared.scheduler)
    assert (code, errors.count("\n")) == (1, 1), errors
    assert errors.startswith(f"the cluster at {shared.address} cannot do this work: ")
    assert f"its scheduler and workers need hknob {__version__}, as here; what is finished is kept" in errors


def without(folder: Path) -> None:
    """A folder to import from, as if this program were not installed."""
    (folder / "hknob_cli").mkdir()
    (folder / "hknob_cli" / "__init__.py").write_text("raise ModuleNotFoundError(\"No module named 'hknob_cli'\")\n")


def test_a_worker_without_this_program(shared, undisturbed, tmp_path: Path) -> None:
    spec, _ = undisturbed
    without(tmp_path)
    shared.mend(0)
    shared.begin_odd_worker(PYTHONPATH=str(tmp_path))
    code, errors = run(spec, tmp_path / "out", *on(shared), "-q")
    assert (code, errors.count("\n")) == (1, 1), errors
    assert errors.startswith("the worker at tcp://127.0.0.1:"), errors
    assert f" does not have hknob; install hknob {__version__} there, and run the same command again" in errors


def test_a_cell_that_no_worker_survives(shared, undisturbed, tmp_path: Path) -> None:
    spec, wanted = undisturbed
    out = tmp_path / "out"
    shared.mend(0)
    shared.end(shared.scheduler)
    shared.begin_scheduler(DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES="0")
    quick = "from hknob_cli.spread import gather; gather.DEATHS, gather.SUSPECT = 2, 1"
    process = start(spec, out, *on(shared), "-q", fault=quick)
    while process.poll() is None:
        shared.mend(1, HKNOB_TEST_DEADLY="17")
        time.sleep(0.05)
    code, errors = finish(process)
    shared.mend(0)
    shared.end(shared.scheduler)
    assert (code, errors.count("\n")) == (1, 1), errors
    assert errors.startswith("cell 17, sample_rate_hz = 2000, counts_per_rev = 1024: ")
    assert run(spec, out, "-q") == (0, "")
    assert left(out) == wanted


QUICK = "from hknob_cli.spread import cluster; cluster.SILENCE = 3.0"


@pytest.mark.parametrize("heals", [True, False], ids=["heals", "stays so"])
def test_a_network_that_is_dead_without_a_word(cluster, undisturbed, tmp_path: Path, heals: bool) -> None:
    """No connection closes; the other side just does not answer any more."""
    spec, wanted = undisturbed
    out = tmp_path / "out"
    with Proxy(cluster.port) as proxy:
        address = f"tcp://127.0.0.1:{proxy.port}"
        fault = QUICK if heals else f"{IMPATIENT}; {QUICK}"
        process = start(spec, out, "--executor", "dask", "--scheduler", address, fault=fault)
        wait_until(lambda: pieces(out) > 0, "a piece is there")
        proxy.frozen.set()
        if heals:
            time.sleep(4)
            proxy.frozen.clear()
        code, errors = finish(process)
    lost = f"lost the scheduler at {address}; looking for it\n"
    if heals:
        assert (code, errors) == (0, f"{lost}found it again\n")
    else:
        kept = f"no Dask scheduler at {address}; what is finished is kept, run the same command again\n"
        assert (code, errors) == (1, lost + kept)
        assert run(spec, out, "-q") == (0, "")
    assert left(out) == wanted


def test_a_network_that_is_cut(cluster, undisturbed, tmp_path: Path) -> None:
    spec, wanted = undisturbed
    out = tmp_path / "out"
    with Proxy(cluster.port) as proxy:
        address = f"tcp://127.0.0.1:{proxy.port}"
        process = start(spec, out, "--executor", "dask", "--scheduler", address)
        wait_until(lambda: pieces(out) > 0, "a piece is there")
        proxy.cut()
        code, errors = finish(process)
    assert (code, errors) == (0, f"lost the scheduler at {address}; looking for it\nfound it again\n")
    assert left(out) == wanted


@pytest.mark.parametrize("kind", [signal.SIGINT, signal.SIGTERM])
def test_interruption(cluster, undisturbed, tmp_path: Path, kind: signal.Signals) -> None:
    spec, wanted = undisturbed
    out = tmp_path / "out"
    process = start(spec, out, *on(cluster))
    wait_until(lambda: pieces(out) > 0, "a piece is there")
    os.killpg(process.pid, kind)
    code, errors = finish(process)
    assert (code, errors) == (130, "interrupted; finished files are kept, run the same command again\n")
    wait_until(lambda: not cluster.busy(), "no worker is at it any more")
    assert run(spec, out, *on(cluster), "-q") == (0, "")
    assert left(out) == wanted
