"""Recorded pulses: every trial of a person by grip force, and one averaged condition (Hasser, Figs 5, 6)."""

from typing import TYPE_CHECKING

import numpy as np

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.identification import Pulsed, pulsed, recorded
from hknob_cli.recordings.trial import Trial
from hknob_cli.results.result_set import MissingError, ResultSet

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

THIN = 6  # of the samples of a thumbnail one in so many is drawn: 0.6 ms of a motion of 20


@drawing
def trial_thumbnails(
    evidence: ResultSet, of: str, *, subject: str = "S1", experiment: str = "1", to_s: float = 0.05
) -> "Figure":
    """Angle (mrad) from rest over time (ms from the onset), every trial of a person, a panel a grip force.

    Raises `MissingError` where no recordings were kept.
    """
    grips: dict[float, list[Trial]] = {}
    for trial in recorded(evidence[of], subject=subject, experiment=experiment):
        grips.setdefault(trial.key.grip_target_n, []).append(trial)
    rows = -(-len(grips) // 3)
    drawn = theme.figure(0.7 + 1.5 * rows)
    panels = drawn.subplots(rows, min(3, len(grips)), squeeze=False, sharex=True, sharey=True).ravel()
    for panel, (grip, trials) in zip(panels, sorted(grips.items()), strict=False):
        for trial in trials:
            time, angle = _from_rest(trial)
            kept = slice(0, int(np.searchsorted(time, to_s)) + 1, THIN)
            panel.plot(1e3 * time[kept], 1e3 * angle[kept], color=theme.COLOURS[0], linewidth=0.8, alpha=0.75)
        panel.set_title(f"{grip:g} N, {len(trials)} trials", loc="left")
    for panel in panels[len(grips) :]:
        panel.set_visible(False)
    drawn.supxlabel("time from the onset of the pulse, ms", fontsize=9)
    drawn.supylabel("angle from rest, mrad", fontsize=9)
    return drawn


def _from_rest(trial: Trial) -> tuple[np.ndarray, np.ndarray]:
    """Time from the onset, and angle from its mean before it."""
    pushed = np.flatnonzero(trial.torque_nm)
    if not len(pushed):
        raise MissingError(f"trial {trial.key.trial} of {trial.key.subject} has no pulse")
    onset = int(pushed[0])
    rest = float(trial.angle_rad[: onset + 1].mean())
    return trial.time_s[onset:] - trial.time_s[onset], trial.angle_rad[onset:] - rest


@drawing
def pulse_vectors(
    evidence: ResultSet,
    of: str,
    *,
    subject: str = "S1",
    experiment: str = "1",
    grip_n: float = 2.4,
    block: int = 1,
    to_s: float = 0.05,
) -> "Figure":
    """Commanded torque, acceleration, velocity and angle of one averaged condition, as the least squares take them.

    Averaged over its trials, smoothed and differentiated as the result says. Raises `MissingError`.
    """
    asked = {"subject": subject, "experiment": experiment, "grip_target_n": grip_n, "block": block}
    one = pulsed(evidence[of], smooth=True, after_s=to_s, **asked)[0]
    motion = one.motion
    if motion.velocity_rad_s is None or motion.acceleration_rad_s2 is None:
        raise MissingError(f"'{of}' was not differentiated")
    time = time_of(one)
    drawn = theme.figure(3.9)
    panels = drawn.subplots(2, 2, sharex=True)
    shown = (
        (panels[0, 0], 1e3 * motion.torque_nm, "torque, mN\u00b7m"),
        (panels[0, 1], 1e-3 * motion.acceleration_rad_s2, "acceleration, 10\u00b3 rad/s\u00b2"),
        (panels[1, 0], motion.velocity_rad_s, "velocity, rad/s"),
        (panels[1, 1], 1e3 * motion.angle_rad, "angle, mrad"),
    )
    for i, (panel, values, label) in enumerate(shown):
        panel.plot(time, values, color=theme.COLOURS[0], drawstyle="default" if i else "steps-post")
        panel.set_ylabel(label)
        rule_pulse(panel, one)
    for panel in panels[1]:
        panel.set_xlabel("time from the onset, ms")
    drawn.align_ylabels(panels[:, 0])
    return drawn


def time_of(one: Pulsed) -> np.ndarray:
    """Time (ms) of every sample, from the onset of the pulse."""
    return 1e3 * one.motion.dt_s * (np.arange(len(one.motion.angle_rad)) - one.start)


def _pulse_ms(one: Pulsed) -> float:
    return 1e3 * one.motion.dt_s * float(np.count_nonzero(one.motion.torque_nm))


def rule_pulse(panel: "Axes", one: Pulsed) -> None:
    """Shade the time of the pulse."""
    panel.axvspan(0.0, _pulse_ms(one), color="black", alpha=0.06, linewidth=0)
