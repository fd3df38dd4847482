"""The same engine source, compiled: for jobs long enough to repay numba's start-up.

The engine's functions are plain Python over floats. Here each is copied with its references to other engine
functions, and to `floor`, replaced by compiled ones, so that nothing in the source knows about a compiler. Neither
side reorders or fuses arithmetic: results are the same to the last bit.
"""

import contextlib
import hashlib
import importlib
import os
import re
import sys
import types
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from hknob_cli.engine.compiling import COMPILING_S, listen
from hknob_cli.engine.kept_code import keep_sealed, load_numba, make_own_folder
from hknob_cli.engine.linking import kinds

# In the order of use: a module's functions are compiled before those that call them.
MOTION = ("propagator", "loop", "turning", "certificate", "rest", "follow", "ensemble")
ORBIT = ("orbit_holds", "orbit_cycle")
PLAIN = (*MOTION, *ORBIT, "relay_cycles")
CELLS = (*MOTION, "budget", *ORBIT, "cells")
GENERAL = (
    *MOTION,
    "general.torque_table",
    "general.torque_curve",
    "general.controller",
    "general.body",
    "general.slide_two",
    "general.slide_many",
    "general.columns",
    "general.cogging",
    "general.teeth",
    "general.teeth_ends",
    "general.flank_rest",
    "general.flanks",
    "general.slopes",
    "general.powers",
    "general.piece_marks",
    "general.corners",
    "general.slope_columns",
    "general.advance",
    "general.hysteresis",
    "general.interval",
    "general.period_map",
    "general.orbit_proof",
    "general.inner_region",
    "general.cog_rest",
    "general.standstill",
    "general.captured",
    "general.looks",
    "general.follow",
    "general.ensemble",
    "general.trace",
    "general.clock_cells",
    *ORBIT,
)
# The general loop under a controller; the law itself is compiled by itself (`compiled_law`).
LAWS = (
    *GENERAL,
    *(f"general.laws.{name}" for name in ("law", "step", "cascade", "sensed", "period", "rest", "follow", "trials")),
)
SETS = (
    *MOTION,
    *(f"sets.{name}" for name in ("ball", "arc_cut", "arc")),
    *(f"sets.{name}" for name in ("polygon", "region", "box")),
    *ORBIT,
    "budget",
    "cells",
    "sets.cells",
)
# As in "cells", but every clock phase instead of sampled ones.
ARC_CELLS = (
    *MOTION,
    *(f"sets.{name}" for name in ("ball", "arc_cut", "arc")),
    "budget",
    *ORBIT,
    "cells",
    "sets.cells",
)
GENERAL_SETS = (
    *LAWS,
    *(f"general.sets.{name}" for name in ("cell", "readings", "memory", "turns", "swings", "known", "ball", "piece")),
    *(f"general.sets.{name}" for name in ("parts", "lattice", "box")),
    *(f"general.sets.{name}" for name in ("curve", "arc_parts", "arc")),
    *(f"sets.{name}" for name in ("polygon", "region")),
)
FRICTION_ARCS = (
    *LAWS,
    *(f"general.sets.{name}" for name in ("cell", "readings", "memory", "turns", "known", "ball")),
    "general.sets.friction_arc",
    "general.sets.cog_stop",
    "general.sets.cog_arc",
    *(f"general.sets.friction_arc{end}" for end in ("_counts", "_rest", "_parts", "s")),
)
FRICTION_SETS = (
    *GENERAL_SETS,
    *(f"general.sets.{name}" for name in ("convex", "friction_step", "lagged_stops", "lagged_step")),
    *(f"general.sets.{name}" for name in ("friction_set", "friction_turns", "friction_piece", "friction_rest")),
    *(f"general.sets.{name}" for name in ("friction_box", "friction_phases")),
)
COGGING_SETS = (
    *GENERAL_SETS,
    *(f"general.sets.{name}" for name in ("convex", "friction_step", "lagged_stops", "lagged_step")),
    *(f"general.sets.{name}" for name in ("friction_set", "friction_turns", "friction_piece", "friction_rest")),
    "general.sets.friction_box",
    *(f"general.sets.{name}" for name in ("friction_arc", "cog_stop", "cog_arc", "friction_arc_rest")),
    *(f"general.sets.{name}" for name in ("cog_fold", "cog_piece", "cog_box")),
)
UNSAMPLED = (
    "propagator",
    "loop",
    "turning",
    *(f"unsampled.{name}" for name in ("state_machine", "settling")),
)
PULSE = ("pulse", "pulse_friction")
INTERPRETED = "interpreted"  # file beside compiled code
ALLOCATING = ("copy_line",)  # functions of the engine that make an array
# What is compiled for a scene, or for a recorded pulse: its modules, and functions of which Python calls one first.
GROUPS = {
    "plain": (PLAIN, ("ensemble.ensemble",)),
    "cells": (CELLS, ("cells.run_cells",)),
    "arc_cells": (ARC_CELLS, ("cells.run_arc_cells",)),
    "bounces": (MOTION, ("turning.bounce_peaks",)),
    "general": (GENERAL, ("ensemble.run_trials",)),
    "clocks": (GENERAL, ("clock_cells.reach_cells",)),  # alone: the loop itself takes the compiler ten times as long
    "laws": (LAWS, ("trials.run_trials_with_law",)),
    "unsampled": (UNSAMPLED, ("settling.settle_motion",)),
    "sets": (SETS, ("box.follow_generation", "cells.follow_cell")),
    "general sets": (GENERAL_SETS, ("box.follow_generation", "arc.follow_arcs")),
    "friction sets": (FRICTION_SETS, ("friction_box.follow_friction", "friction_phases.follow_phases")),
    "friction arcs": (FRICTION_ARCS, ("friction_arcs.follow_friction_arcs",)),
    "cogging sets": (COGGING_SETS, ("cog_box.follow_cogged",)),
    "pulse": (PULSE, ("pulse.follow_linear",)),
}


@cache
def _source_digest() -> str:
    """Digest of the engine's sources: compiled code of another version is never taken from the cache."""
    here = Path(__file__).parent
    digest = hashlib.sha256()
    compilers = ("absent", "jit", "kept_code", "linking")
    for name in sorted({*compilers, *(name for modules, _ in GROUPS.values() for name in modules)}):
        digest.update((here / f"{name.replace('.', '/')}.py").read_bytes())
    return digest.hexdigest()[:16]


def cache_directory() -> Path | None:
    """Where compiled code is kept between runs: ``$HKNOB_CACHE_DIR``, else the user's cache folder, if there is one."""
    base = os.environ.get("HKNOB_CACHE_DIR") or os.environ.get("XDG_CACHE_HOME")
    try:
        root = Path(base) if base else Path.home() / ".cache"
    except RuntimeError:  # a user without a home
        return None
    return root / "hknob" / f"engine-{_source_digest()}"


def _not_kept() -> str:
    """Why compiled code is not kept between runs; empty if it is. What is kept is run, and must be this user's own."""
    folder = cache_directory()
    return "there is no folder for it" if folder is None else make_own_folder(folder)


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


def is_kept(group: str = "plain") -> bool:
    """Whether a group's compiled code is on disk, and only to be loaded."""
    folder = cache_directory()
    if _not_kept() or folder is None:
        return False
    # Folders may go while one looks: make_own_folder tries one, in every process.
    begin = tuple(f"{entry}-" for entry in GROUPS[group][1])
    return any(name.startswith(begin) and name.endswith(".nbi") for _, _, names in os.walk(folder) for name in names)


def note_interpreted(group: str, seconds: float) -> None:
    """Keep, beside compiled code, that a run has interpreted a group for so long: the next run weighs with it."""
    folder = cache_directory()
    if not _not_kept() and folder is not None:
        with contextlib.suppress(OSError), (folder / INTERPRETED).open("a", encoding="ascii") as file:
            file.write(f"{group}: {seconds:.2f}\n")


def interpreted_s(group: str = "plain") -> float:
    """Seconds for which earlier runs have interpreted a group, where that is kept; lines that are damaged count not."""
    folder = cache_directory()
    if _not_kept() or folder is None:
        return 0.0
    try:
        lines = (folder / INTERPRETED).read_text(encoding="ascii", errors="replace").splitlines()
    except OSError:
        return 0.0
    return sum(float(number[1]) for line in lines if (number := re.fullmatch(rf"{group}: (\d+\.\d\d)", line)))


def waiting(group: str = "plain") -> str:
    """What to say before `compiled`; empty where compiled code of these sources is on disk, and only to be loaded."""
    if is_kept(group):
        return ""
    if why := _not_kept():
        return f"each long run compiles the engine: compiled code is not kept because {why}"
    return (
        f"the engine is compiled once for this machine; that takes about {round(COMPILING_S[group])} s on an idle core"
    )


@cache
def compiled(group: str = "plain") -> dict[str, Callable[..., Any]]:
    """Every function of a group by name, compiled on first call; compiled code is cached where a cache can be written.

    A function of a module in a package goes by its module's name, too: ``general.run_trials``.
    """
    import numpy as np

    numba = load_numba()
    _load_target()
    listen()
    keep = not _not_kept()
    if keep:
        numba.config.CACHE_DIR = str(cache_directory())
    named: dict[str, Any] = {}
    parts: dict[types.FunctionType, Any] = {}
    for name in GROUPS[group][0]:
        module = importlib.import_module(f"hknob_cli.engine.{name}")
        prefix = name.rpartition(".")[0]
        for key, function in vars(module).items():
            if not isinstance(function, types.FunctionType) or function.__module__ != module.__name__:
                continue
            if key == "floor":
                parts[function] = np.floor
                continue
            seen = tuple(
                (other, parts[value])
                for other, value in function.__globals__.items()
                if isinstance(value, types.FunctionType) and value in parts
            )
            parts[function], named[f"{prefix}.{key}" if prefix else key] = _compilable(function, seen, keep)
    return named


@cache
def _compilable(function: types.FunctionType, seen: tuple[tuple[str, Any], ...], keep: bool) -> tuple[Any, Any]:
    """A function as a part of others and as an entry, with those that it calls; groups that have it share them."""
    copy = types.FunctionType(function.__code__, {**function.__globals__, **dict(seen)}, function.__name__)
    copy.__qualname__ = function.__name__
    copy.__module__ = function.__module__
    called = function.__code__.co_names
    allocates = function.__name__ in ALLOCATING or any(
        getattr(other, "allocates", False) for name, other in seen if name in called
    )
    part, entry = kinds().part(copy, allocates=allocates), kinds().entry(copy, allocates=allocates)
    if keep:
        entry.enable_caching()
        keep_sealed(entry)
    return part, entry


def _law_part(function: types.FunctionType) -> tuple[Any, Any]:
    """A law, or what it calls, as `_compilable` makes it; what it calls is compiled before."""
    names = [(name, function.__globals__.get(name)) for name in function.__code__.co_names]
    seen = tuple((name, _law_part(value)[0]) for name, value in names if isinstance(value, types.FunctionType))
    return _compilable(function, seen, not _not_kept())


@cache
def compiled_law(act: types.FunctionType) -> Any:
    """The address of a law, compiled by itself: what calls it need not be compiled for it.

    Its helpers are in its own file, or in the engine's: a change of either is another law.
    """
    compiled("laws")  # which loads numba
    from numba.core.ccallback import CFunc
    from numba.core.types import float64

    numbers = float64[::1]
    source: Any = _law_part(act)[1]
    takes = (float64, float64, numbers, numbers, numbers)
    # numba.cfunc would not let it be sealed
    law = CFunc(source.py_func, (takes, float64), locals={}, options={"_nrt": False}, pipeline_class=kinds().pipeline)
    if not _not_kept():
        law.enable_caching()
        keep_sealed(law)
    law.compile()
    return law
