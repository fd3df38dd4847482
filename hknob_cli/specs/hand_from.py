"""A hand from a file: the row of sysid's conditions that a spec means, as the hand of its scene.

A row is a condition (experiment, grip force; at level "subject" a person, at level "all" the mean over persons) and an
estimator, with inertia, damping and stiffness of the grasp.
"""

import hashlib
from collections.abc import Iterable
from io import BytesIO
from math import isfinite
from pathlib import Path
from typing import Any, NamedTuple

from hknob_cli.errors import UsageError
from hknob_cli.specs.hand import HandSpec, same_grip
from hknob_cli.specs.named_file import inside, read_named
from hknob_cli.specs.part import Place
from hknob_cli.specs.parts import Origin
from hknob_cli.specs.plan import GRIP, Axes, Hand
from hknob_cli.specs.source import Source

FILE = "conditions.parquet"
# Columns of what a spec chooses by, in the order of the choice.
KEYS = {"experiment": "experiment", "subject": "subject", "grip_n": "grip_target_n", "estimator": "estimator"}
NUMBERS = ("inertia_kg_m2", "damping_nm_s_per_rad", "stiffness_nm_per_rad")
_MOST = (1e6, 1e9, 1e12)  # of these, as in a scene
STDS = tuple(f"{name}_std" for name in NUMBERS)
APPARATUS = "apparatus_inertia_kg_m2"
BEST_ESTIMATOR = "output_error"
_ALWAYS = ("level", "experiment", "grip_target_n", "estimator")
_REALS = ("grip_target_n", *NUMBERS, *STDS, APPARATUS)
_NEEDED = ("level", *KEYS.values(), *NUMBERS, *STDS, APPARATUS, "flags")

Row = dict[str, Any]
Triple = tuple[float, float, float]


class ChoiceError(ValueError):
    """Keys of a spec do not choose: which ``key`` is wrong, and how."""

    def __init__(self, key: str, message: str) -> None:
        super().__init__(message)
        self.key = key


class Conditions(NamedTuple):
    """The file, its digest, and its rows."""

    file: Path
    sha256: str
    rows: list[Row]


def read_conditions(place: Path) -> Conditions:
    """Conditions in a file, or in a folder of sysid's results. Raises `UsageError`."""
    import pyarrow as pa

    from hknob_cli.specs.parquet import ChangedError, NotTextError, table_of

    file = inside(place, FILE)
    data = read_named(file)
    try:
        table = table_of(BytesIO(data))
    except (NotTextError, ChangedError) as error:
        raise UsageError(f"{file}: {error}") from None
    except (OSError, pa.ArrowException):
        raise UsageError(f"{file}: is not a Parquet file") from None
    missing = [name for name in _NEEDED if name not in table.column_names]
    if missing:
        raise UsageError(f"{file}: has no column {', '.join(missing)}; sysid writes such a file as {FILE}")
    return Conditions(file, hashlib.sha256(data).hexdigest(), _typed(table, file))


def _typed(table: Any, file: Path) -> list[Row]:
    """Rows of the columns that are needed, numbers and texts. Raises `UsageError` for others."""
    import pyarrow as pa

    columns = {}
    for name in _NEEDED:
        kind = pa.float64() if name in _REALS else pa.string()
        if table.column_names.count(name) > 1:
            raise UsageError(f"{file}: has several columns {name}")
        try:
            columns[name] = table.column(name).cast(kind).to_pylist()
        except (pa.ArrowException, ValueError):
            what = "numbers" if name in _REALS else "text"
            raise UsageError(f"{file}: {name}: must be {what}, is {table.column(name).type}") from None
        if name in _ALWAYS and None in columns[name]:
            raise UsageError(f"{file}: {name}: nothing in a row; must be in all of them")
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


def narrowed(rows: list[Row], wanted: Row, keys: Iterable[str]) -> list[Row]:
    """Rows of the ``wanted`` value of each of ``keys``, or of the only one there is.

    Raises `ChoiceError` where there is no such value, and where there are several to choose from.
    """
    for key in keys:
        column, value = KEYS[key], wanted.get(key)
        there = sorted({row[column] for row in rows if row[column] is not None})
        if value is None and key == "estimator" and BEST_ESTIMATOR in there:
            value = BEST_ESTIMATOR
        if value is None:
            if len(there) > 1:
                raise ChoiceError(key, f"missing, and required: {_one_of(there)}")
            continue
        found = [row for row in rows if _is(row[column], value)]
        if not found:
            raise ChoiceError(key, f"must be {_one_of(there)}, got {_text(value)}" if there else "must be absent")
        rows = found
    return rows


def numbers_of(row: Row, subtract: float | None) -> Triple:
    """Inertia (kg·m²), damping (N·m·s/rad), stiffness (N·m/rad) that a row says the grasp adds to the knob.

    ``subtract``: inertia of the apparatus, where the file's includes it. Raises `ChoiceError`.
    """
    apparatus = row[APPARATUS]
    if apparatus is None and subtract is None:
        raise ChoiceError("subtract_apparatus", "missing, and required: the file's inertia includes the apparatus")
    if apparatus is not None and subtract is not None:
        raise ChoiceError(
            "subtract_apparatus", f"must be absent: the file's inertia is without the apparatus' {apparatus:g} kg*m^2"
        )
    for name in NUMBERS:
        if row[name] is None or not isfinite(row[name]):
            raise ChoiceError("from", f"{label(row)} has no {name}")
    inertia, damping, stiffness = (float(row[name]) for name in NUMBERS)
    for name, value, most in zip(NUMBERS, (inertia, damping, stiffness), _MOST, strict=True):
        if abs(value) > most:
            raise ChoiceError("from", f"{label(row)} has a {name} of {value:g}, which is above {most:g}")
        if value < 0.0 and name != NUMBERS[0]:
            raise ChoiceError("from", f"{label(row)} has a {name} of {value:g}, which is below 0")
    return inertia - (subtract or 0.0), damping, stiffness


def label(row: Row) -> str:
    """Which row it is, in words."""
    who = f"subject {row['subject']}" if row["subject"] is not None else "the mean over persons"
    return f"{who}, experiment {row['experiment']}, {row['grip_target_n']:g} N, {row['estimator']}"


def flag_note(rows: list[Row]) -> tuple[str, ...]:
    """A warning of the rows that sysid flagged, if any."""
    said = [f"{label(row)}: {row['flags']}" for row in rows if row["flags"]]
    return (f"warning: a hand is used although flagged: {'; '.join(said)}",) if said else ()


def _is(found: Any, wanted: Any) -> bool:
    if isinstance(wanted, float):
        return found is not None and same_grip(found, wanted)
    return found is not None and str(found) == str(wanted)


def _text(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else f"'{value}'"


def _one_of(values: list[Any]) -> str:
    return f"one of {', '.join(map(_text, values))}" if len(values) > 1 else "".join(map(_text, values))


def place_of(source: Source, name: str) -> Path:
    """The file or folder that a spec names, relative to the spec."""
    return Path(source.name).parent / name


def take_hand(source: Source, spec: HandSpec | None, axes: Axes) -> list[tuple[Place, str]]:
    """Read the file that a hand is from, if it is, and give the hand its numbers.

    Returns faults: places in the spec, and what is wrong there. Nothing is read that another stage is yet to make.
    """
    if spec is None or spec.from_ is None or spec.from_ in source.waiting:
        return []
    try:
        spec.identify(_hand(read_conditions(place_of(source, spec.from_)), spec, axes))
    except UsageError as error:
        return [(("scene", "hand", "from"), str(error))]
    except ChoiceError as error:
        return [(("scene", "hand", error.key), str(error))]
    return []


def _hand(conditions: Conditions, spec: HandSpec, axes: Axes) -> Hand:
    """The hand that a spec means. Raises `ChoiceError`."""
    wanted: dict[str, Any] = {key: getattr(spec, key) for key in ("experiment", "subject", "grip_n", "estimator")}
    means = [row for row in conditions.rows if row["level"] == "all"]
    subjects = [row for row in conditions.rows if row["level"] == "subject"]
    rows = narrowed(means if means and spec.subject is None else subjects, wanted, ("experiment", "subject"))
    if GRIP in axes:
        every = narrowed(rows, wanted, ("estimator",))
        grips = sorted({float(row["grip_target_n"]) for row in every})
        by_grip = {grip: _one(narrowed(every, {"grip_n": grip}, ("grip_n",))) for grip in grips}
        used = list(by_grip.values())
    else:
        used = [_one(narrowed(rows, wanted, ("grip_n", "estimator")))]
        by_grip = {}
    origin = Origin(conditions.file, conditions.sha256, flag_note(used))
    hands = [Hand(*numbers_of(row, spec.subtract_apparatus)) for row in used]
    return hands[0]._replace(by_grip=tuple(zip(by_grip, hands, strict=True)) if by_grip else (), origin=origin)


def _one(rows: list[Row]) -> Row:
    """The only row. Raises `ChoiceError` if there are none or several."""
    if not rows:
        raise ChoiceError("from", "has no condition of this level")
    if len(rows) > 1:
        raise ChoiceError("from", f"has {len(rows)} rows for {label(rows[0])}")
    return rows[0]
