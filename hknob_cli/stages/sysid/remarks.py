"""What an identification remarks: why nothing can be used, and where its estimators disagree."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from hknob_cli.recordings.trial import WRONG_SIGN

Row = Mapping[str, Any]
MOST_SAID = 6
DISAGREE = "estimators disagree"
# Of reasons why nothing comes out, those that count come first; what is said of a trial besides is last.
COUNTS = (
    " left out: ",
    WRONG_SIGN,
    "further pulse",
    "nothing can be identified",
    "nothing is left to identify",
    "not identifiable",
)
FACTOR, ERRORS = 2.0, 3.0  # estimators disagree beyond this factor, and so many standard errors of both
# Of a fourth-order hand these are other quantities.
COMPARED = {
    "inertia": "inertia_kg_m2",
    "damping": "damping_nm_s_per_rad",
    "stiffness": "stiffness_nm_per_rad",
}


def first_reasons(flags: Iterable[Sequence[str]]) -> str:
    """Why no trial can be used: the reasons that count first, each once."""
    every = list(dict.fromkeys(flag for said in flags for flag in said))
    ranked = sorted(every, key=_rank)
    if not ranked:
        return "nothing was recorded"
    more = f"; and {len(ranked) - MOST_SAID} more" if len(ranked) > MOST_SAID else ""
    return "; ".join(ranked[:MOST_SAID]) + more


def _rank(flag: str) -> int:
    return next((place for place, mark in enumerate(COUNTS) if mark in flag), len(COUNTS))


def disagreements(rows: Sequence[Row]) -> list[str]:
    """For each row of a person's condition, where its estimator and the others of the condition differ; empty if not.

    By more than twice, or in sign, and by more than three standard errors of both.
    """
    groups: dict[tuple[Any, ...], list[Row]] = {}
    for row in rows:
        groups.setdefault((row["experiment"], row["subject"], row["grip_target_n"]), []).append(row)
    remarks = {key: "; ".join(_remarks(group)) for key, group in groups.items()}
    return [remarks[row["experiment"], row["subject"], row["grip_target_n"]] for row in rows]


def _remarks(group: Sequence[Row]) -> Iterable[str]:
    for name, column in COMPARED.items():
        told = [row for row in group if row["estimator"] != "fourth_order" and row[column] is not None]
        if len(told) < 2:
            continue
        low, high = min(told, key=lambda row: row[column]), max(told, key=lambda row: row[column])
        few, many = sorted((abs(low[column]), abs(high[column])))
        error = sum((row[f"{column}_std"] or 0.0) ** 2 for row in (low, high)) ** 0.5
        opposite = low[column] < 0.0 < high[column]
        if not (opposite or many > FACTOR * few) or high[column] - low[column] <= ERRORS * error:
            continue
        how = "in sign" if opposite or few == 0.0 else f"by {many / few:.2g} times"
        said = " and ".join(f"{row[column]:.3g} by {row['estimator']}" for row in (low, high))
        yield f"{DISAGREE} on {name} {how}: {said}"
