"""Whether a virtual wall is passive or stable: which limit binds, and what would satisfy each.

A limit holds where its load, what is asked over what there is, stays below 1. Passivity is a property of the device: it
must hold for every passive hand, so b is the damping of the knob alone. A stability limit is about one hand, so b is
the damping of knob and hand. Sources, as in Hasser, sec. 6.2 and 9.5:

- Colgate & Schenkel (1994), passivity: b > K (T / 2 + t_d) + |B|.
- Abbott & Okamura (2005), passivity: K <= min(b / (T / 2 + t_d), 2 T_c / q).
- Gil et al. (2004), Hulin et al. (2006), stability: K < (b + B) / (T / 2 + t_d), for light damping.
- Niemeyer (2001), no oscillation over one count: q <= T_c / K. No damping enters, so that the hand does not matter.

b: damping; B: virtual damping; T_c: Coulomb friction of the knob; q: one count; T: sample period; t_d: transport delay;
K: stiffness of the wall. The first two are published without the delay: b > K T / 2 + |B| and K <= 2 b / T. How it
enters is in `needed_damping`.

The two conditions of passivity are also evaluated with the damping of knob and hand (`..._with_hand`). They then say
that no passive load on this knob with this hand's damper can make it oscillate: a sufficient condition of stability.
"""

from collections.abc import Iterable
from math import ceil, floor, inf, isfinite, pi, sqrt
from typing import NamedTuple

from hknob_cli.theory.laws import WorkingEdge

MOST_COUNTS = 2.0**53  # more is no finite need
_ROUNDED = 1.0 - 1e-12  # whole numbers that rounding exceeds are themselves


class Limit(NamedTuple):
    """One limit in one cell; SI units.

    Attributes:
        holds: Whether it is satisfied.
        load: What is asked over what there is; infinite where there is nothing.
        rate_hz: Sample rate at which it would hold, all else the same; None if it does not depend on the rate, infinite
            if none does.
        damping: Damping at which it would hold, N·m·s/rad: of the knob, or of knob and hand where the limit counts the
            hand's; None if it does not depend on it.
        counts: Counts per revolution at which it would hold; None and infinite as for the rate.
        friction: Coulomb friction at which it would hold, N·m; None if it does not depend on it.
    """

    holds: bool
    load: float
    rate_hz: float | None = None
    damping: float | None = None
    counts: float | None = None
    friction: float | None = None


class Need(NamedTuple):
    """The limit that binds, and what would satisfy all limits that depend on it; None: nothing finite does.

    Attributes:
        binding: Name of the limit with the largest load.
        rate_hz: Least sample rate, Hz.
        damping: Least damping, N·m·s/rad, of the knob; in `Verdict.with_hand`, of knob and hand.
        counts: Fewest counts per revolution.
        friction: Least Coulomb friction, N·m.
    """

    binding: str
    rate_hz: float | None
    damping: float | None
    counts: int | None
    friction: float | None


class Verdict(NamedTuple):
    """All limits in one cell.

    Attributes:
        limits: By name.
        passive: Whether the knob is passive, whoever holds it: both conditions of passivity hold for its own damping.
        device: What binds, and is needed, with the damping of the knob in the conditions of passivity.
        with_hand: The same with the damping of knob and hand in all limits.
    """

    limits: dict[str, Limit]
    passive: bool
    device: Need
    with_hand: Need


def needed_damping(edge: WorkingEdge, *, virtual: float) -> float:
    """Least damping, N·m·s/rad, of a device whose sampled wall is to be passive; ``virtual`` is |B|.

    With x at the samples a slow oscillation, and within a hold whatever gains most, the energy drawn per turn is, in
    units of K and T and for a transport delay of n + f samples, (1/2 + n + f) + f (1 - f) / (4 b) - b. For f = 0 that
    is the criterion of Colgate & Schenkel. With virtual damping, |B| is added to the first term, and 2 |B| / T to K in
    the second: exact without a delay, an upper bound with one.
    """
    first = edge.wall_stiffness * edge.delay_s + virtual
    within = between_samples(edge) * (edge.wall_stiffness * edge.period_s + 2.0 * virtual) ** 2
    return 0.5 * (first + sqrt(first * first + within))


def passive_stiffness(edge: WorkingEdge, damping: float, *, virtual: float) -> float:
    """Largest stiffness, N·m/rad, at which `needed_damping` is what there is; 0 if it is so at none.

    It is 4 b^2 - 4 b (K D + |B|) = f (1 - f) (K T + 2 |B|)^2, solved for K; D is the mean delay.
    """
    part = between_samples(edge)
    square = part * edge.period_s**2
    linear = 4.0 * (part * edge.period_s * virtual + damping * edge.delay_s)
    left = 4.0 * (damping * damping - damping * virtual - part * virtual * virtual)
    return 2.0 * left / (linear + sqrt(linear * linear + 4.0 * square * left)) if left > 0.0 else 0.0


def _rate(edge: WorkingEdge, damping: float, *, virtual: float) -> float:
    """Sample rate, Hz, at which `needed_damping` is what there is; infinite where it is so at none."""
    part, stiffness = between_samples(edge), edge.wall_stiffness
    left = damping * damping - damping * virtual - part * virtual * virtual
    if left <= 0.0:
        return inf if stiffness > 0.0 or virtual > 0.0 else 0.0
    linear = stiffness * (damping * edge.delay_s / edge.period_s + part * virtual)
    return (linear + sqrt(linear * linear + part * stiffness * stiffness * left)) / (2.0 * left)


def between_samples(edge: WorkingEdge) -> float:
    """The product f (1 - f) of the part f of a sample in the transport delay."""
    samples = edge.transport_s / edge.period_s
    part = samples - floor(samples)
    return part * (1.0 - part)


def colgate_schenkel(edge: WorkingEdge, damping: float) -> Limit:
    """Passivity of a sampled wall, on a device of a damping in N·m·s/rad."""
    virtual = abs(edge.wall_damping)
    needed = needed_damping(edge, virtual=virtual)
    return Limit(
        holds=damping > needed or needed == 0.0,
        load=_over(needed, damping),
        rate_hz=_rate(edge, damping, virtual=virtual),
        damping=needed,
    )


def abbott_okamura(edge: WorkingEdge, damping: float) -> Limit:
    """Passivity of a sampled and quantised wall: a limit on the rate and a limit on the counts."""
    needed = needed_damping(edge, virtual=0.0)
    friction = 0.5 * edge.wall_stiffness * edge.quantum_rad
    return Limit(
        holds=damping >= needed and edge.coulomb_torque >= friction,
        load=max(_over(needed, damping), _over(friction, edge.coulomb_torque)),
        rate_hz=_rate(edge, damping, virtual=0.0),
        damping=needed,
        counts=pi * _over(edge.wall_stiffness, edge.coulomb_torque),
        friction=friction,
    )


def gil_hulin(edge: WorkingEdge) -> Limit:
    """Stability of a wall with a transport delay, in this hand; its damping need is of knob and hand."""
    there = edge.damping + edge.wall_damping
    needed = edge.wall_stiffness * edge.delay_s
    load = inf if there < 0.0 else _over(needed, there)
    return Limit(
        holds=there > needed or needed == there == 0.0,
        load=load,
        rate_hz=load / edge.period_s,
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


# In each row the more demanding first, which decides where several are infinitely far from holding.
PASSIVITY = ("colgate_schenkel", "abbott_okamura")
DEVICE = ("niemeyer", "colgate_schenkel", "gil_hulin", "abbott_okamura")
WITH_HAND = ("niemeyer", "colgate_schenkel_with_hand", "gil_hulin", "abbott_okamura_with_hand")
LIMITS = (*DEVICE, *(name for name in WITH_HAND if name not in DEVICE))


def verdict(edge: WorkingEdge) -> Verdict:
    """All limits in one cell."""
    limits = {
        "colgate_schenkel": colgate_schenkel(edge, edge.knob_damping),
        "abbott_okamura": abbott_okamura(edge, edge.knob_damping),
        "gil_hulin": gil_hulin(edge),
        "niemeyer": niemeyer(edge),
        "colgate_schenkel_with_hand": colgate_schenkel(edge, edge.damping),
        "abbott_okamura_with_hand": abbott_okamura(edge, edge.damping),
    }
    hand = edge.damping - edge.knob_damping
    gil = limits["gil_hulin"]
    # What the knob must add to this hand.
    own = {**limits, "gil_hulin": gil._replace(damping=max(0.0, (gil.damping or 0.0) - hand))}
    return Verdict(
        limits=limits,
        passive=all(limits[name].holds for name in PASSIVITY),
        device=_need({name: own[name] for name in DEVICE}),
        with_hand=_need({name: limits[name] for name in WITH_HAND}),
    )


def _need(limits: dict[str, Limit]) -> Need:
    counts = _most(limit.counts for limit in limits.values())
    return Need(
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
