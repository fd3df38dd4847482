"""A virtual person who squeezes until the knob pulses, and lets go: force over time, and the hand at that force.

The text tells the course (Hasser, section 4.2.1): after the beep the subject slowly squeezes; at the threshold the
pulse comes; the subject relaxes and waits for the next. The times, the overshoot of a grip that is to be held and its
wander are assumptions. Means and spread of the hand are those of Tables 1-5, drawn as for `apparatus.experiment`; a
hand between two rows lies on the straight line between them, because it follows the grip at which the pulse comes.
"""

from math import log, pi

import numpy as np

from hknob_cli.apparatus.hand import SecondOrder
from hknob_cli.apparatus.hand_recording import PEAK_RAD, peak_per_torque
from hknob_cli.apparatus.people import Place, Variation, grips, mean_hand, scaled_hand, subject_hand
from hknob_cli.apparatus.streams import Purpose, stream
from hknob_cli.errors import UsageError
from hknob_cli.hardware.order import Trial
from hknob_cli.hardware.person import Person, wander_sines
from hknob_cli.hardware.port import Array, PulseOrder, Simulated, Squeeze
from hknob_cli.printed.tables import apparatus_inertia
from hknob_cli.specs.campaign import Knob
from hknob_cli.specs.pulses import HELD, PulsePlan

AIM_CV = 0.03  # spread of the force that a person aims at about the one that is shown: an assumption
POSTURE_RAD = 0.05  # within which the neutral angle lies on either side of 0, as on the apparatus (`Rig`)
_SINES, _AIM, _ZERO, _POSTURE = range(4)  # last number of each stream


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
        grip_offset_n=Person().zero_std_n * float(own(_ZERO).standard_normal()),
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


def hand_at(squeeze: Squeeze, grip_n: float) -> SecondOrder:
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
