"""Columns of other people's recordings: by which name, in which unit and with which sign a file has them."""

import math
from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag, model_validator
from pydantic_core import PydanticCustomError

from hknob_cli.errors import Fault
from hknob_cli.specs.identification import ColumnPlan
from hknob_cli.specs.part import Part
from hknob_cli.specs.quantity import Unit, to_si
from hknob_cli.specs.source import Source

ColumnName = Literal[
    "subject",
    "experiment",
    "grip_target_n",
    "block",
    "trial",
    "time_s",
    "torque_nm",
    "angle_rad",
    "grip_n",
    "measured_torque_nm",
    "acceleration_rad_s2",
]
TEXTS = ("subject", "experiment")
WHOLE = ("block", "trial")
SI = {
    "time_s": "s",
    "torque_nm": "N*m",
    "measured_torque_nm": "N*m",
    "acceleration_rad_s2": "rad/s^2",
    "angle_rad": "rad",
    "grip_n": "N",
    "grip_target_n": "N",
}
# A sample's column cannot be one number.
CONSTANT = (*TEXTS, *WHOLE, "grip_target_n")
Most = Annotated[float, Field(strict=True, gt=0, le=1e6, allow_inf_nan=False)]


class ColumnSpec(Part):
    """Where a column is in the file, and how its numbers become SI; or one value of all rows."""

    from_: Annotated[
        str | None, Field(alias="from", min_length=1, description="its name in the file; null: the same name")
    ] = None
    unit: Annotated[
        str | None, Field(min_length=1, max_length=40, description="unit of the file's numbers; null: SI")
    ] = None
    scale: Annotated[
        float | None,
        Field(strict=True, allow_inf_nan=False, description="instead of a unit: SI units in one of the file's numbers"),
    ] = None
    sign: Annotated[Literal[1, -1], Field(description="-1 turns the numbers round")] = 1
    value: Annotated[str | float | None, Field(description="instead of a column: the value in all rows")] = None

    @model_validator(mode="after")
    def _one_way(self) -> "ColumnSpec":
        if self.value is not None and self.model_fields_set - {"value"}:
            raise PydanticCustomError("two_keys", "must have nothing beside 'value'")
        if self.unit is not None and self.scale is not None:
            raise PydanticCustomError("two_keys", "must have 'unit' or 'scale', not both")
        if self.scale == 0.0:
            raise PydanticCustomError("no_scale", "must have a scale other than 0")
        return self


def _shape(value: Any) -> str:
    return "column" if isinstance(value, dict) else "name"


# A discriminator, so that what is wrong with one is not said to be no text, too.
NameOrColumn = Annotated[
    Annotated[str, Field(min_length=1), Tag("name")] | Annotated[ColumnSpec, Tag("column")], Discriminator(_shape)
]


class RecordingLimits(Part):
    """Sizes up to which a recording's numbers are no surprise; larger ones are read, with a warning."""

    angle: Annotated[Most, Unit("rad"), Field(description="of angles")] = 100.0
    torque: Annotated[Most, Unit("N*m"), Field(description="of torques, commanded and measured")] = 10.0
    acceleration: Annotated[Most, Unit("rad/s^2"), Field(description="of an accelerometer")] = 1e5
    force: Annotated[Most, Unit("N"), Field(description="of grip forces")] = 1000.0

    def plain(self) -> dict[str, float]:
        """By column."""
        return {
            "angle_rad": self.angle,
            "torque_nm": self.torque,
            "measured_torque_nm": self.torque,
            "acceleration_rad_s2": self.acceleration,
            "grip_n": self.force,
            "grip_target_n": self.force,
        }


def plan_columns(source: Source, given: Mapping[Any, str | ColumnSpec]) -> tuple[dict[str, ColumnPlan], list[Fault]]:
    """Columns by their names here; and what is wrong with units, values and names."""
    found: dict[str, ColumnPlan] = {}
    faults: list[Fault] = []
    for name, one in given.items():
        place = ("columns", name)
        if isinstance(one, str):
            found[name] = ColumnPlan(one)
            continue
        if one.value is not None:
            faults += _constant(source, name, one.value)
            found[name] = ColumnPlan("", value=one.value)
            continue
        for key in ("unit", "scale", "sign"):
            if key in one.model_fields_set and name not in SI:
                faults.append(source.fault((*place, key), "must be absent: this column is no quantity", at_key=True))
        factor = float(one.sign) * (one.scale if one.scale is not None else 1.0)
        if one.unit is not None and name in SI:
            try:
                factor *= to_si(f"1 {one.unit}", SI[name])
            except ValueError as error:
                faults.append(source.fault((*place, "unit"), f"'{one.unit}' {error}"))
        found[name] = ColumnPlan(one.from_ or name, factor)
    seen: dict[str, str] = {}
    for name, plan in found.items():
        if plan.source and plan.source in seen:
            text = f"is from '{plan.source}', as {seen[plan.source]} is; must be from another"
            faults.append(source.fault(("columns", name), text))
        seen.setdefault(plan.source, name)
    return found, faults


def _constant(source: Source, name: str, value: str | float) -> list[Fault]:
    place = ("columns", name, "value")
    if name not in CONSTANT:
        return [source.fault(place, f"must be absent: {name} changes from row to row", at_key=True)]
    if name in TEXTS:
        return [] if isinstance(value, str) else [source.fault(place, f"must be text, got {value:g}")]
    if isinstance(value, str) or not math.isfinite(value) or value < 0.0:
        return [source.fault(place, f"must be a number >= 0, got {value!r}")]
    if name in WHOLE and value != int(value):
        return [source.fault(place, f"must be a whole number, got {value:g}")]
    return []
