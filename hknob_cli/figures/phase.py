"""The phase plane: velocity over angle, the way in faint and the limit cycle strong (Hasser, Fig. 72)."""

from typing import TYPE_CHECKING, Any

import numpy as np

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.panel import edges_between, key, scale_of
from hknob_cli.figures.recording import At, Of, Recording, one_recording
from hknob_cli.results.result_set import MissingError, ResultSet

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ARROWS = 4  # along the cycle


@drawing
def phase_plane(
    evidence: ResultSet,
    of: Of,
    *,
    at: At | None = None,
    from_s: float | None = None,
    to_s: float | None = None,
    steady_s: float = 0.05,
    samples: bool = True,
    height: float = 4.0,
) -> "Figure":
    """Velocity (rad/s) over angle of one recording.

    The last ``steady_s`` (s) of the window are strong, what comes before faint; ``samples`` marks where the controller
    reads in the strong part. ``height`` in inches. Raises `MissingError`.
    """
    one = one_recording(evidence, of, at=at, from_s=from_s, to_s=to_s)
    begin = float(one.time[-1]) - steady_s
    steady = one.between(begin, None)
    if steady.time[0] == one.time[0]:
        raise MissingError(f"{steady_s:g} s of '{one.name}' are more than the window shown")
    unit = scale_of(one.angle)
    drawn = theme.figure(height, width=5.6)
    panel = drawn.subplots()
    before = one.time <= steady.time[0]
    panel.plot(
        unit.factor * one.angle[before], one.velocity[before], color="black", linewidth=0.8, alpha=0.45, label="way in"
    )
    panel.plot(unit.factor * steady.angle, steady.velocity, label="steady", **theme.series(0))
    if samples:
        dots: dict[str, Any] = {"color": theme.COLOURS[1], "marker": "o", "linestyle": "none", "markersize": 3.0}
        read = steady.samples
        panel.plot(unit.factor * steady.angle[read], steady.velocity[read], label="samples", **dots)
    _point(panel, steady, unit.factor)
    _rule(panel, one, unit.factor)
    panel.set_xlabel(f"angle, {unit.prefix}rad")
    panel.set_ylabel("velocity, rad/s")
    key(panel)
    return drawn


def _point(panel: "Axes", steady: Recording, factor: float) -> None:
    """Arrows in the direction of motion, at equal parts of one cycle."""
    peaks, _, up = steady.turns
    tops = peaks[up]
    if len(tops) < 2:
        return
    span = float(tops[1] - tops[0])
    for part in (np.arange(ARROWS) + 0.5) / ARROWS:
        times = tops[0] + span * (part + np.array([0.0, 0.02]))
        (x0, x1), (y0, y1) = (np.interp(times, steady.time, of) for of in (factor * steady.angle, steady.velocity))
        arrow: dict[str, Any] = {
            "arrowstyle": "-|>",
            "color": theme.COLOURS[0],
            "shrinkA": 0,
            "shrinkB": 0,
            "mutation_scale": 13,
        }
        panel.annotate("", (x1, y1), xytext=(x0, y0), arrowprops=arrow)


def _rule(panel: "Axes", one: Recording, factor: float) -> None:
    """The wall, shaded and with its edge dotted, and count edges; what is in view has a name in the key."""
    low, high = panel.get_xlim()
    if one.scene.wall.stiffness > 0.0:
        panel.axvspan(min(low, 0.0), 0.0, color="black", alpha=0.06, linewidth=0)
        name = "edge of the wall" if low < 0.0 < high else "_"
        panel.axvline(0.0, color="black", linewidth=1.1, linestyle=":", label=name)
    edges = edges_between(low, high, factor * one.quantum)
    for i, edge in enumerate(edges):
        name = "_" if i else "edge of a count"
        panel.axvline(edge, color="black", linewidth=0.8, alpha=0.6, linestyle=(0, (1, 2)), label=name)
    panel.set_xlim(low, high)
