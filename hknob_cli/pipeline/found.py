"""What a stage of a pipeline has found, in a sentence or two, for the line that says that it is done."""

import contextlib
import re
import time
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING

from hknob_cli.errors import HknobError

if TYPE_CHECKING:
    from hknob_cli.results.result_set import Result

_MOST = 2  # sentences
_BETWEEN = re.compile(r"(?<=\.) (?=[A-Z])")


def done(stage: str, folder: Path, begin: float) -> str:
    """That a stage was computed, in how long since ``begin`` (s of `time.perf_counter`), and what it has found."""
    took = f"computed in {time.perf_counter() - begin:.2g} s"
    found = found_in(stage, folder)
    return f"{took}. {found}" if found else took


def found_in(stage: str, folder: Path) -> str:
    """The answer of the results in a folder, or its first sentences; empty if there is none.

    Results that cannot be read have none: they are written, and whoever needs them says what is wrong.
    """
    from hknob_cli.page.answers import checked
    from hknob_cli.results.result_set import Result

    result = Result(stage, folder)
    with contextlib.suppress(HknobError):
        if not result.files:
            return ""
        if result.stage == "report":
            return _judged(result)
        answers = checked(result)
        if result.stage == "dfa":
            answers = answers[-1:]  # the exact method, where it was asked for
        return " ".join(_BETWEEN.split(" ".join(answers[:1]))[:_MOST])
    return ""


def _judged(result: "Result") -> str:
    """How many claims of a text have which verdict."""
    from hknob_cli.page.claims.verdict import VERDICTS

    counts = Counter(row["verdict"] for row in result.rows("claims"))
    said = ", ".join(f"{counts[verdict]} {verdict}" for verdict in VERDICTS if counts[verdict])
    return f"Of {sum(counts.values())} claims: {said}."
