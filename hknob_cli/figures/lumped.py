"""Springs, dampers, masses and ground, as lines: what schematics of lumped models are made of."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_LINE: dict[str, Any] = {"color": "black", "linewidth": 1.2, "solid_capstyle": "round", "solid_joinstyle": "round"}


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
