"""Calibrations of the apparatus: torque constant and friction of the motor, slope of the grip cell (App. A, B)."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from hknob_cli.recordings.trial import Array

CURVED = 0.999  # share of the variance that a straight line must explain
_LEAST = 1e-12  # range of currents or forces that is more than rounding; slope, that is more than none


class Line(NamedTuple):
    """Points that a line was fitted to: ``x`` (n,) and ``y`` (n,) in these units, and the ``fitted`` (n,) values.

    The fitted line of a slope has an intercept; of a mean it is level.
    """

    x: Array
    x_unit: str
    y: Array
    y_unit: str
    fitted: Array


class Calibrated(NamedTuple):
    """One quantity with its standard error; ``r_squared`` of the line it is the slope of, if it is one.

    ``line``: the points it rests on, where it is a slope or a mean of some.
    """

    quantity: str
    condition: str
    value: float
    std: float
    unit: str
    r_squared: float | None = None
    flags: tuple[str, ...] = ()
    line: Line | None = None


def motor(columns: Mapping[str, Array]) -> list[Calibrated]:
    """Torque constant and dynamic friction by range of torque.

    ``columns``: range_index, current_a, direction (+1, -1), torque_nm, all of one length. Clockwise and
    counter-clockwise torques of a current are averaged apart; their mean is the motor's torque, half their difference
    the friction. Source: Appendix A.1.
    """
    found = []
    for index in np.unique(columns["range_index"]):
        mine = columns["range_index"] == index
        currents = np.unique(columns["current_a"][mine])
        name = f"range {index:g}"
        ways = [
            [columns["torque_nm"][mine & (columns["current_a"] == i) & (columns["direction"] == way)] for i in currents]
            for way in (1.0, -1.0)
        ]
        if any(len(one) == 0 for way in ways for one in way):
            why = ("some currents lack one of the two directions",)
            found.append(Calibrated("torque constant", name, float("nan"), float("nan"), "N*m/A", flags=why))
            continue
        clockwise, counter = (np.array([one.mean() for one in way]) for way in ways)
        torque, friction = 0.5 * (clockwise + counter), 0.5 * (clockwise - counter)
        found.append(_slope("torque constant", name, "N*m/A", currents, torque, ("A", "N*m")))
        error = float(friction.std(ddof=1) / np.sqrt(len(friction))) if len(friction) > 1 else float("nan")
        trend = _slope("", "", "", currents, friction, ("A", "N*m"))
        turned = ("friction changes with the current",) if abs(trend.value) > 4.0 * trend.std else ()
        level = Line(currents, "A", friction, "N*m", np.full(len(friction), friction.mean()))
        found.append(Calibrated("dynamic friction", name, float(friction.mean()), error, "N*m", None, turned, level))
    return found


def grip_cell(columns: Mapping[str, Array]) -> list[Calibrated]:
    """Voltage per force at every position, and how it depends on the position, relative to the middle one per metre.

    ``columns``: position_m, force_n, voltage_v. Source: Appendix B.
    """
    positions = np.unique(columns["position_m"])
    found = []
    for position in positions:
        here = columns["position_m"] == position
        name = f"{1e3 * position:.3g} mm from the end"
        force, voltage = columns["force_n"][here], columns["voltage_v"][here]
        found.append(_slope("grip cell slope", name, "V/N", force, voltage, ("N", "V")))
    return [*found, _evenness(found)] if len(positions) > 1 else found


def _evenness(slopes: list[Calibrated]) -> Calibrated:
    """Largest slope over the least, both from zero."""
    if not (all(one.value >= _LEAST for one in slopes) or all(one.value <= -_LEAST for one in slopes)):
        why = ("a position has no slope, or one of another sign",)
        return Calibrated("largest slope over least", "positions", float("nan"), float("nan"), "1", flags=why)
    least, *_, largest = sorted(slopes, key=lambda one: abs(one.value))
    ratio = largest.value / least.value
    spread = ratio * float(np.hypot(largest.std / largest.value, least.std / least.value))
    return Calibrated("largest slope over least", "positions", ratio, spread, "1")


def _slope(quantity: str, condition: str, unit: str, x: Array, y: Array, units: tuple[str, str]) -> Calibrated:
    """Slope of a straight line with its standard error, by least squares; ``units`` of x and y."""
    if len(np.unique(x)) < 3:
        why = ("fewer than three different readings",)
        return Calibrated(quantity, condition, float("nan"), float("nan"), unit, flags=why)
    if np.ptp(x) < _LEAST * max(1.0, float(np.abs(x).max())):
        why = ("readings that hardly differ",)
        return Calibrated(quantity, condition, float("nan"), float("nan"), unit, flags=why)
    lean = x - x.mean()
    value = float(lean @ y / (lean @ lean))
    residual = y - y.mean() - value * lean
    variance = float(residual @ residual) / (len(x) - 2)
    spread = float((y - y.mean()) @ (y - y.mean()))
    share = 1.0 - float(residual @ residual) / spread if spread > 0.0 else None
    flags = ("not a straight line",) if share is not None and share < CURVED else ()
    error = float(np.sqrt(variance / (lean @ lean)))
    line = Line(x, units[0], y, units[1], y.mean() + value * lean)
    return Calibrated(quantity, condition, value, error, unit, share, flags, line)
