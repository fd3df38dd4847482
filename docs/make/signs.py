"""The drawing of the sign conventions: ``python docs/make/signs.py`` writes docs/pictures/signs.svg."""

import math
from pathlib import Path

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Circle, FancyArrowPatch, Wedge

INK, WALL, PUSH, TORQUE = "#333333", "#d9d9d9", "#b3541e", "#1f5fa8"
DEPTH = 24.0  # of the pointer in the wall, degrees
PLACE = Path(__file__).parent.parent / "pictures" / "signs.svg"


def main() -> None:
    """Draw it, the same bytes every time."""
    mpl.rcParams["svg.hashsalt"] = "hknob"
    mpl.rcParams["svg.fonttype"] = "path"
    figure = Figure(figsize=(8.0, 3.6), layout="constrained")
    left, right = figure.subplots(1, 2)
    _knob(left)
    _staircase(right)
    figure.savefig(PLACE, metadata={"Date": None}, transparent=False, facecolor="white")
    PLACE.write_text("\n".join(line.rstrip() for line in PLACE.read_text().splitlines()) + "\n")


def _at(degrees: float, radius: float) -> tuple[float, float]:
    """Place at an angle from the wall's edge, which points up; growing angles turn to the right, outwards."""
    return radius * math.sin(math.radians(degrees)), radius * math.cos(math.radians(degrees))


def _turn(axes: Axes, radius: float, first: float, last: float, colour: str) -> None:
    axes.add_patch(
        FancyArrowPatch(
            _at(first, radius),
            _at(last, radius),
            connectionstyle=f"arc3,rad={-0.15 if last > first else 0.15}",
            arrowstyle="-|>",
            mutation_scale=14,
            color=colour,
            linewidth=2,
        )
    )


def _knob(axes: Axes) -> None:
    axes.add_patch(Wedge((0, 0), 1.5, 90, 170, color=WALL))
    axes.add_patch(Circle((0, 0), 0.75, facecolor="white", edgecolor=INK, linewidth=1.5))
    axes.plot(*zip((0, 0), _at(0, 1.6), strict=True), color=INK, linewidth=1, linestyle="--")
    axes.plot(*zip((0, 0), _at(-DEPTH, 0.75), strict=True), color=INK, linewidth=3)
    axes.add_patch(Arc((0, 0), 1.1, 1.1, theta1=90, theta2=90 + DEPTH, color=INK))
    axes.text(*_at(-58, 0.42), "θ < 0", ha="center", va="center", fontsize=10, color=INK)
    axes.text(*_at(0, 1.72), "angle 0: the wall's edge", ha="center", fontsize=10, color=INK)
    axes.text(*_at(-62, 1.12), "inside\nthe wall", ha="center", va="center", fontsize=10, color=INK)
    axes.text(*_at(82, 1.35), "outside:\nθ > 0", ha="center", va="center", fontsize=10, color=INK)
    _turn(axes, 1.25, 30, -8, PUSH)
    axes.text(*_at(40, 1.5), "push (bias),\ninto the wall", ha="left", va="center", fontsize=10, color=PUSH)
    _turn(axes, 0.92, -40, 10, TORQUE)
    axes.text(*_at(-140, 1.15), "torque of the wall > 0, out of it", ha="center", fontsize=10, color=TORQUE)
    axes.set(xlim=(-1.9, 2.3), ylim=(-1.1, 1.95), aspect="equal")
    axes.axis("off")


def _staircase(axes: Axes) -> None:
    edges = range(-4, 4)
    for edge in edges:
        height = max(0, -edge)
        axes.plot([edge, edge + 1], [height, height], color=TORQUE, linewidth=2.5)
    axes.plot([-4, 0, 4], [4, 0, 0], color=INK, linewidth=1, linestyle="--", label="spring without encoder")
    axes.axvspan(-4, 0, color=WALL, zorder=0)
    axes.annotate("", (-1.5, 1), (-1.5, 2), arrowprops={"arrowstyle": "<->", "color": PUSH})
    axes.text(-1.35, 1.45, "K Δθ", color=PUSH, fontsize=10)
    axes.text(0.15, 0.93, "first count", color=TORQUE, fontsize=10)
    axes.set(xlim=(-4, 4), ylim=(-0.2, 4.2), xticks=list(range(-4, 5)), yticks=list(range(5)))
    axes.set_xlabel("angle θ, counts (encoder: floor, offset 0)")
    axes.set_ylabel("torque of the wall, K Δθ")
    axes.legend(frameon=False, fontsize=9, loc="upper right")
    axes.spines[["top", "right"]].set_visible(False)


if __name__ == "__main__":
    main()
