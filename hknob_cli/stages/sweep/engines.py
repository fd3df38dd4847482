"""Which groups of the engine's functions are compiled, and when that is worth its time, for all sweeps of a command.

Many short sweeps are as long as one long sweep: what they had interpreted together decides, and what one has compiled
the next ones take. So are many short runs of the command: what they have interpreted is kept beside compiled code.
"""

from collections.abc import Callable, Mapping
from threading import Lock
from typing import Any

from hknob_cli.engine.attractors import PATIENCE, Patience
from hknob_cli.engine.compiling import COMPILING_S, tell, tell_compiling
from hknob_cli.engine.jit import compiled, interpreted_s, is_kept, note_interpreted, waiting

COMPILE_ABOVE = 600_000  # trial-samples; the interpreter does as many in the time that loading compiled code takes
LOADING_S = 0.5  # that time, with some room; where nothing is kept, compiling takes many times as long
HEAVIER = {
    "plain": 1.0,
    "bounces": 1.0,
    "general": 2.5,
    "laws": 40.0,
    "sets": 1.0,
    "general sets": 20.0,
    "friction sets": 50.0,
    "friction arcs": 40.0,
    "unsampled": 1.0,
}  # times that a sample takes the interpreter longer than in the plain loop, with what is done once a trial


def work_of(expected: Mapping[str, float]) -> float:
    """Trial-samples of the plain loop that take as long as those expected of each group."""
    return sum(samples * HEAVIER[group] for group, samples in expected.items())


class Engines:
    """Compiled functions by their group; ``notify``, else whoever was before, is told of waits."""

    def __init__(self, *, notify: Callable[[str], None] | None = None) -> None:
        self.functions: dict[str, dict[str, Callable[..., Any]]] = {}
        self._notify = notify
        self._one_compiles = Lock()  # threads may want a group at the same time
        self._worth: dict[str, float] = {}
        self._interpreted_s: dict[str, float] = {}
        self._kept_s: dict[str, float] = {}  # of these seconds, those that later runs know of

    def compile(self, group: str) -> None:
        """Have the compiled functions of a group."""
        with self._one_compiles:
            if group in self.functions:
                return
            if self._notify:
                tell_compiling(self._notify)
            if text := waiting(group):
                tell(text)
            self.functions = {**self.functions, group: compiled(group)}

    def compile_for(self, expected: Mapping[str, float]) -> None:
        """Compile the groups whose trial-samples take the interpreter longer than that."""
        for group, samples in expected.items():
            if work_of({group: samples}) > COMPILE_ABOVE * self._compiler_s(group) / LOADING_S:
                self.compile(group)

    def note(self, group: str, seconds: float) -> None:
        """A cell of a group took so long, compiled or not."""
        if group not in self.functions:
            self._interpreted_s[group] = self._interpreted_s.get(group, 0.0) + seconds

    def keep(self) -> None:
        """Let later runs know how long this one has interpreted, where it took longer than loading compiled code."""
        for group, seconds in self._interpreted_s.items():
            new = seconds - self._kept_s.get(group, 0.0)
            if new > LOADING_S and group in HEAVIER and not is_kept(group):
                note_interpreted(group, new)
                self._kept_s[group] = seconds

    def is_due(self, group: str) -> bool:
        """Whether the interpreter has taken as long with a group as compiling does."""
        return group in HEAVIER and group not in self.functions and self.patience(group).seconds == 0.0

    def patience(self, group: str) -> Patience:
        """How much the interpreter tries: until it has taken as long as compiling would, so at most twice what is best.

        What it finds is the same to the last bit, so that no result depends on the clock.
        """
        worth = self._compiler_s(group)
        return Patience(
            samples=int(PATIENCE * worth / LOADING_S), seconds=max(0.0, worth - self._interpreted_s.get(group, 0.0))
        )

    def _compiler_s(self, group: str) -> float:
        """Seconds that it takes to have compiled code of a group: to load it, or to make it, less those interpreted."""
        if group not in self._worth:
            left = 0.0 if is_kept(group) else COMPILING_S[group] - interpreted_s(group)
            self._worth[group] = max(LOADING_S, left)
        return self._worth[group]
