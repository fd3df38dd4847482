"""The loop that describing functions are for, and its relay: block diagram and nonlinearities (Hasser, Figs 41-44)."""

from typing import TYPE_CHECKING, Any

from hknob_cli.figures import drawing, theme
from hknob_cli.results.result_set import ResultSet

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


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
