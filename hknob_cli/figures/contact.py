"""A short contact with the wall: where the torque acts late, and the energy that adds (Hasser, Fig. 60)."""

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.panel import draw_torque_axis, draw_wall, key, scale_of
from hknob_cli.figures.recording import Of, Recording, Which, recordings
from hknob_cli.figures.trajectory_picture import Scale
from hknob_cli.results.result_set import MissingError, ResultSet

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

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
