"""The encoder edge at which a limit cycle works: the wall there is a relay, on or off by one torque step.

A push into the wall comes to balance either within a count, where the knob can rest, or between the torques of two
counts: then the knob is thrown back and forth over the edge between them (Hasser, sec. 7.2). Encoder and virtual wall
are those of the sweep's engine (`engine.loop`).
"""

from math import ceil, pi
from typing import NamedTuple

from hknob_cli.specs.plan import COUNTS, RATE, Actuator, Bias, Cell, Encoder, Hand, Scene


class WorkingEdge(NamedTuple):
    """What the laws and stability limits need of one cell; SI units.

    Attributes:
        inertia: Of knob and hand, kg·m².
        damping: Viscous, of knob and hand, N·m·s/rad.
        knob_damping: Viscous, of the knob alone, N·m·s/rad.
        hand_stiffness: To ground, N·m/rad.
        wall_stiffness: Virtual, N·m/rad.
        wall_damping: Virtual, N·m·s/rad.
        coulomb_torque: Coulomb friction level, N·m.
        quantum_rad: Angle of one count, rad.
        period_s: Sample period T, s.
        transport_s: Delay beyond sampling and hold, s.
        torque_step: By how much the wall's torque changes at the edge, N·m.
        balance: Push at the edge in excess of the torque just outside it, in torque steps. Between 0 and 1 the push is
            balanced on average only; elsewhere the knob can rest within a count.
    """

    inertia: float
    damping: float
    knob_damping: float
    hand_stiffness: float
    wall_stiffness: float
    wall_damping: float
    coulomb_torque: float
    quantum_rad: float
    period_s: float
    transport_s: float
    torque_step: float
    balance: float

    @property
    def delay_s(self) -> float:
        """Mean time from the edge to the torque: half a period until the next sample, and the transport delay."""
        return 0.5 * self.period_s + self.transport_s


def working_edge(scene: Scene, cell: Cell) -> WorkingEdge:
    """The working edge of a scene, with the sample rate (Hz) and counts per revolution of ``cell``.

    Counts into the wall are numbered from 0. Edge m lies m + s counts inside the wall, where s is that of edge 0; the
    torque is 0 outside edge 0, and K q (m + 1 - offset) inside edge m. The working edge is the first whose inner
    torque carries the push that the hand's spring has left over.
    """
    hand = scene.hand or Hand()
    bias = scene.bias or Bias(torque=0.0)
    actuator = scene.actuator or Actuator()
    period, quantum = 1.0 / cell[RATE], 2.0 * pi / cell[COUNTS]
    encoder = scene.encoder or Encoder()
    offset, rounding = encoder.offset_counts, encoder.rounding
    depth = {"floor": 0.0, "nearest": 0.5, "ceil": 1.0, "truncate": 1.0}[rounding] - offset
    full = scene.wall.stiffness * quantum
    spring = hand.stiffness * quantum
    push = 0.5 * full if bias.half_quantum else bias.torque or 0.0
    both = full + spring
    edge = max(0, ceil((push - full * (1.0 - offset) - spring * depth) / both)) if full > 0.0 else 0
    outside = full * (edge - offset) if edge else 0.0
    step = full * (edge + 1.0 - offset) - outside
    left = push - spring * (edge + depth) - outside
    return WorkingEdge(
        inertia=scene.knob.inertia + hand.inertia,
        damping=scene.knob.damping + hand.damping,
        knob_damping=scene.knob.damping,
        hand_stiffness=hand.stiffness,
        wall_stiffness=scene.wall.stiffness,
        wall_damping=scene.wall.damping,
        coulomb_torque=scene.knob.coulomb_torque,
        quantum_rad=quantum,
        period_s=period,
        transport_s=actuator.delay_samples * period,
        torque_step=step,
        balance=left / step if step > 0.0 else 0.0,
    )
