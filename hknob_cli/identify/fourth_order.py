"""The fourth-order hand: finger to ground, fingerpad between finger and knob; fitted by its exact motion.

Section 4.4.1, Figs 13 and 14. The network of Equation 1 gives -(B1 + B2)/J1 as the last element of Equation 2, which
prints -(B1 - B2). All parameters are positive and fitted as logarithms. A 20 ms pulse tells few of them apart:
those that it does not are said not to be identifiable, whatever number comes out.
"""

from collections.abc import Mapping
from math import isfinite, log
from typing import Any

import numpy as np

from hknob_cli.identify.covariance import condition
from hknob_cli.identify.fit import Estimate, Fit
from hknob_cli.identify.linear_motion import hold_matrices, respond_linear
from hknob_cli.identify.motion import Motion
from hknob_cli.identify.nearest import nearest
from hknob_cli.identify.output_error import output_error
from hknob_cli.identify.quality import blank, misfit, unidentified, vaf, whiteness
from hknob_cli.recordings.trial import Array

NAME = "fourth_order"
ORDER = ("inertia", "finger_inertia", "finger_damping", "finger_stiffness", "pad_damping", "pad_stiffness")
FINGER_INERTIA = 3.0e-7  # Section 4.4.1: "a generous estimate"
SPLIT = 10.0  # Section 4.4.1: K1 = 10 K2, B1 = 10 B2
REACH = log(1e4)  # how far from its start a parameter may go
WORST = 1e12  # condition number beyond which the parameters' effects are one
BENT = 2.0  # how many times too small a standard error may be, by the profile of the sum of squares

# What is searched for: springs and dampers in series, as one, are told well; their ratio, finger to pad, is not.
SOUGHT = ("inertia", "finger_inertia", "damping", "stiffness", "damping_ratio", "stiffness_ratio")


def network(parameters: Mapping[str, Any]) -> tuple[Any, Any]:
    """Matrix (4, 4) and input (4,) of knob angle, knob velocity, finger angle, finger velocity. Numbers may be complex.

    Source: Equation 1.
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
    move, push = hold_matrices([network(parameters)], dt_s)
    return respond_linear(move.real, push.real, torque_nm)[0]


def fourth_order(
    motion: Motion,
    *,
    inertia: float | None = None,
    finger_inertia: float | None = FINGER_INERTIA,
    start: Mapping[str, float] | None = None,
) -> Fit:
    """Finger and fingerpad (and inertias) by the least squares of measured less modelled angle.

    ``inertia``: the knob's own in kg·m², with what moves with it, and ``finger_inertia``: known, or None to fit them.
    ``start``: first values by name; by default the second-order fit's, in the 10:1 split of Section 4.4.1. Standard
    errors as of `output_error`. Not identifiable: a standard error above the value; one that the profile of the
    sum of squares shows to be less than half of what it is (`Nearest.misjudged`); a value that ran away from its start
    by 10,000; or all, where their effects are numerically one.
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

    def parts(p: Any) -> dict[str, Any]:
        return {**fixed, **_parts(dict(zip(searched, np.exp(p), strict=True)))}

    def answer(p: Array) -> tuple[Array, Array]:
        systems = [network(parts(p))]
        for k in range(len(p)):
            nudged = p.astype(complex)
            nudged[k] += 1e-30j
            systems.append(network(parts(nudged)))
        move, push = hold_matrices(systems, motion.dt_s)
        moves, pushes = move[1:].imag * 1e30, push[1:].imag * 1e30
        return respond_linear(move.real, push.real, motion.torque_nm, moves, pushes)

    begin = np.log([_sought(first)[name] for name in searched])
    found = nearest(motion, answer, begin, lowest=begin - REACH, highest=begin + REACH)
    here = parts(found.parameters)
    values = np.array([here[name] for name in names])
    by = np.empty((len(names), len(searched)))
    for k in range(len(searched)):
        nudged = found.parameters.astype(complex)
        nudged[k] += 1e-30j
        there = parts(nudged)
        by[:, k] = [np.imag(there[name]) * 1e30 for name in names]
    covariance = by @ found.covariance @ by.T
    worst = condition(found.slopes)
    with np.errstate(invalid="ignore"):
        spread = np.sqrt(np.diagonal(covariance))
    bent = np.array([found.misjudged(k, BENT) for k in range(len(searched))])
    stuck = np.abs(found.parameters - begin) > REACH - 1e-6
    estimates, doubts = {}, []
    reach = by * np.sqrt(np.abs(np.diagonal(found.covariance)))
    for name, value, std, moved, effect in zip(names, values, spread, np.abs(by) > 0.0, reach, strict=True):
        ran = bool(np.any(stuck & moved))
        curved = bool(np.any(bent & (np.abs(effect) > 0.1 * std)))
        sure = bool(isfinite(std) and std < value and not (ran or curved) and worst < WORST)
        estimates[name] = Estimate(float(value), float(std), sure)
        if not sure:
            reason = f"{value:.2g} ± {std:.2g}"
            if ran:
                reason = "it ran to the end of its range"
            elif curved and std < value:
                reason += ", an error that is too small: the fit hardly changes with it"
            doubts.append(f"{name} is not identifiable from this motion: {reason}")
    if not worst < WORST:
        doubts.append(f"the parameters' effects are numerically one (condition number {worst:.1g})")
    share, white = vaf(motion.angle_rad, found.angle_rad), whiteness(found.residuals)
    flags = () if found.converged else ("the search did not converge",)
    return Fit(
        NAME,
        estimates,
        share,
        white,
        (*flags, *misfit(white, share, found.rms_rad, motion), *doubts),
        rms_rad=found.rms_rad,
        offset_rad=found.offset_rad,
        covariance=tuple(map(tuple, covariance.tolist())),
    )


def _parts(sought: Mapping[str, Any]) -> dict[str, Any]:
    """Finger and pad from series and ratio, beside what else is there."""
    found = {name: sought[name] for name in ("inertia", "finger_inertia") if name in sought}
    for kind in ("damping", "stiffness"):
        whole, ratio = sought[kind], sought[f"{kind}_ratio"]
        found[f"finger_{kind}"], found[f"pad_{kind}"] = whole * (1.0 + ratio), whole * (1.0 + ratio) / ratio
    return found


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
