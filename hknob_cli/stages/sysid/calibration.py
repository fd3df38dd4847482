"""The calibration of the motor or of the grip cell: readings taken or made, lines through them."""

from collections.abc import Mapping
from typing import Any

import pyarrow as pa

from hknob_cli.apparatus.experiment import record_grip_cell, record_motor_calibration
from hknob_cli.apparatus.hand_recording import virtual_rig
from hknob_cli.identify import identified
from hknob_cli.recordings.files import GRIP_CELL, MOTOR, read_columns
from hknob_cli.results.arrays import build_table
from hknob_cli.specs.identification import SysidPlan
from hknob_cli.stages.sysid import columns


def calibrate(plan: SysidPlan) -> tuple[pa.Table, pa.Table]:
    """Quantities, and the points that each rests on with its line there. Raises `UsageError`."""
    motor = plan.what == "motor"
    readings: Mapping[str, Any]
    if plan.virtual is None:
        readings = read_columns(plan.recordings, MOTOR if motor else GRIP_CELL)
    elif motor:
        readings = record_motor_calibration(virtual_rig(plan), seed=plan.virtual.seed)._asdict()
    else:
        readings = record_grip_cell(seed=plan.virtual.seed)._asdict()
    found = identified.motor(readings) if motor else identified.grip_cell(readings)
    quantities = [{**one._asdict(), "flags": "; ".join(one.flags)} for one in found]
    points = [
        {
            "quantity": one.quantity,
            "condition": one.condition,
            "x": x,
            "x_unit": one.line.x_unit,
            "y": y,
            "y_unit": one.line.y_unit,
            "fitted": fitted,
        }
        for one in found
        if one.line is not None
        for x, y, fitted in zip(one.line.x, one.line.y, one.line.fitted, strict=True)
    ]
    return build_table(columns.CALIBRATION, quantities), build_table(columns.CALIBRATION_POINTS, points)
