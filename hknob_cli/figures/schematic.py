"""Line drawings of what is modelled: hand, knob, wall and relay (Hasser, Figs 4, 13, 14, 27, 41-44).

Springs, dampers, masses and ground, as lines: what schematics of lumped models are made of.

Lumped models of hand, knob and wall, as line drawings (Hasser, Figs 4, 13, 14, 27).
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from hknob_cli.figures import drawing, theme
from hknob_cli.results.result_set import MissingError, ResultSet

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LINE: dict[str, Any] = {"color": "black", "linewidth": 1.2, "solid_capstyle": "round", "solid_joinstyle": "round"}

SCALE = 0.85  # inches to one unit of a drawing


def spring(panel: "Axes", x0: float, x1: float, y: float, label: str) -> None:
    """A zigzag from ``x0`` to ``x1``, its name above."""
    lead, turns = 0.22 * (x1 - x0), 6
    step = (x1 - x0 - 2.0 * lead) / (2 * turns)
    xs = [x0, x0 + lead, *(x0 + lead + (i + 0.5) * step for i in range(2 * turns)), x1 - lead, x1]
    ys = [y, y, *(y + 0.13 * (-1) ** i for i in range(2 * turns)), y, y]
    panel.plot(xs, ys, **_LINE)
    panel.text(0.5 * (x0 + x1), y + 0.2, label, ha="center", va="bottom")


def damper(panel: "Axes", x0: float, x1: float, y: float, label: str) -> None:
    """A pot and its piston from ``x0`` to ``x1``, its name above."""
    left, right, piston = x0 + 0.32 * (x1 - x0), x0 + 0.68 * (x1 - x0), x0 + 0.55 * (x1 - x0)
    panel.plot([x0, left], [y, y], **_LINE)
    panel.plot([right, left, left, right], [y + 0.14, y + 0.14, y - 0.14, y - 0.14], **_LINE)
    panel.plot([piston, piston], [y - 0.1, y + 0.1], **(_LINE | {"linewidth": 2.0}))
    panel.plot([piston, x1], [y, y], **_LINE)
    panel.text(0.5 * (x0 + x1), y + 0.2, label, ha="center", va="bottom")


def mass(panel: "Axes", x: float, y: float, width: float, height: float, label: str) -> None:
    """A box with its left edge at ``x``, centred at ``y``, its name inside."""
    from matplotlib.patches import Rectangle

    panel.add_patch(Rectangle((x, y - 0.5 * height), width, height, facecolor="none", edgecolor="black", linewidth=1.2))
    panel.text(x + 0.5 * width, y, label, ha="center", va="center")


def ground(panel: "Axes", x: float, y: float, height: float, label: str, *, side: int = -1) -> None:
    """A fixed wall at ``x``, hatched on its left (``side`` -1) or right (1), its name above."""
    low, high = y - 0.5 * height, y + 0.5 * height
    panel.plot([x, x], [low, high], **(_LINE | {"linewidth": 1.6}))
    count = max(3, round(height / 0.22))
    for i in range(count):
        at = low + (i + 0.5) * height / count
        panel.plot([x, x + side * 0.14], [at, at - 0.14], **(_LINE | {"linewidth": 0.8}))
    panel.text(x, high + 0.08, label, ha="center", va="bottom")


def arrow(panel: "Axes", x0: float, x1: float, y: float, label: str) -> None:
    """An arrow from ``x0`` to ``x1``, its name above."""
    look = {"arrowstyle": "-|>", "color": "black", "linewidth": 1.2, "shrinkA": 0, "shrinkB": 0}
    panel.annotate("", (x1, y), xytext=(x0, y), arrowprops=look)
    panel.text(0.5 * (x0 + x1), y + 0.06, label, ha="center", va="bottom")


@drawing
def schematic(_evidence: ResultSet, _of: Any = None, *, kind: str) -> "Figure":
    """A model as springs, dampers and inertias; they turn, but are drawn as if they slid.

    ``kind``: second (hand and knob as one), fourth (finger, fingerpad, actuator), network (the same as a mechanical
    network, angles as its nodes) or wall (outside it and inside it). Raises `MissingError` for any other.
    """
    # Drawing, and the sides of the picture in its own units.
    draws = {
        "second": (_second, (-0.4, 4.4, -0.95, 1.3)),
        "fourth": (_fourth, (-0.4, 7.3, -1.3, 1.3)),
        "network": (_network, (-0.7, 6.7, -0.3, 3.0)),
        "wall": (_wall, (-0.7, 7.0, -4.4, 1.5)),
    }
    if kind not in draws:
        raise MissingError(f"no schematic '{kind}'; there are {', '.join(draws)}")
    return draw_to_scale(*draws[kind])


def draw_to_scale(
    draw: Callable[["Axes"], None], sides: tuple[float, float, float, float], scale: float = SCALE
) -> "Figure":
    """A figure without axes; ``sides``: left, right, low and high in the drawing's unit, ``scale``: inches a unit."""
    left, right, low, high = sides
    drawn = theme.figure(scale * (high - low), width=scale * (right - left))
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


def _network(panel: "Axes") -> None:
    """Elements between the nodes of the two angles, and from each to ground; torque goes through, speed lies across."""
    knob, finger, low, high = 2.2, 4.0, 0.0, 2.2
    panel.plot([-0.2, 6.2], [low, low], **_LINE)
    ground(panel, -0.2, low, 0.3, "")
    panel.text(-0.2, low + 0.25, "ground", ha="center", va="bottom")
    panel.plot([0.5, knob], [high, high], **_LINE)
    panel.plot([finger, 6.0], [high, high], **_LINE)
    for x, name in ((0.5, "T"), (1.5, "J\u2082"), (4.4, "J\u2081"), (5.2, "K\u2081"), (6.0, "B\u2081")):
        _branch(panel, (x, low), (x, high), name)
    for y, name in ((high + 0.35, "K\u2082"), (high - 0.35, "B\u2082")):
        panel.plot([knob, knob], [high, y], **_LINE)
        panel.plot([finger, finger], [high, y], **_LINE)
        _branch(panel, (knob, y), (finger, y), name)
    for x, name, side in ((knob, "\u03b8\u2082", "right"), (finger, "\u03b8\u2081", "left")):
        panel.plot([x], [high], "o", color="black", markersize=4)
        panel.text(x + (-0.12 if side == "right" else 0.12), high + 0.12, name, ha=side, va="bottom")


def _branch(panel: "Axes", start: tuple[float, float], end: tuple[float, float], name: str) -> None:
    """A line from node to node with an element named on it: a circle for the torque, else a box."""
    across = 0.5 * (start[0] + end[0]), 0.5 * (start[1] + end[1])
    panel.plot([start[0], end[0]], [start[1], end[1]], **_LINE)
    shape = "circle" if name == "T" else "square"
    look = {"boxstyle": f"{shape},pad=0.3", "facecolor": "white", "edgecolor": "black", "linewidth": 1.2}
    panel.text(*across, name, ha="center", va="center", bbox=look)


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


@drawing
def block_diagram(_evidence: ResultSet, _of: Any = None) -> "Figure":
    """A linear part G and a nonlinear part H in a closed loop (Hasser, Fig. 41). Needs no result."""
    from matplotlib.patches import Circle, FancyBboxPatch

    figure = theme.figure(2.1)
    axes = figure.subplots()
    axes.set_axis_off()
    axes.set_xlim(0.0, 7.2)
    axes.set_ylim(0.0, 2.1)
    axes.set_aspect("equal")
    for x, y, name, what in (
        (3.1, 1.15, "G(j\u03c9)", "hand and knob"),
        (3.1, 0.1, "H(j\u03c9)", "wall, counts and hold"),
    ):
        axes.add_patch(FancyBboxPatch((x, y), 1.7, 0.62, boxstyle="round,pad=0,rounding_size=0.06", fill=False,
                                      edgecolor="black", linewidth=1.3))  # fmt: skip
        axes.text(x + 0.85, y + 0.4, name, ha="center", va="center", fontsize=11, style="italic")
        axes.text(x + 0.85, y + 0.16, what, ha="center", va="center", fontsize=8)
    axes.add_patch(Circle((1.5, 1.46), 0.16, fill=False, edgecolor="black", linewidth=1.3))
    for start, end in (
        ((0.4, 1.46), (1.34, 1.46)),
        ((1.66, 1.46), (3.1, 1.46)),
        ((4.8, 1.46), (6.8, 1.46)),
        ((5.8, 0.41), (4.8, 0.41)),
        ((1.5, 0.41), (1.5, 1.3)),
    ):
        axes.annotate("", end, start, arrowprops={"arrowstyle": "-|>", "color": "black", "shrinkA": 0, "shrinkB": 0})
    axes.plot([5.8, 5.8], [1.46, 0.41], color="black", linewidth=1.0)
    axes.plot([3.1, 1.5], [0.41, 0.41], color="black", linewidth=1.0)
    axes.plot([5.8], [1.46], marker="o", markersize=4, color="black")
    for x, y, text in (
        (0.45, 1.58, "r(t)\nbias torque"),
        (2.38, 1.58, "u(t)\ntorque on the knob"),
        (5.95, 1.58, "y(t)\nangle \u03b8"),
        (2.3, 0.53, "w(t)\ntorque of the wall"),
    ):
        axes.text(x, y, text, ha="left" if x < 1 or x > 5 else "center", va="bottom", fontsize=8, linespacing=1.1)
    axes.text(1.26, 1.68, "+", ha="center", va="center", fontsize=10)
    axes.text(1.3, 1.2, "\u2212", ha="center", va="center", fontsize=11)
    return figure


@drawing
def nonlinearity(
    _evidence: ResultSet, _of: Any = None, *, panels: tuple[str, ...] = ("relay", "wall", "biased")
) -> "Figure":
    """The relay, the wall over one count, and the wall with half a count's torque (Hasser, Figs 42, 43, 44).

    ``panels`` are among "relay", "wall" and "biased". Needs no result.
    """
    figure = theme.figure(2.5, theme.WIDTH * len(panels) / 3.0 + 0.2 * (3 - len(panels)))
    shapes = {
        "relay": (-1.0, 1.0, "M", "a relay", "input"),
        "wall": (-1.0, 0.0, "K\u0394\u03b8", "the wall within one count", "angle \u03b8"),
        "biased": (-0.5, 0.5, "\u00bdK\u0394\u03b8", "the wall with a bias of half a count", "angle \u03b8"),
    }
    places = figure.subplots(1, len(panels), squeeze=False)[0]
    for axes, panel in zip(places, panels, strict=True):
        _step(axes, *shapes[panel])
    return figure


def _step(axes: "Axes", low: float, high: float, unit: str, title: str, across: str) -> None:
    """A step from ``low`` to ``high`` at 0, between axes through the origin."""
    for side in ("left", "bottom"):
        axes.spines[side].set_position("zero")
        axes.spines[side].set_linewidth(0.8)
    axes.grid(visible=False)
    axes.plot([-1.0, 0.0, 0.0, 1.0], [low, low, high, high], color=theme.COLOURS[0], linewidth=2.4)
    axes.set_xlim(-1.15, 1.15)
    axes.set_ylim(-1.35, 1.35)
    axes.set_xticks([])
    axes.set_yticks([])
    for level in {low, high} - {0.0}:
        text = f"\u2212{unit}" if level < 0 else unit
        axes.text(
            0.06 if level < 0 else -0.06, level, text, ha="left" if level < 0 else "right", va="center", fontsize=9
        )
        axes.plot([-0.03, 0.03], [level, level], color="black", linewidth=0.8)
    axes.text(1.15, -0.09, across, ha="right", va="top", fontsize=8)
    axes.text(0.06, 1.35, "output, N\u00b7m", ha="left", va="top", fontsize=8)
    if low == -1.0 and high == 0.0:
        axes.text(-0.55, -1.08, "inside", ha="center", va="top", fontsize=8)
        axes.text(0.55, 0.08, "outside", ha="center", va="bottom", fontsize=8)
    axes.set_title(title)
