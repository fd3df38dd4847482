"""The controller in C of docs/howto/controller_in_firmware.md gives the torques of the reference's block."""

import ctypes
import shutil
import subprocess
from math import pi
from pathlib import Path

import numpy as np
import pytest

from tests.conftest import ROOT
from tests.controllers.laws import LAWS
from tests.controllers.page_blocks import K

from .markdown import blocks

PAGE = ROOT / "docs" / "howto" / "controller_in_firmware.md"
COMPILER = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")


@pytest.mark.skipif(COMPILER is None, reason="no C compiler")
@pytest.mark.parametrize(("counts", "rate"), [(360, 1000.0), (2650, 4000.0)])
def test_its_torques_are_those_of_the_block(counts: int, rate: float, tmp_path: Path) -> None:
    (source,) = (block.text for block in blocks(PAGE) if block.language == "c")
    (tmp_path / "lag.c").write_text(source, encoding="utf-8")
    flags = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-shared", "-fPIC", "-ffp-contract=off"]
    subprocess.run([str(COMPILER), *flags, "lag.c", "-o", "lag.so", "-lm"], cwd=tmp_path, check=True)
    library = ctypes.CDLL(str(tmp_path / "lag.so"))
    library.bounded_lag_begin.argtypes = [ctypes.c_void_p, *[ctypes.c_double] * 5]
    library.bounded_lag_torque.argtypes = [ctypes.c_void_p, ctypes.c_long]
    library.bounded_lag_torque.restype = ctypes.c_double
    memory = (ctypes.c_double * 5)()
    count = 2.0 * pi / counts
    library.bounded_lag_begin(memory, K, count, 1.0 / rate, 0.15, 0.02)
    block = LAWS["bounded_lag"].Block(counts, rate, keep=0.15, time_constant=0.02)
    acts = 0
    for read in np.random.default_rng(1).integers(-6, 3, 500):
        ours, theirs = library.bounded_lag_torque(memory, int(read)), block.sample(float(read) * count, 0.0, [])[0]
        # A dozen roundings of terms no larger than the wall's torque and a count's.
        assert abs(ours - theirs) <= 12 * np.finfo(float).eps * K * count * 7.0
        acts += abs(theirs - block.w) > 1e-6
    assert acts > 100
