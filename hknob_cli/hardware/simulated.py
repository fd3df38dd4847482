"""A knob that is not there, and who holds it: what a simulated device needs to know.

Before the start the knob rests at ``angle_rad`` and nobody holds it. From the sample of the start on, at times
t = 0, T, 2T, ... after it, the person pushes by ``push_nm`` and the sines of ``push_sines`` into the wall (never
outwards: at least 0), constant from sample to sample, and grips with ``grip_n`` (1 - exp(-t / ``grip_rise_s``)) and
the sines of ``grip_sines``; the grip cell shows ``grip_offset_n`` more. Knob and hand move by
J θ'' + B θ' + K θ = torque - push - coulomb_nm sign θ', exactly from sample to sample.
"""

from typing import NamedTuple

MOST_SINES = 4


class Sine(NamedTuple):
    """``amplitude`` sin(2 pi ``frequency_hz`` t + ``phase``)."""

    amplitude: float
    frequency_hz: float
    phase: float


class Simulated(NamedTuple):
    """Numbers of the simulated knob, hand and person, in SI units; inertia of knob and hand together."""

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
