"""The torque pulse: 20 ms, as high as moves the mean hand of a grip by 0.09 rad."""

from functools import cache
from typing import NamedTuple

from hknob_cli.apparatus.hand import SecondOrder
from hknob_cli.apparatus.people import mean_hand
from hknob_cli.engine.propagator import hold_coefficients
from hknob_cli.engine.turning import first_zero

DURATION_S = 0.02  # section 4.2.1
PEAK_RAD = 0.09  # the middle of 0.07 - 0.11 rad, ibid.


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
