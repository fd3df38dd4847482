"""A process of a fuzzing campaign: a range of seeds, one after the other, counted; failures sent as they are found."""

import faulthandler
import gc
import importlib.metadata
import os
import resource
import shutil
import tempfile
import warnings
from collections import Counter
from collections.abc import Callable
from functools import cache, lru_cache
from pathlib import Path
from typing import Any, NamedTuple

from tests.fuzz.arena import Arena
from tests.fuzz.families import FAMILIES, Failure, dice_of
from tests.fuzz.minimise import minimised
from tests.fuzz.watch import Watch

MEMORY_BYTES = 8 << 30  # of address space; what asks for more has lost its measure
LARGE = 100_000  # bytes that are left as they are
REPORT_EVERY = 200
MEMORY = "/dev/shm"  # a folder that is no disk, where there is one: to write a spec costs as much as to check it
TREES = 256  # of YAML files that are kept


class Task(NamedTuple):
    """Inputs ``start`` to ``stop`` of a family; ``options`` go to what makes them."""

    family: str
    start: int
    stop: int
    options: dict[str, Any]


def work(task: Task, send: Callable[[str, Any], None], now: Any) -> None:
    """Try the inputs. ``now`` has the seed being tried; ``send`` gets counts, and each failure."""
    faulthandler.enable()
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))
    if not FAMILIES[task.family].on_disk:
        warnings.simplefilter("error")
        _try_all(task, None, send, now)
        return
    memory = MEMORY if os.access(MEMORY, os.W_OK) else None
    folder = Path(tempfile.mkdtemp(prefix="hknob-fuzz-", dir=memory))
    try:
        arena = Arena(folder / "arena", Watch())
        warnings.simplefilter("error")
        _make_quick()
        _try_all(task, arena, send, now)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _make_quick() -> None:
    """Spare what has nothing to do with an input: what takes a command milliseconds, and the same each time.

    The versions of libraries, the trees of files that many inputs name (the program keeps the last two; what it makes
    of a tree is made anew), and garbage from before.
    """
    from hknob_cli.specs import source

    importlib.metadata.version = cache(importlib.metadata.version)
    source._composed = lru_cache(TREES)(source._composed.__wrapped__)
    gc.collect()
    gc.freeze()


def _try_all(task: Task, arena: Arena | None, send: Callable[[str, Any], None], now: Any) -> None:
    family = FAMILIES[task.family]
    counts: Counter[tuple[str, str, int | None]] = Counter()
    shrunk: set[str] = set()
    for seed in range(task.start, task.stop):
        now.value = seed
        case = family.make(arena, dice_of(task.family, seed), **task.options)
        tried = family.attempts(case, arena)
        for one in tried:
            counts[case.kind, _said(one.command), one.code] += 1
        counts[case.kind, "inputs", None] += 1
        if tried and tried[-1].breaches:
            failure = Failure(task.family, seed, case, tried[-1])
            if failure.signature not in shrunk:
                shrunk.add(failure.signature)
                failure = smaller(failure, arena)
            send("failure", failure)
        if (seed + 1 - task.start) % REPORT_EVERY == 0 or seed + 1 == task.stop:
            send("counts", counts)
            counts = Counter()
    now.value = task.stop


def _said(command: tuple[str, ...]) -> str:
    """Which of the commands on an input this is."""
    if command[0] in ("check", "decode"):
        return command[0]
    return "dry run" if "--dry-run" in command else "run"


def smaller(failure: Failure, arena: Arena | None) -> Failure:
    """The failure with less of its input, as long as it is the same; a hang, or what is large, as it is."""
    if len(failure.case.data) > LARGE or any(rule == "hang" for rule, _ in failure.attempt.breaches):
        return failure
    family = FAMILIES[failure.family]
    best = failure

    def breaks(data: bytes) -> bool:
        nonlocal best
        case = failure.case._replace(data=data)
        tried = family.attempts(case, arena)
        if not tried or not tried[-1].breaches:
            return False
        found = failure._replace(case=case, attempt=tried[-1])
        if found.signature != failure.signature:
            return False
        best = found
        return True

    minimised(failure.case.data, breaks)
    return best
