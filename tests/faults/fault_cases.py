"""Commands of which a call fails in `failures.py`: what each is run on, and what was done before."""

import re
from pathlib import Path
from typing import NamedTuple

from tests.conftest import SPEC
from tests.faults.crash_cases import LAWS, PAGE, PIPELINE, REMEDIES, SIX, TRIALS

CORPUS = Path(__file__).parents[1] / "fuzz" / "corpus"
TWO = SPEC.replace("phases: 8", "phases: 2")
LOCK = r"(^|/)\.hknob\.lock$"
PYTASK = r"(^|/)(\.pytask.*|pytask\.lock.*)$"
BENCH = r"\.parquet$"  # has run times in it
SYSID = (CORPUS / "sysid_everything.yaml").read_text()
TWO_HANDS = SYSID.replace("subjects: 1", "subjects: 2")
RECORDED = (CORPUS / "sysid_recordings.yaml").read_text().replace("recordings.csv, ", "hands/")
DFA = (CORPUS / "dfa_against.yaml").read_text()


class FaultCase(NamedTuple):
    """``words`` are run in a folder that has ``files``, after each of ``before``.

    ``apart``: files that need not have the same bytes after every run. ``parts``: with pieces and parts so small that a
    small sweep has many. ``reads``: whether it only reads, so that nothing may have changed. ``once``: whether what is
    done is refused the second time.
    """

    name: str
    files: dict[str, str]
    words: tuple[str, ...]
    before: tuple[tuple[str, ...], ...] = ()
    apart: str = LOCK
    parts: bool = False
    reads: bool = False
    once: bool = False

    @property
    def differs(self) -> re.Pattern[str]:
        """Paths that are not compared."""
        return re.compile(self.apart)


def _of(name: str) -> str:
    return (CORPUS / f"{name}.yaml").read_text()


GRID = ("sweep", "spec.yaml", "-o", "grid", "-q")
HANDS = ("sysid", "hands.yaml", "-o", "hands", "-q")
CASES = {
    case.name: case
    for case in (
        FaultCase("sweep", {"spec.yaml": TWO}, ("sweep", "spec.yaml", "-o", "out")),
        FaultCase("drawn", {"spec.yaml": TWO}, ("sweep", "spec.yaml", "-o", "out", "--plot")),
        FaultCase("spread", {"spec.yaml": SIX}, ("sweep", "spec.yaml", "-o", "out", "-j", "2"), parts=True),
        FaultCase(
            "replaced",
            {"spec.yaml": SIX, "other.yaml": SIX.replace("phases: 2", "phases: 3")},
            ("sweep", "spec.yaml", "-o", "out", "-j", "1"),
            (("sweep", "other.yaml", "-o", "out", "-j", "1", "-q"),),
            parts=True,
        ),
        FaultCase("up-to-date", {"spec.yaml": TWO}, ("sweep", "spec.yaml", "-o", "grid"), (GRID,)),
        FaultCase("dfa", {"spec.yaml": TWO, "dfa.yaml": DFA}, ("dfa", "dfa.yaml", "-o", "out"), (GRID,)),
        FaultCase(
            "predict",
            {"spec.yaml": TWO, "case.yaml": _of("case_small"), "predict.yaml": _of("predict_case")},
            ("predict", "predict.yaml", "-o", "out"),
            (GRID,),
        ),
        FaultCase("remedies", {"spec.yaml": REMEDIES}, ("remedies", "spec.yaml", "-o", "out", "-j", "2")),
        FaultCase("design", {"spec.yaml": _of("design_small")}, ("design", "spec.yaml", "-o", "out", "-j", "2")),
        FaultCase("hw-run", {"spec.yaml": TRIALS}, ("hw-run", "spec.yaml", "-o", "out")),
        FaultCase("tried", {"spec.yaml": _of("hw_run_remedies")}, ("hw-run", "spec.yaml", "-o", "out")),
        FaultCase("sysid", {"spec.yaml": SYSID}, ("sysid", "spec.yaml", "-o", "out")),
        FaultCase(
            "recorded",
            {"hands.yaml": SYSID, "spec.yaml": RECORDED},
            ("sysid", "spec.yaml", "-o", "out"),
            (HANDS,),
        ),
        FaultCase(
            "people",
            {"hands.yaml": TWO_HANDS, "spec.yaml": _of("sweep_people")},
            ("sweep", "spec.yaml", "-o", "out"),
            (HANDS,),
        ),
        FaultCase("report", {"spec.yaml": TWO, "page.yaml": PAGE}, ("report", "page.yaml", "-o", "out"), (GRID,)),
        FaultCase(
            "run",
            {"spec.yaml": TWO, "laws.yaml": LAWS, "page.yaml": PAGE, "run.yaml": PIPELINE},
            ("run", "run.yaml", "-o", "out"),
            apart=f"{LOCK}|{PYTASK}",
        ),
        FaultCase(
            "bench", {"spec.yaml": _of("bench_tiny")}, ("bench", "spec.yaml", "-o", "out"), apart=f"{LOCK}|{BENCH}"
        ),
        FaultCase("explore", {"spec.yaml": TWO}, ("explore", "spec.yaml", "--out", "page.html", "--no-open")),
        FaultCase("new", {}, ("new", "sweep", "--out", "spec.yaml"), once=True),
        FaultCase(
            "new-from", {"spec.yaml": TWO}, ("new", "remedies", "--from", "spec.yaml", "--out", "next.yaml"), once=True
        ),
        FaultCase("check", {"spec.yaml": TWO}, ("check", "spec.yaml"), reads=True),
        FaultCase("explain", {"spec.yaml": TWO}, ("explain", "spec.yaml"), reads=True),
        FaultCase(
            "dry-run", {"spec.yaml": TWO}, ("sweep", "spec.yaml", "-o", "grid", "--dry-run"), (GRID,), reads=True
        ),
        FaultCase("verify", {"spec.yaml": TWO}, ("verify", "grid"), (GRID,), reads=True),
    )
}  # fmt: skip
