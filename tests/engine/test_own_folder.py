"""Compiled code is kept, and taken, only from a folder that nobody else can write."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from hknob_cli.engine import jit
from hknob_cli.engine.kept_code import make_own_folder, why_foreign

LONG = "from hknob_cli.engine.jit import compiled, waiting; print(waiting('pulse')); compiled('pulse')"


@pytest.fixture
def base(tmp_path: Path) -> Path:
    tmp_path.chmod(0o700)
    return tmp_path


def test_a_folder_that_is_made_is_this_users_alone(base: Path) -> None:
    before = os.umask(0)
    try:
        assert make_own_folder(base / "a" / "b") == f"{base / 'a'} can be written by others"
        (base / "a").chmod(0o755)
        assert make_own_folder(base / "a" / "b") == ""
    finally:
        os.umask(before)
    assert (base / "a" / "b").stat().st_mode & 0o777 == 0o700


@pytest.mark.parametrize("mode", [0o777, 0o707, 0o770])
def test_others_may_not_write_it(mode: int, base: Path) -> None:
    folder = base / "own"
    folder.mkdir(mode=0o700)
    inner = folder / "inner"
    inner.mkdir()
    inner.chmod(mode)
    assert why_foreign(folder) == f"{inner} can be written by others"
    inner.chmod(0o755)
    assert why_foreign(folder) == ""
    folder.chmod(mode)
    assert why_foreign(folder) == f"{folder} can be written by others"


def test_others_may_not_exchange_it(base: Path) -> None:
    shared = base / "shared"
    folder = shared / "own"
    folder.mkdir(parents=True, mode=0o700)
    shared.chmod(0o777)
    assert why_foreign(folder) == f"{shared} can be written by others"
    shared.chmod(0o1777)  # as /tmp: there nobody can rename what is another's
    assert why_foreign(folder) == ""


def test_a_link_or_no_folder_is_none(base: Path) -> None:
    (base / "real").mkdir(mode=0o700)
    (base / "link").symlink_to(base / "real")
    assert "is not this user's" in why_foreign(base / "link")
    (base / "file").write_text("")
    assert "cannot be made" in make_own_folder(base / "file")


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can give files away")
def test_what_is_another_users_is_not_taken(base: Path) -> None:
    folder = base / "theirs"
    folder.mkdir(mode=0o700)
    os.chown(folder, 12345, 12345)
    assert why_foreign(folder) == f"{folder} is not this user's"
    inner = folder / "own"
    inner.mkdir(mode=0o700)
    assert why_foreign(inner) == f"{folder} is another user's"


def test_compiled_code_is_not_taken_from_a_shared_folder(base: Path) -> None:
    """The cache holds pickles: whoever writes it, runs code in this process."""

    def run() -> str:
        env = {**os.environ, "HKNOB_CACHE_DIR": str(base / "cache")}
        done = subprocess.run([sys.executable, "-c", LONG], env=env, capture_output=True, text=True, check=True)
        return done.stdout.strip()

    assert run().startswith("the engine is compiled once for this machine; that takes about ")
    (folder,) = (base / "cache" / "hknob").glob("engine-*")
    assert folder.stat().st_mode & 0o777 == 0o700
    folder.chmod(0o777)
    assert run().endswith(f"compiled code is not kept because {folder} can be written by others")


def test_a_user_without_a_folder_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jit, "cache_directory", lambda: None)
    assert jit.waiting().endswith("compiled code is not kept because there is no folder for it")
