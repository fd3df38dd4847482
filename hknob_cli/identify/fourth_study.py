"""Section 4.4.1 as a curve: what a second-order fit takes for the inertia of finger, fingerpad and knob.

As the finger gets stiffer than its pad it hides behind it, and the fitted inertia falls to the knob's own. The series
of finger and pad stays what it is, so only the split changes along the curve. With K1/K2 = B1/B2 = r the finger moves
1/(1 + r) of what the knob does, and adds J1/(1 + r)^2 to it.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from hknob_cli.errors import UsageError
from hknob_cli.identify.finger_network import FINGER_INERTIA, network, respond_fourth, split
from hknob_cli.identify.least_squares import least_squares
from hknob_cli.identify.linear_motion import hold_matrices
from hknob_cli.identify.motion import Motion
from hknob_cli.identify.output_error import output_error
from hknob_cli.recordings.trial import Array

FASTEST = 1e9  # rate of the finger times the interval, beyond which rounding costs the fitted damping more than 1e-6
RATIOS = tuple(float(ratio) for ratio in np.geomspace(1.0, 1000.0, 13))


class Hidden(NamedTuple):
    """Fitted second-order values at a ratio K1/K2 = B1/B2, and the share of the angle's variance they explain."""

    ratio: float
    estimator: str
    inertia: float
    damping: float
    stiffness: float
    vaf: float


def hidden_inertia(
    damping: float,
    stiffness: float,
    *,
    inertia: float,
    finger_inertia: float = FINGER_INERTIA,
    ratios: Sequence[float] = RATIOS,
    pulse_s: float = 0.02,
    window_s: float = 0.03,
    dt_s: float = 1e-4,
    progress: Callable[[int, int], None] = lambda _done, _total: None,
) -> list[Hidden]:
    """Second-order fits of noiseless pulse responses of the fourth-order hand, by least squares and output error.

    ``damping``, ``stiffness``: of finger and pad in series (Table 1's at 14.2 N in the dissertation's figure);
    ``inertia`` of the knob and what turns with it, ``finger_inertia`` (kg·m²). Velocity and acceleration are the
    model's own, so that nothing but the model's order is at work. Raises `UsageError` for a finger too light to follow.
    """
    for ratio in ratios:
        if (1.0 + ratio) ** 2 / ratio * damping / finger_inertia * dt_s > FASTEST:
            raise UsageError(
                f"a finger of {finger_inertia:g} kg*m^2 at the ratio {ratio:g} is too fast to be followed; "
                "make it heavier, or the ratio nearer to 1"
            )
    torque = np.zeros(round(window_s / dt_s) + 1)
    torque[: round(pulse_s / dt_s)] = 1.0
    found = []
    for done, ratio in enumerate(ratios):
        progress(done, len(ratios))
        parts = {"inertia": inertia, "finger_inertia": finger_inertia, **split(damping, stiffness, ratio)}
        torque_nm = torque * (0.08 / float(np.max(respond_fourth(parts, torque, dt_s))))
        motion = _motion(parts, torque_nm, dt_s)
        for fit in (least_squares(motion), output_error(motion)):
            whole, loss, spring = (fit.parameters[name].value for name in ("inertia", "damping", "stiffness"))
            found.append(Hidden(ratio, fit.estimator, whole, loss, spring, fit.vaf))
    return found


def _motion(parts: dict[str, float], torque_nm: Array, dt_s: float) -> Motion:
    matrix, push = network(parts)
    move, added = (one[0] for one in hold_matrices(matrix, push, dt_s))
    states = np.zeros((len(torque_nm), 4))
    for i, torque in enumerate(torque_nm[:-1]):
        states[i + 1] = move @ states[i] + added * torque
    rates = states @ matrix.T + np.outer(torque_nm, push)
    return Motion(dt_s, torque_nm, states[:, 0].copy(), states[:, 1].copy(), rates[:, 1].copy())
