"""The body of a scene in numbers: what moves, without dimensions, and its motion over spans of time as matrices."""

from collections.abc import Sequence
from math import inf, pi, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hknob_cli.engine.general.body import RATES, Body
from hknob_cli.engine.general.cogging import COGGED, SLOPE, TOOTHED
from hknob_cli.engine.propagator import hold_coefficients, slowest_rate
from hknob_cli.engine.turning import zero_spacing
from hknob_cli.scene.increments import halves, increment, increments, power_series, slowest_decay
from hknob_cli.specs.motor import Cogging
from hknob_cli.specs.plan import Actuator, Bias, Hand, Scene

Array = NDArray[np.float64]


def make_body(scene: Scene, *, period: float, quantum: float, shift: float, split: float) -> tuple[Body, float]:
    """The body of a scene, and the rate of its slowest mode that decays."""
    hand, actuator = scene.hand or Hand(), scene.actuator or Actuator()
    inertia, encoder_shift = scene.knob.inertia + hand.inertia, shift
    square = period * period / inertia
    push = _push_of(scene, square, quantum)
    alpha = (scene.knob.damping + hand.damping) * period / inertia
    beta = hand.stiffness * square
    lag = period / actuator.time_constant if actuator.time_constant > 0.0 else 0.0
    finger = _finger_of(hand, period, inertia)
    driven = 0.0
    if scene.behind and finger.ratio:
        push, driven, shift = _push_on_finger(push, finger, shift)
    coil, coil_rate = 0.0, 0.0
    if scene.coil:
        coil_rate = period / scene.coil.time_constant
        coil = scene.coil.damping * period / inertia * coil_rate
    order = 2 + (2 if finger.ratio else 0) + (1 if coil else 0) + (1 if lag else 0)
    modes = _modes_of_knob(order, alpha, beta, -push - beta * shift)
    if coil:
        _add_coil(modes, 4 if finger.ratio else 2, coil, coil_rate)
    if finger.ratio:
        _add_finger(modes, finger, shift, driven)
    if lag:
        _add_lag(modes, lag)
    more: list[Array] = []  # of teeth with friction, or of cogging
    stuck_constant = np.zeros(0)
    if scene.play:
        # The second matrix is that of teeth that do not press; what friction holds has its own.
        if scene.knob.coulomb_torque > 0.0 or scene.cogging:
            more, stuck_constant = _stuck(modes.held, finger), modes.held_constant
        modes = _parted(modes, finger)
    a, c, held, held_constant, entry = modes
    cogs = _cogs(scene.cogging, square=square, quantum=quantum, offset=encoder_shift)
    if cogs:
        more += _on_slopes((a, held) if scene.play else (a,), cogs[SLOPE], entry)
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
            [
                *(a.ravel(), held.ravel()),
                *increments(a, held, split, alpha, beta, stepped=cogs is not None),
                *(one.ravel() for one in more),
            ]
        ).tolist(),
        terms=len(series) // 2,
        vectors=np.concatenate([c, held_constant, entry, series, stuck_constant]).tolist(),
        play=scene.play / quantum,
        halt=[0.0],
        cogs=cogs,
    )
    return body, slowest_rate(alpha, beta) if second_order else slowest_decay(a)


def _push_of(scene: Scene, square: float, quantum: float) -> float:
    """The steady torque that pushes a knob into the wall, without dimensions; ``square``: period² over inertia."""
    bias = scene.bias or Bias(torque=0.0)
    return 0.5 * scene.wall.stiffness * square if bias.half_quantum else (bias.torque or 0.0) * square / quantum


def _cogs(cogging: Cogging | None, *, square: float, quantum: float, offset: float) -> list[float] | None:
    """Cogging as `engine.general.cogging` has it; None without any. ``offset``: of position 0 from the angle 0."""
    if cogging is None or cogging.torque == 0.0:
        return None
    peak, length = cogging.torque * square / quantum, pi / cogging.per_revolution / quantum
    slope, centre = 2.0 * peak / length, cogging.centre / quantum - offset
    return [slope, length, centre, peak, sqrt(slope), abs(centre) + length]


class _Finger(NamedTuple):
    """The finger behind its pad, without dimensions: the pad's over the knob's inertia, its own over its own.

    ``ratio``: the knob's inertia over the finger's; 0 without a finger.
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


def _push_on_finger(push: float, finger: _Finger, shift: float) -> tuple[float, float, float]:
    """A push that acts on the finger: what is left of it on the knob, what drives the finger, and the neutral angle.

    Its spring is neutral elsewhere, or without a spring it is driven.
    """
    driven = push * finger.ratio
    if finger.stiffness > 0.0:
        return 0.0, 0.0, shift + driven / finger.stiffness
    return 0.0, driven, shift


class _Modes(NamedTuple):
    """Rates of change of the states, a matrix and a constant each: of a knob that moves, and of one that is held.

    ``entry``: what a torque on the knob changes.
    """

    a: Array
    c: Array
    held: Array
    held_constant: Array
    entry: Array


def _modes_of_knob(order: int, alpha: float, beta: float, pull: float) -> _Modes:
    """Of a knob under its own damping, spring and steady ``pull``, with room for what else the body has."""
    a, c, entry = np.zeros((order, order)), np.zeros(order), np.zeros(order)
    entry[1] = 1.0
    a[0, 1] = 1.0
    a[1, :2] = -beta, -alpha
    c[1] = pull
    return _Modes(a, c, np.zeros((order, order)), np.zeros(order), entry)


def _add_coil(modes: _Modes, at: int, coil: float, coil_rate: float) -> None:
    """A winding, whose state is number ``at``."""
    a, _, held, _, _ = modes
    a[1, at] = -coil
    a[at, 1] = 1.0
    a[at, at] = held[at, at] = -coil_rate


def _add_finger(modes: _Modes, finger: _Finger, shift: float, driven: float) -> None:
    """A finger, by d and w = d': angle and speed of the knob relative to it."""
    a, c, held, held_constant, entry = modes
    entry[3] = 1.0
    a[1, 2:4] = -finger.pad_stiffness, -finger.pad_damping
    own = np.zeros(len(entry))  # acceleration of the finger
    own[:2] = -finger.stiffness, -finger.damping
    own[2] = finger.ratio * finger.pad_stiffness + finger.stiffness
    own[3] = finger.ratio * finger.pad_damping + finger.damping
    a[2, 3] = held[2, 3] = 1.0
    a[3] = a[1] - own
    c[3] = c[1] + finger.stiffness * shift + driven
    held[3] = -own
    held[3, 1] = 0.0
    held_constant[3] = finger.stiffness * shift + driven


def _add_lag(modes: _Modes, lag: float) -> None:
    """An actuator's lag, whose torque is the last state."""
    a, _, held, _, entry = modes
    a[-1, -1] = held[-1, -1] = -lag
    a[:, -1] += entry


def _stuck(held: Array, finger: _Finger) -> list[Array]:
    """Matrices of a finger behind teeth at a knob that friction holds: they press, they do not, and halves of both."""
    loose = held.copy()
    loose[3, :4] = finger.stiffness, 0.0, -finger.stiffness, -finger.damping
    return [held, loose, halves(held), halves(loose)]


def _parted(modes: _Modes, finger: _Finger) -> _Modes:
    """With what moves while teeth do not press in place of what is held."""
    loose = modes.a.copy()
    loose[1, 2:4] = 0.0
    loose[3, 2:4] = -finger.stiffness, -finger.damping
    return modes._replace(held=loose, held_constant=modes.c.copy())


def _on_slopes(matrices: Sequence[Array], slope: float, entry: Array) -> list[Array]:
    """Matrices on the rising and the falling slopes of cogging, and their halves behind them."""
    sloped = []
    for mode in matrices:
        for spring in (slope, -slope):
            beside = mode.copy()
            beside[:, 0] -= spring * entry
            sloped.append(beside)
    return [*sloped, *(halves(one) for one in sloped)]


def _reach(beta: float, finger: _Finger) -> float:
    """Position of a unit root of energy, counts; infinite where nothing holds the knob."""
    if not finger.ratio:
        return 1.0 / sqrt(beta) if beta > 0.0 else inf
    if finger.pad_stiffness == 0.0 or finger.stiffness == 0.0:
        return inf
    return sqrt(1.0 / finger.pad_stiffness + finger.ratio / finger.stiffness)


def add_spans(body: Body, spans: Sequence[float]) -> Body:
    """The body with D over more times (sample periods) at its matrices' end.

    As it is with two states, or where a motion is followed from event to event by its halves.
    """
    n = body.order
    if n == 2 or body.play > 0.0 or body.cogs is not None:
        return body
    a = np.array(body.matrices[: n * n]).reshape(n, n)
    more = [increment(a, span, body.alpha, body.beta).ravel() for span in spans]
    return body._replace(matrices=[*body.matrices, *np.concatenate(more).tolist()])


def turns_of(body: Body) -> float:
    """Times that the fastest mode of a body turns round in a sample interval."""
    size = body.order**2
    first = (RATES if body.cogs is None else TOOTHED if body.play > 0.0 else COGGED) * size
    a = np.array(body.matrices[first : first + size]).reshape(body.order, body.order)
    return float(np.abs(np.linalg.eigvals(a).imag).max()) / pi
