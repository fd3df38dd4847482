"""Results of an identification as drawings need them: fits by condition, and the recorded motions they are of."""

from typing import Any, NamedTuple

from hknob_cli.apparatus.rig import virtual_rig
from hknob_cli.identify.motion import Motion
from hknob_cli.identify.prepare import Preparation, Prepared, conditions
from hknob_cli.identify.second_order import Plant
from hknob_cli.recordings.read import read
from hknob_cli.recordings.trial import Trial
from hknob_cli.results.result_set import MissingError, Result, Rows
from hknob_cli.specs.identification import SysidPlan
from hknob_cli.specs.source import Source
from hknob_cli.specs.sysid import validate_sysid

APPARATUS = "apparatus_inertia_kg_m2"
COLUMNS = {"inertia": "inertia_kg_m2", "damping": "damping_nm_s_per_rad", "stiffness": "stiffness_nm_per_rad"}


class Pulsed(NamedTuple):
    """A recorded condition as a motion, from the onset of its pulse on; ``start`` is the sample of the onset."""

    of: Prepared
    motion: Motion
    start: int


def plan_of(result: Result) -> SysidPlan:
    """What the identification that made a result was asked for. Raises `MissingError` for another kind of result."""
    if result.stage != "sysid":
        raise MissingError(f"'{result.name}' is not of an identification, but of {result.stage}")
    source = Source(result.name)
    source.value = {"kind": "sysid", **result.provenance["spec"]}
    return validate_sysid(source)


def rows_of(result: Result, file: str, **asked: Any) -> Rows:
    """Rows of a table with the values asked for (None: any), those with a whole second-order model.

    Raises `MissingError` where there is none.
    """
    chosen = {name: value for name, value in asked.items() if value is not None}
    table = result.table(file)
    if lacking := sorted({*chosen, *COLUMNS.values()} - set(table.column_names)):
        raise MissingError(f"no column {', '.join(lacking)} in {file} of '{result.name}'")
    found = [
        row
        for row in table.to_pylist()
        if all(row[name] == value for name, value in chosen.items())
        and all(row[column] is not None for column in COLUMNS.values())
    ]
    if not found:
        told = ", ".join(f"{name} {value}" for name, value in chosen.items())
        raise MissingError(f"no fit of '{result.name}' with {told or 'anything'}")
    return found


def plant_of(row: dict[str, Any]) -> Plant:
    """The second-order model of a row of fits, apparatus included, whether or not it was subtracted."""
    values = {name: row[column] for name, column in COLUMNS.items()}
    values["inertia"] += row.get(APPARATUS) or 0.0
    return Plant(**values, coulomb=row.get("coulomb_nm") or 0.0)


def recorded(result: Result, **asked: Any) -> list[Trial]:
    """Recorded trials with the keys asked for (None: any). Raises `MissingError` where none were kept."""
    file = "samples" if result.has_pulses else "recordings"
    result.table(file)  # says so where they were not kept
    chosen = {name: value for name, value in asked.items() if value is not None}
    trials = read([result.folder / f"{file}.parquet"])
    found = [one for one in trials if all(getattr(one.key, name) == value for name, value in chosen.items())]
    if not found:
        raise MissingError(f"no recording of '{result.name}' with {chosen}")
    return found


def pulsed(result: Result, *, smooth: bool, after_s: float = 0.03, **asked: Any) -> list[Pulsed]:
    """Averaged motions of the recorded conditions, prepared as the result's own; ``smooth``: as for least squares.

    Raises `MissingError` where there are none.
    """
    plan = plan_of(result)
    own = plan.prepare
    window = (own.window_s[0], after_s)
    how = Preparation(average=True, decimate=1, differentiate=False, window_s=window)
    if smooth:
        how = Preparation(decimate=own.decimate, window_s=window)
    counts = virtual_rig(plan).counts_per_rev or None if plan.virtual is not None else plan.counts_per_rev
    found = []
    for one in conditions(recorded(result, **asked), how, counts_per_rev=counts):
        if one.motion is not None:
            start = next(i for i, torque in enumerate(one.motion.torque_nm) if torque)
            found.append(Pulsed(one, one.motion, start))
    if not found:
        raise MissingError(f"no recording of '{result.name}' can be used")
    return found
