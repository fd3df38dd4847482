"""One recorded trial: its pulse or other input, the exact motion, and what the apparatus makes of it.

The apparatus that a plan describes: sample clock, encoder, motor and amplifier, knobs and grip cell, each with what is
not ideal about it.

Inputs other than a pulse are step, ramp, sinusoid, chirp, noise and pseudorandom binary sequence (Hasser, sec. 2.1).
Each is a torque that is held from sample to sample, as high as moves the mean hand of a grip by 0.09 rad at the most.
A virtual hand has neither reflexes nor will, which the text names as the price of long inputs. The torque pulse takes
20 ms, and is as high.
"""

from dataclasses import dataclass, fields, replace
from functools import cache
from math import isfinite, pi
from typing import Any, NamedTuple

import numpy as np

from hknob_cli.apparatus.hand import SLIDING, Hand, Mechanism, SecondOrder, follow, mechanism
from hknob_cli.apparatus.people import mean_hand
from hknob_cli.engine.propagator import hold_coefficients
from hknob_cli.engine.turning import first_zero
from hknob_cli.errors import UsageError
from hknob_cli.recordings.trial import Array, Key, Purpose, Trial, stream
from hknob_cli.specs.identification import InputPlan, SysidPlan

_POSITIVE = ("sample_rate_hz", "small_knob_kg_m2", "medium_knob_kg_m2", "grip_ramp_s", "trigger_share", "after_s")


@dataclass(frozen=True, kw_only=True)
class Rig:
    """Numbers of the apparatus, in SI units; every nuisance is off at 0.

    Printed (Chapters 3 and 4, Appendices A and C): ``sample_rate_hz``; ``counts_per_rev`` of the encoder (0: no
    quantisation), which rounds down; the inertia (kg·m²) of the turning parts with the small (17.8 mm) and the medium
    (29.9 mm) knob; ``coulomb_nm``, friction of motor and bearings; ``amplifier_s``, time constant of a first-order lag,
    a quarter of the 200 µs in which the current settles. The inertias are for hands of fourth order; a hand of second
    order has hand and apparatus in one, as tabled.

    Assumed, since not printed: ``torque_error``, by which share the torque exceeds the commanded one;
    ``angle_noise_rad``, rms of the encoder before it rounds; ``grip_noise_n``, rms of the grip cell;
    ``grip_ramp_s``, how long a squeeze takes from nothing to the target; ``posture_rad``, within which the
    neutral angle of the hand lies on either side of 0, at random; ``preload``, up to which share of the friction level
    the hand pulls at the knob that friction holds before the pulse. ``trigger_share`` of the target is the threshold
    that fires the pulse. ``torque_noise_nm`` is the rms noise of a torque sensor, None if there is none: the
    printed one was of no use. It reads the motor's torque; with ``torque_sees_friction`` it carries the motor, as the
    printed one did, and reads that torque less what friction takes of it. ``acceleration_noise`` is the rms noise
    (rad/s²) of an accelerometer on the knob, None if there is none, as in print. ``before_s`` and ``after_s`` the
    onset are recorded.

    Raises `UsageError` for a number out of range.
    """

    sample_rate_hz: float = 10_000.0
    counts_per_rev: int = 640_000
    small_knob_kg_m2: float = 19.8e-7
    medium_knob_kg_m2: float = 32.7e-7
    coulomb_nm: float = 0.56e-3
    amplifier_s: float = 50e-6
    torque_error: float = 0.0
    angle_noise_rad: float = 2e-6
    grip_noise_n: float = 0.01
    grip_ramp_s: float = 1.0
    posture_rad: float = 0.05
    preload: float = 0.0
    trigger_share: float = 1.0
    torque_noise_nm: float | None = None
    torque_sees_friction: bool = False
    acceleration_noise: float | None = None
    before_s: float = 5e-3
    after_s: float = 60e-3

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            positive = field.name in _POSITIVE
            least = -1.0 if field.name == "torque_error" else 0.0
            if value is None and field.name in ("torque_noise_nm", "acceleration_noise"):
                continue
            if not isfinite(value) or value < least or (positive and value == 0.0):
                raise UsageError(f"rig: {field.name} must be {'> 0' if positive else f'>= {least:g}'}, got {value:g}")
        if self.preload > 1.0:
            raise UsageError(f"rig: preload must be <= 1, got {self.preload:g}")

    @classmethod
    def ideal(cls) -> "Rig":
        """An apparatus without any nuisance but the encoder's steps; those that are off by default stay off."""
        return cls(coulomb_nm=0.0, amplifier_s=0.0, angle_noise_rad=0.0, grip_noise_n=0.0, posture_rad=0.0)

    @property
    def interval_s(self) -> float:
        """Time from sample to sample."""
        return 1.0 / self.sample_rate_hz

    @property
    def count_rad(self) -> float:
        """Angle of a count; 0 without quantisation."""
        return 2.0 * pi / self.counts_per_rev if self.counts_per_rev else 0.0


def virtual_rig(plan: SysidPlan) -> Rig:
    """The apparatus: as printed, or ideal, except for what is given. Raises `UsageError` for a number out of range."""
    assert plan.virtual is not None
    given: dict[str, Any] = dict(plan.virtual.rig)
    return replace(Rig.ideal() if plan.virtual.ideal else Rig(), **given)


_NOISE = 3  # of the bench's random streams
_REGISTER = 9  # bits: 511 chips before a sequence repeats


def unit_input(one: InputPlan, interval_s: float) -> Array:
    """The input at every sample (n,), its largest value 1."""
    time: Array = interval_s * np.arange(round(one.duration_s / interval_s), dtype=np.float64)
    which = np.floor(time / one.chip_s * (1.0 + 1e-12)).astype(int)
    rate = (one.to_hz - one.from_hz) / one.duration_s
    found: Array
    if one.kind == "step":
        found = np.ones_like(time)
    elif one.kind == "ramp":
        found = (np.arange(time.size) + 1.0) / time.size
    elif one.kind == "sine":
        found = np.sin(2.0 * np.pi * one.from_hz * time)
    elif one.kind == "chirp":
        found = np.sin(2.0 * np.pi * (one.from_hz + 0.5 * rate * time) * time)
    elif one.kind == "prbs":
        found = binary_sequence(int(which[-1]) + 1)[which]
    else:
        drawn = stream(0, Purpose.BENCH, _NOISE).standard_normal(int(which[-1]) + 1)
        found = (drawn / np.max(np.abs(drawn)))[which]
    return found


def binary_sequence(length: int) -> Array:
    """A maximal-length sequence of 1 and -1, by a shift register with the polynomial x^9 + x^5 + 1."""
    register = [1] * _REGISTER
    found = np.empty(length)
    for i in range(length):
        found[i] = 2.0 * register[-1] - 1.0
        register = [register[8] ^ register[4], *register[:-1]]
    return found


@cache
def scaled_input(one: InputPlan, hand: SecondOrder, interval_s: float, peak_rad: float) -> Array:
    """The input as torque (n,), N·m, at which a hand that nothing disturbs turns by ``peak_rad`` (rad) at the most."""
    shape = unit_input(one, interval_s)
    body = mechanism(hand)
    angle = follow(body, body.rest(0.0), runs(shape), interval_s)[:, 0]
    scaled: Array = shape * (peak_rad / float(np.max(np.abs(angle))))
    return scaled


def runs(values: Array) -> list[tuple[float, int]]:
    """Values (n,) as stretches of one value, with their lengths."""
    ends = np.flatnonzero(np.diff(values)) + 1
    starts = np.concatenate(([0], ends))
    counts = np.diff(np.concatenate((starts, [len(values)])))
    return [(float(values[at]), int(count)) for at, count in zip(starts, counts, strict=True)]


DURATION_S = 0.02  # section 4.2.1
PEAK_RAD = 0.09  # the middle of 0.07 - 0.11 rad, ibid.

_REACH = 6.0  # standard deviations of the grip cell's noise: the ramp starts that far below the threshold


class Pulse(NamedTuple):
    """A commanded torque (N·m) for a time (s), from the sample on that fires it."""

    torque_nm: float
    duration_s: float = DURATION_S


def peak_per_torque(hand: SecondOrder, duration_s: float = DURATION_S) -> float:
    """Largest angle (rad) that a hand at rest goes through for each N·m of a pulse, without friction or lag.

    Exact: the turning point during the pulse if there is one, else that after it.
    """
    alpha, beta, drive = hand.damping / hand.inertia, hand.stiffness / hand.inertia, 1.0 / hand.inertia
    turning = float(first_zero(0.0, drive, alpha, beta))
    if turning < duration_s:
        return float(hold_coefficients(alpha, beta, turning)[1]) * drive
    s, g, _ = hold_coefficients(alpha, beta, duration_s)
    x, v = g * drive, s * drive
    left = float(first_zero(v, -beta * x, alpha, beta))
    s, g, _ = hold_coefficients(alpha, beta, left)
    return float(x + s * v - g * beta * x)


@cache
def scaled_pulse(experiment: int, grip_n: float, *, peak_rad: float = PEAK_RAD) -> Pulse:
    """The pulse of an experiment at a grip (N). Raises `UsageError` if that is not in its table.

    Friction is not allowed for: with that of the apparatus the peaks are lower, and still within 0.07 - 0.11 rad.
    """
    return Pulse(peak_rad / peak_per_torque(mean_hand(experiment, grip_n)))


def record_trial(rig: Rig, hand: Hand, pulse: Pulse | Array, key: Key, rng: np.random.Generator) -> Trial:
    """Record a pulse on a hand, from before its onset, which is at ``rig.before_s``, to after it.

    Or another torque (n,), N·m, sample by sample: then the grip is held at its threshold.

    Torque of a row is commanded from that sample to the next; angle and grip are read just before. The angle is a whole
    number of counts, rounded down. ``rng`` is drawn from in an order that does not depend on the hand.
    """
    before, after = (round(time * rig.sample_rate_hz) for time in (rig.before_s, rig.after_s))
    samples = before + after + 1
    pulsed = isinstance(pulse, Pulse)
    if isinstance(pulse, Pulse):
        commanded = np.full(min(round(pulse.duration_s * rig.sample_rate_hz), after), pulse.torque_nm)
    else:
        commanded = pulse[:after]
    pushed = len(commanded)
    posture, loaded = rig.posture_rad * rng.uniform(-1.0, 1.0), rig.preload * rng.uniform(-1.0, 1.0)
    noise = rng.standard_normal(samples)
    body = mechanism(hand, coulomb=rig.coulomb_nm, lag_s=rig.amplifier_s)
    start = body.rest(loaded * rig.coulomb_nm)
    acts = [((1.0 + rig.torque_error) * torque, count) for torque, count in runs(commanded)]
    stretches = [(0.0, before), *acts, (0.0, after - pushed)]
    states = follow(body, start, [one for one in stretches if one[1] > 0], rig.interval_s)
    torque = np.zeros(samples)
    torque[before : before + pushed] = commanded
    angle = posture + states[:, 0] + rig.angle_noise_rad * noise
    measured = None
    grip = squeeze(rig, key.grip_target_n, before, samples, rng, held=not pulsed)
    if rig.torque_noise_nm is not None:
        acting = states[:, -1] if rig.amplifier_s > 0.0 else (1.0 + rig.torque_error) * torque
        if rig.torque_sees_friction:
            acting = acting - taken_by_friction(body, states, acting)
        measured = acting + rig.torque_noise_nm * rng.standard_normal(samples)
    felt = None
    if rig.acceleration_noise is not None:
        felt = _accelerated(body, states, before_torque(rig, states, torque))
        felt = felt + rig.acceleration_noise * rng.standard_normal(samples)
    return Trial(
        key=key,
        time_s=np.arange(samples) / rig.sample_rate_hz,
        torque_nm=torque,
        angle_rad=np.floor(angle / rig.count_rad) * rig.count_rad if rig.count_rad else angle,
        grip_n=grip,
        measured_torque_nm=measured,
        acceleration_rad_s2=felt,
    )


def before_torque(rig: Rig, states: Array, commanded: Array) -> Array:
    """Motor's torque (n,), N·m, at each sample just before its ``commanded`` torque (n,) acts."""
    return states[:, -1] if rig.amplifier_s > 0.0 else (1.0 + rig.torque_error) * np.append(0.0, commanded[:-1])


def _accelerated(body: Mechanism, states: Array, acting: Array) -> Array:
    """Acceleration (n,), rad/s², of the knob under a motor's torque (n,), N·m."""
    order = len(body.entry) // 2 * 2
    net = (acting - taken_by_friction(body, states, acting)) / body.inertia
    return np.asarray(net + states[:, :order] @ body.rates[SLIDING, 1, :order])


def taken_by_friction(body: Mechanism, states: Array, acting: Array) -> Array:
    """Friction torque (n,), N·m, at each state (n, order): its level against the motion, or what holds the knob still.

    ``acting``: the motor's torque (n,). A knob that turns round in a sample counts as it moves after it.
    """
    order = len(body.entry) // 2 * 2  # without the torque that lags
    hand = -body.inertia * states[:, :order] @ body.rates[SLIDING, 1, :order]
    speed = states[:, 1]
    return np.where(speed != 0.0, body.coulomb * np.sign(speed), np.clip(acting - hand, -body.coulomb, body.coulomb))


def squeeze(
    rig: Rig, target_n: float, before: int, samples: int, rng: np.random.Generator, *, held: bool = False
) -> Array:
    """Measured grip force (N): a ramp with noise, cut so that sample ``before`` is the first at the threshold or above.

    The ramp goes on through the pulse, which is over before a hand can answer; or it ends at the threshold, ``held``.
    Nothing is held for a target of 0.
    """
    threshold, rate = rig.trigger_share * target_n, target_n / rig.grip_ramp_s * rig.interval_s
    if rate == 0.0:
        return rig.grip_noise_n * rng.standard_normal(samples)
    climb = int(np.ceil(2.0 * _REACH * rig.grip_noise_n / rate)) + 1
    total = before + climb + samples
    steps = np.arange(total) - before - climb // 2
    force = threshold + rate * (np.minimum(steps, 0) if held else steps) + rig.grip_noise_n * rng.standard_normal(total)
    fired = before + int((force[before:] >= threshold).argmax())
    return force[fired - before : fired - before + samples]
