"""Largest stiffness of a wall by each limit, over its virtual damping: the K-B plane (Colgate & Brown 1994).

Three kinds of line: passive in any hand, with the knob's own damping; stable in one hand; and what an encoder's counts
allow, which is friction over a count. The conditions are those of `passivity`, solved for the stiffness.
"""

from collections.abc import Sequence
from math import isfinite, nan
from typing import NamedTuple

import numpy as np

from hknob_cli.theory.criteria import MOST_DELAY
from hknob_cli.theory.laws import WorkingEdge
from hknob_cli.theory.passivity import passive_stiffness
from hknob_cli.theory.sampled_plant import frequencies, sampled_plant, stable_gains


class Lines(NamedTuple):
    """Largest stiffness, N·m/rad, at each virtual damping; not a number where a limit has no word.

    Attributes:
        colgate_schenkel: Passive in any hand, without counts.
        abbott_okamura: The same with counts; it knows no virtual damping.
        gil_hulin: Stable in this hand, for light damping.
        exact: Stable in this hand: the roots of the sampled loop of a wall that also pulls are inside the unit circle.
        niemeyer: No oscillation over one count.
    """

    colgate_schenkel: list[float]
    abbott_okamura: list[float]
    gil_hulin: list[float]
    exact: list[float]
    niemeyer: list[float]


def stiffness_limits(edge: WorkingEdge, damping: Sequence[float]) -> Lines:
    """The lines over virtual damping B, N·m·s/rad; the wall's own stiffness and damping in ``edge`` do not count."""
    step = edge.coulomb_torque / edge.quantum_rad
    passive = [passive_stiffness(edge, edge.knob_damping, virtual=abs(virtual)) for virtual in damping]
    return Lines(
        colgate_schenkel=passive,
        abbott_okamura=[min(passive_stiffness(edge, edge.knob_damping, virtual=0.0), 2.0 * step)] * len(damping),
        gil_hulin=[max(0.0, (edge.damping + virtual) / edge.delay_s) for virtual in damping],
        exact=_exact(edge, damping),
        niemeyer=[step] * len(damping),
    )


def _exact(edge: WorkingEdge, damping: Sequence[float]) -> list[float]:
    """Of a wall whose torque is K x_k + B (x_k - x_k-1) / T, pulling and pushing, on knob and hand; 0 where none is."""
    plant = sampled_plant(
        inertia=edge.inertia,
        damping=edge.damping,
        stiffness=edge.hand_stiffness,
        period_s=edge.period_s,
        transport_s=edge.transport_s,
    )
    if plant.delay > MOST_DELAY:
        return [nan] * len(damping)
    grid = frequencies(plant)
    # Times z, because of the difference: (z - 1) / (T z).
    changed = np.polymul(plant.over, [1.0, 0.0]) / edge.period_s
    whole, over = (np.polymul(one, [1.0, 1.0]) for one in (plant.whole, plant.over))
    found = []
    for virtual in damping:
        with np.errstate(all="ignore"):
            gains = stable_gains(np.polyadd(whole, virtual * changed), over, grid, around=0.0)
        found.append(gains[1] if gains and isfinite(gains[1]) else 0.0 if gains is None else nan)
    return found
