"""A population in a sweep's spec: people whose hands were identified, or drawn from how such hands spread."""

from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Field, field_validator, model_validator
from pydantic_core import PydanticCustomError

from hknob_cli.specs.hand import Grip, Label, printed_beside_table, printed_grip_schema
from hknob_cli.specs.part import Part
from hknob_cli.specs.quantity import WHOLE, Inertia, NotSweepable

MOST_PEOPLE = 100_000
_DRAWN = ("people", "seed")
_OF_A_FILE = ("experiment", "estimator", "subtract_apparatus", "spread")


def _exclusions(schema: dict[str, Any]) -> None:
    """Say in the JSON Schema which keys need or exclude one another."""
    schema["oneOf"] = [{"required": ["from"]}, {"required": ["table"]}]
    table = {**dict.fromkeys(_OF_A_FILE, False), "grip_n": printed_grip_schema()}
    schema["dependentSchemas"] = {"table": {"required": ["grip_n"], "properties": table}}
    subjects = {"required": ["spread"], "properties": {"spread": {"const": "subjects"}}}
    schema |= {"if": subjects, "then": {"properties": dict.fromkeys(_DRAWN, False)}}


class PopulationSpec(Part):
    """People who turn the knob: every cell of the grid is swept for the hand of each."""

    model_config = ConfigDict(json_schema_extra=_exclusions)

    from_: Annotated[
        str | None,
        Field(
            alias="from",
            min_length=1,
            description="results of sysid, a folder or its conditions.parquet, relative to this file",
        ),
    ] = None
    table: Annotated[
        Literal[1, 2, 3, 4, 5] | None,
        WHOLE,
        Field(description="Hasser's hand models: printed means and deviations"),
    ] = None
    grip_n: Annotated[Grip | None, Field(description="row of the table or file: its grip force")] = None
    experiment: Annotated[Label | None, Field(description="of the file: its experiment")] = None
    estimator: Annotated[str | None, Field(description="of the file: default output_error, if it is there")] = None
    subtract_apparatus: Annotated[
        Inertia | None, NotSweepable(), Field(description="inertia of the apparatus, where the file's includes it")
    ] = None
    spread: Annotated[
        Literal["lognormal", "subjects"],
        Field(description="people drawn from a lognormal as the subjects of the file spread; or these subjects"),
    ] = "lognormal"
    people: Annotated[int, Field(strict=True, ge=1, le=MOST_PEOPLE, description="people to draw")] = 200
    seed: Annotated[int, Field(strict=True, ge=0, le=2**32 - 1, description="of the draw; the same people by it")] = 1

    _printed = field_validator("grip_n")(printed_beside_table)

    @model_validator(mode="after")
    def _one_of(self) -> "PopulationSpec":
        if (self.from_ is None) == (self.table is None):
            raise PydanticCustomError("one_of", "must have exactly one of 'from' and 'table'")
        if self.table is not None and self.grip_n is None:
            raise PydanticCustomError("two_keys", "must have 'grip_n' beside 'table'")
        return self

    def contradictions(self) -> list[tuple[str, str]]:
        """Keys that others exclude, and why."""
        found = []
        if self.table is not None:
            found += [(key, "must be absent where people are of a table") for key in _OF_A_FILE if self._given(key)]
        elif self.spread == "subjects":
            found += [(key, "must be absent where the people are the subjects") for key in _DRAWN if self._given(key)]
        return found

    def _given(self, key: str) -> bool:
        return key in self.model_fields_set
