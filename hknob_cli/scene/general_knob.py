"""One cell of a scene with more in it than the plain loop has: friction, finger, lag, limits, a continuous sensor.

Like `scene.sampled_knob`, in counts and sample periods; without an encoder a count is a milliradian.
"""

from collections.abc import Sequence
from math import inf, isfinite, pi, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hknob_cli.engine.general.body import Body
from hknob_cli.engine.general.controller import Controller
from hknob_cli.engine.general.torque_table import HEAD, RISE_BELOW, TURN
from hknob_cli.engine.propagator import hold_coefficients, slowest_rate
from hknob_cli.engine.turning import zero_spacing
from hknob_cli.errors import ComputationError
from hknob_cli.scene.increments import halves, increment, increments, power_series, slowest_decay
from hknob_cli.scene.torque_over_angle import Clock, is_shaped, table_of
from hknob_cli.specs.parts import SampleClock
from hknob_cli.specs.plan import Actuator, Bias, Encoder, Hand, Scene

Array = NDArray[np.float64]

MOST_TURNS = 1e5  # in a sample interval: each is an event that is followed
UNIT_RAD = 1e-3  # a "count" of a continuous sensor


class GeneralKnob(NamedTuple):
    """A scene sampled: its body and controller without dimensions, and the scales back to SI.

    ``period_s``: of a clock that jitters the longest interval; ``inertia_kg_m2``: of all that turns with the knob;
    ``rate``: of the slowest mode that decays, per sample; ``behind``: whether the body that is sensed is a motor, and
    the finger the knob with its hand behind a gear.
    """

    body: Body
    wall: Controller
    quantum_rad: float
    period_s: float
    inertia_kg_m2: float
    shift: float
    delay_line: int
    rate: float
    behind: bool = False

    def angle_rad(self, x: float) -> float:
        """Angle of a position ``x``."""
        return (x + self.shift) * self.quantum_rad

    def position(self, angle_rad: float) -> float:
        """Position, in counts, at an angle."""
        return angle_rad / self.quantum_rad - self.shift

    def speed(self, velocity_rad_s: float) -> float:
        """Velocity in counts per sample."""
        return velocity_rad_s * self.period_s / self.quantum_rad

    def start(self, angle_rad: float, velocity_rad_s: float) -> list[float]:
        """State at the start of a trial: the finger moves with the knob, no torque acts."""
        return [self.position(angle_rad), self.speed(velocity_rad_s), *([0.0] * (self.body.order - 2))]

    @property
    def torque_nm(self) -> float:
        """Torque of a unit acceleration of the knob."""
        return self.inertia_kg_m2 * self.quantum_rad / self.period_s**2

    @property
    def energy_j(self) -> float:
        """One unit of energy, J (counts per sample)², in joules."""
        return self.inertia_kg_m2 * (self.quantum_rad / self.period_s) ** 2


def sample_general(
    scene: Scene, *, sample_rate_hz: float, counts_per_rev: int | None, walled: bool = True
) -> GeneralKnob:
    """Reduce a scene to one cell. ``walled``: whether the wall's torque is the loop's, and not a law's.

    Raises `ComputationError` if its numbers overflow, if it rings so often in an interval that nobody waits for it, or
    if the loop without a law does not remember all that it takes.
    """
    actuator = scene.actuator or Actuator()
    encoder = scene.encoder or Encoder()
    hand = scene.hand or Hand()
    jitter = scene.clock.jitter if scene.clock else 0.0
    period = (1.0 + jitter) / sample_rate_hz  # the longest
    quantum = 2.0 * pi / (counts_per_rev * scene.turns) if counts_per_rev else UNIT_RAD
    inertia = scene.knob.inertia + hand.inertia
    square = period * period / inertia
    nearest = scene.encoder is not None and encoder.rounding == "nearest"
    shift = encoder.offset_counts - (0.5 if nearest else 0.0) if scene.encoder else 0.0
    whole = int(actuator.delay_samples)
    split = float(actuator.delay_samples - whole)
    kappa = scene.wall.stiffness * square
    offset = encoder.offset_counts if scene.encoder else 0.0
    table = None
    if is_shaped(scene):
        if counts_per_rev is None:
            raise ComputationError("a torque over the angle needs counts: with a continuous sensor it is not followed")
        clock, apart = Clock(counts_per_rev, quantum, offset), 0.0 if walled else kappa
        table = table_of(scene, clock, kappa=kappa - apart, unit_nm=quantum / square)
        kappa = apart - float(table[RISE_BELOW] / table[TURN])
    wall = Controller(
        kappa=kappa,
        damping=scene.wall.damping * (1.0 + jitter) * period / inertia,  # firmware divides by the period meant
        sense=-1.0 if encoder.rounding in ("ceil", "truncate") else 1.0,
        truncate=1.0 if encoder.rounding == "truncate" else 0.0,
        offset=offset,
        analog=0.0 if scene.encoder else 1.0,
        step=actuator.torque_step * square / quantum,
        limit=inf if actuator.torque_limit is None else actuator.torque_limit * square / quantum,
        split=split,
        table=table,
        band=actuator.dead_band * square / quantum,
        hysteresis=encoder.width_counts(quantum) if scene.encoder else 0.0,
        clock=_clock(scene.clock) if scene.clock and jitter > 0.0 else None,
    )
    if walled and wall.hysteresis > 0.0 and wall.damping > 0.0:
        raise ComputationError("virtual damping beside hysteresis of the encoder is followed under a law")
    body, slowest = make_body(scene, period=period, quantum=quantum, shift=shift, split=split)
    commands = [] if table is None else table[HEAD : HEAD + (len(table) - HEAD) // 3].tolist()
    numbers = [*wall[: wall._fields.index("limit")], wall.band, *commands, body.friction, body.push, body.play]
    numbers += [*body.matrices, *body.vectors]
    if not all(isfinite(value * value) for value in numbers):
        place = f"at {sample_rate_hz:g} Hz" + (f" and {counts_per_rev} counts" if counts_per_rev else "")
        raise ComputationError(f"{place} the scene's numbers overflow")
    turns = _turns(body)
    if turns > MOST_TURNS:
        often = f"it rings to and fro {turns:.2g} times in each interval"
        raise ComputationError(
            f"at {sample_rate_hz:g} Hz the scene cannot be followed: {often}, at most {MOST_TURNS:g}"
        )
    return GeneralKnob(
        body=body,
        wall=wall,
        quantum_rad=quantum,
        period_s=period,
        inertia_kg_m2=inertia,
        shift=shift,
        delay_line=whole + 1 if actuator.delay_samples > 0.0 else 0,
        rate=slowest,
        behind=scene.behind,
    )


def _clock(clock: SampleClock) -> Array:
    """A clock as `engine.general.jitter` has it, at its beginning."""
    longest = 1.0 + clock.jitter
    shortest, spread = (1.0 - clock.jitter) / longest, 2.0 * clock.jitter / longest
    return np.array([1.0, shortest, spread, float(clock.seed), 0.0, 1.0 / longest])


def make_body(scene: Scene, *, period: float, quantum: float, shift: float, split: float) -> tuple[Body, float]:
    """The body of a scene, and the rate of its slowest mode that decays."""
    hand, actuator = scene.hand or Hand(), scene.actuator or Actuator()
    inertia = scene.knob.inertia + hand.inertia
    square = period * period / inertia
    bias = scene.bias or Bias(torque=0.0)
    push = 0.5 * scene.wall.stiffness * square if bias.half_quantum else (bias.torque or 0.0) * square / quantum
    alpha = (scene.knob.damping + hand.damping) * period / inertia
    beta = hand.stiffness * square
    lag = period / actuator.time_constant if actuator.time_constant > 0.0 else 0.0
    finger = _finger_of(hand, period, inertia)
    driven = 0.0
    if scene.behind and finger.ratio:
        # The push is on the finger: its spring is neutral elsewhere, or without a spring it is driven.
        driven, push = push * finger.ratio, 0.0
        if finger.stiffness > 0.0:
            shift, driven = shift + driven / finger.stiffness, 0.0
    coil, coil_rate = 0.0, 0.0
    if scene.coil:
        coil_rate = period / scene.coil.time_constant
        coil = scene.coil.damping * period / inertia * coil_rate
    order = 2 + (2 if finger.ratio else 0) + (1 if coil else 0) + (1 if lag else 0)
    a, c, entry = np.zeros((order, order)), np.zeros(order), np.zeros(order)
    entry[1] = 1.0
    a[0, 1] = 1.0
    a[1, :2] = -beta, -alpha
    c[1] = -push - beta * shift
    held, held_constant = np.zeros((order, order)), np.zeros(order)
    if coil:
        at = 4 if finger.ratio else 2
        a[1, at] = -coil
        a[at, 1] = 1.0
        a[at, at] = held[at, at] = -coil_rate
    if finger.ratio:
        # d and w = d': angle and speed of the knob relative to the finger.
        entry[3] = 1.0
        a[1, 2:4] = -finger.pad_stiffness, -finger.pad_damping
        own = np.zeros(order)  # acceleration of the finger
        own[:2] = -finger.stiffness, -finger.damping
        own[2] = finger.ratio * finger.pad_stiffness + finger.stiffness
        own[3] = finger.ratio * finger.pad_damping + finger.damping
        a[2, 3] = held[2, 3] = 1.0
        a[3] = a[1] - own
        c[3] = c[1] + finger.stiffness * shift + driven
        held[3] = -own
        held[3, 1] = 0.0
        held_constant[3] = finger.stiffness * shift + driven
    if lag:
        a[order - 1, order - 1] = held[order - 1, order - 1] = -lag
        a[:, order - 1] += entry
    stuck: list[Array] = []
    stuck_constant = held_constant
    if scene.play:
        # The second matrix is that of teeth that do not press; what friction holds has its own.
        if scene.knob.coulomb_torque > 0.0:
            loose = held.copy()
            loose[3, :4] = finger.stiffness, 0.0, -finger.stiffness, -finger.damping
            stuck = [held, loose, halves(held), halves(loose)]
        held, held_constant = a.copy(), c.copy()
        held[1, 2:4] = 0.0
        held[3, 2:4] = -finger.stiffness, -finger.damping
    second_order = order == 2
    ones = hold_coefficients(alpha, beta, split), hold_coefficients(alpha, beta, 1.0 - split)
    series = power_series(alpha, beta) if second_order else np.zeros(0)
    body = Body(
        order=order,
        friction=scene.knob.coulomb_torque * square / quantum,
        alpha=alpha,
        beta=beta,
        spacing=zero_spacing(alpha, beta) if second_order else inf,
        pad_damping=finger.pad_damping,
        pad_stiffness=finger.pad_stiffness,
        ratio=finger.ratio,
        finger_damping=finger.damping,
        finger_stiffness=finger.stiffness,
        coil=coil,
        coil_rate=coil_rate,
        lag=lag,
        shift=shift,
        push=push,
        reach=_reach(beta, finger),
        damped=alpha + finger.pad_damping + finger.damping + coil > 0.0 or scene.knob.coulomb_torque > 0.0,
        s1=ones[0][0],
        g1=ones[0][1],
        f1=ones[0][2],
        s2=ones[1][0],
        g2=ones[1][1],
        f2=ones[1][2],
        drive=float(c[1]),
        matrices=np.concatenate(
            [a.ravel(), held.ravel(), *increments(a, held, split, alpha, beta), *(one.ravel() for one in stuck)]
        ).tolist(),
        terms=len(series) // 2,
        vectors=np.concatenate([c, held_constant, entry, series, stuck_constant if stuck else []]).tolist(),
        play=scene.play / quantum,
        halt=[0.0],
    )
    return body, slowest_rate(alpha, beta) if second_order else slowest_decay(a)


class _Finger(NamedTuple):
    """The finger behind its pad, without dimensions: the pad's over the knob's inertia, its own over its own.

    ``ratio``: of the knob's inertia to the finger's, 0 where there is none.
    """

    pad_damping: float = 0.0
    pad_stiffness: float = 0.0
    ratio: float = 0.0
    damping: float = 0.0
    stiffness: float = 0.0


def _finger_of(hand: Hand, period: float, inertia: float) -> _Finger:
    """The finger of a hand on a knob of an inertia, kg m²; ``period``: of the clock, s."""
    pad, own = hand.fingerpad, hand.finger
    if not own or not pad:
        return _Finger()
    return _Finger(
        pad_damping=pad.damping * period / inertia,
        pad_stiffness=pad.stiffness * (period * period / inertia),
        ratio=inertia / own.inertia,
        damping=own.damping * (period / own.inertia),
        stiffness=own.stiffness * period * (period / own.inertia),
    )


def _reach(beta: float, finger: _Finger) -> float:
    """Position of a unit root of energy, counts; infinite where nothing holds the knob."""
    if not finger.ratio:
        return 1.0 / sqrt(beta) if beta > 0.0 else inf
    if finger.pad_stiffness == 0.0 or finger.stiffness == 0.0:
        return inf
    return sqrt(1.0 / finger.pad_stiffness + finger.ratio / finger.stiffness)


def add_spans(body: Body, spans: Sequence[float]) -> Body:
    """The body with D over more times (sample periods) at its matrices' end; as it is with play, or two states."""
    n = body.order
    if n == 2 or body.play > 0.0:
        return body
    a = np.array(body.matrices[: n * n]).reshape(n, n)
    more = [increment(a, span, body.alpha, body.beta).ravel() for span in spans]
    return body._replace(matrices=[*body.matrices, *np.concatenate(more).tolist()])


def _turns(body: Body) -> float:
    """Times that the fastest mode of a body turns round in a sample interval."""
    a = np.array(body.matrices[: body.order**2]).reshape(body.order, body.order)
    return float(np.abs(np.linalg.eigvals(a).imag).max()) / pi
