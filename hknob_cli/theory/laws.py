"""Closed laws for the size and pitch of a limit cycle, and the encoder edge at which it works.

The wall at the edge is a relay: its torque steps by K q (wall stiffness times one count), a mean delay D after the edge
is crossed; D is half a sample period T, plus what transport delay there is. Without the latter 2 D = T, and the laws
read as printed. None of them is for the motion that spans many counts, nor for a push far from half a torque step.

The encoder edge at which a limit cycle works: the wall there is a relay, on or off by one torque step.

A push into the wall comes to balance either within a count, where the knob can rest, or between the torques of two
counts: then the knob is thrown back and forth over the edge between them (Hasser, sec. 7.2). Encoder and virtual wall
are those of the sweep's engine (`engine.loop`).
"""

from math import ceil, isfinite, pi, sqrt
from typing import NamedTuple

from hknob_cli.specs.plan import RATE, Actuator, Bias, Cell, Encoder, Hand, Scene, knob_counts

MOST_DELAY_ANGLE = 0.5  # rad; the first term that the describing function's limit leaves out is then 4 %
MOST_COUNTS = 2.0  # peak to peak; beyond, a motion that is symmetric about its edge reaches the next one
LEAST_BALANCE, MOST_BALANCE = 0.2, 0.8  # torque steps; the laws assume 0.5
MOST_FRICTION = 0.12  # Coulomb friction in torque steps; beyond, the velocity is not triangular enough
MOST_FRICTION_SHARE = 0.1  # of the energy that the delay feeds in, for laws that know no friction
MOST_SPRING = 0.25  # torque of the hand's spring at the peak over the relay's, for laws that know no spring
RMS_SINE = 0.707 / 2.0  # of peak to peak: the correction as printed (Hasser, sec. 9.3)
RMS_ARCS = sqrt(8.0 / 15.0) / 2.0  # of peak to peak: parabolic arcs, which are what constant torques make
FRICTION_HOLDS = "friction holds the knob"


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
    period, quantum = 1.0 / cell[RATE], 2.0 * pi / knob_counts(scene, cell)
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


class Prediction(NamedTuple):
    """One law's word on one cell.

    Attributes:
        p2p_rad: Peak to peak, rad; None where the law has no value.
        frequency_hz: Frequency, Hz; None where the law has no value.
        in_domain: Whether the law's assumptions hold.
        reason: The first that does not; empty where all hold.
    """

    p2p_rad: float | None
    frequency_hz: float | None
    in_domain: bool
    reason: str


def describing_function(edge: WorkingEdge) -> Prediction:
    """The describing function of the relay, in the limit of a short delay: p2p = 4 K q D / (pi b).

    A relay of ±K q / 2 with delay D oscillates where the phase of the plant makes up for it,
    J w² - k = b w / tan(w D) (Hasser, sec. 7.2), with amplitude (2 K q / pi) sin(w D) / (b w). With sin(w D) = w D and
    tan(w D) = w D: w² = (k + b / D) / J, and p2p = C q T with C = 2 K / (pi b) where D = T / 2. The next terms give
    w² = (k + b / D) / (J + b D / 3), so that p2p and w are too large by about (w D)² / 6 each.
    """
    if missing := _missing(edge):
        return missing
    p2p = 4.0 * edge.wall_stiffness * edge.quantum_rad * edge.delay_s / (pi * edge.damping)
    omega = _harmonic_omega(edge)
    return _judged(edge, p2p, omega, given=omega, knows_friction=False, knows_spring=True)


def quantum_period(edge: WorkingEdge, *, constant: float | None = None) -> Prediction:
    """The dissertation's law p2p = C q T (Hasser, sec. 9.3), C in 1/s.

    ``constant`` is C, from a known case; such a law has no frequency. None: C = 2 K / (pi b), the describing
    function's, with 2 D for T where there is a transport delay, and with its frequency.
    """
    if constant is None:
        return describing_function(edge)
    p2p = constant * edge.quantum_rad * edge.period_s
    if missing := _missing(edge):
        return missing._replace(p2p_rad=p2p)
    return _judged(edge, p2p, _harmonic_omega(edge), given=None, knows_friction=False, knows_spring=True)


def energy_balance(edge: WorkingEdge) -> Prediction:
    """Energy over one cycle of a relay oscillation under constant torques, with Coulomb friction T_c if there is any.

    The velocity is triangular with slope a = K q / (2 J), so p2p = a P² / 16 over the period P. Damping takes
    b a² P³ / 48, friction 2 T_c p2p, and each of the two late switchings feeds in K q D a P / 4:
    (b a / 48) P² + (T_c / 8) P - K q D / 2 = 0. Without friction p2p = 3 K q D / (2 b) and f = sqrt(b / (48 J D)); with
    D = T / 2 that is p2p = (3 K / 4 b) q T and f = sqrt(b / (24 J T)).

    Friction that exceeds the torque in one of the two positions of the relay holds the knob there: no cycle.
    """
    if _held(edge):
        return Prediction(0.0, 0.0, False, FRICTION_HOLDS)
    if missing := _missing(edge, friction_dissipates=True):
        return missing
    slope = edge.wall_stiffness * edge.quantum_rad / (2.0 * edge.inertia)
    square = edge.damping * slope / 48.0
    linear = edge.coulomb_torque / 8.0
    fed = 0.5 * edge.wall_stiffness * edge.quantum_rad * edge.delay_s
    period = 2.0 * fed / (linear + sqrt(linear * linear + 4.0 * square * fed))
    omega = 2.0 * pi / period
    p2p = slope * period * period / 16.0
    return _judged(edge, p2p, omega, given=omega, knows_friction=True, knows_spring=False)


def _harmonic_omega(edge: WorkingEdge) -> float:
    """Angular frequency of the describing function's limit, rad/s."""
    return sqrt((edge.hand_stiffness + edge.damping / edge.delay_s) / edge.inertia)


def _held(edge: WorkingEdge) -> bool:
    """Whether friction, and not the balance of push and wall, keeps the knob where one position of the relay put it."""
    least = edge.torque_step * min(edge.balance, 1.0 - edge.balance)
    return 0.0 < least <= edge.coulomb_torque


def _missing(edge: WorkingEdge, *, friction_dissipates: bool = False) -> Prediction | None:
    """A prediction without values, where there is no relay, or nothing that bounds what it drives."""
    if edge.wall_stiffness <= 0.0:
        return Prediction(None, None, False, "the wall has no stiffness")
    if edge.damping <= 0.0 and not (friction_dissipates and edge.coulomb_torque > 0.0):
        return Prediction(None, None, False, "there is no viscous damping")
    return None


def _judged(
    edge: WorkingEdge, p2p: float, omega: float, *, given: float | None, knows_friction: bool, knows_spring: bool
) -> Prediction:
    """The prediction with its domain; ``omega``: the motion's, rad/s; ``given``: that which the law gives, if any."""
    frequency = None if given is None else given / (2.0 * pi)
    if not isfinite(p2p) or not isfinite(omega):
        return Prediction(None, None, False, "the numbers overflow")
    reason = _outside(edge, p2p, omega, knows_friction=knows_friction, knows_spring=knows_spring)
    return Prediction(p2p, frequency, not reason, reason)


def _outside(edge: WorkingEdge, p2p: float, omega: float, *, knows_friction: bool, knows_spring: bool) -> str:
    """The first assumption that does not hold; empty if all do."""
    step = edge.wall_stiffness * edge.quantum_rad
    fed = 4.0 * step * omega * edge.delay_s / pi  # energy of a cycle's late switchings, over its peak to peak
    checks = (
        (edge.damping <= 0.0, "there is no viscous damping"),
        (_held(edge), FRICTION_HOLDS),
        (not 0.0 < edge.balance < 1.0, "the push is carried at rest"),
        (edge.wall_damping != 0.0, "the law knows no virtual damping"),
        (abs(edge.torque_step - step) > 1e-9 * step, "the torque step at the wall's edge is not one count"),
        (p2p > MOST_COUNTS * edge.quantum_rad, "the motion spans more than the counts beside one edge"),
        (omega * edge.delay_s > MOST_DELAY_ANGLE, "the delay is not short against a cycle"),
        (not LEAST_BALANCE <= edge.balance <= MOST_BALANCE, "the push is far from half a torque step"),
        (edge.coulomb_torque > MOST_FRICTION * step, "friction is not small against a torque step"),
        (
            not knows_friction and 2.0 * edge.coulomb_torque > MOST_FRICTION_SHARE * fed,
            "the law knows no friction",
        ),
        (
            not knows_spring and edge.hand_stiffness * p2p > MOST_SPRING * step,
            "the law knows no hand stiffness",
        ),
    )
    return next((reason for fails, reason in checks if fails), "")
