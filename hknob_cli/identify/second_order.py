"""The second-order model: its answer to a recorded torque, and first guesses of its inertia, damping and stiffness.

A first guess needs no derivative: it is of the equation of motion, integrated twice. A single guess will not do: the
search from one that is a period off ends there. So all terms of the equation pass the same low-pass of several
cutoffs, and each solution is a place to begin.
"""

from collections.abc import Mapping
from math import exp
from typing import NamedTuple

import numpy as np

from hknob_cli.engine.pulse import Coefficients, Pull
from hknob_cli.identify.motion import Motion, differentiate, low_pass
from hknob_cli.recordings.trial import Array

RAMP = 1e-7  # per sample: what is left of a straight line's curvature


class Plant(NamedTuple):
    """Inertia kg·m², damping N·m·s/rad, stiffness N·m/rad, Coulomb friction N·m: of hand and apparatus together."""

    inertia: float
    damping: float
    stiffness: float
    coulomb: float = 0.0


class Start(NamedTuple):
    """Where a motion begins: angle rad from the spring's rest, and velocity rad/s."""

    angle_rad: float = 0.0
    velocity_rad_s: float = 0.0


AT_REST = Start()


def respond(
    plant: Plant,
    torque_nm: Array,
    dt_s: float,
    *,
    lag_s: float = 0.0,
    friction: bool = False,
    ramps: bool = False,
    start: Start = AT_REST,
) -> Array:
    """Angle (n,) rad at every sample, from rest at 0 or ``start``, under a torque held from sample i to i + 1.

    ``lag_s``: time constant of a first-order lag between command and torque. ``ramps``: the torque is not held, but
    runs straight from sample to sample, without a lag. ``friction``: its turns are followed even
    where ``coulomb`` is 0. Exact from turn to turn, with friction and a lag, too.
    """
    return respond_with_slopes(plant, torque_nm, dt_s, lag_s=lag_s, friction=friction, ramps=ramps, start=start)[0]


def respond_with_slopes(
    plant: Plant,
    torque_nm: Array,
    dt_s: float,
    *,
    lag_s: float = 0.0,
    friction: bool = False,
    ramps: bool = False,
    start: Start | None = None,
) -> tuple[Array, Array]:
    """As `respond`; and derivatives (n, 4) of the angle by log inertia, damping, stiffness and Coulomb friction.

    With a ``start``, (n, 6): by its angle and velocity, too.
    """
    from hknob_cli.engine.jit import compiled

    kernels = compiled("pulse")
    torque = np.ascontiguousarray(torque_nm, dtype=float)
    gain = dt_s * dt_s / plant.inertia
    alpha, beta, phi = plant.damping * dt_s / plant.inertia, plant.stiffness * gain, plant.coulomb * gain
    angle, slopes = np.empty(len(torque)), np.zeros((len(torque), 3 if start is None else 5))
    friction = friction or plant.coulomb > 0.0
    first, speed = start or AT_REST
    speed *= dt_s
    decay, fading = _fading(torque, dt_s / lag_s if lag_s > 0.0 else 0.0, ramps=ramps)
    if decay > 0.0:
        torque = torque - fading if ramps else torque
    with np.errstate(over="ignore", invalid="ignore"):
        follow = kernels["follow_with_friction" if friction else "follow_torque"]
        follow(Pull(torque, fading, decay), Coefficients(gain, alpha, beta, phi), first, speed, angle, slopes)
        by_alpha, by_beta, by_phi = slopes.T[:3]
        # The response is of first degree in torque, friction and start together: gain d/dgain + phi d/dphi
        # + first d/dfirst + speed d/dspeed leaves it as is.
        forced = angle if start is None else angle - first * slopes[:, 3] - speed * slopes[:, 4]
        by = np.empty((len(torque), 4 if start is None else 6))
        by[:, 0] = -(forced + alpha * by_alpha + beta * by_beta)
        by[:, 1], by[:, 2], by[:, 3] = by_alpha * (dt_s / plant.inertia), by_beta * gain, by_phi * gain
        if start is not None:
            by[:, 4], by[:, 5] = slopes[:, 3], slopes[:, 4] * dt_s
    return angle, by


def _fading(torque: Array, decay: float, *, ramps: bool) -> tuple[float, Array]:
    """Decay per sample and part (n,) of the torque that decays so in each hold, of ramps or of a lag (0: none).

    A straight line is the end of a slow exponential: with `RAMP` per sample it is met to that share of its rise.
    """
    if ramps:
        return RAMP, np.append(torque[:-1] - torque[1:], 0.0) / RAMP
    return (decay, lagged_part(torque, decay)) if decay > 0.0 else (0.0, np.empty(0))


def lagged_part(torque_nm: Array, decay: float) -> Array:
    """What a lag adds to the command at the start of each hold: (n,) N m, decaying by exp(-decay) over the hold."""
    from scipy.signal import lfilter

    keep = exp(-decay)
    reached = lfilter([0.0, 1.0 - keep], [1.0, -keep], torque_nm)
    return np.asarray(reached - torque_nm, dtype=float)


FACTORS = (1, 2, 4, 8, 16, 32, 64, 128)  # of the sample rate, that the low-pass leaves
FEWEST = 12  # samples that are left of the narrowest
MOST = 4  # places to begin
TERMS = ("inertia", "damping", "stiffness")


class Begin(NamedTuple):
    """Where a search begins: the plant, its first state, and the rest angle."""

    plant: Plant
    start: Start
    rest_rad: float


def running_starts(
    motion: Motion, known: Mapping[str, float], *, coulomb_nm: float = 0.0, lag_s: float = 0.0
) -> list[Begin]:
    """Places to begin, that with the smallest residual first; none if all solutions have an inertia below zero.

    ``known``: parameters by name that are not searched for.
    """
    found: list[tuple[float, Begin]] = []
    for factor in FACTORS:
        if factor > 1 and len(motion.angle_rad) < FEWEST * factor:
            break
        plant = _solved(motion, factor, known, coulomb_nm)
        if plant is not None:
            left, begin = _begun(motion, plant, lag_s)
            if np.isfinite(left):
                found.append((left, begin))
    found.sort(key=lambda one: one[0])
    return [begin for _, begin in found[:MOST]]


def at_samples(motion: Motion) -> Array:
    """Torque at the samples: of one that is held between them the mean of before and after."""
    torque = motion.torque_nm
    if motion.ramps:
        return torque
    mean: Array = 0.5 * (torque + np.concatenate([torque[:1], torque[:-1]]))
    return mean


def _solved(motion: Motion, factor: int, known: Mapping[str, float], coulomb_nm: float) -> Plant | None:
    """J a + B v + K x = T + constant by least squares of low-passed terms, friction known taken off."""
    angle, torque = low_pass(motion.angle_rad, factor), low_pass(at_samples(motion), factor)
    velocity = differentiate(angle, motion.dt_s)
    terms = {"inertia": differentiate(velocity, motion.dt_s), "damping": velocity, "stiffness": angle}
    if coulomb_nm:
        torque = torque - coulomb_nm * np.sign(velocity)
    torque = torque - sum(known[one] * terms[one] for one in TERMS if one in known)
    free = [one for one in TERMS if one not in known]
    inside = slice(2 * factor, -2 * factor)
    table = np.stack([*(terms[one] for one in free), np.ones_like(angle)], axis=1)[inside]
    lengths = np.sqrt(np.sum(table * table, axis=0))
    if not np.all(lengths > 0.0):
        return None
    solved = np.linalg.lstsq(table / lengths, torque[inside], rcond=None)[0] / lengths
    values = {one: known[one] for one in TERMS if one in known} | dict(zip(free, map(float, solved), strict=False))
    if not values["inertia"] > 0.0:
        return None
    for one in ("damping", "stiffness"):
        if one not in known:
            values[one] = max(values[one], 0.0)
    return Plant(values["inertia"], values["damping"], values["stiffness"], coulomb_nm)


def _begun(motion: Motion, plant: Plant, lag_s: float) -> tuple[float, Begin]:
    """Sum of squares left by a plant whose first state and rest angle fit best."""
    start = Start() if not motion.free_start else Start(0.0, _first_velocity(motion))
    rest = 0.0
    for _ in range(2 if plant.coulomb else 1):
        angle, slopes = respond_with_slopes(
            plant, motion.torque_nm, motion.dt_s, lag_s=lag_s, ramps=motion.ramps, start=start
        )
        state = slopes[:, 4:] if plant.stiffness else slopes[:, 5:]
        table = np.column_stack([*(state.T if motion.free_start else ()), np.ones_like(angle)])
        if not (np.all(np.isfinite(angle)) and np.all(np.isfinite(table))):
            return np.inf, Begin(plant, start, rest)
        better = np.linalg.lstsq(table, motion.angle_rad - angle, rcond=None)[0]
        rest = float(better[-1])
        if motion.free_start:
            first = start.angle_rad + float(better[0]) if plant.stiffness else 0.0
            start = Start(first, start.velocity_rad_s + float(better[-2]))
    left = motion.angle_rad - angle - table @ better
    return float(left @ left), Begin(plant, start, rest)


def best_motion(motion: Motion, plant: Plant) -> tuple[Array, Array]:
    """Angle (n,) of a plant from the first state that fits best, its rest angle added, and its slopes (n, 6)."""
    begin = _begun(motion, plant, 0.0)[1]
    angle, slopes = respond_with_slopes(
        plant, motion.torque_nm, motion.dt_s, ramps=motion.ramps, start=begin.start, friction=plant.coulomb > 0.0
    )
    return angle + begin.rest_rad, slopes


def _first_velocity(motion: Motion) -> float:
    few = max(2, min(10, len(motion.angle_rad) // 10))
    return float(motion.angle_rad[few] - motion.angle_rad[0]) / (few * motion.dt_s)


def integrated_start(motion: Motion) -> Plant:
    """Least squares of J x + B int x + K int int x = int int T: no derivative, so little noise. From rest.

    Torque is integrated exactly (it is held), the angle by the trapezoidal rule. Inertia at least what a free body
    would need to have moved so far; all zero if there is no torque or no motion.
    """
    dt, torque, angle = motion.dt_s, motion.torque_nm, motion.angle_rad
    impulse = np.concatenate(([0.0], np.cumsum(torque)[:-1])) * dt
    pushed = np.concatenate(([0.0], np.cumsum(impulse[:-1] * dt + 0.5 * dt * dt * torque[:-1])))
    once = np.concatenate(([0.0], np.cumsum(0.5 * dt * (angle[1:] + angle[:-1]))))
    twice = np.concatenate(([0.0], np.cumsum(0.5 * dt * (once[1:] + once[:-1]))))
    columns = np.stack([angle, once, twice], axis=1)
    lengths = np.sqrt(np.sum(columns * columns, axis=0))
    if not np.any(torque) or not np.all(lengths > 0.0):
        return Plant(0.0, 0.0, 0.0)
    solved = np.linalg.lstsq(columns / lengths, pushed, rcond=None)[0] / lengths
    floor = 0.02 * float(np.max(np.abs(pushed[: 1 + int(np.argmax(np.abs(angle)))]))) / float(np.max(np.abs(angle)))
    return Plant(max(float(solved[0]), floor), max(float(solved[1]), 0.0), max(float(solved[2]), 0.0))
