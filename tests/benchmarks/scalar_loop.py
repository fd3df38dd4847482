"""The plain scalar C loop of scalar_loop.c, compiled by gcc and called through ctypes."""

import ctypes
import subprocess
from math import pi
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hknob_cli.engine.loop import Loop

Array = NDArray[np.float64]

FLAGS = {"strict": ["-ffp-contract=off"], "fused": []}


class ScalarLoop:
    """The C loop under one set of `FLAGS`; every call takes one state a trial and runs one trial after the other."""

    def __init__(self, folder: Path, name: str) -> None:
        library = folder / f"{name}.so"
        source = Path(__file__).with_suffix(".c")
        options = ["-O3", "-march=native", *FLAGS[name], "-shared", "-fPIC"]
        subprocess.run(["gcc", *options, str(source), "-o", str(library), "-lm"], check=True)
        self._library = ctypes.CDLL(str(library))

    def advance(self, x: Array, v: Array, steps: int, loop: Loop) -> None:
        """Advance all trials in place."""
        self._library.advance(_at(x), _at(v), ctypes.c_long(len(x)), ctypes.c_long(steps), _at(_packed(loop)))

    def measure(self, x: Array, v: Array, skip: int, window: int, loop: Loop) -> tuple[Array, Array]:
        """Advance all trials in place; highest and lowest extremum of each over the last ``window`` samples."""
        high, low = np.empty(len(x)), np.empty(len(x))
        spans = ctypes.c_long(len(x)), ctypes.c_long(skip), ctypes.c_long(window)
        self._library.measure(_at(x), _at(v), *spans, _at(_packed(loop)), _at(high), _at(low))
        return high, low


def _packed(loop: Loop) -> Array:
    """The loop as C's struct. What the C loop leaves out must be absent."""
    if (loop.sense, loop.offset, loop.split) != (1.0, 0.0, 0.0):
        raise ValueError("the C loop knows a floor encoder without offset or delay only")
    if not 0.0 < loop.beta - 0.25 * loop.alpha**2 < (0.5 * pi) ** 2:
        raise ValueError("the C loop knows an underdamped plant sampled over four times per ringing period only")
    return np.array([loop.alpha, loop.beta, loop.kappa, loop.gamma, loop.s2, loop.g2, loop.f2])


def _at(values: Array) -> ctypes.c_void_p:
    return values.ctypes.data_as(ctypes.c_void_p)
