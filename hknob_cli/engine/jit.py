"""The same engine source, compiled: for jobs long enough to repay numba's start-up.

The engine's functions are plain Python over floats. Here each is copied with its references to other engine
functions, and to `floor`, replaced by compiled ones, so that nothing in the source knows about a compiler. Neither
side reorders or fuses arithmetic: results are the same to the last bit.
"""

import hashlib
import importlib
import os
import sys
import types
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

# In the order of use: a module's functions are compiled before those that call them.
MODULES = ("propagator", "loop", "turning", "certificate", "rest", "follow", "ensemble", "trace", "relay_cycles")


def _source_digest() -> str:
    """Digest of the engine's sources: compiled code of another version is never taken from the cache."""
    here = Path(__file__).parent
    digest = hashlib.sha256()
    for name in (*MODULES, "jit"):
        digest.update((here / f"{name}.py").read_bytes())
    return digest.hexdigest()[:16]


def cache_directory() -> Path | None:
    """Where compiled code is kept between runs: ``$HKNOB_CACHE_DIR``, else the user's cache folder, if there is one."""
    base = os.environ.get("HKNOB_CACHE_DIR") or os.environ.get("XDG_CACHE_HOME")
    try:
        root = Path(base) if base else Path.home() / ".cache"
    except RuntimeError:  # a user without a home
        return None
    return root / "hknob" / f"engine-{_source_digest()}"


def _writable(path: Path | None) -> bool:
    if path is None:
        return False
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError:
        return False
    return os.access(path, os.W_OK)


def _load_target() -> None:
    """Load numba's target without its linear algebra: that would load all of scipy.linalg, and the engine has none."""
    from numba.core.registry import cpu_target

    blas = "scipy.linalg.cython_blas"
    known = blas in sys.modules
    if not known:
        sys.modules[blas] = None  # type: ignore[assignment]  # makes its import fail, which numba allows for
    try:
        cpu_target.target_context.refresh()
    finally:
        if not known:
            del sys.modules[blas]


def is_cached() -> bool:
    """Whether compiled code of these sources is on disk, so that `compiled` takes no more than loading it."""
    folder = cache_directory()
    return folder is not None and any(folder.glob("**/*.nbi"))


@cache
def compiled() -> dict[str, Callable[..., Any]]:
    """Every engine function by name, compiled on first call; compiled code is cached where a cache can be written."""
    import numba
    import numpy as np

    _load_target()
    folder = cache_directory()
    keep = _writable(folder)
    if keep:
        numba.config.CACHE_DIR = str(folder)  # type: ignore[attr-defined]
    done: dict[str, Any] = {}
    for name in MODULES:
        module = importlib.import_module(f"hknob_cli.engine.{name}")
        for key, function in vars(module).items():
            if not isinstance(function, types.FunctionType) or function.__module__ != module.__name__:
                continue
            if key == "floor":
                done[key] = np.floor
                continue
            copy = types.FunctionType(function.__code__, {**function.__globals__, **done}, key)
            copy.__qualname__ = key
            copy.__module__ = module.__name__
            done[key] = numba.njit(copy, cache=keep, nogil=True)
    return done
