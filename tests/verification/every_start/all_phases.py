"""Every clock phase of one start, proven with outward rounding to end in orbits that are proven, too.

Where `everywhere.py` cuts polygons, intervals of phases are halved (`halve.py`): simpler, and at the end undecided by
no more than what is left around each cut.
"""

from dataclasses import dataclass, field

import numpy as np

from tests.verification.every_start.cell import Cell, NotProven, floats, iv
from tests.verification.every_start.everywhere import Proof, slowest
from tests.verification.every_start.follow import ALL
from tests.verification.every_start.halve import LARGEST, halve

LEAST = 2.0**-40  # width of an interval that is not halved again


@dataclass
class Phases(Proof):
    """What is proven of one start: the share of phases of each orbit at least, and the phases that are undecided."""

    shares: list[float] = field(default_factory=list)
    undecided: float = 0.0
    pieces: int = 0


def prove_phases(cell: Cell, angle: float, velocity: float) -> Phases:
    """Every phase at which the first sample can meet a knob that starts at ``angle`` [rad] and ``velocity`` [rad/s].

    Raises:
        NotProven: Something in the argument does not hold within the roundings.
    """
    proof = Phases(cell)
    x, v = iv.mpf(repr(angle)) / cell.quantum, iv.mpf(repr(velocity)) * cell.period / cell.quantum
    start = np.array([floats(x), floats(v)])
    rate = np.array([floats(v), floats(-cell.alpha * v - cell.beta * x - cell.gamma)])  # the wall does not act yet
    flow = np.array([floats(-cell.beta), floats(-cell.alpha)])
    if not np.abs(flow).max(axis=1).sum() < LARGEST:
        raise NotProven("the series of the free motion is too short")
    samples = 200 + int(60.0 * slowest(cell))
    stack, count = np.zeros((200, 2)), 1
    stack[0] = 0.0, 1.0
    powers, drives, shrinking = cell.powers(1), cell.drives(), cell.shrinking(samples)
    while True:
        shares = np.zeros(len(proof.orbits) + 1)
        why, count, pieces, undecided, at_x, at_v = halve(
            stack, count, start, rate, flow, powers, drives, shrinking, cell.inverse_beta, proof.table(), shares, LEAST
        )
        proof.shares = [one + float(more) for one, more in zip(proof.shares, shares, strict=False)]
        proof.pieces += pieces
        proof.undecided += undecided
        if why == ALL:
            proof.complete = True
            return proof
        if not proof.learn(at_x, at_v):
            raise NotProven(f"phases {stack[count - 1]} stay near the edge of a margin")
        proof.shares.append(0.0)
