"""A recorded pulse on a hand with a finger of its own, and models of second and fourth order (Hasser, Figs 15, 16)."""

from typing import TYPE_CHECKING, Any

import numpy as np

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.identification import Pulsed, plan_of, plant_of, pulsed, rows_of
from hknob_cli.figures.panel import key
from hknob_cli.figures.pulses import modelled, rule_pulse, time_of
from hknob_cli.identify.fourth_order import FINGER_INERTIA, respond_fourth, split
from hknob_cli.identify.second_order import Plant
from hknob_cli.printed.tables import apparatus_inertia
from hknob_cli.results.result_set import MissingError, ResultSet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

THIN_DATA = 2  # of the samples one in so many is drawn


@drawing
def fourth_beside_second(
    evidence: ResultSet,
    of: str,
    *,
    block: int = 1,
    estimator: str = "output_error",
    acceleration: bool = False,
    to_s: float = 0.05,
) -> "Figure":
    """Angle (mrad) recorded of a hand, by its second-order fit, by a fourth-order model, and what they leave (µrad).

    The model is section 4.4.1's: the fit's damping and stiffness split between finger and fingerpad, 10 to 1, a finger
    of 3 g·cm², and the apparatus' inertia as printed. ``acceleration``: accelerations instead, of the recording
    smoothed and differentiated twice, and of both models. Raises `MissingError`.
    """
    result = evidence[of]
    one = pulsed(result, smooth=acceleration, after_s=to_s, block=block)[0]
    own = one.of.condition
    asked = {"experiment": own.experiment, "subject": own.subject, "grip_target_n": own.grip_target_n, "block": block}
    plant = plant_of(rows_of(result, "trials", estimator=estimator, **asked)[0])
    plan = plan_of(result)
    second = modelled(plant, one, coulomb_nm=plan.coulomb_nm, lag_s=plan.lag_s)
    models = {"second-order fit": second, "fourth-order model": _with_finger(plant, one)}
    return _accelerations(one, models) if acceleration else _angles(one, models)


def _with_finger(plant: Plant, one: Pulsed) -> np.ndarray:
    """Angle (rad) of the knob by the network of Equation 1 under the recorded torque."""
    parts = {
        "inertia": apparatus_inertia(int(one.of.condition.experiment)),
        "finger_inertia": FINGER_INERTIA,
        **split(plant.damping, plant.stiffness),
    }
    return respond_fourth(parts, one.motion.torque_nm, one.motion.dt_s)


def _angles(one: Pulsed, models: dict[str, np.ndarray]) -> "Figure":
    time = time_of(one)
    drawn = theme.figure(4.2)
    above, below = drawn.subplots(2, 1, sharex=True, height_ratios=[2.0, 1.0])
    wide: dict[str, Any] = {"color": "black", "linewidth": 3.5, "alpha": 0.3}
    above.plot(time[::THIN_DATA], 1e3 * one.motion.angle_rad[::THIN_DATA], label="recorded, mean of the trials", **wide)
    for i, (name, angle) in enumerate(models.items()):
        above.plot(time[::THIN_DATA], 1e3 * angle[::THIN_DATA], label=name, **theme.series(i))
        below.plot(time[::THIN_DATA], 1e6 * (one.motion.angle_rad - angle)[::THIN_DATA], **theme.series(i))
    for panel in (above, below):
        rule_pulse(panel, one)
    above.set_ylabel("angle, mrad")
    below.set_ylabel("left over, \u00b5rad")
    below.set_xlabel("time from the onset, ms")
    key(above)
    drawn.align_ylabels([above, below])
    return drawn


def _accelerations(one: Pulsed, models: dict[str, np.ndarray]) -> "Figure":
    if one.motion.acceleration_rad_s2 is None:
        raise MissingError("the motion was not differentiated")
    time, dt = time_of(one), one.motion.dt_s
    drawn = theme.figure(2.9)
    panel = drawn.subplots()
    wide: dict[str, Any] = {"color": "black", "linewidth": 3.5, "alpha": 0.3}
    panel.plot(time, 1e-3 * one.motion.acceleration_rad_s2, label="recorded, smoothed and differentiated twice", **wide)
    for i, (name, angle) in enumerate(models.items()):
        panel.plot(time, 1e-3 * np.gradient(np.gradient(angle, dt), dt), label=name, **theme.series(i))
    rule_pulse(panel, one)
    panel.set_xlabel("time from the onset, ms")
    panel.set_ylabel("acceleration, 10\u00b3 rad/s\u00b2")
    key(panel)
    return drawn
