"""The columns of the identification's files, and of those in which its estimators are studied."""

import pyarrow as pa

from hknob_cli.results.columns import Column

_REAL, _WHOLE, _TEXT = pa.float64(), pa.int64(), pa.string()

TRIAL_KEYS = (
    Column("experiment", _TEXT, "", "grasp and knob"),
    Column("subject", _TEXT, "", "who"),
    Column("grip_target_n", _REAL, "N", "grip force at which the pulse fires"),
    Column("block", _WHOLE, "1", "block of trials"),
    Column("trial", _WHOLE, "1", "trial; null where the trials of a block were averaged"),
)
CONDITION_KEYS = (
    Column("level", _TEXT, "", "subject: mean over the blocks of one person; all: mean over persons"),
    Column("experiment", _TEXT, "", "grasp and knob"),
    Column("subject", _TEXT, "", "who; null over all persons"),
    Column("grip_target_n", _REAL, "N", "grip force at which the pulse fires"),
)
ESTIMATOR = Column("estimator", _TEXT, "", "how it was estimated")
# By name in a fit: column, unit, what it is.
PARAMETERS = {
    "inertia": ("inertia_kg_m2", "kg*m^2", "moment of inertia"),
    "damping": ("damping_nm_s_per_rad", "N*m*s/rad", "damping"),
    "stiffness": ("stiffness_nm_per_rad", "N*m/rad", "stiffness"),
    "damping_ratio": ("damping_ratio", "1", "damping ratio B / (2 sqrt(J K))"),
    "coulomb": ("coulomb_nm", "N*m", "Coulomb friction"),
    "finger_inertia": ("finger_inertia_kg_m2", "kg*m^2", "moment of inertia of the finger"),
    "finger_damping": ("finger_damping_nm_s_per_rad", "N*m*s/rad", "damping of the finger, to ground"),
    "finger_stiffness": ("finger_stiffness_nm_per_rad", "N*m/rad", "stiffness of the finger, to ground"),
    "pad_damping": ("pad_damping_nm_s_per_rad", "N*m*s/rad", "damping of the fingerpad"),
    "pad_stiffness": ("pad_stiffness_nm_per_rad", "N*m/rad", "stiffness of the fingerpad"),
}
ALWAYS = ("inertia", "damping", "stiffness", "damping_ratio")
SKIN = {
    "inertia": ("mass_kg", "kg", "equivalent mass at the surface of the knob"),
    "damping": ("damping_n_s_per_m", "N*s/m", "damping along the surface of the knob"),
    "stiffness": ("stiffness_n_per_m", "N/m", "stiffness along the surface of the knob"),
}
_FIT = "standard error of the fit"
_SPREAD = "at level subject: standard error over blocks; at level all: standard deviation over persons"
QUALITY = (
    Column("vaf", _REAL, "1", "share of the variance of the angle that the model accounts for"),
    Column("white", _REAL, "1", "p-value of the residuals being white noise; null where unknown"),
)
FLAGS = Column("flags", _TEXT, "", "what is doubtful about it, in words; empty where nothing is")
AVERAGED = Column("trials", _WHOLE, "1", "trials that it rests on")
DIFFER = Column(
    "trials_differ",
    _REAL,
    "1",
    "standard deviation of the averaged trials about their mean beyond noise, over the peak of it; null of one trial",
)
APPARATUS = Column("apparatus_inertia_kg_m2", _REAL, "kg*m^2", "inertia subtracted as the apparatus's own; null: none")
TRUTH = (
    *TRIAL_KEYS,
    ESTIMATOR,
    Column("parameter", _TEXT, "", "what was estimated: inertia, damping or stiffness"),
    Column("value", _REAL, "", "the estimate, in the column unit"),
    Column("std", _REAL, "", "its standard error"),
    Column("truth", _REAL, "", "the simulated value, mean over the trials that the fit rests on"),
    Column("unit", _TEXT, "", "unit of value, std and truth"),
    Column("error_percent", _REAL, "%", "estimate less truth, in per cent of the truth"),
    Column("holds", pa.bool_(), "", "whether the 95 % interval, 1.96 standard errors to either side, holds the truth"),
)
CALIBRATION = (
    Column("quantity", _TEXT, "", "what was calibrated"),
    Column("condition", _TEXT, "", "range of torque, or position of the force"),
    Column("value", _REAL, "", "its value, in the column unit"),
    Column("std", _REAL, "", "its standard error"),
    Column("unit", _TEXT, "", "unit of value and std"),
    Column("r_squared", _REAL, "1", "share of the variance that a straight line explains; null where there is none"),
    Column("flags", _TEXT, "", "what is doubtful about it; empty where nothing is"),
)
CALIBRATION_POINTS = (
    Column("quantity", _TEXT, "", "what was calibrated by the points"),
    Column("condition", _TEXT, "", "range of torque, or position of the force"),
    Column("x", _REAL, "", "current or force, in the column x_unit"),
    Column("x_unit", _TEXT, "", "unit of x"),
    Column("y", _REAL, "", "torque, friction torque or voltage, in the column y_unit"),
    Column("y_unit", _TEXT, "", "unit of y and fitted"),
    Column("fitted", _REAL, "", "y of the fitted line there"),
)


def parameter_columns(names: tuple[str, ...], *, spread: bool, skin: bool) -> list[Column]:
    """Columns of parameters with their errors, translational ones with ``skin``."""
    what = _SPREAD if spread else _FIT
    chosen = [PARAMETERS[name] for name in names] + (list(SKIN.values()) if skin else [])
    columns = []
    for column, unit, meaning in chosen:
        columns.append(Column(column, _REAL, unit, meaning))
        columns.append(Column(f"{column}_std", _REAL, unit, what))
    return columns


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
