"""A knob that is not there, and who holds it: what a simulated device needs to know.

Before the start the knob rests at ``angle_rad`` and nobody holds it. From the sample of the start on, at times
t = 0, T, 2T, ... after it, the person pushes by ``push_nm`` and the sines of ``push_sines`` into the wall (never
outwards: at least 0), constant from sample to sample, and grips with ``grip_n`` (1 - exp(-t / ``grip_rise_s``)) and
the sines of ``grip_sines``; the grip cell shows ``grip_offset_n`` more. Knob and hand move by
J θ'' + B θ' + K θ = torque - push - coulomb_nm sign θ', exactly from sample to sample.
"""

from typing import NamedTuple

MOST_SINES = 4
MOST_HANDS = 10


class Sine(NamedTuple):
    """``amplitude`` sin(2 pi ``frequency_hz`` t + ``phase``)."""

    amplitude: float
    frequency_hz: float
    phase: float


class Squeeze(NamedTuple):
    """How a simulated person squeezes a knob that pulses, from the start on (`person.grip_of`).

    ``aim_n``: force aimed at; ``rise_s`` to the highest force, or to the aim with ``climbs``: then the force goes on
    rising; ``overshoot``: share; ``reaction_s`` before the squeeze, and from the first sample of the pulse to letting
    go, with the time constant ``relax_s``; ``strength_n``: the firmest grip; ``sines`` of shares. ``hands``: rows of
    grip (N), inertia, damping and stiffness of knob and hand, rising, between which the hand at the pulse lies.
    ``sensors``: rms noise of a torque sensor (N·m) and of an accelerometer (rad/s²), None without one; and
    whether the torque sensor carries the motor, and so does not read what friction takes.
    """

    aim_n: float
    rise_s: float
    overshoot: float
    climbs: bool
    reaction_s: float
    relax_s: float
    strength_n: float
    hands: tuple[tuple[float, float, float, float], ...]
    sines: tuple[Sine, ...] = ()
    sensors: tuple[float | None, float | None, bool] = (None, None, True)


class Simulated(NamedTuple):
    """Numbers of the simulated knob, hand and person, in SI units; inertia of knob and hand together.

    ``squeeze``: of a person whose knob pulses; then grip and push of the others, and what the hand is, do not count.
    """

    inertia: float
    damping: float
    stiffness: float
    coulomb_nm: float
    angle_rad: float
    push_nm: float
    grip_n: float
    grip_rise_s: float
    grip_offset_n: float
    push_sines: tuple[Sine, ...] = ()
    grip_sines: tuple[Sine, ...] = ()
    squeeze: Squeeze | tuple[()] = ()
