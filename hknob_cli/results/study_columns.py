"""The columns of the files in which estimators are studied."""

import pyarrow as pa

from hknob_cli.results.columns import Column

_REAL, _TEXT = pa.float64(), pa.string()

BIAS = (
    Column("grip_n", _REAL, "N", "grip force of the printed mean hand that is true"),
    Column("nuisance", _TEXT, "", "what is varied: noise_rad, coulomb_nm, lag_s, counts_per_rev or decimation"),
    Column("level", _REAL, "", "how much of it, in the column level_unit"),
    Column("level_unit", _TEXT, "", "unit of level"),
    Column("estimator", _TEXT, "", "how it was estimated"),
    Column("parameter", _TEXT, "", "what was estimated: inertia, damping, stiffness or coulomb"),
    Column("truth", _REAL, "", "its true value, in the column unit"),
    Column("unit", _TEXT, "", "unit of truth"),
    Column("bias_percent", _REAL, "%", "mean estimate less truth, in per cent of the truth"),
    Column("std_percent", _REAL, "%", "standard deviation of the estimates, in per cent of the truth"),
)
HIDDEN = (
    Column("ratio", _REAL, "1", "stiffness and damping of the finger over those of its pad, K1/K2 = B1/B2"),
    Column("estimator", _TEXT, "", "how the second-order model was fitted"),
    Column("inertia_kg_m2", _REAL, "kg*m^2", "moment of inertia that it takes finger, pad and knob for"),
    Column("damping_nm_s_per_rad", _REAL, "N*m*s/rad", "damping of the same"),
    Column("stiffness_nm_per_rad", _REAL, "N*m/rad", "stiffness of the same"),
    Column("vaf", _REAL, "1", "share of the variance of the angle that the model accounts for"),
    Column("knob_inertia_kg_m2", _REAL, "kg*m^2", "true inertia of the knob and what turns with it"),
    Column("finger_inertia_kg_m2", _REAL, "kg*m^2", "true inertia of the finger"),
)
