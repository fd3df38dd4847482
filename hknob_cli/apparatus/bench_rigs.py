"""The rigs of Appendices A-C: dynamometer for the motor, weights on the grip cell, pulses on knobs nobody holds."""

from collections.abc import Sequence
from math import tau
from typing import Any, NamedTuple

import numpy as np

from hknob_cli.apparatus.hand import SecondOrder
from hknob_cli.apparatus.hand_recording import Pulse, record_trial, scaled_pulse
from hknob_cli.apparatus.people import grips
from hknob_cli.apparatus.rig import Rig
from hknob_cli.apparatus.streams import Purpose, stream
from hknob_cli.errors import UsageError
from hknob_cli.printed.tables import table
from hknob_cli.recordings.trial import Array, Key, Trial

_MOTOR, _CELL, _KNOB = range(3)  # first number of each bench's stream

# Appendix A.1: torque constant (N·m/A) and largest torque (N·m) of a range.
SMALL_RANGE, WORKING_RANGE = (26.4e-3, 2e-3), (28.4e-3, 30e-3)

# Appendix B: where the force acts, from the end of the knob (m); the first and the last are the "deviant" cases.
POSITIONS_M = (3.18e-3, 6.35e-3, 9.53e-3)
POSITION_FACTOR = 1.9  # "nearly twice", coefficient at 9.53 mm over that at 3.18 mm
NOMINAL_V_PER_N = 0.1  # assumed: 10 V for the cell's 100 N

# Appendix C: damping more than ten times, stiffness more than a hundred times below the lightest grasp's; their values
# are assumed.
BEARING_DAMPING, BEARING_STIFFNESS = 1e-5, 1e-4
SHAFT = "shaft"


class MotorCalibration(NamedTuple):
    """Rows of a dynamometer run, all of one length.

    ``range_index``: 0 small torques, 1 working range; ``current_a`` of the motor; ``direction``: +1 clockwise, -1
    counter-clockwise; ``time_s`` since that direction began; ``angle_rad`` of the shaft; ``torque_nm`` at the sensor,
    against which the dynamometer turns the shaft.
    """

    range_index: np.ndarray[Any, np.dtype[np.int64]]
    current_a: Array
    direction: Array
    time_s: Array
    angle_rad: Array
    torque_nm: Array


class GripCell(NamedTuple):
    """Rows of a grip cell's calibration: ``position_m`` from the end of the knob, ``force_n`` on it, ``voltage_v``."""

    position_m: Array
    force_n: Array
    voltage_v: Array


def record_motor_calibration(
    rig: Rig,
    *,
    currents: int = 11,
    turns: float = 3.0,
    turn_s: float = 4.0,
    noise_nm: float = 2e-5,
    ripple_nm: float = 0.0,
    seed: int = 0,
) -> MotorCalibration:
    """Torque against drive current: per range, and current from 0 to the largest, ``turns`` each way, every 100 ms.

    The sensor reads Kt·i + direction·Tc: half the difference of the two means is the friction, Tc = ``rig.coulomb_nm``.
    ``noise_nm``: rms of the sensor (assumed); ``ripple_nm``: amplitude of a ripple that comes nine times a turn
    (assumed, off). Source: Appendix A.1. Raises `UsageError` for fewer than two currents.
    """
    if currents < 2:
        raise UsageError(f"currents must be >= 2, got {currents}")
    rows: list[tuple[Any, ...]] = []
    for index, (constant, most) in enumerate((SMALL_RANGE, WORKING_RANGE)):
        for step, current in enumerate(np.linspace(0.0, most / constant, currents)):
            rng = stream(seed, Purpose.BENCH, _MOTOR, index, step)
            for direction in (1.0, -1.0):
                time = 0.1 * np.arange(round(turns * turn_s / 0.1))
                turned = time / turn_s * tau
                angle = turned if direction > 0.0 else turns * tau - turned
                torque = (1.0 + rig.torque_error) * constant * current + direction * rig.coulomb_nm
                reading = torque + ripple_nm * np.sin(9.0 * angle) + noise_nm * rng.standard_normal(len(time))
                same = np.ones(len(time))
                rows.append((index * same, current * same, direction * same, time, angle, reading))
    index_column, *columns = (np.concatenate(column) for column in zip(*rows, strict=True))
    return MotorCalibration(index_column.astype(np.int64), *columns)


def cell_sensitivity(position_m: float) -> float:
    """Voltage per force (V/N) of a grip cell under a force at a distance from the end of the knob.

    Linear between the printed cases: the nearer the flexure that the shell hinges on, the less the cell feels.
    """
    reach = POSITIONS_M[-1] - POSITIONS_M[0]
    drop = 2.0 * (POSITION_FACTOR - 1.0) / (POSITION_FACTOR + 1.0) / reach
    return NOMINAL_V_PER_N * (1.0 - drop * (position_m - 0.5 * (POSITIONS_M[0] + POSITIONS_M[-1])))


def record_grip_cell(
    *,
    forces_n: Sequence[float] = (0.0, 1.0, 2.0, 4.0, 6.0, 8.0, 10.0, 12.0, 15.0),
    positions_m: Sequence[float] = POSITIONS_M,
    repeats: int = 3,
    noise_v: float = 1e-3,
    zero_v: float = 0.0,
    seed: int = 0,
) -> GripCell:
    """Voltage of the grip cell under test forces, those on the knob: twice the weights, by the lever.

    ``noise_v``: rms of a reading, ``zero_v``: its value without force (both assumed). Source: Appendix B. Raises
    `UsageError` for a position at which the cell would feel nothing.
    """
    rows = []
    for place, position in enumerate(positions_m):
        sensitivity = cell_sensitivity(position)
        if sensitivity <= 0.0:
            raise UsageError(f"a force at {position:g} m from the end is not on the grip cell's shell")
        for step, force in enumerate(forces_n):
            rng = stream(seed, Purpose.BENCH, _CELL, place, step)
            for _ in range(repeats):
                rows.append((position, force, zero_v + sensitivity * force + noise_v * float(rng.standard_normal())))
    return GripCell(*np.array(rows).T.copy())


def setups() -> dict[str, float]:
    """Inertia (kg·m²) of the apparatus by setup: the bare shaft, and the columns of Table 10 with a knob on it."""
    rows = {row["quantity"]: row for row in table(10)}
    whole = rows["Empirical estimate"]
    shaft = next(row for name, row in rows.items() if str(name).startswith("minus empirical estimate"))
    found = {SHAFT: -1e-7 * float(shaft["small_experimental"] or 0.0)}
    return found | {name: 1e-7 * value for name, value in whole.items() if isinstance(value, float)}


def record_apparatus(
    rig: Rig,
    *,
    chosen: Sequence[str] = (SHAFT, "small_experimental", "medium_experimental"),
    trials: int = 3,
    damping: float = BEARING_DAMPING,
    stiffness: float = BEARING_STIFFNESS,
    seed: int = 0,
) -> list[Trial]:
    """Pulses of the six magnitudes of the first experiment on knobs that nobody holds: nobody's grip, target 0.

    ``chosen``: of `setups`, which is the subject of a trial's key; its block is the magnitude's number, the lightest
    first; its experiment is "apparatus". ``damping`` (N·m·s/rad) and ``stiffness`` (N·m/rad) of the bearings. Source:
    Appendix C. Raises `UsageError` for an unknown setup.
    """
    known = setups()
    found = []
    for setup in chosen:
        if setup not in known:
            raise UsageError(f"no setup '{setup}'; there are: {', '.join(known)}")
        body = SecondOrder(known[setup], damping, stiffness)
        for block, grip in enumerate(grips(1), 1):
            pulse = Pulse(scaled_pulse(1, grip).torque_nm)
            for trial in range(1, trials + 1):
                rng = stream(seed, Purpose.BENCH, _KNOB, list(known).index(setup), block, trial)
                found.append(record_trial(rig, body, pulse, Key(setup, "apparatus", 0.0, block, trial), rng))
    return found
