"""The C of docs/howto/controller_in_firmware.md gives the torques of the reference's block, and those of a sweep."""

import ctypes
import shlex
import shutil
import subprocess
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.conftest import ROOT, Command
from tests.controllers.laws import LAWS
from tests.controllers.page_blocks import K

from .markdown import blocks

PAGE = ROOT / "docs" / "howto" / "controller_in_firmware.md"
COMPILER = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
pytestmark = pytest.mark.skipif(COMPILER is None, reason="no C compiler")


class Compiled:
    """The page's C, begun."""

    def __init__(self, folder: Path, counts: int, rate: float, time_constant: float) -> None:
        (source,) = (block.text for block in blocks(PAGE) if block.language == "c")
        (folder / "lag.c").write_text(source, encoding="utf-8")
        flags = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-shared", "-fPIC", "-ffp-contract=off"]
        subprocess.run([str(COMPILER), *flags, "lag.c", "-o", "lag.so", "-lm"], cwd=folder, check=True)
        library = ctypes.CDLL(str(folder / "lag.so"))
        library.bounded_lag_begin.argtypes = [ctypes.c_void_p, *[ctypes.c_double] * 5]
        library.bounded_lag_torque.argtypes = [ctypes.c_void_p, ctypes.c_long]
        library.bounded_lag_torque.restype = ctypes.c_double
        self.library, self.memory = library, (ctypes.c_double * 5)()
        library.bounded_lag_begin(self.memory, K, 2.0 * pi / counts, 1.0 / rate, 0.15, time_constant)

    def torque(self, count: int) -> float:
        return float(self.library.bounded_lag_torque(self.memory, count))


@pytest.mark.parametrize(("counts", "rate"), [(360, 1000.0), (2650, 4000.0)])
def test_its_torques_are_those_of_the_block(counts: int, rate: float, tmp_path: Path) -> None:
    ours, count = Compiled(tmp_path, counts, rate, 0.02), 2.0 * pi / counts
    block = LAWS["bounded_lag"].Block(counts, rate, keep=0.15, time_constant=0.02)
    acts = 0
    for read in np.random.default_rng(1).integers(-6, 3, 500):
        theirs = block.sample(float(read) * count, 0.0, [])[0]
        assert abs(ours.torque(int(read)) - theirs) <= _rounding(count)
        acts += abs(theirs - block.w) > 1e-6
    assert acts > 100


def test_its_torques_are_those_of_the_sweep_that_the_page_records(hknob: Command, tmp_path: Path) -> None:
    (tmp_path / "experiments").symlink_to(ROOT / "experiments")
    command = [block.text for block in blocks(PAGE) if block.language == "console"][-1].removeprefix("$ hknob ")
    # The motion is that of one trial; sets of starts under a law would be compiled.
    done = hknob(*shlex.split(command), "--set", "starts={angle: 0.02, phases: 8}", "-q")
    assert done.returncode == 0, done.stderr
    (script,) = (block.text for block in blocks(PAGE) if block.language == "python")
    found: dict[str, Any] = {}
    exec(script.replace("results/", f"{tmp_path}/results/"), found)
    ours = Compiled(tmp_path, 1024, 1000.0, 0.2)
    assert len(found["counts"]) == 200
    assert min(found["counts"]) < 0
    for count, torque in zip(found["counts"], found["torques"], strict=True):
        assert abs(ours.torque(count) - torque) <= _rounding(2.0 * pi / 1024)


def _rounding(count_rad: float) -> float:
    """A dozen roundings of terms no larger than the wall's torque and a count's."""
    return float(12 * np.finfo(float).eps * K * count_rad * 7.0)
