"""Memory of a long run: kept from one piece of work to the next, where the C library can be told so."""

import platform
import subprocess
import sys

import pytest

FAULTS = """\
import resource, sys
import numpy as np
import pyarrow as pa
from hknob_cli.spread.processes import keep_memory

if sys.argv[1] == "kept":
    keep_memory()


def piece():
    arrays = [np.ones(50_000) for _ in range(100)]


piece()
before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
for _ in range(10):
    piece()
print(resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before, pa.default_memory_pool().backend_name)
"""


def faults(how: str) -> tuple[int, str]:
    said = subprocess.run([sys.executable, "-c", FAULTS, how], capture_output=True, text=True, check=True).stdout
    count, pool = said.split()
    return int(count), pool


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="only the GNU C library can be told")
def test_pages_are_taken_once() -> None:
    """A piece takes 40 MB, ten thousand pages, and there are ten."""
    (kept, pool), (given_back, _) = faults("kept"), faults("given back")
    assert pool == "system"
    assert kept < 1000 < given_back
