"""docs/reference/columns.md, made of the columns that each stage declares: ``python docs/make/columns.py``."""

from collections.abc import Iterator
from importlib import import_module
from typing import Any

_HEAD = """\
# Columns

Results are Parquet files. This page is made from the program itself (`make schemas`). Each file begins with the axes of
the grid. A group of columns is in a file only where the spec asks for it. Unit and meaning are also in each field's
metadata, and the spec and the versions that made a file in its `hknob.provenance`.
"""
_SWEEP = "hknob_cli.results.columns"
_HW, _SYSID = "hknob_cli.results.campaign_files", "hknob_cli.stages.sysid.columns"
_REMEDIES, _DESIGN = "hknob_cli.stages.remedies.columns", "hknob_cli.stages.design.work"
_PREDICT = "hknob_cli.stages.predict.work"
# Title of a file; then its groups: when the group is there, the module that declares it, names in that module.
_FILES: dict[str, tuple[tuple[str, str, str], ...]] = {
    "`sweep`: cells.parquet, a row for each cell": (
        ("always", _SWEEP, "CELLS"),
        ("every start", _SWEEP, "EVERY_START"),
        ("one start, every phase", _SWEEP, "ONE_START"),
        ("`starts: anywhere`", _SWEEP, "ANYWHERE"),
        ("`population`", _SWEEP, "PEOPLE"),
        ("`growth`", _SWEEP, "GROWTH"),
        ("backlash of a gear, cogging", _SWEEP, "RATTLE"),
        ("a sample clock that jitters", _SWEEP, "JITTER_MAX"),
        ("`perceive`", _SWEEP, "TOUCH_DB TOUCH_HZ STEP_DB HEARING_HZ HEARING_DB PHON RELATIVE_DB FELT HEARD"),
    ),
    "`sweep`: orbits.parquet, a row for each attractor of a cell": (
        ("always", _SWEEP, "ORBITS"),
        ("friction", _SWEEP, "FRICTION"),
        ("a gear with compliance", _SWEEP, "BEHIND"),
        ("backlash of a gear, cogging", _SWEEP, "PLAY"),
        ("a sample clock that jitters", _SWEEP, "JITTER"),
        ("no sample clock", _SWEEP, "CONTACT"),
        ("`perceive`", _SWEEP, "TOUCH_DB TOUCH_HZ STEP_DB HEARING_HZ HEARING_DB PHON RELATIVE_DB"),
    ),
    "`sweep`: trajectories.parquet, with `record`": (
        ("always", _SWEEP, "TRAJECTORY"),
        ("several starts", _SWEEP, "START"),
        ("a finger", _SWEEP, "FINGER"),
    ),
    "`sweep`: basins.parquet, with `basins`": (("always", _SWEEP, "BASINS"),),
    "`dfa`: dfa.parquet": (
        ("always", "hknob_cli.stages.dfa.run", "COLUMNS"),
        ("method `sampled`", "hknob_cli.stages.dfa.run", "SAMPLED"),
        ("`against` a complete sweep", "hknob_cli.stages.dfa.run", "LISTED"),
        ("`against`", "hknob_cli.stages.compare", "COLUMNS"),
    ),
    "`predict`: predict.parquet": (
        ("always", _PREDICT, "PREDICTIONS"),
        ("`against`", "hknob_cli.stages.compare", "COLUMNS"),
    ),
    "`predict`: passivity.parquet": (("always", _PREDICT, "PASSIVITY"), ("a hand", _PREDICT, "WITH_HAND")),
    "`predict`: criteria.parquet, with `criteria`": (
        ("always", "hknob_cli.stages.predict.work", "CRITERIA"),
        ("a sweep to compare with", "hknob_cli.stages.predict.work", "AGAINST"),
    ),
    "`dfa`, `predict`: differences.parquet, with `against`": (("always", "hknob_cli.stages.compare", "_STATISTICS"),),
    "`remedies`: remedies.parquet, and cases.parquet": (
        ("always", _REMEDIES, "KEYS AXES BUZZ"),
        ("`tune`", _REMEDIES, "TUNED"),
        ("a bounded lag", _REMEDIES, "DOMAIN"),
        ("starts in ranges", _SWEEP, "RANGED"),
        ("`perceive`", _REMEDIES, "TOUCH STEP_DB HEARING HEARING_DB RELATIVE_DB"),
        ("cases.parquet", _REMEDIES, "CASES NEEDS"),
    ),
    "`design`: design.parquet, a row for each design": (
        ("always", _DESIGN, "REMEDY COST MOTION PEOPLE VERDICT"),
        ("`hearing`", _DESIGN, "HEARING_DB"),
        ("redraws of people", _DESIGN, "REDRAWN"),
        ("a bounded lag", _DESIGN, "DOMAIN"),
        ("starts in ranges", _SWEEP, "RANGED"),
    ),
    "`sysid`: trials.parquet and conditions.parquet": (
        ("trials.parquet", _SYSID, "TRIAL_KEYS"),
        ("conditions.parquet", _SYSID, "CONDITION_KEYS"),
        ("each parameter, with `_std`", _SYSID, "ESTIMATOR PARAMETERS"),
        ("always", _SYSID, "QUALITY FLAGS AVERAGED DIFFER APPARATUS"),
    ),
    "`sysid`: truth.parquet, with `against`": (("always", _SYSID, "TRUTH"),),
    "`sysid`: calibration.parquet and calibration_points.parquet": (
        ("calibration.parquet", _SYSID, "CALIBRATION"),
        ("calibration_points.parquet", _SYSID, "CALIBRATION_POINTS"),
    ),
    "`sysid`: bias.parquet and hidden_inertia.parquet, with `study`": (
        ("bias.parquet", _SYSID, "BIAS"),
        ("hidden_inertia.parquet", _SYSID, "HIDDEN"),
    ),
    "`hw-run`: samples.parquet": (
        ("as a recording", "hknob_cli.recordings.columns", "KEYS SAMPLES"),
        ("a torque sensor", "hknob_cli.recordings.columns", "MEASURED_TORQUE"),
        ("beside it", _HW, "MORE_SAMPLES"),
        ("an accelerometer", _HW, "ACCELERATION"),
    ),
    "`hw-run`: trials.parquet": (
        ("always", _HW, "CELL TRIAL_KEYS TRIALS"),
        ("`controller`, `remedies`", _HW, "CONTROLLED"),
        ("`profile`, `detents`, `end_stops` or `dead_zone`", _HW, "SHAPED"),
        ("`encoder` or `actuator`", _HW, "CONVERTED"),
        ("`remedies`", _HW, "TRIED"),
    ),
    "`hw-run`: trials.parquet, with `what: pulses`": (
        ("always", "hknob_cli.results.campaign_files", "PULSE_TRIALS"),
        ("a virtual device", "hknob_cli.results.campaign_files", "TRUTH"),
    ),
    "`hw-run`: remedies.parquet, with `remedies`": (
        ("always", "hknob_cli.stages.hw_run.remedies", "MEASURED"),
        ("`against`", "hknob_cli.stages.hw_run.remedies", "COMPUTED"),
        ("always", _REMEDIES, "NEEDS"),
    ),
    "`hw-run`: timing.parquet": (("always", _HW, "TIMING"),),
    "`bench`: bench.parquet, a row for each run": (("always", "hknob_cli.stages.bench.work", "RUNS"),),
    "`report`: claims.parquet, a row for each claim": (("always", "hknob_cli.page.claims.verdict", "COLUMNS"),),
}


def page() -> str:
    """The text, in Markdown."""
    return "\n".join(_lines()) + "\n"


def _lines() -> Iterator[str]:
    yield _HEAD
    for title, groups in _FILES.items():
        yield f"## {title}\n"
        yield "| column | unit | meaning | there with |"
        yield "|---|---|---|---|"
        for when, module, names in groups:
            for name in names.split():
                for column, unit, meaning in _columns(getattr(import_module(module), name)):
                    yield f"| `{column}` | {_unit(unit)} | {meaning.replace('|', '&#124;')} | {when} |"
        yield ""


def _columns(declared: Any) -> list[tuple[str, str, str]]:
    """Name, unit and meaning of one column, of a tuple of them, or of a mapping to them."""
    if hasattr(declared, "meaning"):
        declared = (declared,)
    several = declared.values() if isinstance(declared, dict) else declared
    return [(one.name, one.unit, one.meaning) if hasattr(one, "meaning") else one for one in several]


def _unit(unit: str) -> str:
    return "" if unit in ("", "1") else unit.replace("*", "·")


if __name__ == "__main__":
    print(page(), end="")
