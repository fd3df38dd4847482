"""Kinds of input that are fuzzed: how one is made of a seed, how it is tried, and how it is written down."""

from collections.abc import Callable, Sequence
from pathlib import Path
from random import Random
from typing import Any, NamedTuple

from tests.fuzz import frame_attempt, spec_attempt, table_attempt
from tests.fuzz.attempt import Attempt
from tests.fuzz.frame_case import frame_case
from tests.fuzz.spec_case import spec_case


class Family(NamedTuple):
    """``make`` an input in an arena with dice, ``attempts`` of it there, and the ``file`` that it is saved as.

    An input has a ``kind`` and its ``data``, bytes. ``piece``: how many a process tries before another takes its place.
    Where nothing is on a disk there is no arena.
    """

    make: Callable[..., Any]
    attempts: Callable[[Any, Any], Sequence[Attempt]]
    file: str
    piece: int
    on_disk: bool = True


FAMILIES = {
    "spec": Family(lambda _arena, dice, **how: spec_case(dice, **how), spec_attempt.attempts, "spec.yaml", 5000),
    "frame": Family(lambda _, dice: frame_case(dice), frame_attempt.attempts, "session.txt", 50_000, on_disk=False),
    "table": Family(table_attempt.table_case, table_attempt.attempts, "table.dat", 5000),
}


class Failure(NamedTuple):
    """An input that broke a rule: its seed, what it was, and the command that showed it."""

    family: str
    seed: int
    case: Any
    attempt: Attempt

    @property
    def signature(self) -> str:
        """What failures of one cause have in common, as a name of a folder."""
        rule, detail = self.attempt.breaches[0]
        words = detail.split(": ")[0] if rule == "traceback" else ""
        text = f"{self.family} {rule} {words}"
        return "".join(c if c.isalnum() and c.isascii() else "-" for c in text)[:100].strip("-")

    def save(self, folder: Path) -> Path:
        """Write the input and how to try it again into a folder of its own; that folder."""
        place = folder / self.signature / str(self.seed)
        place.mkdir(parents=True, exist_ok=True)
        (place / FAMILIES[self.family].file).write_bytes(self.case.data)
        said = "\n".join(f"{rule}: {detail}" for rule, detail in self.attempt.breaches)
        again = f"{self.family} {self.case.kind} seed {self.seed}\ncommand: {list(self.attempt.command)!r}\n"
        text = f"{again}exit code: {self.attempt.code}\n{said}\n\n{self.attempt.err}\n"
        (place / "how.txt").write_text(text, encoding="utf-8", errors="backslashreplace")
        return place


def dice_of(family: str, seed: int) -> Random:
    """Chance, the same for a seed on every machine."""
    return Random(f"{family} {seed}")
