"""The apparatus: line drawings of our own, and its benches (Hasser, Figs 1, 2, 17, 77-81).

The print has a CAD drawing and photographs. These show what its text says of them; knobs and the knob's end are to
scale, the rest is not.
"""

from typing import TYPE_CHECKING, Any

from hknob_cli.apparatus.experiment import POSITIONS_M
from hknob_cli.apparatus.hand_recording import Rig
from hknob_cli.figures import drawing, theme
from hknob_cli.figures.schematic import SCALE, draw_to_scale, ground
from hknob_cli.results.result_set import MissingError, Result, ResultSet, Rows

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SMALL_MM, MEDIUM_MM = 17.8, 29.9  # diameters of the knobs (sec. 5.1)
FLEXURE_MM = 1.9  # of free flexure (Appendix B)
SMALL_TEXT = 8
_FINGER_MM = 15.0  # width of a finger, assumed
_EDGE: dict[str, Any] = {"edgecolor": "black", "linewidth": 1.2, "facecolor": "none"}
_FLESH: dict[str, Any] = {"edgecolor": theme.COLOURS[1], "linewidth": 1.4, "facecolor": theme.COLOURS[1], "alpha": 0.25}


@drawing
def apparatus_drawing(_evidence: ResultSet, _of: Any = None, *, kind: str) -> "Figure":
    """A part of the apparatus. Needs no result.

    ``kind``: rig (knob, motor, encoder, cells), pinch (the first grasp, from the knob's end), grasps (the four others)
    or calibration (weights on the grip cell, and the knob's end). Raises `MissingError` for any other.
    """
    # Drawing, the sides of the picture in its own units, and inches to a unit.
    draws = {
        "rig": (_rig, (-0.2, 8.6, -1.75, 2.1), SCALE),
        "pinch": (_pinch, (-3.7, 3.7, -1.6, 1.9), 0.75),
        "grasps": (_grasps, (-3.3, 11.2, -7.4, 1.7), 0.49),
        "calibration": (_calibration, (-0.4, 8.2, -1.0, 2.6), SCALE),
    }
    if kind not in draws:
        raise MissingError(f"no drawing '{kind}' of the apparatus; there are {', '.join(draws)}")
    return draw_to_scale(*draws[kind])


def _box(panel: "Axes", left: float, low: float, width: float, height: float, **style: Any) -> None:
    from matplotlib.patches import Rectangle

    panel.add_patch(Rectangle((left, low), width, height, **(_EDGE | style)))


def _note(panel: "Axes", at: tuple[float, float], text: str, place: tuple[float, float]) -> None:
    """A text at ``place``, with a thin line from it to what it names."""
    panel.annotate(
        text, at, place, fontsize=SMALL_TEXT, ha="center", va="bottom" if place[1] > at[1] else "top", linespacing=1.15,
        arrowprops={"arrowstyle": "-", "color": "black", "linewidth": 0.6, "shrinkA": 1, "shrinkB": 0},
    )  # fmt: skip


def _rig(panel: "Axes") -> None:
    """Along the shaft: the motor's housing may turn, and a cell holds it back."""
    rig = Rig()
    _box(panel, 0.5, -0.52, 1.0, 1.04)  # knob
    _box(panel, 0.85, 0.52, 0.3, 0.16, facecolor="black", alpha=0.35)  # grip cell's shell
    _box(panel, 1.5, -0.1, 5.9, 0.2)  # shaft
    for x in (2.3, 6.1):  # bearings of the housing
        _box(panel, x, 0.1, 0.25, 0.3)
        _box(panel, x, -0.4, 0.25, 0.3)
        panel.plot([x, x + 0.25], [0.1, 0.4], color="black", linewidth=0.8)
        panel.plot([x, x + 0.25], [-0.4, -0.1], color="black", linewidth=0.8)
    _box(panel, 3.1, -0.6, 2.4, 1.2)
    panel.text(4.3, 0.35, "motor", ha="center", va="center")
    _box(panel, 7.2, -0.8, 0.1, 1.6, facecolor="black", alpha=0.35)  # encoder disk
    _box(panel, 7.45, 0.45, 0.35, 0.4)  # its reading head
    _box(panel, 4.15, -1.2, 0.3, 0.6)  # arm
    _box(panel, 3.95, -1.4, 0.7, 0.2, facecolor="black", alpha=0.35)  # torque cell
    panel.plot([0.9, 8.2], [-1.5, -1.5], color="black", linewidth=1.6)
    for x in (2.42, 6.22):
        panel.plot([x, x], [-1.5, -0.4], color="black", linewidth=1.2)
        panel.plot([x, x], [0.4, 0.75], color="black", linewidth=1.2)
    _note(panel, (1.0, 0.62), "knob, with a cell\nfor the grip's force", (1.0, 1.35))
    _note(panel, (2.42, 0.7), "bearings that let\nthe housing turn", (2.75, 1.35))
    _note(panel, (4.3, 0.6), "Maxon RE025, driven by a\nTA-115 as a source of current", (4.75, 1.35))
    _note(panel, (7.25, 0.8), f"optical encoder,\n{rig.counts_per_rev:,} counts", (7.2, 1.35))
    panel.annotate(
        "reaction torque cell (not used:\noff-axis moments disturbed it)",
        (4.65, -1.3),
        (6.5, -0.98),
        fontsize=SMALL_TEXT,
        ha="left",
        va="center",
        arrowprops={"arrowstyle": "-", "color": "black", "linewidth": 0.6, "shrinkA": 1, "shrinkB": 0},
    )
    panel.text(0.75, -1.1, "read and driven\nat 10 kHz", ha="center", va="center", fontsize=SMALL_TEXT)


def _knob(panel: "Axes", x: float, y: float, diameter_mm: float) -> float:
    """A knob seen from its end, a unit a centimetre, and its axis; its radius in units."""
    from matplotlib.patches import Circle

    radius = 0.05 * diameter_mm
    panel.add_patch(Circle((x, y), radius, **_EDGE))
    panel.plot([x - 0.1, x + 0.1], [y, y], color="black", linewidth=0.8)
    panel.plot([x, x], [y - 0.1, y + 0.1], color="black", linewidth=0.8)
    return radius


def _finger(panel: "Axes", tip: tuple[float, float], degrees: float, length: float, name: str = "") -> None:
    """A finger as a bar with a round end, its width to the knob's scale; the end is at ``tip``, along ``degrees``."""
    from math import cos, pi, radians, sin

    from matplotlib.patches import Polygon

    half, turn = 0.05 * _FINGER_MM, radians(degrees)
    round_end = [(half * sin(at) - half, half * cos(at)) for at in (pi * i / 24 for i in range(25))]
    outline = [(-length, half), *round_end, (-length, -half)]
    placed = [(tip[0] + x * cos(turn) - y * sin(turn), tip[1] + x * sin(turn) + y * cos(turn)) for x, y in outline]
    panel.add_patch(Polygon(placed, closed=False, **_FLESH))
    place = (tip[0] - 0.55 * length * cos(turn), tip[1] - 0.55 * length * sin(turn))
    panel.text(*place, name, ha="center", va="center", fontsize=SMALL_TEXT)


def _push(panel: "Axes", start: tuple[float, float], end: tuple[float, float]) -> None:
    look = {"arrowstyle": "-|>", "color": "black", "linewidth": 1.2, "shrinkA": 0, "shrinkB": 0}
    panel.annotate("", end, start, arrowprops=look)


def _pinch(panel: "Axes") -> None:
    """Thumb and forefinger in opposition, and the pulse that turns the knob clockwise."""
    radius = _knob(panel, 0.0, 0.0, SMALL_MM)
    _finger(panel, (-radius, 0.0), 0.0, 2.6, "thumb")
    _finger(panel, (radius, 0.0), 180.0, 2.6, "forefinger")
    turn = {"arrowstyle": "-|>", "color": "black", "linewidth": 1.2, "connectionstyle": "arc3,rad=-0.5"}
    panel.annotate("", (0.75, 1.05), (-0.75, 1.05), arrowprops=turn)
    panel.text(0.0, 1.55, "pulse of 20 ms, clockwise", ha="center", va="bottom", fontsize=SMALL_TEXT)
    panel.annotate("", (-radius, -1.1), (radius, -1.1), arrowprops={"arrowstyle": "<->", "color": "black"})
    panel.text(0.0, -1.18, f"{SMALL_MM} mm", ha="center", va="top", fontsize=SMALL_TEXT)
    _box(panel, -0.1, -0.55, 0.2, 0.3, facecolor="black", alpha=0.35)
    panel.text(0.0, 0.2, "grip cell", ha="center", va="bottom", fontsize=SMALL_TEXT)
    _push(panel, (-0.65, -0.4), (-0.1, -0.4))
    _push(panel, (0.65, -0.4), (0.1, -0.4))


def _grasps(panel: "Axes") -> None:
    wide = 0.05 * _FINGER_MM
    for x, y, diameter, name in (
        (0.0, 0.0, SMALL_MM, "(a) key pinch, 17.8 mm"),
        (7.8, 0.0, MEDIUM_MM, "(b) simple pinch, 29.9 mm"),
        (0.0, -4.9, MEDIUM_MM, "(c) key pinch, 29.9 mm"),
        (7.8, -4.9, MEDIUM_MM, "(d) three fingers, 29.9 mm"),
    ):
        radius = _knob(panel, x, y, diameter)
        panel.text(x, y - 2.0, name, ha="center", va="top", fontsize=9)
        _finger(panel, (x - radius, y), 0.0, 1.6, "thumb")
        if "key" in name:  # the forefinger lies across, the side of its last joint on the knob
            _finger(panel, (x + radius + wide, y + 1.0), 90.0, 2.6)
            side = "side of the\nforefinger"
            panel.text(x + radius + 2.0 * wide + 0.1, y, side, ha="left", va="center", fontsize=SMALL_TEXT)
        elif "simple" in name:
            _finger(panel, (x + radius, y), 180.0, 1.6, "forefinger")
        else:  # two fingers that touch each other, opposite to the thumb
            reach = ((radius + wide) ** 2 - wide**2) ** 0.5 - wide
            _finger(panel, (x + reach, y + wide), 180.0, 1.8, "forefinger")
            _finger(panel, (x + reach, y - wide), 180.0, 1.8, "middle")


def _calibration(panel: "Axes") -> None:
    """(a) the hinged beam doubles the weight; (b) the end of the knob: shell, flexure and cell, along the axis."""
    ground(panel, 0.0, 1.2, 0.6, "hinge")
    panel.plot([0.0, 3.6], [1.2, 1.2], color="black", linewidth=3.0)
    panel.plot([1.8, 1.68, 1.92, 1.8], [0.92, 1.17, 1.17, 0.92], color="black", linewidth=1.2)
    _box(panel, 1.35, 0.1, 0.9, 0.82)
    panel.text(1.8, 0.48, "knob", ha="center", va="center", fontsize=SMALL_TEXT)
    panel.plot([3.6, 3.6], [1.2, 0.5], color="black", linewidth=0.8)
    _box(panel, 3.4, 0.1, 0.4, 0.4, facecolor="black", alpha=0.35)
    panel.text(3.6, 0.0, "weight W", ha="center", va="top", fontsize=SMALL_TEXT)
    panel.text(1.8, 0.0, "feels 2 W", ha="center", va="top", fontsize=SMALL_TEXT)
    panel.text(1.8, 2.3, "(a) the beam over the knob", ha="center", va="bottom", fontsize=9)
    for x in (0.9, 2.7):
        panel.text(x, 1.3, "equal", ha="center", va="bottom", fontsize=SMALL_TEXT)
    # (b): a unit is 4 mm along the axis; the tip is at the right. Where the flexure lies is not printed.
    tip, unit = 7.9, 0.25
    hinge = tip - unit * 1e3 * POSITIONS_M[-1] - 0.3
    root = hinge - unit * FLEXURE_MM
    panel.plot(
        [tip, tip, root - 0.5, root - 0.5, root, root, tip],
        [0.3, -0.2, -0.2, 1.02, 1.02, 0.3, 0.3],
        color="black", linewidth=1.2, solid_joinstyle="round",
    )  # fmt: skip
    panel.text(tip - 0.75, 0.05, "body of the knob", ha="center", va="center", fontsize=SMALL_TEXT)
    panel.plot([root, hinge], [0.9, 0.9], color="black", linewidth=2.2)
    _box(panel, hinge, 0.62, tip - hinge, 0.4)
    nominal = tip - unit * 1e3 * POSITIONS_M[1]
    _box(panel, nominal - 0.18, 0.3, 0.36, 0.32, facecolor="black", alpha=0.35)
    for i, position in enumerate(POSITIONS_M):
        x = tip - unit * 1e3 * position
        _push(panel, (x, 1.5), (x, 1.04))
        weight = "bold" if i == 1 else "normal"
        panel.text(x, 1.53, f"{1e3 * position:.2f}", ha="center", va="bottom", fontsize=SMALL_TEXT, weight=weight)
    panel.text(nominal, 1.82, "force on the shell, mm from the tip", ha="center", va="bottom", fontsize=SMALL_TEXT)
    _note(panel, (0.5 * (root + hinge), 0.88), f"flexure, {FLEXURE_MM} mm", (root - 0.35, 1.3))
    _note(panel, (nominal, 0.35), "load cell", (nominal, -0.45))
    panel.text(6.2, 2.3, "(b) the end of the knob", ha="center", va="bottom", fontsize=9)


TORQUE, FRICTION, CELL = "torque constant", "dynamic friction", "grip cell slope"


@drawing
def motor_calibration(evidence: ResultSet, of: str) -> "Figure":
    """Motor torque and dynamic friction (mN·m) over current (mA), a panel a range of torque, with the lines fitted.

    Torque is the mean of both directions, friction half their difference. Raises `MissingError`.
    """
    result = evidence[of]
    slopes, lines = _slopes(result, TORQUE), _points(result)
    drawn = theme.figure(3.2)
    panels = drawn.subplots(1, len(slopes), squeeze=False)[0]
    for panel, (condition, slope) in zip(panels, slopes.items(), strict=True):
        for i, (quantity, name) in enumerate(((TORQUE, "torque"), (FRICTION, "dynamic friction"))):
            _draw(panel, lines.get((quantity, condition), []), i, name, 1e3, 1e3)
        panel.set_title(f"slope {1e3 * slope:.1f} mN\u00b7m/A", loc="left")
        panel.set_xlabel("drive current, mA")
        panel.set_ylabel("torque, mN\u00b7m")
    drawn.legend(*panels[0].get_legend_handles_labels(), loc="outside upper left", ncols=2, handlelength=3.0)
    return drawn


@drawing
def grip_cell(evidence: ResultSet, of: str) -> "Figure":
    """Voltage of the grip cell over the force on the knob, a line a place at which the force acts.

    Raises `MissingError`.
    """
    result = evidence[of]
    lines = _points(result)
    drawn = theme.figure(3.2)
    panel = drawn.subplots()
    for i, (condition, slope) in enumerate(_slopes(result, CELL).items()):
        _draw(panel, lines.get((CELL, condition), []), i, f"{condition}: {1e3 * slope:.0f} mV/N")
    panel.set_xlabel("force on the knob, N")
    panel.set_ylabel("voltage of the cell, V")
    panel.legend(loc="upper left")
    return drawn


@drawing
def amplifier_step(_evidence: ResultSet, _of: Any = None, *, current_a: float = 0.4) -> "Figure":
    """Current (A) of amplifier and motor after a step of ``current_a``, over six samples of the apparatus.

    It is the first-order lag of the virtual apparatus, a quarter of the 200 µs in which the printed one settles
    (Appendix A.2): an assumption, since inductance and bandwidth are not printed. Needs no result.
    """
    import numpy as np

    from hknob_cli.apparatus.hand_recording import Rig

    rig = Rig()
    time = np.linspace(0.0, 6.0 * rig.interval_s, 241)
    current = -current_a * np.expm1(-time / rig.amplifier_s)
    settled = -rig.amplifier_s * np.log(0.02)  # within 2 %
    drawn = theme.figure(2.6)
    panel = drawn.subplots()
    panel.plot([-100.0, 0.0, 0.0, 600.0], [0.0, 0.0, current_a, current_a], label="commanded", **theme.series(1))
    panel.plot(np.concatenate(([-100.0], 1e6 * time)), np.concatenate(([0.0], current)), label="motor current",
               **theme.series(0))  # fmt: skip
    panel.axvline(1e6 * settled, color="black", linewidth=0.8, linestyle=(0, (1, 2)))
    panel.annotate(f"within 2 % after {1e6 * settled:.0f} \u00b5s", (1e6 * settled, 0.5 * current_a), (6, 0),
                   textcoords="offset points", fontsize=8, va="center")  # fmt: skip
    panel.set_xticks(100.0 * np.arange(-1, 7))
    panel.set_xlim(-100.0, 600.0)
    panel.set_ylim(-0.05 * current_a, 1.12 * current_a)
    panel.set_xlabel("time, \u00b5s: a division is a sample of the apparatus")
    panel.set_ylabel("current, A")
    panel.legend(loc="lower right")
    return drawn


def _draw(panel: "Axes", rows: Rows, index: int, name: str, along: float = 1.0, up: float = 1.0) -> None:
    """Readings as markers, and their fitted line."""
    rows = sorted(rows, key=lambda row: float(row["x"]))
    style: dict[str, Any] = theme.series(index) | {
        "marker": theme.MARKERS[index % len(theme.MARKERS)],
        "markersize": 3.5,
    }
    x = [along * row["x"] for row in rows]
    panel.plot(x, [up * row["y"] for row in rows], **(style | {"linestyle": "none"}))
    panel.plot(x, [up * row["fitted"] for row in rows], label=name, **theme.series(index))


def _slopes(result: Result, quantity: str) -> dict[str, float]:
    rows = [row for row in result.rows("calibration") if row["quantity"] == quantity]
    if not rows:
        raise MissingError(f"no {quantity} in '{result.name}'")
    return {row["condition"]: row["value"] for row in rows}


def _points(result: Result) -> dict[tuple[str, str], Rows]:
    """Readings with their lines, by quantity and condition."""
    found: dict[tuple[str, str], Rows] = {}
    for row in result.rows("calibration_points"):
        found.setdefault((row["quantity"], row["condition"]), []).append(row)
    return found
