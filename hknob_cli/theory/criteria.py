"""Published criteria of a haptic wall's stability that the passivity of a sampled spring is not (Hasser, sec. 6.2).

The dissertation names them and gives no formula. What each is about differs, and so does its damping:

- `tsypkin` no oscillation, in this hand: Tsypkin (1962, 1964), absolute stability of a sampled loop with any torque
  between 0 and K x: Re H(e^jw) + 1/K > 0 at all w. H is knob and hand, from held torque to sampled angle.
- `tsai_colgate` no oscillation, in this hand: Tsai & Colgate (1995). They assume an oscillation and show a
  contradiction from what a unilateral spring is, after Mitra. See `tsai_colgate`.
- `miller` no oscillation, whatever else the hand does: Miller, Colgate & Freeman (1999a, 1999b). The damper of knob and
  hand has passivity to spare, b, and may lose what the wall lacks: see `miller`.
- `love_book` stability of the knob alone: Love & Book (1995), by Jury's criterion, with K and B of the wall.
- `llewellyn` stability in any passive hand, of any passive environment behind the wall's spring and damper as a virtual
  coupling: Adams & Hannaford (1999), by Llewellyn's criterion for two-ports.

All but one are about a wall without counts. At an encoder's edge the torque steps, so that no line K x, however steep,
bounds it there: `Criterion.quantised` is the stiffness that a criterion allows with counts.
"""

from collections.abc import Callable
from math import inf, isnan, sqrt
from typing import NamedTuple

import numpy as np

from hknob_cli.specs.plan import Encoder, Scene
from hknob_cli.theory.laws import WorkingEdge
from hknob_cli.theory.passivity import needed_damping, passive_stiffness
from hknob_cli.theory.sampled_plant import (
    Array,
    SampledPlant,
    frequencies,
    least,
    sampled_plant,
    stable_gains,
)

MOST_SHIFT = 8  # samples; of the multipliers of `tsai_colgate`
MOST_DELAY = 20  # samples; beyond, the roots of `love_book` are too badly told by its coefficients
_STEPS = 25  # of a golden section

UNDAMPED = "nothing damps the knob"
UNHELD = "nothing holds the knob outside the wall"
VIRTUAL = "the torque is no function of one angle with virtual damping"
FRICTION = "the criterion knows no friction"


class Criterion(NamedTuple):
    """One criterion's word on one cell; SI units.

    Attributes:
        holds: Whether it is satisfied by the wall without counts; None where it has no word.
        stiffness: Largest stiffness of the wall that satisfies it, all else the same, N·m/rad; None: no word,
            infinite: every stiffness does, 0: none does.
        in_domain: Whether its assumptions hold.
        reason: The first that does not; empty where all do.
        quantised: The same stiffness for the wall with the encoder's counts; None where it has no word on counts.
        least_damping, most_damping: Range of virtual damping B that satisfies it at the wall's stiffness, N·m·s/rad;
            None where it gives none.
    """

    holds: bool | None
    stiffness: float | None
    in_domain: bool
    reason: str
    quantised: float | None = None
    least_damping: float | None = None
    most_damping: float | None = None


class Case(NamedTuple):
    """One cell; SI units.

    Attributes:
        edge: Its working edge.
        knob_inertia: Moment of inertia of the knob alone, kg·m².
        steepest: Steepest line from the place of rest to the quantised wall's torque, over K; infinite where the torque
            steps at the place of rest. A push brings the rest to an edge of the encoder.
    """

    edge: WorkingEdge
    knob_inertia: float
    steepest: float


def tsypkin(case: Case) -> Criterion:
    """Absolute stability of the sampled wall: K < -1 / min Re H(e^jw).

    With counts the torque lies below a steeper line, `Case.steepest` times K: the criterion allows so much less.
    """
    edge = case.edge
    if silent := _no_word(edge):
        return silent
    plant = _with_hand(edge)
    most = _gain(least(lambda omega: plant.at(omega).real, frequencies(plant)))
    return _judged(edge, edge.wall_stiffness < most, most, quantised=most / case.steepest, rests=True)


def tsai_colgate(case: Case) -> Criterion:
    """No oscillation of the sampled unilateral wall.

    Its torque f(x) = K x for x >= 0, else 0, has for any two samples f_i (f_k / K - x_k) >= 0, with equality for i = k.
    Summed over a cycle with x = c - H f this gives, for any whole shift p and 0 <= r <= 1: if

        Re[(1/K + H(e^jw)) (1 - r e^jpw)] > 0 at all 0 < w <= pi

    no cycle exists: each of its harmonics would add to a sum that is not above 0. A constant push c cancels, as
    1 - r >= 0. With r = 0 it is Tsypkin's condition, so that it allows no less. The largest K over r and p, up to
    `MOST_SHIFT` samples, counts. We know the paper by its abstract, which has the method and these properties; its own
    choice of shifts may differ. (The same multipliers are those of Zames & Falb for monotone torques.) With counts the
    torque is no such function.
    """
    edge = case.edge
    if silent := _no_word(edge):
        return silent
    plant = _with_hand(edge)
    grid = frequencies(plant)
    shifts = [sign * p for p in range(1, MOST_SHIFT + 1) for sign in (1, -1)]
    response = plant.at(grid)
    best = min((_softest(grid, response, p) for p in shifts), key=lambda found: found[1])[0]
    most = 0.0
    for p, r in (best, (1, 0.0)):

        def spare(omega: Array, p: int = p, r: float = r) -> Array:
            return -_needed(omega, plant.at(omega), p, r)

        most = max(most, _gain(least(spare, grid)))
    return _judged(edge, edge.wall_stiffness < most, most, quantised=0.0, rests=True)


def _needed(omega: Array, response: np.ndarray, p: int, r: float) -> Array:
    """The 1/K that frequency by frequency satisfies the condition of `tsai_colgate`."""
    turned = 1.0 - r * np.exp(1j * p * omega)
    found: Array = -(response * turned).real / turned.real
    return found


def _softest(grid: Array, response: np.ndarray, p: int) -> tuple[tuple[int, float], float]:
    """The shift with the r that needs the least 1/K, and that; quasi-convex in r, so golden section finds it."""

    def worst(r: float) -> float:
        return float(_needed(grid, response, p, r).max())

    low, high, ratio = 0.0, 1.0 - 1e-9, 0.5 * (sqrt(5.0) - 1.0)
    first, second = high - ratio * (high - low), low + ratio * (high - low)
    at_first, at_second = worst(first), worst(second)
    for _ in range(_STEPS):
        if at_first <= at_second:
            high, second, at_second = second, first, at_first
            first = high - ratio * (high - low)
            at_first = worst(first)
        else:
            low, first, at_first = first, second, at_second
            second = low + ratio * (high - low)
            at_second = worst(second)
    return (p, 0.5 * (low + high)), worst(0.5 * (low + high))


def miller(case: Case) -> Criterion:
    """No oscillation in a hand with a damper: what the damper has to spare exceeds what the wall lacks.

    A torque u_k held for T does work u_k (x_k+1 - x_k); a damper b takes at least b (x_k+1 - x_k)^2 / T of it, so that
    knob and hand have passivity b to spare, whatever springs, masses and dampers else are in them. A wall whose torque
    rises by at most K with the angle, straight or not, lacks at most K T / 2 + |B|, and more with a delay
    (`passivity.needed_damping`). So b > K T / 2 + |B|: the wall of Colgate & Schenkel, here with curves, and with the
    hand's damper. The papers' own formulas were not at hand: this is the principle that the dissertation states. At a
    count's edge the torque rises infinitely fast.
    """
    edge = case.edge
    virtual = abs(edge.wall_damping)
    there = edge.damping
    if there <= 0.0 and (edge.wall_stiffness > 0.0 or virtual > 0.0):
        return Criterion(False, 0.0, True, "", 0.0)
    most = passive_stiffness(edge, there, virtual=virtual)
    return _judged(edge, there > needed_damping(edge, virtual=virtual), most, quantised=0.0, rests=False)


def love_book(case: Case) -> Criterion:
    """Stability of the knob alone on a wall that pulls as well as pushes: all roots inside the unit circle.

    The wall's torque is K x_k + B (x_k - x_k-1) / T. Jury's criterion says of a polynomial's coefficients whether its
    roots are inside. Where one reaches the circle (`sampled_plant.stable_gains`) is where his bounds lie: an upper one
    of K, a lower and an upper one of B.
    """
    edge = case.edge
    plant = sampled_plant(
        inertia=case.knob_inertia,
        damping=edge.knob_damping,
        stiffness=0.0,
        period_s=edge.period_s,
        transport_s=edge.transport_s,
    )
    if plant.delay > MOST_DELAY:
        return Criterion(None, None, False, f"it is computed for delays of up to {MOST_DELAY} samples")
    grid = frequencies(plant)
    changed = np.polymul(plant.over, [1.0, 0.0]) / edge.period_s  # (z - 1) / (T z), times z
    longer = [np.polymul(one, [1.0, 1.0]) for one in (plant.whole, plant.over)]
    stiff = stable_gains(
        np.polyadd(longer[0], edge.wall_damping * changed), longer[1], grid, around=edge.wall_stiffness
    )
    damped = stable_gains(
        np.polyadd(longer[0], edge.wall_stiffness * longer[1]), changed, grid, around=abs(edge.wall_damping)
    )
    most = stiff[1] if stiff else 0.0
    # Without a wall a free knob has its root at 1, and stands anywhere.
    holds = bool(stiff and (stiff[0] or -1.0) < edge.wall_stiffness < stiff[1])
    found = _judged(edge, holds, most, quantised=None, rests=False)
    return found._replace(least_damping=damped[0] if damped else None, most_damping=damped[1] if damped else None)


def llewellyn(case: Case) -> Criterion:
    """Unconditional stability of the knob with the wall's K and B as a virtual coupling, by Llewellyn's criterion.

    A passive hand at one end, any passive environment at the other; a rigid one makes the wall. With the knob's
    impedance by the bilinear rule, Re Z = b_k, the hold (z + 1) / (2 z) and the coupling's impedance
    Z_c = B + K T z / (z - 1) (Adams & Hannaford 1999), the criterion is

        2 b_k Re(1/Z_c) >= |hold| - Re hold    at all frequencies,

    which for B = 0 is K <= 8 b_k / T. That is four times what is necessary for the passivity of a sampled wall: their
    hold takes the torque to act on a velocity between samples, half a sample earlier than it does. The scene has no
    environment behind the wall; the criterion is about any.
    """
    edge = case.edge
    spare, virtual = edge.knob_damping, edge.wall_damping
    if edge.transport_s > 0.0:
        return Criterion(None, None, False, "the two-port knows no delay beyond the hold")
    if virtual < 0.0:
        return Criterion(False, 0.0, True, "")
    # With c = cos(w T / 2), S = K T and 1 - cos(w T) = 2 - 2 c^2, Re(1/Z_c) is (S + 2 B) (1 - cos(w T)) over
    # S^2 + 2 B (S + B) (1 - cos(w T)), and the right side is c (1 - c). What is left, over 1 - c, is a cubic in c.

    def slack(stiffness: float) -> float:
        """Least of it over 0 <= c <= 1."""
        spring = stiffness * edge.period_s
        left, cubic = 4.0 * spare * (spring + 2.0 * virtual), 4.0 * virtual * (spring + virtual)
        right = spring * spring + cubic
        c = min(1.0, sqrt(max(right - left, 0.0) / (3.0 * cubic))) if cubic > 0.0 else float(right > left)
        return left * (1.0 + c) - c * right + cubic * c**3

    if spare <= 0.0:
        return Criterion(edge.wall_stiffness <= 0.0 and virtual <= 0.0, 0.0, True, "")
    # The slack is concave in K, so that what is allowed is one range; with much B it may begin above 0.
    low, high = 0.0, 8.0 * (spare + virtual) / edge.period_s
    while slack(2.0 * high) > slack(high):
        high *= 2.0
    first, last = 0.0, high
    for _ in range(_STEPS):
        third = (last - first) / 3.0
        first, last = (first + third, last) if slack(first + third) < slack(last - third) else (first, last - third)
    low = first if slack(0.0) < 0.0 else 0.0
    if slack(low) < 0.0:
        return _judged(edge, edge.wall_stiffness <= 0.0, 0.0, quantised=None, rests=False)
    while slack(high) >= 0.0:
        low, high = high, 2.0 * high
    for _ in range(80):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if slack(middle) >= 0.0 else (low, middle)
    return _judged(edge, slack(edge.wall_stiffness) >= 0.0, low, quantised=None, rests=False)


CRITERIA: dict[str, Callable[[Case], Criterion]] = {
    "tsypkin": tsypkin,
    "tsai_colgate": tsai_colgate,
    "miller": miller,
    "love_book": love_book,
    "llewellyn": llewellyn,
}


def judge(name: str, case: Case) -> Criterion:
    """One criterion of `CRITERIA`. Raises `OverflowError` for numbers that it cannot compute with."""
    try:
        with np.errstate(all="ignore"):
            found = CRITERIA[name](case)
    except (ArithmeticError, ValueError, np.linalg.LinAlgError):
        raise OverflowError(name) from None
    if any(value is not None and isnan(value) for value in (found.stiffness, found.quantised)):
        raise OverflowError(name)
    return found


def case_of(scene: Scene, edge: WorkingEdge) -> Case:
    """What the criteria need of a cell of a scene, whose `laws.working_edge` is ``edge``."""
    bias, encoder = scene.bias, scene.encoder or Encoder()
    # Edge m lies m + s counts inside the wall and raises the torque to K q (m + 1 - offset): the first is the steepest.
    depth = {"floor": 0.0, "nearest": 0.5, "ceil": 1.0, "truncate": 1.0}[encoder.rounding] - encoder.offset_counts
    pushed = bias is not None and (bias.half_quantum or bool(bias.torque))
    steepest = inf if pushed or depth <= 0.0 else max(1.0, (1.0 - encoder.offset_counts) / depth)
    return Case(edge, scene.knob.inertia, steepest)


def _with_hand(edge: WorkingEdge) -> SampledPlant:
    return sampled_plant(
        inertia=edge.inertia,
        damping=edge.damping,
        stiffness=edge.hand_stiffness,
        period_s=edge.period_s,
        transport_s=edge.transport_s,
    )


def _no_word(edge: WorkingEdge) -> Criterion | None:
    """Of a criterion of a torque that is a function of the angle, on a plant that comes to rest by itself."""
    if edge.wall_damping:
        return Criterion(None, None, False, VIRTUAL)
    return Criterion(None, None, False, UNDAMPED) if edge.damping <= 0.0 else None


def _gain(least_real: float) -> float:
    """Largest gain of a condition 1/K + ``least_real`` > 0."""
    return -1.0 / least_real if least_real < 0.0 else inf


def _judged(edge: WorkingEdge, holds: bool, most: float, *, quantised: float | None, rests: bool) -> Criterion:
    """The criterion with its domain; ``rests``: whether it asks that the knob comes to rest outside the wall, too."""
    reason = FRICTION if edge.coulomb_torque > 0.0 else UNHELD if rests and edge.hand_stiffness <= 0.0 else ""
    return Criterion(holds, most, not reason, reason, quantised)
