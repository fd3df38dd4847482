"""Benches of the apparatus: motor torque and friction, the amplifier's step, grip cell (Hasser, Figs 77-79, 81)."""

from typing import TYPE_CHECKING, Any

from hknob_cli.figures import drawing, theme
from hknob_cli.results.result_set import MissingError, Result, ResultSet, Rows

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

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

    from hknob_cli.apparatus.rig import Rig

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
