"""Interrupted runs: nothing half written, nothing lost, the next run gives the same bytes."""

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.conftest import EXPERIMENTS, HKNOB, SPEC

BUSY = SPEC.replace("phases: 8", "phases: 100000").replace("[1000]", "{lin: [1000, 2000, 30]}")


def start(spec: Path, out: Path, *args: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [HKNOB, "sweep", spec, "-o", out, *args], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


@pytest.mark.parametrize("kind", [signal.SIGINT, signal.SIGTERM])
def test_interruption_exits_130_and_leaves_nothing(kind: signal.Signals, spec_file, tmp_path: Path) -> None:
    out = tmp_path / "out"
    process = start(spec_file(BUSY), out)
    deadline = time.monotonic() + 120
    while not (out / ".hknob.lock").exists() and time.monotonic() < deadline:
        time.sleep(0.01)
    time.sleep(0.2)
    process.send_signal(kind)
    _, errors = process.communicate(timeout=120)
    assert process.returncode == 130
    assert errors.splitlines()[-1].startswith("interrupted")
    assert not out.exists()


@pytest.mark.long
def test_kill_at_random_instants(spec_file, tmp_path: Path) -> None:
    spec = EXPERIMENTS / "smoke_grid.yaml"
    subprocess.run([HKNOB, "sweep", spec, "-o", tmp_path / "undisturbed", "-q"], check=True, capture_output=True)
    out = tmp_path / "out"
    chance = random.Random(20261121)
    killed = 0
    for _ in range(12):
        process = start(spec, out, "--force")
        time.sleep(chance.uniform(0.1, 0.5))
        process.kill()
        process.communicate()
        killed += process.returncode == -signal.SIGKILL
    assert killed > 0
    subprocess.run([HKNOB, "sweep", spec, "-o", out, "-q"], check=True, capture_output=True)
    for name in ("cells.parquet", "orbits.parquet"):
        assert (out / name).read_bytes() == (tmp_path / "undisturbed" / name).read_bytes()
    assert {path.name for path in out.iterdir()} == {"cells.parquet", "orbits.parquet", ".hknob.lock"}


def test_two_runs_on_one_folder(hknob, spec_file, tmp_path: Path) -> None:
    out = tmp_path / "out"
    process = start(spec_file(BUSY), out)
    deadline = time.monotonic() + 120
    while not (out / ".hknob.lock").exists() and time.monotonic() < deadline:
        time.sleep(0.01)
    time.sleep(0.2)  # the file is there a moment before it is locked
    process.send_signal(signal.SIGSTOP)  # or it could be done before the second begins
    second = hknob("sweep", spec_file(SPEC, "other.yaml"), "-o", out)
    process.kill()
    process.communicate()
    assert second.returncode == 3
    assert "another run is writing here" in second.stderr


def test_output_of_another_origin_is_refused(hknob, spec_file, tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / "cells.parquet").write_text("mine")
    done = hknob("sweep", spec_file(), "-o", out, "--force")
    assert (done.returncode, (out / "cells.parquet").read_text()) == (3, "mine")
    (out / "cells.parquet").unlink()
    assert hknob("sweep", spec_file(), "-o", out).returncode == 0
    done = hknob("sweep", spec_file(SPEC.replace("small", "large"), "l.yaml"), "-o", out)
    assert done.returncode == 3
    assert "holds the sweep 'small'" in done.stderr


def test_output_that_cannot_be_written(hknob, spec_file, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    done = hknob("sweep", spec_file(), "-o", tmp_path / "file" / "out")
    assert done.returncode == 1
    assert "cannot be written" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_full_disk(hknob, spec_file, tmp_path: Path) -> None:
    """Every partial file is a link to a device without room."""
    out = tmp_path / "out"
    out.mkdir()
    code = (
        "import sys, pyarrow.parquet as pq; from hknob_cli.results import store\n"
        "plain = pq.write_table\n"
        "pq.write_table = lambda table, stream, **kw: plain(table, open('/dev/full', 'wb'), **kw)\n"
        f"sys.argv = ['hknob', 'sweep', {str(spec_file())!r}, '-o', {str(out)!r}]\n"
        "from hknob_cli.cli.main import main; main()"
    )
    done = subprocess.run([HKNOB.with_name("python"), "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 1, done.stderr
    assert "No space left" in done.stderr
    assert {path.name for path in out.iterdir()} == {".hknob.lock"}


@pytest.mark.long
def test_foreign_and_stale_pictures(hknob, spec_file, tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / "grid.png").write_text("mine")
    done = hknob("sweep", spec_file(), "-o", out, "--plot")
    assert (done.returncode, (out / "grid.png").read_text()) == (3, "mine")
    (out / "grid.png").unlink()
    assert hknob("sweep", spec_file(), "-o", out, "--plot").returncode == 0
    assert hknob("sweep", spec_file(), "-o", out, "--plot", "--force").returncode == 0
    assert hknob("sweep", spec_file(), "-o", out, "--set", "starts.phases=9").returncode == 0
    assert not (out / "grid.png").exists()  # it showed what the files no longer hold


@pytest.mark.parametrize("stream", ["1", "2"])
def test_closed_streams(stream: str, spec_file, tmp_path: Path) -> None:
    good, bad = spec_file(), spec_file(SPEC.replace("0.27", "-1"), "bad.yaml")
    for path, code in ((good, 0), (bad, 2)):
        line = f"{HKNOB} sweep {path} -o {tmp_path / 'out'} {stream}>&-"
        done = subprocess.run(line, shell=True, capture_output=True, text=True, check=False)
        assert done.returncode == code
        assert "Traceback" not in done.stdout + done.stderr


def test_output_to_a_full_device(spec_file, tmp_path: Path) -> None:
    line = f"{HKNOB} sweep {spec_file()} -o {tmp_path / 'out'} > /dev/full"
    done = subprocess.run(line, shell=True, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "Traceback" not in done.stderr


def test_files_in_the_way_that_are_no_files(hknob, spec_file, tmp_path: Path) -> None:
    out = tmp_path / "out"
    (out / "cells.parquet").mkdir(parents=True)
    done = hknob("sweep", spec_file(), "-o", out)
    assert (done.returncode, "not written by hknob" in done.stderr) == (3, True)
    (out / "cells.parquet").rmdir()
    os.mkfifo(out / "cells.parquet")
    done = hknob("sweep", spec_file(), "-o", out)
    assert (done.returncode, "is not a file" in done.stderr) == (3, True)
    assert hknob("sweep", spec_file(), "-o", tmp_path / ("x" * 300)).returncode == 1


def heeds(process: subprocess.Popen[str], kind: signal.Signals) -> bool:
    """Whether a process has said what it does on a signal; before, Python itself is still beginning."""
    status = Path(f"/proc/{process.pid}/status").read_text()
    caught = next(line for line in status.splitlines() if line.startswith("SigCgt:"))
    return bool(int(caught.split()[1], 16) >> (kind - 1) & 1)


@pytest.mark.long
@pytest.mark.skipif(sys.platform != "linux", reason="looks at what a process does on signals in /proc")
def test_signals_at_any_instant_of_the_start(spec_file, tmp_path: Path) -> None:
    """A signal to the whole group, while one process parses and the other loads: one line, and 130."""
    chance = random.Random(7)
    for _ in range(12):
        process = subprocess.Popen(
            [HKNOB, "sweep", spec_file(BUSY), "-o", tmp_path / "out"],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        deadline = time.monotonic() + 120
        while not heeds(process, signal.SIGTERM) and time.monotonic() < deadline:
            time.sleep(0.001)
        time.sleep(chance.uniform(0.0, 0.2))
        os.killpg(process.pid, signal.SIGTERM)
        _, errors = process.communicate(timeout=120)
        assert process.returncode == 130
        assert errors.count("interrupted") == 1
        assert "Traceback" not in errors
        assert not (tmp_path / "out").exists()


@pytest.mark.skipif(sys.platform != "linux", reason="finds the child of a process in /proc")
@pytest.mark.parametrize(
    ("kind", "code", "said"),
    [
        (signal.SIGTERM, 130, "interrupted; "),
        (signal.SIGKILL, 1, "the process that reads the command line was ended by signal 9;"),
    ],
)
def test_a_signal_to_the_one_that_parses(kind: signal.Signals, code: int, said: str, spec_file, tmp_path: Path) -> None:
    process = start(spec_file(BUSY), tmp_path / "out")
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    deadline = time.monotonic() + 120
    while not (found := children.read_text().split()) and time.monotonic() < deadline:
        time.sleep(0.001)
    os.kill(int(found[0]), signal.SIGSTOP)  # so that it is not through before
    os.kill(int(found[0]), kind)
    os.kill(int(found[0]), signal.SIGCONT)
    _, errors = process.communicate(timeout=120)
    assert process.returncode == code
    assert errors.startswith(said), errors
    assert errors.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_closed_pipe(spec_file, tmp_path: Path) -> None:
    read, write = os.pipe()
    os.close(read)
    plain = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}
    done = subprocess.run(
        [HKNOB, "sweep", spec_file(), "-o", tmp_path / "out"],
        env=plain,
        stdout=write,
        stderr=subprocess.PIPE,
        text=True,
        check=False,
    )
    os.close(write)
    assert "Traceback" not in done.stderr
    assert (tmp_path / "out" / "orbits.parquet").exists()
