"""A disk that is really full: what is finished stays, and each time there is a little more room the run goes on."""

import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.conftest import SPEC
from tests.faults.spread_runs import SLOW, SWEEP, finish, left, pieces, run, start, wait_until


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """A file system of 256 kB."""
    place = tmp_path / "disk"
    place.mkdir()
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=256k", "none", place], capture_output=True, check=False
    )
    if mounted.returncode:
        pytest.skip("cannot mount a small disk here")
    yield place
    subprocess.run(["umount", place], check=True)


@pytest.mark.long
def test_a_sweep_goes_on_as_room_is_made(small_disk: Path, tmp_path: Path) -> None:
    spec = tmp_path / "spec.yaml"
    spec.write_text(SWEEP)
    assert run(spec, tmp_path / "undisturbed") == (0, "")
    out = small_disk / "out"
    filler = small_disk / "filler"
    filler.write_bytes(bytes(250_000))
    refused = 0
    for size in range(220_000, 0, -30_000):
        code, errors = run(spec, out, "-q")
        if code == 0:
            break
        assert (code, errors.count("\n")) == (1, 1)
        assert errors.startswith(f"{out}: cannot be written: No space left on device; ")
        assert errors.endswith("make room there, and run the same command again\n")
        refused += 1
        with filler.open("r+b") as stream:
            stream.truncate(size)
    # Pieces that end out of order wait beside the parts: how much room is enough depends on the workers' timing.
    subprocess.run(["mount", "-o", "remount,size=1m", small_disk], check=True)
    assert run(spec, out, "-q") == (0, "")
    assert refused >= 3
    assert left(out) == left(tmp_path / "undisturbed")


@pytest.mark.long
def test_a_disk_that_becomes_read_only(small_disk: Path, tmp_path: Path) -> None:
    spec = tmp_path / "spec.yaml"
    spec.write_text(SWEEP)
    out = small_disk / "out"
    process = start(spec, out, "-q", fault=SLOW)
    wait_until(lambda: pieces(out) > 0, "a piece is there")
    process.kill()
    finish(process)
    subprocess.run(["mount", "-o", "remount,ro", small_disk], check=True)
    code, errors = run(spec, out, "-q")
    assert (code, errors) == (1, f"{out}: cannot be written: Read-only file system\n")
    subprocess.run(["mount", "-o", "remount,rw", small_disk], check=True)
    assert run(spec, out, "-q") == (0, "")


def test_a_small_sweep_says_what_to_do(small_disk: Path, hknob, spec_file) -> None:
    (small_disk / "filler").write_bytes(bytes(250_000))
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(small_disk)
        done = hknob("sweep", spec_file(SPEC), "-o", small_disk / "out")
    assert done.returncode == 1
    assert done.stderr == (
        f"{small_disk / 'out'}: cannot be written: No space left on device; make room there, and run the same command "
        "again\n"
    )
    (small_disk / "filler").unlink()
    assert hknob("sweep", spec_file(SPEC), "-o", small_disk / "out").returncode == 0


def test_a_read_only_disk_is_said(small_disk: Path, hknob, spec_file) -> None:
    subprocess.run(["mount", "-o", "remount,ro", small_disk], check=True)
    done = hknob("sweep", spec_file(SPEC), "-o", small_disk / "out")
    assert (done.returncode, done.stderr) == (1, f"{small_disk / 'out'}: cannot be written: Read-only file system\n")
    subprocess.run(["mount", "-o", "remount,rw", small_disk], check=True)
    assert hknob("sweep", spec_file(SPEC), "-o", small_disk / "out").returncode == 0


@pytest.mark.long
@pytest.mark.parametrize("filler", [262_144, 230_000])
def test_no_room_for_compiled_code(filler: int, small_disk: Path, hknob, spec_file) -> None:
    """It is compiled for this run alone: from no room for a folder to room for some of it."""
    (small_disk / "filler").write_bytes(bytes(filler))
    spec = spec_file(SPEC.replace("phases: 8", "phases: 200000"))  # fewer are done before a compiler would be
    done = hknob("sweep", spec, "-o", small_disk.parent / "out", HKNOB_CACHE_DIR=str(small_disk / "cache"))
    assert done.returncode == 0
    assert "compiling the engine for this machine" in done.stderr
