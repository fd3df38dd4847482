"""The columns of a campaign of pulses that a grip fires: its trials, and the audit of their sample clock."""

import pyarrow as pa

from hknob_cli.results.campaign_files import TIMING, TRIAL_KEYS
from hknob_cli.results.columns import Column
from hknob_cli.specs.plan import RATE

_REAL, _WHOLE, _TEXT, _FLAG = pa.float64(), pa.int64(), pa.string(), pa.bool_()

PULSE_KEYS = (
    Column("order", _WHOLE, "1", "number of the trial, in the order they were run; the trial of the recordings"),
    Column("block", _WHOLE, "1", "block of trials, from 1"),
    Column("grip_target_n", _REAL, "N", "grip force at which the pulse fires"),
    Column(RATE, _REAL, "Hz", "sample rate of the device's loop"),
)
PULSE_TRIALS = (
    *PULSE_KEYS,
    Column("fired", _FLAG, "", "whether the pulse came"),
    Column("pulse_torque_nm", _REAL, "N*m", "torque of the pulse that was asked for"),
    Column("pulse_width_s", _REAL, "s", "time for which it acted, by the samples; null where it did not come"),
    Column("fired_s", _REAL, "s", "from the start to the first sample of the pulse; null where it did not come"),
    Column("grip_n", _REAL, "N", "grip force at the first sample of the pulse"),
    Column("grip_pulse_n", _REAL, "N", "mean grip force during the pulse"),
    Column("grip_zero_n", _REAL, "N", "what the grip cell showed before the start, subtracted"),
    Column("peak_rad", _REAL, "rad", "how far the knob turned from where it was before the pulse, at most"),
    Column("ended", _TEXT, "", "why it ended: released, gripping (the hand did not relax), unfired, operator, over"),
    Column("samples", _WHOLE, "1", "samples kept, about the pulse; of an unfired trial the last ones"),
    Column("gaps", _WHOLE, "1", "samples whose index is missing"),
    Column("overruns", _WHOLE, "1", "samples for which the device's loop was late"),
    Column("fault", _TEXT, "", "what is doubtful about it, in words; empty where nothing is"),
    Column("device", _TEXT, "", "what the device calls itself"),
    Column("native_counts", _WHOLE, "1/rev", "counts per revolution of the device's own encoder"),
)
# Of a simulated knob and hand together, at the grip at which the pulse came; null where it did not.
TRUTH = (
    Column("true_inertia_kg_m2", _REAL, "kg*m^2", "inertia of the simulated knob and hand at the pulse"),
    Column("true_damping_nm_s_per_rad", _REAL, "N*m*s/rad", "damping of the same"),
    Column("true_stiffness_nm_per_rad", _REAL, "N*m/rad", "stiffness of the same"),
)
PULSE_TIMING = (*PULSE_KEYS, *TIMING[len(TRIAL_KEYS) :])
