"""The columns of a recording: name, type, unit and meaning; what is required, and what a sane value is."""

from typing import NamedTuple

import pyarrow as pa

from hknob_cli.results.campaign_files import ACCELERATION
from hknob_cli.results.columns import Column

KEYS = (
    Column("subject", pa.string(), "", "who held the knob"),
    Column("experiment", pa.string(), "", "grasp and knob"),
    Column("grip_target_n", pa.float64(), "N", "target of the grip force"),
    Column("block", pa.int64(), "1", "block of trials, between which the hand let go"),
    Column("trial", pa.int64(), "1", "number of the trial in its block"),
)
SAMPLES = (
    Column("time_s", pa.float64(), "s", "time, rising within a trial"),
    Column("torque_nm", pa.float64(), "N*m", "commanded torque, from this sample to the next, positive as the angle"),
    Column("angle_rad", pa.float64(), "rad", "measured angle of the knob"),
    Column("grip_n", pa.float64(), "N", "measured grip force"),
)
MEASURED_TORQUE = Column("measured_torque_nm", pa.float64(), "N*m", "measured torque; null where there is no sensor")

TEXTS = ("subject", "experiment")
REQUIRED = ("time_s", "angle_rad")
TORQUES = ("torque_nm", MEASURED_TORQUE.name)  # of which one must be there
SENSED = (MEASURED_TORQUE, ACCELERATION)  # of sensors that few have
MAY_MISS = ("grip_n", *(column.name for column in SENSED))  # in all rows of a trial
EVERY = tuple(column.name for column in (*KEYS, *SAMPLES, *SENSED))
UNNAMED = "unnamed"  # subject and experiment of a file without such columns


class Limit(NamedTuple):
    """Largest magnitude that is no surprise, and the unit that a larger one was probably given in.

    ``key``: of the spec's ``limits``, which raises it.
    """

    most: float
    unit: str
    likely: str
    key: str


LIMITS = {
    "angle_rad": Limit(100.0, "rad", "degrees or counts", "angle"),
    "torque_nm": Limit(10.0, "N m", "mN m", "torque"),
    "measured_torque_nm": Limit(10.0, "N m", "mN m", "torque"),
    ACCELERATION.name: Limit(1e5, "rad/s^2", "deg/s^2", "acceleration"),
    "grip_n": Limit(1000.0, "N", "mN or grams", "force"),
    "grip_target_n": Limit(1000.0, "N", "mN or grams", "force"),
}
LARGEST = 1e6  # of any number, in SI units: beyond it is no knob
LONGEST_STEP_S = 1.0
LONGEST_TRIAL_S = 1000.0
