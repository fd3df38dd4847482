"""The knob's motion over time, with the torque that answers it (Hasser, Figs 15, 16, 22-28, 31, 32, 69, 71).

A short contact with the wall: where the torque acts late, and the energy that this adds (Hasser, Fig. 60).
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.panel import Scale, draw_steps, draw_torque_axis, draw_wall, key, scale_of, torque_scale
from hknob_cli.figures.recording import Of, Recording, Which, recordings
from hknob_cli.results.result_set import MissingError, ResultSet

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

HEIGHTS = {"angle": 2.3, "torque": 1.05, "acceleration": 2.3, "energy": 1.3}  # of panels, inches
BOUNCES = 10  # that the lines of mean peaks and troughs take in (Hasser, sec. 6.4.2)


class View(NamedTuple):
    """Recordings that are drawn, and what of them.

    ``samples`` marks where the controller reads; ``counts`` rules the count edges. ``scaled`` draws the torque of one
    recording over the angle, as the angle that it answers to, instead of below. ``acceleration`` draws accelerations
    only (mean between rows). ``bounces`` marks the bounce peaks and draws the energy below, with a parabola through
    them. ``peaks_lines`` rules the mean of the last ten peaks and troughs.
    """

    samples: bool = False
    counts: bool = True
    scaled: bool = False
    acceleration: bool = False
    bounces: bool = False
    peaks_lines: bool = False

    @property
    def parts(self) -> list[str]:
        """The panels, from above."""
        upper = ["acceleration"] if self.acceleration else ["angle", *([] if self.scaled else ["torque"])]
        return upper + (["energy"] if self.bounces else [])


@drawing
def time_response(evidence: ResultSet, of: Of, *, which: Which, view: View, height: float | None = None) -> "Figure":
    """Angle over time, torque below; or accelerations.

    ``height`` in inches. Raises `MissingError`.
    """
    shown = recordings(evidence, of, at=which.at, from_s=which.from_s, to_s=which.to_s)
    if view.scaled and (len(shown) > 1 or shown[0].scene.wall.stiffness == 0.0):
        raise MissingError("'scaled' is of one recording, with a wall")
    names = _names(shown, which.labels)
    parts = view.parts
    heights = [HEIGHTS[part] for part in parts]
    drawn = theme.figure(height or 0.5 + sum(heights))
    panels = drawn.subplots(len(parts), 1, squeeze=False, sharex=True, height_ratios=heights)[:, 0]
    time = scale_of(*(each.time for each in shown))
    draw = {"angle": _draw_angles, "torque": _draw_torques, "acceleration": _draw_accelerations, "energy": _draw_energy}
    for panel, part in zip(panels, parts, strict=True):
        draw[part](panel, shown, names, time)
    if parts[0] == "angle":
        _mark_angles(panels[0], shown, time, view)
    key(panels[0])
    panels[-1].set_xlabel(f"time, {time.prefix}s")
    panels[-1].set_xlim(*(time.factor * shown[0].time[[0, -1]]))
    drawn.align_ylabels(list(panels))
    return drawn


def _names(shown: list[Recording], labels: Sequence[str] | None) -> list[str]:
    if labels is None:
        return ["knob"] if len(shown) == 1 else [_told(each) for each in shown]
    if len(labels) != len(shown):
        raise MissingError(f"{len(shown)} recordings, but {len(labels)} labels")
    return list(labels)


def _told(one: Recording) -> str:
    told = [f"{name} {value:.4g}" for name, value in one.cell.items() if name != "trial"]
    return ", ".join([one.name, *told])


def _angle_unit(shown: list[Recording]) -> Scale:
    return scale_of(*(each.angle for each in shown))


def _styles(shown: list[Recording]) -> list[dict[str, Any]]:
    """Line styles of recordings: the first wide and pale where nothing but a wall parts them."""
    styles = [theme.series(i) for i in range(len(shown))]
    if len(shown) > 1 and all(each.scene.wall.stiffness == 0.0 for each in shown):
        styles[0] |= {"linewidth": 3.0, "alpha": 0.55}
    return styles


def _draw_angles(panel: "Axes", shown: list[Recording], names: list[str], time: Scale) -> None:
    unit = _angle_unit(shown)
    for one, name, style in zip(shown, names, _styles(shown), strict=True):
        panel.plot(time.factor * one.time, unit.factor * one.angle, label=name, **style)
        if one.finger is not None:
            panel.plot(time.factor * one.time, unit.factor * one.finger, label=f"finger of {name}", **theme.series(4))
    panel.set_ylabel(f"angle, {unit.prefix}rad")


def _mark_angles(panel: "Axes", shown: list[Recording], time: Scale, view: View) -> None:
    """What is drawn on the panel of the angles beside them."""
    unit, one = _angle_unit(shown), shown[0]
    if view.samples:
        _mark_samples(panel, shown, time, unit)
    if view.scaled:
        _draw_answered(panel, one, time, unit)
    if view.bounces:
        _mark_bounces(panel, one, time, unit)
    if view.peaks_lines:
        _rule_peaks(panel, one, time, unit)
    draw_wall(panel, one, unit, counts=view.counts)


def _mark_samples(panel: "Axes", shown: list[Recording], time: Scale, unit: Scale) -> None:
    for one, style in zip(shown, _styles(shown), strict=True):
        dots: dict[str, Any] = {"color": style["color"], "marker": "o", "linestyle": "none", "markersize": 3.0}
        panel.plot(time.factor * one.time[one.samples], unit.factor * one.angle[one.samples], label="samples", **dots)


def _draw_answered(panel: "Axes", one: Recording, time: Scale, unit: Scale) -> None:
    """The torque as the angle it answers to, with its own scale at the right."""
    stiffness = one.scene.wall.stiffness
    label = "torque of the wall (right)"
    draw_steps(panel, one, time, -unit.factor / stiffness, label=label, linewidth=1.1, color=theme.COLOURS[1])
    draw_torque_axis(panel, one, unit)


def _draw_torques(panel: "Axes", shown: list[Recording], _names: list[str], time: Scale) -> None:
    pulses = {each.pulse for each in shown if each.pulse}
    if pulses and all(each.scene.wall.stiffness == 0.0 for each in shown):
        torque, until = next(iter(pulses))
        unit, end = Scale(abs(torque)), float(shown[0].time[-1])
        times = [0.0, 0.0, until, until, end]
        values = [0.0, torque, torque, 0.0, 0.0]
        panel.plot([time.factor * t for t in times], [unit.factor * v for v in values], color="black")
    else:
        unit = torque_scale(*shown)
        for one, style in zip(shown, _styles(shown), strict=True):
            draw_steps(panel, one, time, unit.factor, **style)
    panel.set_ylabel(f"torque, {unit.prefix}N\u00b7m")


def _draw_accelerations(panel: "Axes", shown: list[Recording], names: list[str], time: Scale) -> None:
    """Mean acceleration between rows, which the end of a pulse parts."""
    for one, name, style in zip(shown, names, _styles(shown), strict=True):
        spans = np.diff(one.time)
        times = time.factor * (one.time[:-1] + 0.5 * spans)
        panel.plot(times, 1e-3 * np.diff(one.velocity) / spans, label=name, **style)
        if one.finger_velocity is not None:
            values = 1e-3 * np.diff(one.finger_velocity) / spans
            panel.plot(times, values, label=f"finger of {name}", **theme.series(4))
    panel.set_ylabel("acceleration,\n10\u00b3 rad/s\u00b2")


def _peaks(one: Recording) -> tuple[np.ndarray, np.ndarray]:
    """Times (s) and angles (rad) of the peaks outside the wall."""
    times, angles, up = one.turns
    kept = up & (angles > 0.0)
    return times[kept], angles[kept]


def _mark_bounces(panel: "Axes", one: Recording, time: Scale, unit: Scale) -> None:
    times, angles = _peaks(one)
    panel.plot(time.factor * times, unit.factor * angles, markersize=4.5, label="bounce peaks", **theme.points(1))


def _draw_energy(panel: "Axes", shown: list[Recording], _names: list[str], time: Scale) -> None:
    """Energy, and the second-order polynomial through it at the bounce peaks."""
    one = shown[0]
    times, _ = _peaks(one)
    if len(times) < 3:
        raise MissingError(f"'{one.name}' has {len(times)} bounce peaks; a parabola needs three")
    energy = np.interp(times, one.time, one.energy)
    unit = Scale(float(one.energy.max()))
    second, first, constant = np.polyfit(times, energy, 2)
    along = np.linspace(one.time[0], one.time[-1], 100)
    curve = unit.factor * (second * along**2 + first * along + constant)
    panel.plot(time.factor * one.time, unit.factor * one.energy, linewidth=0.8, alpha=0.6, **theme.series(0))
    panel.plot(time.factor * times, unit.factor * energy, markersize=4.5, **theme.points(1))
    said = f"parabola through the peaks, {1e3 * second:.2f} mJ/s\u00b2"
    panel.plot(time.factor * along, curve, label=said, **theme.series(1))
    panel.set_ylim(0.0, 1.15 * unit.factor * float(max(energy.max(), one.energy[one.acts == 0.0].max())))
    panel.set_ylabel(f"energy, {unit.prefix}J")
    panel.legend(loc="upper left")


def _rule_peaks(panel: "Axes", one: Recording, time: Scale, unit: Scale) -> None:
    times, angles, up = one.turns
    if min(up.sum(), (~up).sum()) < BOUNCES:
        raise MissingError(f"'{one.name}' has fewer than {BOUNCES} bounces in the window shown")
    peak, trough = (float(angles[kept][-BOUNCES:].mean()) for kept in (up, ~up))
    apart = f"mean trough, {unit.factor * (peak - trough):.3f} {unit.prefix}rad below"
    for kept, mean, label, style in ((up, peak, "mean of ten peaks", "--"), (~up, trough, apart, ":")):
        ends = [time.factor * times[kept][-BOUNCES], time.factor * one.time[-1]]
        panel.plot(ends, [unit.factor * mean] * 2, color=theme.COLOURS[1], linestyle=style, label=label)


LATE = {"late entry": (2, "////"), "late exit": (3, "\\\\\\\\")}  # colour and hatch


class Held(NamedTuple):
    """A recording with both torques at instants where it changes: times (s), angles (rad), torque as an angle (rad)."""

    time: np.ndarray
    angle: np.ndarray
    answered: np.ndarray


@drawing
def contact_energy(evidence: ResultSet, of: Of, *, which: Which) -> "Figure":
    """Angle and torque of short contacts, a panel each, and the energy added so far below (µJ).

    The torque is scaled to the angle that it answers to. Shaded: inside the wall without torque (late entry), and
    torque outside it (late exit). The energy added is what the wall has done more than one that answers the same
    reading at once. Raises `MissingError` where the encoder's edges are not the wall's.
    """
    shown = recordings(evidence, of, at=which.at, from_s=which.from_s, to_s=which.to_s)
    names = list(which.labels or (each.name for each in shown))
    if len(names) != len(shown):
        raise MissingError(f"{len(shown)} recordings, but {len(names)} labels")
    added = [_added(each) for each in shown]
    heights = [2.0] * len(shown) + [1.4]
    drawn = theme.figure(0.7 + sum(heights))
    panels = drawn.subplots(len(heights), 1, sharex=True, height_ratios=heights)
    time, unit = scale_of(*(each.time for each in shown)), scale_of(*(each.angle for each in shown))
    low = min(float(min(each.angle.min(), (-each.acts / each.scene.wall.stiffness).min())) for each in shown)
    high = max(float(each.angle[[0]].max()) for each in shown)
    for panel, one, name in zip(panels, shown, names, strict=False):
        panel.set_ylim(1.1 * unit.factor * low, 1.1 * unit.factor * high)
        _draw_contact(panel, one, name, time, unit)
        panel.set_ylabel(f"angle, {unit.prefix}rad")
    key(panels[0])
    energy = scale_of(*added)
    for i, (one, name, gained) in enumerate(zip(shown, names, added, strict=True)):
        panels[-1].plot(time.factor * one.time, energy.factor * gained, label=name, **theme.series(i))
        said = f"{energy.factor * gained[-1]:.1f} {energy.prefix}J"
        place = (time.factor * one.time[-1], energy.factor * gained[-1])
        panels[-1].annotate(said, place, xytext=(-3, 3), textcoords="offset points", ha="right", fontsize=8)
    panels[-1].set_ylim(0.0, 1.25 * energy.factor * max(float(gained.max()) for gained in added))
    panels[-1].set_ylabel(f"energy added, {energy.prefix}J")
    panels[-1].set_xlabel(f"time, {time.prefix}s")
    panels[-1].set_xlim(*(time.factor * shown[0].time[[0, -1]]))
    panels[-1].legend(loc="upper left")
    drawn.align_ylabels(list(panels))
    return drawn


def _held(one: Recording) -> Held:
    """Rows, with one more at every change of torque: the same instant before it."""
    changes = np.flatnonzero(np.diff(one.acts)) + 1
    answered = -one.acts / one.scene.wall.stiffness
    return Held(
        np.insert(one.time, changes, one.time[changes]),
        np.insert(one.angle, changes, one.angle[changes]),
        np.insert(answered, changes, answered[changes - 1]),
    )


def _draw_contact(panel: "Axes", one: Recording, name: str, time: Scale, unit: Scale) -> None:
    held = _held(one)
    times, angle, answered = time.factor * held.time, unit.factor * held.angle, unit.factor * held.answered
    late = {"late entry": (angle < 0.0) & (answered == 0.0), "late exit": (angle > 0.0) & (answered < 0.0)}
    for part, where in late.items():
        index, hatch = LATE[part]
        shade: dict[str, Any] = {"facecolor": theme.COLOURS[index], "alpha": 0.45, "hatch": hatch, "linewidth": 0.0}
        panel.fill_between(times, angle, answered, where=where.tolist(), label=part, **shade)
    panel.plot(times, angle, label="knob", **theme.series(0))
    panel.plot(times, answered, label="torque of the wall (right)", color=theme.COLOURS[1], linewidth=1.1)
    read = one.samples
    dots: dict[str, Any] = {"color": theme.COLOURS[0], "marker": "o", "linestyle": "none", "markersize": 3.0}
    panel.plot(time.factor * one.time[read], unit.factor * one.angle[read], **dots)
    draw_torque_axis(panel, one, unit)
    draw_wall(panel, one, unit)
    panel.text(0.985, 0.06, name, transform=panel.transAxes, ha="right", va="bottom")


def _added(one: Recording) -> np.ndarray:
    """Work of the wall so far (J), more than that of a wall that answers the same reading at once.

    All energy that changes is the wall's work, for nothing damps the knob; its rows carry no energy of the wall. The
    immediate wall has the potential U of slope -torque, 0 outside: K d^2 (n(n + 1)/2 + (n + 1) f) at n counts d and a
    part f inside, K angle^2 / 2 with a continuous sensor.
    """
    scene = one.scene
    encoder, hand = scene.encoder, scene.hand
    damped = scene.knob.damping or scene.coil or scene.knob.coulomb_torque or (hand and (hand.damping or hand.finger))
    if damped or scene.wall.stiffness == 0.0 or (encoder and (encoder.rounding != "floor" or encoder.offset_counts)):
        raise MissingError(f"'{one.name}' is damped, or has no wall, or count edges that are not the wall's")
    inside = np.maximum(0.0, -one.angle)
    if one.quantum:
        whole, part = np.divmod(inside / one.quantum, 1.0)
        potential = scene.wall.stiffness * one.quantum**2 * (0.5 * whole * (whole + 1.0) + (whole + 1.0) * part)
    else:
        potential = 0.5 * scene.wall.stiffness * inside**2
    total = one.energy + potential
    added: np.ndarray = total - total[0]
    return added
