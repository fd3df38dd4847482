"""Whether a wall is passive, the first that closed laws say: a sentence or two, with the bounds that it breaks.

Passivity is of the device: it must hold for every hand. Stability is of one hand, or of none.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from hknob_cli.report.table import short

Row = Mapping[str, Any]
LIMITS = {
    "colgate_schenkel": "Colgate & Schenkel",
    "abbott_okamura": "Abbott & Okamura",
    "gil_hulin": "Gil & Hulin",
    "niemeyer": "Niemeyer",
}
# The conditions of passivity: what each asks for, and what is said where there is nothing of it.
_ASKED = {
    "colgate_schenkel": ("the knob's own damping", "damping, and the knob has none of its own"),
    "abbott_okamura": (
        "the knob's own damping or friction",
        "damping and friction, and the knob lacks one or both of its own",
    ),
}


def passive_verdict(rows: Sequence[Row]) -> str:
    """Of rows of ``passivity.parquet``: passive in any hand or not, the bounds broken, and by how much; then stable."""
    return _of_one(rows[0]) if len(rows) == 1 else _of_many(rows)


def _of_one(row: Row) -> str:
    stable = f"{_where(row)} it is {'' if row['gil_hulin'] else 'not '}stable by {LIMITS['gil_hulin']}."
    if row["device_passive"]:
        return f"The wall is passive, whoever holds the knob. {stable}"
    broken = "; ".join(f"{LIMITS[name]} ask for {_load(row, name)}" for name in _ASKED if not row[name])
    return f"The wall is not passive at this rate and these counts: {broken}. {stable}"


def _load(row: Row, name: str) -> str:
    """What a bound asks for, over what there is."""
    what, none = _ASKED[name]
    load = row[f"{name}_load"]
    return none if load is None else f"{short(load, 3)} times {what}"


def _of_many(rows: Sequence[Row]) -> str:
    count, passive = len(rows), sum(row["device_passive"] for row in rows)
    stable = sum(row["gil_hulin"] for row in rows)
    last = f"{_where(rows[0])} it is stable in {_part(stable, count)} by {LIMITS['gil_hulin']}."
    if passive == count:
        return f"The wall is passive in {_part(passive, count)}, whoever holds the knob. {last}"
    broken = {name: sum(not row[name] for row in rows) for name in _ASKED}
    said = ", and ".join(f"{LIMITS[name]}'s bound in {_part(some, count)}" for name, some in broken.items() if some)
    return f"The wall is passive in {_part(passive, count)}, whoever holds the knob. It breaks {said}. {last}"


def _part(some: int, count: int) -> str:
    how_many = "none of " if not some else "all " if some == count else f"{some:,} of "
    return f"{how_many}{count:,} cells"


def _where(row: Row) -> str:
    return "In this hand" if "binding_limb_with_hand" in row else "Without a hand"
