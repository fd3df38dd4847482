"""A trial of the general loop as its functions want it, made by hand."""

from typing import Any

from hknob_cli.engine.general.ensemble import TrialSpace
from hknob_cli.engine.general.period_map import Space


def trial_of(
    z: list[float],
    ring: list[float],
    space: Space,
    rows: list[list[float]] | None = None,
    states: list[Any] | None = None,
    lines: list[Any] | None = None,
) -> TrialSpace:
    """A trial, and the orbits that are known: what it keeps of itself is not meant to matter."""
    kept, n = rows or [], len(z)
    return TrialSpace(
        z=z,
        ring=ring,
        check=[7.0] * n,
        check_ring=[7.0] * len(ring),
        keep=[7.0] * n,
        keep_ring=[7.0] * len(ring),
        counts=[float(len(kept))],
        table=[x for one_row in kept for x in one_row],
        states=[x for state in states or [] for x in state],
        lines=[x for line in lines or [] for x in line],
        space=space,
    )
