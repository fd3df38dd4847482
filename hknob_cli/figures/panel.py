"""What panels of motion share: units, the wall and its counts, keys above the axes, steps."""

from typing import TYPE_CHECKING, Any

import numpy as np

from hknob_cli.figures import theme
from hknob_cli.figures.recording import Recording
from hknob_cli.figures.trajectory_picture import Scale

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ROOM = 145  # characters of a key's line in a full-width figure, its lines and gaps counted as six an entry
BESIDE = 0.8  # inches beside a panel, of any width, for its labels
MOST_EDGES = 40  # count edges that a panel shows


def scale_of(*arrays: np.ndarray) -> Scale:
    """A unit in which the largest of some arrays is at least 0.1."""
    return Scale(10.0 * max(float(np.abs(array).max()) for array in arrays))


def torque_scale(*shown: Recording) -> Scale:
    """A unit that suits the largest torque of the actuator; 1.3 N·m rather than 1300 mN·m."""
    unit = scale_of(*(each.acts for each in shown))
    if unit.factor * max(float(np.abs(each.acts).max()) for each in shown) >= 1000.0:
        unit.prefix, unit.factor = "", 1.0
    return unit


def draw_torque_axis(panel: "Axes", one: Recording, unit: Scale) -> None:
    """At the right, the torque of a wall whose angle is the one on the left, in ``unit``."""
    torque = torque_scale(one)
    per = -torque.factor * one.scene.wall.stiffness / unit.factor

    def to_torque(angle: Any) -> Any:
        return per * angle

    def to_angle(torque: Any) -> Any:
        return torque / per

    own = panel.secondary_yaxis("right", functions=(to_torque, to_angle))
    own.set_ylabel(f"torque, {torque.prefix}N\u00b7m")
    own.spines["right"].set_visible(True)


def key(panel: "Axes") -> None:
    """Legend above the axes, where nothing is drawn, in as many columns as its longest entry leaves room for."""
    longest = max(len(label) for label in panel.get_legend_handles_labels()[1])
    figure = panel.get_figure(root=True)
    assert figure is not None  # a panel is always in one
    room = ROOM * (figure.get_figwidth() - BESIDE) / (theme.WIDTH - BESIDE)
    columns = min(5, max(1, int(room / (longest + 6))))
    panel.legend(
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
        ncols=columns,
        borderaxespad=0.2,
        handlelength=2.6,
        columnspacing=1.4,
    )


def draw_wall(panel: "Axes", one: Recording, unit: Scale, *, counts: bool = True) -> None:
    """Shade the wall below angle 0, and rule its edge and the count edges that are in view."""
    low, high = panel.get_ylim()
    if one.scene.wall.stiffness == 0.0:
        return
    panel.axhspan(min(low, 0.0), 0.0, color="black", alpha=0.06, linewidth=0)
    panel.axhline(0.0, color="black", linewidth=0.8, linestyle=(0, (4, 2)))
    if counts:
        for edge in edges_between(low, high, unit.factor * one.quantum):
            panel.axhline(edge, color="black", linewidth=0.5, alpha=0.35, linestyle=(0, (1, 2)))
    panel.set_ylim(low, high)


def edges_between(low: float, high: float, step: float) -> list[float]:
    """Multiples of ``step`` but 0 between two values; none where they are too many to tell apart."""
    if step <= 0.0 or (high - low) / step > MOST_EDGES:
        return []
    return [float(i * step) for i in range(int(np.ceil(low / step)), int(np.floor(high / step)) + 1) if i]


def draw_steps(panel: "Axes", one: Recording, time: Scale, factor: float, **style: Any) -> None:
    """The actuator's torque, times ``factor``, as it holds from change to change."""
    times, torques = one.steps
    panel.plot(time.factor * times, factor * torques, drawstyle="steps-post", **style)
