"""A wall designed in the digital domain: full state feedback that gives the sampled loop the continuous wall's poles.

In the manner of Gillespie & Cutkosky (1996; dissertation, Section 10.4): with the gains l of
det(zI - Phi + Gamma l) = (z - exp(s1 T))(z - exp(s2 T)), s1 and s2 the poles of knob, hand and wall together, the knob in
the wall moves from sample to sample as against a continuous spring. It needs position and velocity, differenced or sensed.
"""

import numpy as np

from hknob_cli.remedies.lanes import Array, Lanes, flow_over
from hknob_cli.remedies.remedy import Action, Plain, Reading


def matched_gains(lanes: Lanes) -> tuple[Array, Array]:
    """Gains on position and velocity, in steps of the wall per count and per count a sample."""
    flow = flow_over(lanes, 1.0)
    s, g, f = flow
    a, b = 1.0 - lanes.beta * g, -lanes.beta * s
    half = 0.5 * lanes.alpha
    square = lanes.beta + lanes.kappa - half * half
    root = np.sqrt(np.abs(square))
    pair = np.where(square >= 0.0, np.cos(root), np.cosh(root))
    trace, product = 2.0 * np.exp(-half) * pair, np.exp(-lanes.alpha)
    # trace: a + f - (g l1 + s l2); determinant: a f - s b - l1 (g f - s s) - l2 (s a - g b)
    m11, m12, m21, m22 = g, s, g * f - s * s, s * a - g * b
    r1, r2 = a + f - trace, a * f - s * b - product
    det = m11 * m22 - m12 * m21
    return (r1 * m22 - m12 * r2) / det / lanes.kappa, (m11 * r2 - r1 * m21) / det / lanes.kappa


class MatchedWall(Plain):
    """``sensor``: the velocity is sensed, not differenced."""

    rows = 1

    def __init__(self, *, sensor: bool) -> None:
        self.senses_speed = sensor

    def constants(self, lanes: Lanes) -> tuple[Array, ...]:
        """Where counts lie, and the gains."""
        return (lanes.offset, *matched_gains(lanes))

    def act(self, reading: Reading, memory: Array, fixed: tuple[Array, ...]) -> Action:
        """State feedback inside the wall, nothing outside."""
        offset, place, pace = fixed
        at = reading.count + offset
        speed = at - memory[0] if reading.speed is None else reading.speed
        return Action((np.where(reading.count < 0.0, -(place * at + pace * speed), 0.0),), at[None])
