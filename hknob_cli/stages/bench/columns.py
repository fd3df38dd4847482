"""The columns of the benchmark's file."""

import pyarrow as pa

from hknob_cli.results.columns import Column

_REAL, _WHOLE, _TEXT = pa.float64(), pa.int64(), pa.string()

RUNS = (
    Column("scene", _TEXT, "", "name of the scene"),
    Column("method", _TEXT, "", "exact, a SciPy method, a method with a fixed step, or a MuJoCo integrator"),
    Column("setting", _TEXT, "", "compiled or interpreted, relative tolerance, or steps a sample"),
    Column("friction", _TEXT, "", "how friction is treated: none, stick, smoothed, soft or stiff (a constraint)"),
    Column("verdict", _TEXT, "", "accurate, inaccurate, wrong attractor, failed, too slow or no reference"),
    Column("reason", _TEXT, "", "why it failed; empty where it did not"),
    Column("error_rad", _REAL, "rad", "largest difference of the angle from the reference's, at any sample"),
    Column("error_counts", _REAL, "count", "error_rad in encoder counts; null for a continuous sensor"),
    Column("relative_error", _REAL, "1", "error_rad over the reference's swing"),
    Column("p2p_rad", _REAL, "rad", "highest less lowest angle at the samples of the last third"),
    Column("p2p_relative_error", _REAL, "1", "difference of p2p_rad from the reference's, over the reference's swing"),
    Column("seconds", _REAL, "s", "processor time of the run with its set-up, the best of several where it is short"),
    Column("repeats", _WHOLE, "1", "runs that the best time is of"),
    Column("steps", _WHOLE, "1", "time steps; samples, of the exact engine"),
    Column("evaluations", _WHOLE, "1", "right-hand sides; null where the method does not say"),
    Column("samples", _WHOLE, "sample", "sample intervals of the trial"),
    Column("reference", _TEXT, "", "what errors are against: exact (the engine) or digits60 (60 digits)"),
    Column("no_reference", _TEXT, "", "why the scene has no reference; empty where it has one"),
    Column("reference_swing_rad", _REAL, "rad", "the reference's p2p of the last third; of the whole trial, at rest"),
)
