"""Compiled code on the disk that is damaged is said, removed and compiled again; settings of numba stop nothing."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

# A function of the smallest group, and a law, which is compiled by itself.
USE = """
from hknob_cli.controllers.half_sample import half_sample
from hknob_cli.engine import compiling
from hknob_cli.engine.jit import compiled, compiled_law

compiling.tell_compiling(lambda text: print(text) if "compiled code" in text or text.startswith("compiled") else None)
print(compiled("bounces")["hold_coefficients"](0.1, 0.2, 0.5))
print(compiled_law(half_sample).address > 0)
"""
RESULT = ["(0.483651857545281, 0.1224327533539806, 0.9271482635746758)", "True"]


def use(base: Path, **env: str) -> list[str]:
    done = subprocess.run(
        [sys.executable, "-c", USE],
        env={**os.environ, "HKNOB_CACHE_DIR": str(base / "cache"), **env},
        cwd=base,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout.splitlines()


def spoil(path: Path, how: str) -> None:
    content = path.read_bytes()
    middle = len(content) // 2
    flipped = content[:middle] + bytes([content[middle] ^ 16]) + content[middle + 1 :]
    path.write_bytes({"empty": b"", "cut": content[:middle], "flipped": flipped}[how])


@pytest.mark.long
def test_damaged_code_is_compiled_again_and_said(tmp_path: Path) -> None:
    first = use(tmp_path)
    assert [line for line in first if not line.startswith("compiled")] == RESULT
    assert use(tmp_path) == RESULT  # kept
    for ending, how in ((".nbi", "empty"), (".nbc", "flipped"), (".nbc", "cut")):
        files = sorted((tmp_path / "cache").rglob(f"*{ending}"))
        assert len(files) == 2
        for file in files:
            spoil(file, how)
        again = use(tmp_path)
        said = [line for line in again if line.startswith("compiled code of ")]
        assert len(said) == 2
        assert all("is not as it was kept (damaged): it is removed, and compiled again" in line for line in said)
        assert [line for line in again if not line.startswith("compiled")] == RESULT
        assert use(tmp_path) == RESULT


@pytest.mark.one_in(3)
@pytest.mark.parametrize("content", ["disable_jit: 1\nopt: 0\n", "{", "disable_jit: [\n"])
def test_settings_of_numba_in_the_working_folder_are_without_effect(content: str, tmp_path: Path) -> None:
    (tmp_path / ".numba_config.yaml").write_text(content)
    assert [line for line in use(tmp_path, NUMBA_DISABLE_JIT="1") if not line.startswith("compiled")] == RESULT
    assert use(tmp_path) == RESULT  # it was compiled, and as without these settings
