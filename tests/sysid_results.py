"""Small identifications of virtual people and benches, run and written as `hknob sysid` writes them."""

from pathlib import Path

import pyarrow as pa

from hknob_cli.results.provenance import describe
from hknob_cli.results.store import write
from hknob_cli.specs.load import validate
from hknob_cli.specs.source import parse
from hknob_cli.stages.sysid.against import calibrate, study_bias, study_hidden
from hknob_cli.stages.sysid.run import SysidStage, kept_recordings

IDEAL = "rig: {coulomb_nm: 0.0, amplifier_s: 0.0}"
HANDS = f"""\
kind: sysid
name: hands
virtual: {{experiments: [1], subjects: 2, blocks: 2, trials: 2, grips: [0.71, 2.4, 14.2], {IDEAL}}}
keep_recordings: true
"""
FOURTH = f"""\
kind: sysid
name: fourth
virtual: {{experiments: [1], subjects: 1, blocks: 1, trials: 2, grips: [14.2], model: fourth, {IDEAL}}}
estimators: [output_error]
keep_recordings: true
"""
MOTOR = "kind: sysid\nname: motor\nwhat: motor\nvirtual: {}\n"
GRIP_CELL = "kind: sysid\nname: grip-cell\nwhat: grip_cell\nvirtual: {}\n"
APPARATUS = """\
kind: sysid
name: apparatus
what: apparatus
virtual: {trials: 1}
estimators: [least_squares, output_error, output_error_friction]
settling_time_constant: 50 us
"""
STUDY = """\
kind: sysid
name: study
study:
  bias:
    repeats: 2
    nuisances: {noise_rad: [0.0, 1.0e-3], coulomb_nm: [0.0, 5.6e-4], lag_s: [0.0, 5.0e-5], decimation: [1, 10]}
  hidden_inertia: {ratios: [1, 10, 100]}
"""


def identify(root: Path, text: str) -> Path:
    """Run a spec and write its tables into a folder of its name, which is returned."""
    plan = validate(parse(text, "spec.yaml"))
    folder = root / plan.name
    folder.mkdir()
    tables: dict[str, pa.Table] = {}
    if plan.study:
        tables = {"bias": study_bias(plan.study.bias), "hidden_inertia": study_hidden(plan.study.hidden)}
    elif plan.what in ("motor", "grip_cell"):
        tables = dict(zip(("calibration", "calibration_points"), calibrate(plan), strict=True))
    else:
        stage = SysidStage(plan)
        trials = stage.trials()
        tables = dict(zip(("trials", "conditions"), stage.run(trials), strict=True))
        if plan.keep:
            tables["recordings"] = kept_recordings(trials)
    stamp = describe(stage="sysid", values=plan.values, overrides=())
    write({folder / f"{name}.parquet": table for name, table in tables.items()}, stamp)
    return folder
