"""Stability limits of a virtual wall, the one that binds, and what would satisfy each.

A limit holds where its load, what is asked over what there is, stays below 1. Sources, as in Hasser, sec. 6.2 and 9.5:

- Colgate & Schenkel (1994): b > K T / 2 + |B|.
- Abbott & Okamura (2005): K <= min(2 b / T, 2 T_c / q).
- Gil et al. (2004), Hulin et al. (2006): K < (b + B) / (T / 2 + t_d), for light damping and a delay t_d.
- Niemeyer (2001): q <= T_c / K.

b: damping of knob and hand; B: virtual damping; T_c: Coulomb friction; q: one count; T: sample period; K: stiffness of
the wall.
"""

from collections.abc import Iterable
from math import ceil, inf, isfinite, pi
from typing import NamedTuple

from hknob_cli.theory.working_edge import WorkingEdge

MOST_COUNTS = 2.0**53  # more is no finite need
_ROUNDED = 1.0 - 1e-12  # whole numbers that rounding exceeds are themselves


class Limit(NamedTuple):
    """One stability limit in one cell; SI units.

    Attributes:
        holds: Whether it is satisfied.
        load: What is asked over what there is; infinite where there is nothing.
        rate_hz: Sample rate at which it would hold, all else the same; None if it does not depend on the rate, infinite
            if none does.
        damping: Damping of knob and hand at which it would hold, N·m·s/rad; None if it does not depend on it.
        counts: Counts per revolution at which it would hold; None and infinite as for the rate.
        friction: Coulomb friction at which it would hold, N·m; None if it does not depend on it.
    """

    holds: bool
    load: float
    rate_hz: float | None = None
    damping: float | None = None
    counts: float | None = None
    friction: float | None = None


class Verdict(NamedTuple):
    """All limits in one cell, by name, and what would satisfy all that depend on it; None: nothing finite does.

    Attributes:
        limits: By name.
        binding: Name of the limit with the largest load.
        rate_hz: Least sample rate, Hz.
        damping: Least damping of knob and hand, N·m·s/rad.
        counts: Fewest counts per revolution.
        friction: Least Coulomb friction, N·m.
    """

    limits: dict[str, Limit]
    binding: str
    rate_hz: float | None
    damping: float | None
    counts: int | None
    friction: float | None


def colgate_schenkel(edge: WorkingEdge) -> Limit:
    """Passivity of a sampled wall."""
    virtual = abs(edge.wall_damping)
    needed = 0.5 * edge.wall_stiffness * edge.period_s + virtual
    return Limit(
        holds=edge.damping > needed,
        load=_over(needed, edge.damping),
        rate_hz=0.5 * _over(edge.wall_stiffness, edge.damping - virtual),
        damping=needed,
    )


def abbott_okamura(edge: WorkingEdge) -> Limit:
    """Passivity of a sampled and quantised wall: a limit on the rate and a limit on the counts."""
    damping = 0.5 * edge.wall_stiffness * edge.period_s
    friction = 0.5 * edge.wall_stiffness * edge.quantum_rad
    return Limit(
        holds=edge.damping >= damping and edge.coulomb_torque >= friction,
        load=max(_over(damping, edge.damping), _over(friction, edge.coulomb_torque)),
        rate_hz=0.5 * _over(edge.wall_stiffness, edge.damping),
        damping=damping,
        counts=pi * _over(edge.wall_stiffness, edge.coulomb_torque),
        friction=friction,
    )


def gil_hulin(edge: WorkingEdge) -> Limit:
    """Stability of a wall with a transport delay."""
    there = edge.damping + edge.wall_damping
    needed = edge.wall_stiffness * edge.delay_s
    return Limit(
        holds=there > needed,
        load=_over(needed, there),
        rate_hz=_over(needed, there) / edge.period_s,
        damping=max(0.0, needed - edge.wall_damping),
    )


def niemeyer(edge: WorkingEdge) -> Limit:
    """A torque step that friction withstands."""
    needed = edge.wall_stiffness * edge.quantum_rad
    return Limit(
        holds=edge.coulomb_torque >= needed,
        load=_over(needed, edge.coulomb_torque),
        counts=2.0 * pi * _over(edge.wall_stiffness, edge.coulomb_torque),
        friction=needed,
    )


# The more demanding first, which decides where several are infinitely far from holding.
LIMITS = {
    "niemeyer": niemeyer,
    "colgate_schenkel": colgate_schenkel,
    "gil_hulin": gil_hulin,
    "abbott_okamura": abbott_okamura,
}


def verdict(edge: WorkingEdge) -> Verdict:
    """All limits in one cell."""
    limits = {name: limit(edge) for name, limit in LIMITS.items()}
    counts = _most(limit.counts for limit in limits.values())
    return Verdict(
        limits=limits,
        binding=max(limits, key=lambda name: limits[name].load),
        rate_hz=_most(limit.rate_hz for limit in limits.values()),
        damping=_most(limit.damping for limit in limits.values()),
        counts=None if counts is None or counts > MOST_COUNTS else ceil(counts * _ROUNDED),
        friction=_most(limit.friction for limit in limits.values()),
    )


def _over(asked: float, there: float) -> float:
    """Ratio; 0 where nothing is asked, infinite where something is and there is nothing."""
    if asked <= 0.0:
        return 0.0
    return asked / there if there > 0.0 else inf


def _most(needs: Iterable[float | None]) -> float | None:
    most = max(need for need in needs if need is not None)
    return most if isfinite(most) else None
