"""Of many like long tests, those that a word draws: `make long` draws by the commit, `make long ALL=1` runs all.

Cases are counted in the order of their files. Of those with ``drawn(n, k)`` each stretch of n has k that run; which
ones depends on the word alone, so that every process draws the same, and every case has its turn. A series that a test
makes itself is shorter where its fixture ``drawn`` says so.
"""

import hashlib
from collections import Counter
from collections.abc import Sequence
from typing import Any

import pytest

REST = 7  # one in so many of the cases that `one_in` leaves to the long ones


def turns(by: str, n: int) -> int:
    """How far a word moves what is drawn: 0 to n - 1."""
    return int.from_bytes(hashlib.sha256(by.encode()).digest()[:8]) % n


def first_of_each(cases: Sequence[tuple[Any, ...]]) -> list[Any]:
    """Cases as parameters, of which the first with each name is not long; the name comes first."""
    names = [case[0] for case in cases]
    return [
        pytest.param(*case, marks=[pytest.mark.long] if case[0] in names[:i] else []) for i, case in enumerate(cases)
    ]


class Draw:
    """A plugin of pytest that leaves out the long tests that ``by`` does not draw, and says how many."""

    def __init__(self, by: str) -> None:
        self.by = by
        self.here: tuple[int, int] | None = None  # drawn, of how many; None before this process has collected any

    def choose(self, items: Sequence[pytest.Item]) -> tuple[list[pytest.Item], list[pytest.Item]]:
        """Those to run, and those left out; each in order."""
        before: Counter[tuple[int, int]] = Counter()
        run, out = [], []
        for item in items:
            mark = item.get_closest_marker("drawn") if item.get_closest_marker("long") else None
            if mark is None:
                run.append(item)
                continue
            n, k = (*mark.args, 1)[:2]
            place = (before[n, k] + turns(self.by, n)) % n
            before[n, k] += 1
            (run if place < k else out).append(item)
        total = before.total()
        self.here = (total - len(out), total)
        return run, out

    def pytest_collection_modifyitems(self, config: pytest.Config, items: list[pytest.Item]) -> None:
        """Leave out what is not drawn, after `tests.conftest` has marked the cases."""
        items[:], out = self.choose(items)
        if out:
            config.hook.pytest_deselected(items=out)

    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """A worker tells what it has drawn."""
        if self.here and hasattr(session.config, "workeroutput"):
            session.config.workeroutput["drawn"] = self.here

    @pytest.hookimpl(optionalhook=True)
    def pytest_testnodedown(self, node: Any, error: object) -> None:
        """What a worker has drawn: all draw the same."""
        self.here = tuple(getattr(node, "workeroutput", {}).get("drawn", ())) or self.here

    def pytest_terminal_summary(self, terminalreporter: Any) -> None:
        """How many, and how to run all."""
        if self.here:
            some, of = self.here
            terminalreporter.write_line(
                f"drawn by {self.by}: {some} of {of} long cases that have many like them, and fewer kills and crashes; "
                "make long ALL=1 runs all, make long DRAW=WORD others"
            )
