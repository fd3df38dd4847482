"""A virtual person, who holds the knob at the wall, or squeezes it until it pulses.

The text tells the course of a pulse (Hasser, section 4.2.1): after the beep the subject slowly squeezes; at the
threshold the pulse comes; the subject relaxes and waits for the next. The times, the overshoot of a grip that is to be
held and its wander are assumptions. Means and spread of the hand are those of Tables 1-5, drawn as for
`apparatus.experiment`; a hand between two rows lies on the straight line between them, because it follows the grip at
which the pulse comes.
"""

from functools import cache
from math import exp, log, log1p, pi, sin, sqrt
from typing import NamedTuple

import numpy as np

from hknob_cli.apparatus.hand import SecondOrder
from hknob_cli.apparatus.hand_recording import PEAK_RAD, peak_per_torque
from hknob_cli.apparatus.people import Place, Variation, grips, mean_hand, scaled_hand, subject_hand
from hknob_cli.errors import UsageError
from hknob_cli.hardware.order import Trial
from hknob_cli.hardware.port import Array, PulseOrder, Simulated, Sine, Squeeze
from hknob_cli.printed import Grasp, apparatus_inertia, grasps, table
from hknob_cli.recordings.trial import Purpose, stream
from hknob_cli.specs.campaign import Knob
from hknob_cli.specs.pulses import HELD, PulsePlan

PRINTED_TARGET_N = 0.71  # of the grip force in Chapter 8 (sec. 8.2)
TREMOR_HZ = (8.0, 12.0)  # physiological tremor: McAuley & Marsden 2000, Brain 123, 1545-1567
WANDER_HZ = (0.15, 1.0)  # an assumption: slower than vision corrects
STEADY_S = 2.0  # "1-3 seconds of sustained buzzing" (sec. 8.2): the part over which a trial's mean grip is taken

_DRAWS = 100  # of a push: each is good with a chance of about a half, or better
_GRIP, _PUSH, _ZERO = range(3)  # last number of each stream


class Person(NamedTuple):
    """Habits of a person; shares are rms values relative to the mean.

    Printed: the trial means of the grip force scatter as in Table 8 about a target of 0.71 N; for another target in
    proportion. Assumed, since not printed: ``grip_wander_share``, slow wander of the grip force within a trial (some
    percent of a light force held with sight of it: Jones, Hamilton & Wolpert 2002, J. Neurophysiol. 88, 1533-1544) and
    ``grip_tremor_share``; ``push_nm`` into the wall, by how much it differs from trial to trial (``push_cv``), wanders
    and trembles, for "bias torque was not controlled" (sec. 8.4); ``grip_rise_s``, and the spread of the cell's zero.

    Who pushes more weakly than friction feels no wall; "just enough torque to maintain contact" (sec. 8.2) is more. A
    push whose weakest moment is below friction is therefore drawn again, unless ``push_nm`` itself is no better.

    ``wandering_push`` and ``grip_wander`` off: the push is ``push_nm``, the grip ``grip_target_n``, in every trial.
    """

    push_nm: float = 1e-3
    grip_target_n: float = PRINTED_TARGET_N
    wandering_push: bool = True
    grip_wander: bool = True
    push_cv: float = 0.2
    push_wander_share: float = 0.1
    push_tremor_share: float = 0.03
    grip_wander_share: float = 0.02
    grip_tremor_share: float = 0.005
    grip_rise_s: float = 0.1
    zero_std_n: float = 0.1


def hold(person: Person, knob: Knob, *, seed: int, place: tuple[int, ...], angle_rad: float = 0.02) -> Simulated:
    """The knob, let go at ``angle_rad``, in the hand of a person in one trial.

    The hand is that of a simple pinch on the small knob (Table 1) at the mean grip force of the trial. ``place``: whole
    numbers >= 0 that tell the trial from all others, such as (sample rate, counts, repeat): the same ones draw the same
    trial under a seed, whatever other trials there are. Grip, push and zero have streams of their own.

    Raises `UsageError` if a number is out of range, or if knob and hand have no inertia together.
    """
    for name, value in (("push_nm", person.push_nm), ("grip_target_n", person.grip_target_n)):
        if not 0.0 <= value < float("inf"):
            raise UsageError(f"person: {name} must be >= 0, got {value:g}")
    grip, push = person.grip_target_n, person.push_nm
    grip_sines: tuple[Sine, ...] = ()
    push_sines: tuple[Sine, ...] = ()
    if person.grip_wander:
        grip, grip_sines = _grip(person, stream(seed, Purpose.PERSON, *place, _GRIP))
    if person.wandering_push:
        push, push_sines = _push(person, knob.coulomb_torque, stream(seed, Purpose.PERSON, *place, _PUSH))
    hand = hand_at(grip)
    inertia = knob.inertia + hand.inertia
    if inertia <= 0.0:
        what = f"knob and hand have no inertia together at a grip of {grip:.3g} N"
        raise UsageError(f"person: {what}: {inertia:.3g} kg·m²")
    return Simulated(
        inertia=inertia,
        damping=knob.damping + hand.damping,
        stiffness=hand.stiffness,
        coulomb_nm=knob.coulomb_torque,
        angle_rad=angle_rad,
        push_nm=push,
        grip_n=grip,
        grip_rise_s=person.grip_rise_s,
        grip_offset_n=person.zero_std_n * float(stream(seed, Purpose.PERSON, *place, _ZERO).standard_normal()),
        push_sines=push_sines,
        grip_sines=grip_sines,
    )


def hand_at(grip_n: float) -> Grasp:
    """Table 1's simple pinch at any grip force: straight lines between the rows, the first one also below 0.71 N.

    Raises `UsageError` above the firmest grip of the table.
    """
    rows = grasps(1)
    if not 0.0 <= grip_n <= rows[-1].grip_n:
        raise UsageError(f"the hand of Table 1 is known up to a grip of {rows[-1].grip_n:g} N, got {grip_n:g} N")
    above = next((i for i in range(1, len(rows)) if grip_n <= rows[i].grip_n), len(rows) - 1)
    low, high = rows[above - 1], rows[above]
    share = (grip_n - low.grip_n) / (high.grip_n - low.grip_n)
    values = [(1.0 - share) * a + share * b for a, b in zip(low[1:], high[1:], strict=True)]
    return Grasp(grip_n, *values)


@cache
def printed_grips() -> tuple[float, float]:
    """Mean and standard deviation (N) of the sixteen grip forces of Table 8."""
    rows = [row for row in table(8) if isinstance(row["encoder_bits"], float)]
    grips = [value for row in rows for name, value in row.items() if name.startswith("grip_")]
    values = np.array([value for value in grips if isinstance(value, float)])
    return float(values.mean()), float(values.std(ddof=1))


def _grip(person: Person, rng: np.random.Generator) -> tuple[float, tuple[Sine, ...]]:
    """Mean grip of a trial and the sines about it: trial means over `STEADY_S` scatter as printed, wander included."""
    mean, std = printed_grips()
    scale = person.grip_target_n / PRINTED_TARGET_N
    sines = wander_sines(rng, person.grip_target_n, person.grip_wander_share, person.grip_tremor_share)
    # A sine of random phase contributes this much to the variance of a mean over the steady part.
    wander = sum(0.5 * sine.amplitude**2 * _sinc(sine.frequency_hz * STEADY_S) ** 2 for sine in sines)
    own = sqrt(max(0.0, (scale * std) ** 2 - wander))
    return max(0.0, scale * mean + own * float(rng.standard_normal())), sines


def _push(person: Person, friction_nm: float, rng: np.random.Generator) -> tuple[float, tuple[Sine, ...]]:
    """Mean push of a trial and the sines about it; drawn so that friction changes it only where it would stop it."""
    sines = wander_sines(rng, 1.0, person.push_wander_share, person.push_tremor_share)
    weakest = 1.0 - sum(sine.amplitude for sine in sines)
    variance = log1p(person.push_cv**2)
    for _ in range(_DRAWS if person.push_nm * weakest > friction_nm else 1):
        push = person.push_nm * exp(sqrt(variance) * float(rng.standard_normal()) - 0.5 * variance)
        if push * weakest > friction_nm:
            break
    return push, tuple(sine._replace(amplitude=push * sine.amplitude) for sine in sines if push > 0.0)


def wander_sines(rng: np.random.Generator, mean: float, wander_share: float, tremor_share: float) -> tuple[Sine, ...]:
    """Two sines of slow wander and two of tremor, with frequencies and phases of their own; none of no amplitude."""
    found = []
    for share, (low, high) in ((wander_share, WANDER_HZ), (tremor_share, TREMOR_HZ)):
        for _ in range(2):  # of rms share / sqrt(2) each
            frequency, phase = float(rng.uniform(low, high)), float(rng.uniform(0.0, 2.0 * pi))
            if share * mean > 0.0:
                found.append(Sine(share * mean, frequency, phase))
    return tuple(found)


def _sinc(turns: float) -> float:
    return sin(pi * turns) / (pi * turns) if turns else 1.0


AIM_CV = 0.03  # spread of the force that a person aims at about the one that is shown: an assumption
POSTURE_RAD = 0.05  # within which the neutral angle lies on either side of 0, as on the apparatus (`Rig`)
_SINES, _AIM, _OFFSET, _POSTURE = range(4)  # last number of each stream


def order_of(plan: PulsePlan, grip_n: float) -> PulseOrder:
    """What the device is told of the pulse at a grip (N)."""
    pulses = plan.pulses
    if plan.torques:
        torque = plan.torques[plan.grips.index(grip_n)]
    else:
        torque = PEAK_RAD / peak_per_torque(_between(_rows(plan, None), grip_n), pulses.width)
    return PulseOrder(
        grip_n=grip_n,
        band_n=pulses.band * grip_n,
        dwell_s=pulses.dwell if pulses.trigger == HELD else 0.0,
        release_n=pulses.release * grip_n,
        torque_nm=torque,
        width_s=pulses.width,
    )


def squeezer(plan: PulsePlan, trial: Trial) -> Simulated:
    """Knob and person in a trial, drawn under the seed by grip, block and number of the trial.

    Raises `UsageError` where knob and hand have no inertia together.
    """
    who, target = plan.pulses.person, trial.grip_target_n
    place = who.table, who.person, round(1e6 * target), trial.block, trial.number

    def own(which: int) -> np.random.Generator:
        return stream(plan.seed, Purpose.PERSON, *place, which)

    rows = _rows(plan, trial)
    hand, knob = _between(rows, target), plan.knob or Knob()
    share, sensors = AIM_CV if who.person else 0.0, plan.pulses.sensors
    squeeze = Squeeze(
        aim_n=target * (1.0 + share * float(own(_AIM).standard_normal())),
        rise_s=who.rise,
        overshoot=who.overshoot,
        climbs=plan.pulses.trigger != HELD,
        reaction_s=who.reaction,
        relax_s=who.relax,
        strength_n=who.strength,
        hands=rows,
        sines=wander_sines(own(_SINES), 1.0, who.wander, 0.0),
        sensors=(sensors.torque_noise, sensors.acceleration_noise, sensors.torque_sees_friction),
    )
    return Simulated(
        inertia=hand.inertia,
        damping=hand.damping,
        stiffness=hand.stiffness,
        coulomb_nm=knob.coulomb_torque,
        angle_rad=POSTURE_RAD * float(own(_POSTURE).uniform(-1.0, 1.0)),
        push_nm=0.0,
        grip_n=target,
        grip_rise_s=who.rise,
        grip_offset_n=Person().zero_std_n * float(own(_OFFSET).standard_normal()),
        squeeze=squeeze,
    )


def _rows(plan: PulsePlan, trial: Trial | None) -> tuple[tuple[float, float, float, float], ...]:
    """Grip, inertia, damping and stiffness of knob and hand by the rows of the table; of the mean without a trial."""
    who = plan.pulses.person
    own = apparatus_inertia(who.table)
    added = (plan.knob.inertia - own, plan.knob.damping) if plan.knob else (0.0, 0.0)
    at = (who.table, who.person, trial.block) if trial else ()
    factors = (
        [  # of the block and of the trial, the same at every grip
            stream(plan.seed, purpose, *at, *more).standard_normal(3)
            for purpose, more in ((Purpose.BLOCK, ()), (Purpose.TRIAL, (trial.number,)))
        ]
        if trial
        else []
    )
    found = []
    for grip in grips(who.table):
        hand = mean_hand(who.table, grip)
        if trial is not None and who.person:
            hand = subject_hand(Place(who.table, who.person, grip), seed=plan.seed)
            for cvs, chance in zip(Variation()[1:], factors, strict=True):
                hand = scaled_hand(hand, cvs, chance)
        inertia = hand.inertia + added[0]
        if inertia <= 0.0:
            raise UsageError(f"knob and hand have no inertia together at {grip:g} N: {inertia:.3g} kg·m²")
        found.append((grip, inertia, hand.damping + added[1], hand.stiffness))
    return tuple(found)


def squeezing_hand(squeeze: Squeeze, grip_n: float) -> SecondOrder:
    """Hand and knob together at a grip force (N)."""
    return _between(squeeze.hands, grip_n)


def _between(rows: tuple[tuple[float, float, float, float], ...], grip_n: float) -> SecondOrder:
    forces, *columns = (np.array(column) for column in zip(*rows, strict=True))
    return SecondOrder(*(float(np.interp(grip_n, forces, column)) for column in columns))


def grip_of(squeeze: Squeeze, time_s: Array, fired_s: float | None) -> Array:
    """Grip force (N) at times (n,) since the start; ``fired_s``: when the pulse came, None where it has not."""
    lets_go_s = np.inf if fired_s is None else fired_s + squeeze.reaction_s
    t = np.maximum(np.minimum(time_s, lets_go_s) - squeeze.reaction_s, 0.0)
    if squeeze.climbs:
        force = squeeze.aim_n * t / squeeze.rise_s
    else:
        decay = -log(squeeze.overshoot) / squeeze.rise_s  # the first maximum is at rise_s, that much above the aim
        turn = pi * t / squeeze.rise_s
        force = squeeze.aim_n * (1.0 - np.exp(-decay * t) * (np.cos(turn) + decay * squeeze.rise_s / pi * np.sin(turn)))
    wander = sum((one.amplitude * np.sin(2.0 * pi * one.frequency_hz * t + one.phase) for one in squeeze.sines), 0.0)
    force = np.minimum(force * (1.0 + wander), squeeze.strength_n)
    relaxed = np.exp(-np.maximum(time_s - lets_go_s, 0.0) / squeeze.relax_s)
    return np.asarray(force * relaxed, dtype=np.float64)
