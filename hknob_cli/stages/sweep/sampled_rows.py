"""Some cells of a piece of a sweep, as rows: to compare them with the same cells, computed again by another worker."""

from collections.abc import Iterable, Mapping
from math import isclose
from typing import Any

from hknob_cli.stages.sweep.assembly import decode

# Of numbers from processors whose C libraries round `exp` and `sin` differently: what a fault changes is seldom less.
NEAR, NOTHING = 1e-6, 1e-9  # relative; and absolute, in SI units

Rows = list[dict[str, Any]]


def rows_of(data: bytes, place: int, some: Iterable[Mapping[str, Any]]) -> Rows:
    """Rows that a piece has of ``some`` of its cells, the first at ``place``, and of their orbits.

    Cells are given by their axes.
    """
    cells, orbits = decode(data)
    wanted = list(some)
    rows: Rows = cells.slice(place, len(wanted)).to_pylist()
    names = [name for name in wanted[0] if name in orbits.schema.names]
    keys = zip(*(orbits[name].to_pylist() for name in names), strict=True)
    there = {tuple(row[name] for name in names) for row in rows}
    return rows + [orbits.slice(i, 1).to_pylist()[0] for i, key in enumerate(keys) if key in there]


def same(one: Rows, other: Rows) -> bool:
    """Whether all rows are the same to the last bit, as workers of one machine find them."""
    return repr(one) == repr(other)


def nearly_same(one: Rows, other: Rows) -> bool:
    """Whether they are, apart from the last digits of real numbers, as workers of several machines find them."""
    return len(one) == len(other) and all(
        a.keys() == b.keys() and all(_near(a[name], b[name]) for name in a) for a, b in zip(one, other, strict=True)
    )


def _near(one: Any, other: Any) -> bool:
    if isinstance(one, float) and isinstance(other, float):
        return isclose(one, other, rel_tol=NEAR, abs_tol=NOTHING) or (one != one and other != other)
    return bool(one == other)
