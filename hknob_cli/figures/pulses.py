"""Torque pulses: as recorded, beside models of second and fourth order, and what they work against.

Hasser, Figs 5-8; on a hand with a finger of its own Figs 15, 16.
"""

from typing import TYPE_CHECKING, Any

import numpy as np

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.identification import Pulsed, plan_of, plant_of, pulsed, recorded, rows_of
from hknob_cli.figures.panel import Scale, key, scale_of
from hknob_cli.figures.recording import At, Of, one_recording
from hknob_cli.identify.fourth_order import FINGER_INERTIA, respond_fourth, split
from hknob_cli.identify.second_order import Plant, respond
from hknob_cli.printed import apparatus_inertia
from hknob_cli.recordings.trial import Trial
from hknob_cli.results.result_set import MissingError, ResultSet
from hknob_cli.specs.plan import Hand

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

THIN = 6  # of the samples of a thumbnail one in so many is drawn: 0.6 ms of a motion of 20

THIN_DATA = 3  # of the samples one in so many is drawn


@drawing
def trial_thumbnails(
    evidence: ResultSet, of: str, *, subject: str = "S1", experiment: str = "1", to_s: float = 0.05
) -> "Figure":
    """Angle (mrad) from rest over time (ms from the onset), every trial of a person, a panel a grip force.

    Raises `MissingError` where no recordings were kept.
    """
    grips: dict[float, list[Trial]] = {}
    for trial in recorded(evidence[of], subject=subject, experiment=experiment):
        if trial.torque_nm.any():  # of a campaign a grip may have fired none
            grips.setdefault(trial.key.grip_target_n, []).append(trial)
    if not grips:
        raise MissingError(f"no trial of '{of}' has a pulse")
    drawn, panels = _panels(len(grips), above=0.7, each=1.5)
    for panel, (grip, trials) in zip(panels, sorted(grips.items()), strict=False):
        for trial in trials:
            time, angle = _from_rest(trial)
            kept = slice(0, int(np.searchsorted(time, to_s)) + 1, THIN)
            panel.plot(1e3 * time[kept], 1e3 * angle[kept], color=theme.COLOURS[0], linewidth=0.8, alpha=0.75)
        panel.set_title(f"{grip:g} N, {len(trials)} trials", loc="left")
    return drawn


def _panels(count: int, *, above: float, each: float) -> "tuple[Figure, NDArray[Any]]":
    """A figure of so many panels of angle over time, three a row; ``above`` and ``each`` row: inches."""
    rows = -(-count // 3)
    drawn = theme.figure(above + each * rows)
    panels = drawn.subplots(rows, min(3, count), squeeze=False, sharex=True, sharey=True).ravel()
    for panel in panels[count:]:
        panel.set_visible(False)
    drawn.supxlabel("time from the onset of the pulse, ms", fontsize=9)
    drawn.supylabel("angle from rest, mrad", fontsize=9)
    return drawn, panels


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


@drawing
def models_beside_data(
    evidence: ResultSet,
    of: str,
    *,
    subject: str = "S1",
    experiment: str = "1",
    block: int = 1,
    other: int = 2,
    estimator: str = "output_error",
    to_s: float = 0.05,
) -> "Figure":
    """Angle (mrad) of an averaged condition, by its own model, and by that of block ``other``, a panel a grip force.

    Models know the friction and the lag that the identification knew. Raises `MissingError`.
    """
    result = evidence[of]
    known = plan_of(result)
    drawn_of = pulsed(result, smooth=False, after_s=to_s, subject=subject, experiment=experiment, block=block)
    drawn_of.sort(key=lambda one: one.of.condition.grip_target_n)
    drawn, panels = _panels(len(drawn_of), above=0.9, each=1.6)
    wide: dict[str, Any] = {"color": "black", "linewidth": 3.5, "alpha": 0.3}
    for panel, one in zip(panels, drawn_of, strict=False):
        grip, time = one.of.condition.grip_target_n, time_of(one)[::THIN_DATA]
        rule_pulse(panel, one)
        panel.plot(time, 1e3 * one.motion.angle_rad[::THIN_DATA], label="recorded", **wide)
        for i, (number, label) in enumerate(((block, "model of these data"), (other, f"model of block {other}"))):
            asked = {"subject": subject, "experiment": experiment, "grip_target_n": grip, "block": number}
            plant = plant_of(rows_of(result, "trials", estimator=estimator, **asked)[0])
            angle = modelled(plant, one, coulomb_nm=known.coulomb_nm, lag_s=known.lag_s)
            panel.plot(time, 1e3 * angle[::THIN_DATA], label=label, **theme.series(i))
        panel.set_title(f"{grip:g} N", loc="left")
    drawn.legend(*panels[0].get_legend_handles_labels(), loc="outside upper left", ncols=3, handlelength=3.0)
    return drawn


def modelled(plant: Plant, one: Pulsed, *, coulomb_nm: float = 0.0, lag_s: float = 0.0) -> np.ndarray:
    """Angle (rad) of a second-order model under a recorded torque, the friction known beside that fitted."""
    if plant.inertia <= 0.0:
        raise MissingError("a model without inertia does not move")
    if not plant.coulomb:
        plant = plant._replace(coulomb=coulomb_nm)
    return respond(plant, one.motion.torque_nm, one.motion.dt_s, lag_s=lag_s)


def _draw_terms(
    panel: "Axes", time: np.ndarray, commanded: np.ndarray, terms: dict[str, np.ndarray], *, factor: float, step: str
) -> None:
    """Torques over time: the command wide, their sum dotted, and each term; ``factor`` to the axis's unit."""
    wide: dict[str, Any] = {"color": "black", "linewidth": 4.0, "alpha": 0.3}
    panel.plot(time, factor * commanded, label="commanded", drawstyle=step, **wide)
    panel.plot(time, factor * sum(terms.values()), label="sum", color="black", linewidth=1.0, linestyle=":")
    for i, (name, values) in enumerate(terms.items()):
        panel.plot(time, factor * values, label=name, **theme.series(i))


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
    _draw_terms(panel, time, motion.torque_nm, terms, factor=1e3, step="steps-post")
    panel.set_xlabel("time from the onset, ms")
    panel.set_ylabel("torque, mN\u00b7m")
    panel.set_xlim(float(time[0]), float(time[-1]))
    key(panel)
    return drawn


@drawing
def pulse_terms(evidence: ResultSet, of: Of, *, at: At | None = None, to_s: float | None = None) -> "Figure":
    """Torques (mN·m) of inertia, damping and stiffness, J θ'' + B θ' + K θ, their sum, and the pulse commanded.

    J, B and K are the scene's, the motion is recorded; accelerations are means between rows. Up to ``to_s`` (s). Raises
    `MissingError` for a hand of fourth order, with a wall or friction, or without a pulse.
    """
    one = one_recording(evidence, of, at=at, to_s=to_s)
    scene, hand = one.scene, one.scene.hand or Hand()
    if one.pulse is None or scene.wall.stiffness > 0.0 or hand.finger or scene.coil or scene.knob.coulomb_torque > 0.0:
        raise MissingError(f"'{one.name}' is not a pulse on a hand of second order, without a wall and friction")
    spans = np.diff(one.time)
    middle = one.time[:-1] + 0.5 * spans
    velocity, angle = (0.5 * (of[:-1] + of[1:]) for of in (one.velocity, one.angle))
    terms = {
        "inertia": (scene.knob.inertia + hand.inertia) * np.diff(one.velocity) / spans,
        "damping": (scene.knob.damping + hand.damping) * velocity,
        "stiffness": hand.stiffness * angle,
    }
    time, unit = scale_of(one.time), Scale(abs(one.pulse.torque))
    drawn = theme.figure(3.4)
    panel = drawn.subplots()
    commanded = np.where(middle < one.pulse.duration, one.pulse.torque, 0.0)
    _draw_terms(panel, time.factor * middle, commanded, terms, factor=unit.factor, step="steps-mid")
    panel.set_xlabel(f"time, {time.prefix}s")
    panel.set_ylabel(f"torque, {unit.prefix}N\u00b7m")
    panel.set_xlim(0.0, time.factor * float(one.time[-1]))
    key(panel)
    return drawn


THIN_MEAN = 2  # of the samples one in so many is drawn


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
    above.plot(time[::THIN_MEAN], 1e3 * one.motion.angle_rad[::THIN_MEAN], label="recorded, mean of the trials", **wide)
    for i, (name, angle) in enumerate(models.items()):
        above.plot(time[::THIN_MEAN], 1e3 * angle[::THIN_MEAN], label=name, **theme.series(i))
        below.plot(time[::THIN_MEAN], 1e6 * (one.motion.angle_rad - angle)[::THIN_MEAN], **theme.series(i))
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
