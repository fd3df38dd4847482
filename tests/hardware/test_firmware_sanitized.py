"""Tests of the target's C sources under sanitizers: of addresses, and of what C does not define."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from .firmware import need_compiler

HERE = Path(__file__).parent
KINDS = "-fsanitize=address,undefined,float-cast-overflow,float-divide-by-zero"
FIRMWARE = sorted(path.name for path in HERE.glob("test_firmware_*.py") if path != Path(__file__))
ON_HOST = "../crosscheck/test_hw_run_targets.py::test_a_target_gives_the_samples_of_the_virtual_device"
FAULTS = {
    "signed integer overflow": "int big = 2147483647; return argc + big == 0;",
    "heap-buffer-overflow": "char *two = malloc(2); two[argc + 1] = 1; return two[0];",
    "is outside the range of representable values": "return (int)(argc * 1e300);",
}


@pytest.fixture(scope="module")
def guarded() -> dict[str, str]:
    """The environment in which all C is compiled with sanitizers, and Python can load it."""
    command = need_compiler()
    runtime = subprocess.run([*command, "-print-file-name=libasan.so"], capture_output=True, text=True).stdout.strip()
    if not Path(runtime).is_absolute():
        pytest.skip(f"{command[0]} has no sanitizers")
    command += [KINDS, "-fno-sanitize-recover=all", "-g"]
    leaks = "detect_leaks=0"  # Python itself keeps what it has to its end
    return {**os.environ, "ASAN_OPTIONS": leaks, "CC": " ".join(command), "LD_PRELOAD": runtime}


@pytest.mark.long
@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_noticed(fault: str, guarded: dict[str, str], tmp_path: Path) -> None:
    """Else the test below could not fail."""
    source = tmp_path / "fault.c"
    source.write_text(f"#include <stdlib.h>\nint main(int argc, char **argv) {{ (void)argv; {FAULTS[fault]} }}\n")
    subprocess.run([*guarded["CC"].split(), str(source), "-o", str(tmp_path / "fault")], check=True)
    done = subprocess.run([tmp_path / "fault"], capture_output=True, text=True, env=guarded)
    assert done.returncode != 0
    assert fault in done.stderr


@pytest.mark.long
@pytest.mark.drawn(4)
@pytest.mark.parametrize("tests", [*FIRMWARE, ON_HOST])
def test_the_firmware(tests: str, guarded: dict[str, str]) -> None:
    """All that its tests do with it, as a library beside Python and as a process."""
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", str(HERE / tests), "-k", "not qemu"]
    done = subprocess.run(command, capture_output=True, text=True, env=guarded, cwd=HERE.parent.parent)
    assert done.returncode == 0, done.stdout[-4000:] + done.stderr[-4000:]
    assert "[100%]" in done.stdout
