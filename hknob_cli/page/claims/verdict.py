"""From computed values to a verdict, by the rule that `Claim` states. No verdict is ever written down elsewhere."""

import pickle
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import pyarrow as pa

from hknob_cli.errors import UsageError
from hknob_cli.page.claims.checks import compute, known
from hknob_cli.page.claims.ledger import Claim, Ledger, Reading
from hknob_cli.results.arrays import build_table
from hknob_cli.results.columns import Column
from hknob_cli.results.result_set import MissingError, ResultSet
from hknob_cli.spread.forks import by_processes

REPRODUCED, DIFFERS, CONTRADICTED, NOT_TESTABLE = VERDICTS = (
    "reproduced",
    "differs",
    "contradicted",
    "not testable",
)

MANY = 40  # claims, which one process does not judge before others have begun

_REAL, _TEXT, _FLAG = pa.float64(), pa.string(), pa.bool_()
# Of a reading: its name, computed value, verdict, why it has no value, and why the print does not allow it.
READING = pa.struct(
    [("name", _TEXT), ("computed", _REAL), ("verdict", _TEXT), ("missing", _TEXT), ("excluded", _TEXT)],
)
COLUMNS = (
    Column("claim", _TEXT, "", "id of the claim"),
    Column("place", _TEXT, "", "section, table, figure or equation of the text"),
    Column("says", _TEXT, "", "what the text says"),
    Column("printed", _REAL, "", "printed value, in the column unit; null for a statement"),
    Column("computed", _REAL, "", "computed value in the reading used, in the column unit; null where there is none"),
    Column("unit", _TEXT, "", "unit of printed and computed"),
    Column("reading", _TEXT, "", "reading used: of those the print allows, the one that agrees best"),
    Column("verdict", _TEXT, "", "reproduced, differs, contradicted or not testable"),
    Column("tolerance", _TEXT, "", "when the claim counts as reproduced, and when it only differs"),
    Column("because", _TEXT, "", "why this tolerance; why it is not testable, where it is not"),
    Column("agreeing", pa.int64(), "1", "readings that the print allows and in which the claim is reproduced"),
    Column("allowed", pa.int64(), "1", "readings that the print allows"),
    Column("data", _TEXT, "", "results that the reading used was computed from"),
    Column(
        "readings",
        pa.list_(READING),
        "",
        "every reading tried: name, computed value (null if none), verdict, why it is missing, why the print excludes "
        "it (null if it does not). Empty if the claim has one reading only",
    ),
    Column("finding", _TEXT, "", "what is known beside the number"),
    Column("check", _TEXT, "", "computation that checks it"),
    Column("figure", _TEXT, "", "id of the figure that shows it"),
)


class Judged(NamedTuple):
    """One reading, its computed value, and what follows from it."""

    reading: Reading
    computed: float | None
    verdict: str
    missing: str = ""


@dataclass(frozen=True)
class Judge:
    """What judges some of the claims of a ledger, in whatever process."""

    claims: Sequence[Claim]
    evidence: ResultSet

    def __call__(self, start: int, stop: int) -> bytes:
        """Claims ``start`` to ``stop``, pickled. Raises `UsageError` for arguments that a check does not take."""
        return pickle.dumps([judge_claim(claim, self.evidence) for claim in self.claims[start:stop]])


def judge(ledger: Ledger, evidence: ResultSet, *, jobs: int = 1) -> pa.Table:
    """Every claim of a ledger with its verdict, as a table, by ``jobs`` processes.

    Raises `UsageError` for arguments that a check does not take.
    """
    claims = ledger.claims
    known()  # loaded before processes begin
    rows = by_processes(
        Judge(claims, evidence), len(claims), jobs=jobs if len(claims) >= MANY else 1, first=4, most=16,
        name=lambda one: f"claim {claims[one.start].id}",
    )  # fmt: skip
    return build_table(COLUMNS, rows)


def judge_claim(claim: Claim, evidence: ResultSet) -> dict[str, Any]:
    """One row of the table. Raises `UsageError` for arguments that its check does not take."""
    readings = [_read(claim, reading, evidence) for reading in claim.all_readings] if claim.check else []
    allowed = [judged for judged in readings if judged.reading.excluded is None]
    best = min(allowed, key=lambda judged: _rank(claim, judged), default=None)
    missing = best.missing if best else ""
    return {
        "claim": claim.id,
        "place": claim.place,
        "says": claim.says,
        "printed": claim.printed,
        "computed": best.computed if best else None,
        "unit": claim.unit,
        "reading": best.reading.name if best and not missing else "",
        "verdict": best.verdict if best else NOT_TESTABLE,
        "tolerance": _tolerance(claim),
        "because": claim.untestable or missing or claim.because or "",
        "agreeing": sum(judged.verdict == REPRODUCED for judged in allowed),
        "allowed": len(allowed),
        "data": ", ".join(_data(claim, best, evidence)) if best else "",
        "readings": [_told(judged) for judged in readings] if claim.readings else [],
        "finding": claim.finding or "",
        "check": claim.check or "",
        "figure": claim.figure or "",
    }


def _told(judged: Judged) -> dict[str, Any]:
    """A reading as `READING` has it."""
    reading, computed, verdict, missing = judged
    given = {"name": reading.name, "excluded": reading.excluded}
    return given | {"computed": computed, "verdict": verdict, "missing": missing}


def _read(claim: Claim, reading: Reading, evidence: ResultSet) -> Judged:
    assert claim.check is not None
    assert claim.holds is not None
    try:
        computed = compute(claim.check, evidence, {**claim.arguments, **reading.arguments})
    except MissingError as error:
        return Judged(reading, None, NOT_TESTABLE, str(error))
    except UsageError as error:
        raise UsageError(f"claim {claim.id}: {error}") from error
    if computed is None:
        return Judged(reading, None, NOT_TESTABLE, "the computation has no value here")
    if claim.holds.hold(computed, claim.printed):
        return Judged(reading, computed, REPRODUCED)
    near = claim.near is not None and claim.near.hold(computed, claim.printed)
    return Judged(reading, computed, DIFFERS if near else CONTRADICTED)


def _data(claim: Claim, judged: Judged, evidence: ResultSet) -> list[str]:
    """Names of the results that a reading is computed from."""
    arguments = {**claim.arguments, **judged.reading.arguments}
    given = (str(arguments.get(key)) for key in ("result", "to", "against"))
    return list(dict.fromkeys(name for name in given if name in evidence))


def _rank(claim: Claim, judged: Judged) -> tuple[int, float]:
    """The best verdict first; of equal ones the nearest to the printed value, else the first."""
    near = 0.0 if judged.computed is None or claim.printed is None else abs(judged.computed - claim.printed)
    return VERDICTS.index(judged.verdict), near


def _tolerance(claim: Claim) -> str:
    words = {
        "within": "within {:g}",
        "within_percent": "within {:g} %",
        "at_least": "at least {:g}",
        "at_most": "at most {:g}",
    }
    parts = []
    for title, bounds in (("holds", claim.holds), ("differs", claim.near)):
        if bounds:
            given = [text.format(value) for key, text in words.items() if (value := getattr(bounds, key)) is not None]
            parts.append(f"{title}: {', '.join(given)}")
    return "; ".join(parts)


def reading_text(reading: Mapping[str, Any], unit: str, *, minus: str = "-") -> str:
    """A reading in words: its value, what follows from it, and why it does not count where it does not.

    ``reading``: an entry of the column ``readings``; ``unit``: of its value.
    """
    computed = reading["computed"]
    value = reading["missing"]
    if computed is not None:
        value = f"{minus if computed < 0.0 else ''}{abs(computed):.4g} {unit}".strip()
    excluded = f" (not allowed: {reading['excluded']})" if reading["excluded"] else ""
    return f"{reading['name']}: {value}, {reading['verdict']}{excluded}"
