"""Changes that may survive, each with its reason: read from `accepted.toml`."""

import tomllib
from collections import Counter
from pathlib import Path

from tests.mutation.mutate import Mutant
from tests.mutation.table import name_of

KINDS = ("equivalent", "conservative", "effort")
# equivalent: does the same for every input that there is. conservative: proves less or the same, and never more; how
# much less is bounded by a test. effort: decides how long a proof is looked for, not whether it holds.


class Accepted:
    """The entries of one file; counted as they are met."""

    def __init__(self, path: Path, function: str | None = None) -> None:
        name = name_of(path)
        entries = tomllib.loads(Path(__file__).with_name("accepted.toml").read_text()).get(name, [])
        self.entries = [one for one in entries if function in (None, one["function"])]
        assert all(one["kind"] in KINDS and one["reason"] for one in self.entries)
        self.met: Counter[tuple[int, str]] = Counter()
        self.counts: Counter[str] = Counter()
        self.killed: list[str] = []

    def _of(self, mutant: Mutant) -> tuple[int, dict[str, str]] | None:
        for number, one in enumerate(self.entries):
            here = one["function"] == mutant.name and one.get("line", mutant.text) == mutant.text
            if here and mutant.change in one["changes"]:
                return number, one
        return None

    def take(self, mutant: Mutant) -> str | None:
        """The reason why a mutant may survive; None if none is listed."""
        found = self._of(mutant)
        if found is None:
            return None
        number, one = found
        self.met[number, mutant.change] += 1
        self.counts[one["kind"]] += 1
        return one["reason"]

    def note_killed(self, mutant: Mutant) -> None:
        """Remember a listed mutant that a test finds all the same."""
        found = self._of(mutant)
        if found is not None:
            self.killed.append(f"{mutant.name}: {mutant.change} is killed")

    def stale(self) -> list[str]:
        """Entries that no surviving mutant has met."""
        return [
            f"{one['function']}: {change}"
            for number, one in enumerate(self.entries)
            for change in one["changes"]
            if not self.met[number, change]
        ]
