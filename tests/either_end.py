"""Workers collect the tests from either end, so that each compiles half of their files where none is compiled yet.

In a fresh clone pytest compiles each file of tests, with its assertions written anew: half a minute. From the same end
two workers compile the same files at the same time. Meeting in the middle, each loads what the other has kept.
"""

import os
from collections.abc import Sequence
from pathlib import Path

TESTS = Path(__file__).parent


def from_either_end(args: Sequence[str], below: Path) -> list[str]:
    """What a worker is to collect, paths below a folder: every other worker takes the tests' folder from its end."""
    number = os.environ.get("PYTEST_XDIST_WORKER", "").removeprefix("gw")
    whole = [below / arg for arg in args] == [TESTS]
    if not whole or not number.isdecimal() or int(number) % 2 == 0:
        return list(args)
    tops = {TESTS / path.relative_to(TESTS).parts[0] for path in TESTS.rglob("test_*.py")}
    return [str(path) for path in sorted(tops, reverse=True)]
