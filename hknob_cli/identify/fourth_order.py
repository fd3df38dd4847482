"""The fourth-order hand: finger to ground, fingerpad between finger and knob; its exact motion, and its fit by that.

Equation 1 gives -(B1 + B2)/J1 as the last element of Equation 2, which prints -(B1 - B2).

Exact motion of any linear plant under a held torque, and its derivatives by whatever its matrix depends on.

All parameters are positive and fitted as logarithms. A 20 ms pulse tells few of them apart, and what it leaves open is
no ellipse: two springs and dampers in series move alike in either order except for the finger's inertia, and alike for
K1/K2 above and below B1/B2. So the search starts from several places, and an interval holds all that fits as well as
chance allows (`nearest.spread`). What is not told is said not to be identifiable, whatever number comes out.
"""

from collections.abc import Callable, Mapping
from math import ceil, isfinite, log, log2, sqrt
from typing import Any

import numpy as np

from hknob_cli.identify.fit import Estimate, Fit, blank, condition, misfit, unidentified, vaf, whiteness, widen
from hknob_cli.identify.motion import Motion
from hknob_cli.identify.nearest import Minimum, Nearest, cost, nearest, spread
from hknob_cli.identify.output_error import output_error
from hknob_cli.recordings.trial import Array

ORDER = ("inertia", "finger_inertia", "finger_damping", "finger_stiffness", "pad_damping", "pad_stiffness")
FINGER_INERTIA = 3.0e-7  # Section 4.4.1: "a generous estimate"
SPLIT = 10.0  # Section 4.4.1: K1 = 10 K2, B1 = 10 B2


def hold_matrices(
    matrix: Array, push: Array, dt_s: float, matrices: Array | None = None, pushes: Array | None = None
) -> tuple[Array, Array]:
    """What a hold does to the state, (1 + p, m, m), and what a unit torque adds, (1 + p, m): values, then derivatives.

    ``matrix`` (m, m) and ``push`` (m,) of x' = matrix x + push torque, the states angles and velocities in turn;
    ``matrices`` (p, m, m), ``pushes`` (p, m): their derivatives by each of p parameters, if any. The exponential of
    [[A, b], [0, 0]] dt, by `pulse.exponential`.
    """
    from hknob_cli.engine.jit import compiled

    order = len(push)
    if matrices is None or pushes is None:
        matrices, pushes = np.empty((0, order, order)), np.empty((0, order))
    whole = np.zeros((1 + len(pushes), order + 1, order + 1))
    whole[0, :order, :order], whole[0, :order, order] = matrix, push
    whole[1:, :order, :order], whole[1:, :order, order] = matrices, pushes
    # Velocities in rad per hold, and torque in what moves the first velocity by 1: elements of like size.
    unit = np.ones(order + 1)
    unit[1:order:2] = dt_s
    unit[order] = 1.0 / max(float(np.max(np.abs(push))) * dt_s * dt_s, np.finfo(float).tiny)
    whole *= dt_s * unit[:, None] / unit
    norm = float(np.max(np.sum(np.abs(whole[0]), axis=1)))
    squarings = max(0, ceil(log2(norm)) + 1) if norm > 0.0 else 0
    whole *= 0.5**squarings
    total, spare = np.empty_like(whole), np.empty_like(whole)
    with np.errstate(over="ignore", invalid="ignore"):
        kernel = compiled("pulse")["exponential"]
        kernel(whole[0], whole[1:], squarings, total[0], total[1:], spare[0], spare[1:], np.empty_like(whole[0]))
    total *= unit / unit[:, None]
    return np.ascontiguousarray(total[:, :order, :order]), np.ascontiguousarray(total[:, :order, order])


def respond_linear(move: Array, push: Array, torque_nm: Array) -> tuple[Array, Array]:
    """First state (n,) from rest, and its derivatives (n, p), of what `hold_matrices` gives."""
    from hknob_cli.engine.jit import compiled

    count, order = len(push) - 1, push.shape[1]
    torque = np.ascontiguousarray(torque_nm, dtype=float)
    angle, slopes = np.empty(len(torque)), np.empty((len(torque), count))
    with np.errstate(over="ignore", invalid="ignore"):
        kernel = compiled("pulse")["follow_linear"]
        kernel(torque, move[0], push[0], move[1:], push[1:], np.zeros((count + 2, order)), angle, slopes)
    return angle, slopes


def network(parameters: Mapping[str, float]) -> tuple[Array, Array]:
    """Matrix (4, 4) and input (4,) of knob angle, knob velocity, finger angle, finger velocity.

    Source: Section 4.4.1, Equation 1. Without the knob it is of third order, as Karason and Srinivasan's (1995) model.
    """
    knob, tip, b1, k1, b2, k2 = (parameters[name] for name in ORDER)
    matrix = np.array(
        [
            [0.0, 1.0, 0.0, 0.0],
            [-k2 / knob, -b2 / knob, k2 / knob, b2 / knob],
            [0.0, 0.0, 0.0, 1.0],
            [k2 / tip, b2 / tip, -(k1 + k2) / tip, -(b1 + b2) / tip],
        ]
    )
    return matrix, np.array([0.0, 1.0 / knob, 0.0, 0.0])


def network_slopes(parameters: Mapping[str, float]) -> tuple[Array, Array]:
    """Derivatives (6, 4, 4) and (6, 4) of matrix and input by the parameters' logarithms, in their `ORDER`."""
    knob, tip, b1, k1, b2, k2 = (parameters[name] for name in ORDER)
    matrix, push = network(parameters)
    matrices, pushes = np.zeros((6, 4, 4)), np.zeros((6, 4))
    matrices[0, 1], pushes[0] = -matrix[1], -push
    matrices[1, 3] = -matrix[3]
    matrices[2, 3, 3], matrices[3, 3, 2] = -b1 / tip, -k1 / tip
    for which, here, there, value in ((4, 1, 3, b2), (5, 0, 2, k2)):
        matrices[which, 1, [here, there]] = -value / knob, value / knob
        matrices[which, 3, [here, there]] = value / tip, -value / tip
    return matrices, pushes


def split(damping: float, stiffness: float, ratio: float = SPLIT) -> dict[str, float]:
    """Finger and fingerpad in series that have ``damping`` and ``stiffness`` between knob and ground, in this ratio."""
    pad = (1.0 + ratio) / ratio
    return {
        "finger_damping": ratio * pad * damping,
        "finger_stiffness": ratio * pad * stiffness,
        "pad_damping": pad * damping,
        "pad_stiffness": pad * stiffness,
    }


def respond_fourth(parameters: Mapping[str, float], torque_nm: Array, dt_s: float) -> Array:
    """Angle (n,) rad of the knob, from rest at 0, under a torque held from sample i to i + 1."""
    move, push = hold_matrices(*network(parameters), dt_s)
    return respond_linear(move, push, torque_nm)[0]


def respond_with_slopes(
    parameters: Mapping[str, float], torque_nm: Array, dt_s: float, by: Array
) -> tuple[Array, Array]:
    """`respond_fourth`, and its derivatives (n, p) by what moves the logarithms of the parameters as ``by`` (6, p)."""
    matrices, pushes = network_slopes(parameters)
    moves = np.tensordot(by.T, matrices, axes=1), by.T @ pushes
    return respond_linear(*hold_matrices(*network(parameters), dt_s, *moves), torque_nm)


NAME = "fourth_order"
REACH = log(1e4)  # how far from its start a parameter may go
WORST = 1e12  # condition number beyond which the parameters' effects are one

# What is searched for: springs and dampers in series, as one, are told well; their ratio, finger to pad, is not.
SOUGHT = ("inertia", "finger_inertia", "damping", "stiffness", "damping_ratio", "stiffness_ratio")
# Where searches begin, too: ratios of damping and of stiffness, on either side of their equality and of one.
THIRD = 1.0 / 3.0
STARTS = ((4.0, 3.0), (1.2, 1.0), (1.0, 3.0), (3.0, 1.0), (THIRD, 1.0), (1.0, THIRD), (100.0, 30.0), (30.0, 100.0))
FARTHEST = log(100.0)  # a ratio's logarithm where a search begins: the valleys are flat beyond
STEPS, ENOUGH = 25, 1e-5  # of a search whose end is only compared; a share of the sum of squares


def fourth_order(
    motion: Motion,
    *,
    inertia: float | None = None,
    finger_inertia: float | None = FINGER_INERTIA,
    start: Mapping[str, float] | None = None,
) -> Fit:
    """Finger and fingerpad (and inertias) by the least squares of measured less modelled angle.

    ``inertia``: the knob's own in kg·m², with what moves with it, and ``finger_inertia``: known, or None to fit them.
    ``start``: first values by name; by default the second-order fit's, in the 10:1 split of Section 4.4.1, and others.
    Standard errors as of `output_error`, or larger where `nearest.spread` finds more that fits as well. Not
    identifiable: a standard error above the value, or three times the value or a third of it that fits as well; a
    value that ran away from its start by 10,000; or all, where their effects are numerically one.

    Of 730 synthetic pulses of 60 ms (ratios 1 to 100 and beyond, noise 2 to 100 µrad, the knob's inertia known or not),
    2063 of 3285 numbers were told, and their intervals held the truth in 96.7 %: 93 to 100 % by noise, by knowledge of
    the inertia, and by whether K1/K2 = B1/B2. With the finger's inertia alone free, in 96 % of 112; with neither
    inertia known in 82 % of the 90 told of 522, which is flagged.
    """
    known = {"inertia": inertia, "finger_inertia": finger_inertia}
    names = tuple(name for name in ORDER if known.get(name) is None)
    why = blank(motion)
    if why:
        return unidentified(NAME, names, why)
    first = dict(start) if start else _first(motion, known)
    if not first:
        return unidentified(NAME, names, "the torque moves nothing: nothing can be identified")
    searched = tuple(name for name in SOUGHT if known.get(name) is None)
    fixed = {name: value for name, value in known.items() if value is not None}

    def parts(p: Array) -> dict[str, float]:
        return {**fixed, **_parts(dict(zip(searched, np.exp(p), strict=True)))}

    def answer(p: Array) -> tuple[Array, Array]:
        here = parts(p)
        return respond_with_slopes(here, motion.torque_nm, motion.dt_s, _slopes(here, searched))

    def elsewhere(fit: Callable[..., Minimum], begin: Array) -> list[Minimum]:
        def turned(p: Array, ratios: tuple[float, float], heavier: float = 0.0) -> Minimum:
            near = tuple(min(max(ratio, -FARTHEST), FARTHEST) for ratio in ratios)
            return fit(_turned(p, searched, parts, near, heavier), steps=STEPS, enough=ENOUGH)

        found = [fit(begin, steps=STEPS, enough=ENOUGH)]
        found += [turned(begin, (log(a), log(b))) for a, b in STARTS]
        best = min(found, key=cost).parameters
        a, b = (best[searched.index(name)] for name in ("damping_ratio", "stiffness_ratio"))
        # The same relaxation with the ratios' order reversed, the same springs with finger and pad exchanged, and both.
        for ratios in ((a, 2.0 * a - b), (-a, -b), (-a, b - 2.0 * a)):
            found += [turned(best, ratios, more) for more in ((0.0, 1.0, -1.0) if finger_inertia is None else (0.0,))]
        return found

    begin = np.log([_sought(first)[name] for name in searched])
    found = nearest(motion, answer, begin, lowest=begin - REACH, highest=begin + REACH, elsewhere=elsewhere)
    return _fit(motion, found, names, searched, parts, begin)


def _fit(
    motion: Motion,
    found: Nearest,
    names: tuple[str, ...],
    searched: tuple[str, ...],
    parts: Callable[[Array], dict[str, float]],
    begin: Array,
) -> Fit:
    explained, white = vaf(motion.angle_rad, found.angle_rad), whiteness(found.residuals)
    bad = misfit(white, explained, found.rms_rad, motion)
    part = np.zeros_like(found.covariance)
    if bad:
        total, part, more = widen(found.covariance, found.slopes, found.residuals, white)
        bad, found = (*bad, *more), found._replace(covariance=total)
    here = parts(found.parameters)
    by = _slopes(here, searched)
    stuck = np.abs(found.parameters - begin) > REACH - 1e-6
    worst = condition(found.slopes)
    estimates, doubts, shares = {}, [], []
    for name in names:

        def logarithm(p: Array, name: str = name) -> tuple[float, Array]:
            at = parts(p)
            return log(at[name]), _slopes(at, searched)[ORDER.index(name)]

        row = by[ORDER.index(name)]
        ran = bool(np.any(stuck & (row != 0.0)))
        own = sqrt(max(float(row @ found.covariance @ row), 0.0))
        share = own if ran or not worst < WORST else spread(found, logarithm)
        value, std = here[name], here[name] * share
        sure = bool(isfinite(std) and std < value and not ran and worst < WORST)
        if not sure:
            reason = f"{value:.2g} ± {here[name] * own:.2g}"
            if ran:
                reason = "it ran to the end of its range"
            elif own < 1.0:
                reason += ", an error that is too small: what is far from it fits as well"
            doubts.append(f"{name} is not identifiable from this motion: {reason}")
        own_part = here[name] * sqrt(max(float(row @ part @ row), 0.0)) if bad else 0.0
        estimates[name] = Estimate(float(value), float(std), sure, min(own_part, float(std)))
        shares.append((value, own, share))
    if len(names) == len(ORDER):
        doubts.append("neither inertia is known: intervals have been too narrow in one of five synthetic cases")
    if not worst < WORST:
        doubts.append(f"the parameters' effects are numerically one (condition number {worst:.1g})")
    index = [ORDER.index(name) for name in names]
    scale = np.array([value * (share / own if own > 0.0 and isfinite(share) else 1.0) for value, own, share in shares])
    covariance = by[index] @ found.covariance @ by[index].T * np.outer(scale, scale)
    flags = () if found.converged else ("the search did not converge",)
    return Fit(
        NAME,
        estimates,
        explained,
        white,
        (*flags, *bad, *doubts),
        rms_rad=found.rms_rad,
        offset_rad=found.offset_rad,
        covariance=tuple(map(tuple, covariance.tolist())),
    )


def _turned(
    p: Array,
    searched: tuple[str, ...],
    parts: Callable[[Array], dict[str, float]],
    ratios: tuple[float, ...],
    heavier: float,
) -> Array:
    """Another start: with these logarithms of the ratios, and a finger heavier by that much of a logarithm.

    A finger that moves with a share 1/(1 + ratio) of the knob's velocity adds the square of it of its inertia: the knob
    has what is left of the whole, if it is searched for.
    """
    other = p.copy()
    other[searched.index("damping_ratio")], other[searched.index("stiffness_ratio")] = ratios
    if "finger_inertia" in searched:
        other[searched.index("finger_inertia")] += heavier
    if "inertia" in searched:
        was, now = (parts(one[: len(searched)]) for one in (p, other))  # the rest angle is last
        carried = [
            one["finger_inertia"] * (one["pad_damping"] / (one["pad_damping"] + one["finger_damping"])) ** 2
            for one in (was, now)
        ]
        whole = was["inertia"] + carried[0]
        other[searched.index("inertia")] = log(max(whole - carried[1], 0.3 * whole))
    return other


def _parts(sought: Mapping[str, Any]) -> dict[str, Any]:
    """Finger and pad from series and ratio, beside what else is there."""
    found = {name: sought[name] for name in ("inertia", "finger_inertia") if name in sought}
    for kind in ("damping", "stiffness"):
        whole, ratio = sought[kind], sought[f"{kind}_ratio"]
        found[f"finger_{kind}"], found[f"pad_{kind}"] = whole * (1.0 + ratio), whole * (1.0 + ratio) / ratio
    return found


def _slopes(parts: Mapping[str, float], searched: tuple[str, ...]) -> Array:
    """Derivatives (6, p) of the parts' logarithms, in their `ORDER`, by the logarithms of what is searched for."""
    by = np.zeros((len(ORDER), len(SOUGHT)))
    by[0, 0] = by[1, 1] = 1.0
    for k, kind in enumerate(("damping", "stiffness")):
        finger, pad = parts[f"finger_{kind}"], parts[f"pad_{kind}"]
        by[[2 + k, 4 + k], 2 + k] = 1.0
        by[2 + k, 4 + k], by[4 + k, 4 + k] = finger / (finger + pad), -pad / (finger + pad)
    return by[:, [SOUGHT.index(name) for name in searched]]


def _sought(parts: Mapping[str, float]) -> dict[str, float]:
    found = {name: parts[name] for name in ("inertia", "finger_inertia") if name in parts}
    for kind in ("damping", "stiffness"):
        finger, pad = parts[f"finger_{kind}"], parts[f"pad_{kind}"]
        found[kind], found[f"{kind}_ratio"] = finger * pad / (finger + pad), finger / pad
    return found


def _first(motion: Motion, known: Mapping[str, float | None]) -> dict[str, float]:
    second = output_error(motion).parameters
    whole, damping, stiffness = (second[name].value for name in ("inertia", "damping", "stiffness"))
    if not whole > 0.0:
        return {}
    tip = known["finger_inertia"] or FINGER_INERTIA
    knob = known["inertia"] or max(whole - tip, 0.5 * whole)
    floor = 1e-3 * whole / (len(motion.angle_rad) * motion.dt_s)
    parts = split(max(damping, floor), max(stiffness, floor))
    return {"inertia": knob, "finger_inertia": tip, **parts}
