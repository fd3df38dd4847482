"""The Nyquist picture of a relay with the hold's delay: the plant's curve, and where each sample rate meets it.

The describing function of a relay, 4M/(pi A), has a real negative inverse; the half sample of delay of a zero-order
hold turns it counter-clockwise by omega T/2 (Hasser, sec. 7.2, Figs 45, 46).
"""

from math import pi
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hknob_cli.scene.sampled_knob import SampledKnob
from hknob_cli.theory.relay import Relay, describing_function, response


class Crossing(NamedTuple):
    """Where the turned inverse of the describing function meets the plant's curve.

    ``point``: G in rad/(N m); ``omega``: rad/s; ``amplitude_rad``: half of peak to peak, |G| 4M/pi.
    """

    rate_hz: float
    omega: float
    point: complex
    amplitude_rad: float

    @property
    def frequency_hz(self) -> float:
        """Cycles per second."""
        return self.omega / (2.0 * pi)


def crossing(knob: SampledKnob) -> Crossing | None:
    """The slowest cycle by one harmonic; None where there is none below the Nyquist frequency."""
    loop = knob.loop
    delay = 0.5 + max(0, knob.delay_line - 1) + loop.split
    found = describing_function(Relay(loop.alpha, loop.beta, 1.0, delay), 1)
    if not found:
        return None
    omega = found[0].omega
    bare = Relay(loop.alpha, loop.beta, 1.0, 0.0)
    point = complex(response(bare, np.array([omega]))[0]) * knob.period_s**2 / knob.inertia_kg_m2
    level = 0.5 * loop.kappa * knob.quantum_rad * knob.inertia_kg_m2 / knob.period_s**2
    return Crossing(1.0 / knob.period_s, omega / knob.period_s, point, abs(point) * 4.0 * level / pi)


def plant_curve(knob: SampledKnob, omega: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Frequency response of hand and knob, rad/(N m), at ``omega`` (rad/s)."""
    inertia = knob.inertia_kg_m2
    damping = knob.loop.alpha * inertia / knob.period_s
    stiffness = knob.loop.beta * inertia / knob.period_s**2
    return np.asarray(1.0 / (stiffness - inertia * omega**2 + 1j * damping * omega), dtype=np.complex128)
