"""Lumped models of hand, knob and wall, as line drawings (Hasser, Figs 4, 13, 14, 27)."""

from typing import TYPE_CHECKING, Any

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.lumped import arrow, damper, ground, mass, spring
from hknob_cli.results.result_set import MissingError, ResultSet

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SCALE = 0.85  # inches to one unit of a drawing


@drawing
def schematic(_evidence: ResultSet, _of: Any = None, *, kind: str) -> "Figure":
    """A model as springs, dampers and inertias; they turn, but are drawn as if they slid.

    ``kind``: second (hand and knob as one), fourth (finger, fingerpad, actuator) or wall (outside it and inside it).
    Raises `MissingError` for any other.
    """
    # Drawing, and the sides of the picture in its own units.
    draws = {
        "second": (_second, (-0.4, 4.4, -0.95, 1.3)),
        "fourth": (_fourth, (-0.4, 7.3, -1.3, 1.3)),
        "wall": (_wall, (-0.7, 7.0, -4.4, 1.5)),
    }
    if kind not in draws:
        raise MissingError(f"no schematic '{kind}'; there are {', '.join(draws)}")
    draw, (left, right, low, high) = draws[kind]
    drawn = theme.figure(SCALE * (high - low), width=SCALE * (right - left))
    panel = drawn.subplots()
    draw(panel)
    panel.set_xlim(left, right)
    panel.set_ylim(low, high)
    panel.set_aspect("equal")
    panel.set_axis_off()
    return drawn


def _second(panel: "Axes") -> None:
    ground(panel, 0.0, 0.0, 1.5, "ground")
    _pair(panel, 0.0, 1.8, "K", "B")
    mass(panel, 1.8, 0.0, 0.9, 1.3, "J")
    arrow(panel, 2.7, 3.7, 0.0, "torque T")
    arrow(panel, 2.25, 2.95, 0.8, "angle \u03b8")


def _fourth(panel: "Axes") -> None:
    ground(panel, 0.0, 0.0, 1.5, "ground")
    _pair(panel, 0.0, 1.8, "K\u2081", "B\u2081")
    mass(panel, 1.8, 0.0, 1.0, 1.3, "finger\nJ\u2081")
    _pair(panel, 2.8, 4.6, "K\u2082", "B\u2082")
    panel.text(3.7, -0.95, "fingerpad", ha="center", va="top")
    mass(panel, 4.6, 0.0, 1.0, 1.3, "actuator\nJ\u2082")
    arrow(panel, 5.6, 6.6, 0.0, "torque T")
    arrow(panel, 2.3, 3.0, 0.8, "\u03b8\u2081")
    arrow(panel, 5.1, 5.8, 0.8, "\u03b8\u2082")


def _wall(panel: "Axes") -> None:
    """The push g points at the wall; the angle grows away from it, and is 0 where the knob meets the wall's spring."""
    for y, inside in ((0.0, False), (-3.0, True)):
        ground(panel, 0.0, y, 1.9, "hand and motor")
        spring(panel, 0.0, 1.8, y + 0.6, "k")
        damper(panel, 0.0, 1.8, y, "b")
        damper(panel, 0.0, 1.8, y - 0.6, "B")
        mass(panel, 1.8, y, 1.0, 1.7, "fingers\nj")
        mass(panel, 2.8, y, 1.0, 1.7, "knob\nJ")
        arrow(panel, 2.4, 3.2, y + 1.0, "push g")
        edge = 3.8 if inside else 4.7
        spring(panel, edge, 5.7 if inside else 6.6, y, "K")
        ground(panel, 5.7 if inside else 6.6, y, 1.3, "virtual wall", side=1)
        panel.plot([edge, edge], [y - 0.5, y + 0.5], color="black", linewidth=1.6)
        if not inside:
            arrow(panel, 4.7, 3.85, y - 0.7, "angle \u03b8")
            panel.plot([4.7, 4.7], [y - 0.95, y - 0.5], color="black", linewidth=0.8, linestyle=":")
        panel.text(2.8, y - 1.0, f"{'inside' if inside else 'outside'} the wall", ha="center", va="top")


def _pair(panel: "Axes", x0: float, x1: float, stiffness: str, damping: str, *, y: float = 0.0) -> None:
    spring(panel, x0, x1, y + 0.4, stiffness)
    damper(panel, x0, x1, y - 0.4, damping)
