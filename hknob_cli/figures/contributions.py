"""What a recorded pulse works against: torques of an identified inertia, damping and stiffness (Hasser, Fig. 7)."""

from typing import TYPE_CHECKING, Any

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.identification import plant_of, pulsed, rows_of
from hknob_cli.figures.panel import key
from hknob_cli.figures.recorded import time_of
from hknob_cli.results.result_set import MissingError, ResultSet

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@drawing
def identified_terms(
    evidence: ResultSet,
    of: str,
    *,
    subject: str = "S1",
    experiment: str = "1",
    grip_n: float = 2.4,
    block: int = 1,
    estimator: str = "least_squares",
    to_s: float = 0.05,
) -> "Figure":
    """Torques (mN·m) J θ'' + B θ' + K θ, identified parameters times the recorded motion, their sum, and the command.

    The motion is smoothed and differentiated as the result says. Raises `MissingError`.
    """
    asked = {"subject": subject, "experiment": experiment, "grip_target_n": grip_n, "block": block}
    one = pulsed(evidence[of], smooth=True, after_s=to_s, **asked)[0]
    plant = plant_of(rows_of(evidence[of], "trials", estimator=estimator, **asked)[0])
    motion = one.motion
    if motion.velocity_rad_s is None or motion.acceleration_rad_s2 is None:
        raise MissingError(f"'{of}' was not differentiated")
    terms = {
        "inertia": plant.inertia * motion.acceleration_rad_s2,
        "damping": plant.damping * motion.velocity_rad_s,
        "stiffness": plant.stiffness * motion.angle_rad,
    }
    time = time_of(one)
    drawn = theme.figure(3.4)
    panel = drawn.subplots()
    wide: dict[str, Any] = {"color": "black", "linewidth": 4.0, "alpha": 0.3}
    panel.plot(time, 1e3 * motion.torque_nm, label="commanded", drawstyle="steps-post", **wide)
    panel.plot(time, 1e3 * sum(terms.values()), label="sum", color="black", linewidth=1.0, linestyle=":")
    for i, (name, values) in enumerate(terms.items()):
        panel.plot(time, 1e3 * values, label=name, **theme.series(i))
    panel.set_xlabel("time from the onset, ms")
    panel.set_ylabel("torque, mN\u00b7m")
    panel.set_xlim(float(time[0]), float(time[-1]))
    key(panel)
    return drawn
