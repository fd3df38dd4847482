"""Calibrations as straight lines: motor torque and friction over current, grip cell (Hasser, Figs 77, 78, 81)."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from hknob_cli.apparatus.bench_rigs import record_grip_cell, record_motor_calibration
from hknob_cli.page import ink
from hknob_cli.page.figures import drawing
from hknob_cli.page.figures.identification import stage_of
from hknob_cli.results.evidence import Evidence, MissingError, Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Columns = Mapping[str, Any]


@drawing
def motor_calibration(evidence: Evidence, of: str) -> "Figure":
    """Motor torque and dynamic friction (mN·m) over current (mA), a panel a range of torque, with the line fitted.

    Torque is the mean of both directions, friction half their difference. Raises `MissingError`.
    """
    result = evidence[of]
    fitted = _fitted(result, "torque constant")
    columns = _readings(result, "motor")
    drawn = ink.figure(3.2)
    ranges = np.unique(columns["range_index"])
    panels = drawn.subplots(1, len(ranges), squeeze=False)[0]
    for panel, index in zip(panels, ranges, strict=True):
        mine = columns["range_index"] == index
        currents = np.unique(columns["current_a"][mine])
        ways = [_means(columns, mine & (columns["direction"] == way), currents) for way in (1.0, -1.0)]
        torque, friction = 0.5 * (ways[0] + ways[1]), 0.5 * (ways[0] - ways[1])
        constant = fitted[f"range {index:g}"]
        line = torque.mean() + constant * (currents - currents.mean())
        own = f"{1e3 * constant:.1f} mN\u00b7m/A"
        panel.plot(1e3 * currents, 1e3 * torque, label="torque", markersize=4.0, **ink.points(0))
        panel.plot(1e3 * currents, 1e3 * line, label="fitted line", **ink.series(0))
        panel.plot(1e3 * currents, 1e3 * friction, label="dynamic friction", markersize=4.0, **ink.points(1))
        panel.set_title(f"slope {own}", loc="left")
        panel.set_xlabel("drive current, mA")
        panel.set_ylabel("torque, mN\u00b7m")
    drawn.legend(*panels[0].get_legend_handles_labels(), loc="outside upper left", ncols=3)
    return drawn


@drawing
def grip_cell(evidence: Evidence, of: str) -> "Figure":
    """Voltage of the grip cell over the force on the knob, a line a place at which the force acts.

    Raises `MissingError`.
    """
    result = evidence[of]
    slopes = _fitted(result, "grip cell slope")
    columns = _readings(result, "grip_cell")
    drawn = ink.figure(3.2)
    panel = drawn.subplots()
    places = np.unique(columns["position_m"])
    for i, (place, slope) in enumerate(zip(places, slopes.values(), strict=True)):
        here = columns["position_m"] == place
        force, voltage = columns["force_n"][here], columns["voltage_v"][here]
        style = ink.series(i) | {"marker": ink.MARKERS[i % len(ink.MARKERS)], "markersize": 3.5}
        line = voltage.mean() + slope * (force - force.mean())
        panel.plot(force, voltage, **(style | {"linestyle": "none"}))
        panel.plot(force, line, label=f"{1e3 * place:.2f} mm from the end: {1e3 * slope:.0f} mV/N", **ink.series(i))
    panel.set_xlabel("force on the knob, N")
    panel.set_ylabel("voltage of the cell, V")
    panel.legend(loc="upper left")
    return drawn


def _means(columns: Columns, chosen: np.ndarray, currents: np.ndarray) -> np.ndarray:
    """Mean torque at each current."""
    return np.array([columns["torque_nm"][chosen & (columns["current_a"] == one)].mean() for one in currents])


def _fitted(result: Result, quantity: str) -> dict[str, float]:
    rows = [row for row in result.rows("calibration") if row["quantity"] == quantity]
    if not rows:
        raise MissingError(f"no {quantity} in '{result.name}'")
    return {row["condition"]: row["value"] for row in rows}


def _readings(result: Result, what: str) -> Columns:
    """What the calibration was computed from, recorded on the virtual bench again; others are not kept with it."""
    stage = stage_of(result)
    plan = stage.plan
    if plan.what != what:
        raise MissingError(f"'{result.name}' is of {plan.what}, not of {what}")
    if plan.virtual is None:
        raise MissingError(f"the readings behind '{result.name}' are not kept with it")
    if what == "motor":
        return record_motor_calibration(stage.rig(), seed=plan.virtual.seed)._asdict()
    return record_grip_cell(seed=plan.virtual.seed)._asdict()
