"""A hand from a file: the row of sysid's conditions that a spec means, as the hand of its scene."""

from pathlib import Path
from typing import Any

from hknob_cli.errors import UsageError
from hknob_cli.specs.conditions import (
    ChoiceError,
    Conditions,
    Row,
    flag_note,
    label,
    narrowed,
    numbers_of,
    read_conditions,
)
from hknob_cli.specs.hand import HandSpec
from hknob_cli.specs.part import Place
from hknob_cli.specs.parts import Origin
from hknob_cli.specs.plan import GRIP, Axes, Hand
from hknob_cli.specs.source import Source


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
