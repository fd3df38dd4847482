"""The hand on the knob in a spec: by its numbers, as measured at a grip, as identified, or of a population."""

from math import isclose
from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Field, PrivateAttr, ValidationInfo, field_validator, model_validator
from pydantic_core import PydanticCustomError

from hknob_cli.specs import plan
from hknob_cli.specs.part import Part, Place
from hknob_cli.specs.quantity import WHOLE, AddedInertia, Damping, Inertia, NotSweepable, Quantity, Stiffness

Grip = Annotated[float, Quantity("N")]


def printed_grips() -> list[float]:
    """Grip forces (N) of Tables 1-5, which are the same in each."""
    from hknob_cli.printed import grasps

    return [grasp.grip_n for grasp in grasps(1)]


def same_grip(one: float, other: float) -> bool:
    """Whether two grip forces (N) are the same except for rounding, of units as of the person who wrote them."""
    return isclose(one, other, rel_tol=1e-9)


def unprinted(grip_n: float) -> str | None:
    """What is wrong with a grip force (N) of a printed hand; None if Tables 1-5 have a row for it."""
    grips = printed_grips()
    if any(same_grip(grip_n, grip) for grip in grips):
        return None
    allowed = ", ".join(f"{grip:g}" for grip in grips)
    return f"must be a grip force of Tables 1-5, {allowed}"


def printed_beside_table(value: float | None, info: ValidationInfo) -> float | None:
    """Validator of a grip force: beside a ``table`` it is one of its rows."""
    wrong = unprinted(value) if value is not None and info.data.get("table") is not None else None
    if wrong:
        raise PydanticCustomError("grip", "{reason}", {"reason": wrong})
    return value


def printed_grip_schema() -> dict[str, Any]:
    """JSON Schema of a grip force beside a table."""
    return {"anyOf": [{"enum": printed_grips()}, {"type": "string"}]}


_GIVEN = ("inertia", "damping", "stiffness", "finger", "fingerpad")
_OF_A_FILE = ("experiment", "subject", "estimator", "subtract_apparatus")
Label = Annotated[str, Field(min_length=1)] | Annotated[int, Field(strict=True)]


def _exclusions(schema: dict[str, Any]) -> None:
    """Say in the JSON Schema which keys need or exclude one another."""
    schema["dependentRequired"] = {"table": ["grip_n"], **{key: ["from"] for key in _OF_A_FILE}}
    schema["dependentSchemas"] = {
        "table": {"properties": {**dict.fromkeys((*_GIVEN, "from"), False), "grip_n": printed_grip_schema()}},
        "from": {"properties": dict.fromkeys((*_GIVEN, "table"), False)},
        "grip_n": {"anyOf": [{"required": ["table"]}, {"required": ["from"]}]},
    }


class HandSpec(Part):
    """The hand on the knob; its neutral angle is 0.

    Second order, moving with the knob, by ``inertia``, ``damping`` and ``stiffness``; as measured, by ``table`` and
    ``grip_n``; or as identified, ``from`` a file. Or fourth order, by ``finger`` and ``fingerpad``.
    """

    model_config = ConfigDict(json_schema_extra=_exclusions)
    _identified: plan.Hand = PrivateAttr(default_factory=plan.Hand)

    inertia: Annotated[AddedInertia, Field(description="moment of inertia the grasp adds")] = 0.0
    damping: Annotated[Damping, Field(description="damping of the grasp")] = 0.0
    stiffness: Annotated[Stiffness, Field(description="stiffness of the grasp")] = 0.0
    finger: plan.Finger | None = None
    fingerpad: plan.Fingerpad | None = None
    table: Annotated[
        Literal[1, 2, 3, 4, 5] | None,
        WHOLE,
        Field(
            description="Hasser's hand models, without the apparatus: 1 simple and 2 key pinch of a 17.8 mm knob;"
            " 3 simple, 4 key pinch and 5 three fingers of a 29.9 mm knob"
        ),
    ] = None
    grip_n: Annotated[Grip | None, Field(description="row of the table or file: its grip force")] = None
    from_: Annotated[
        str | None,
        Field(
            alias="from",
            min_length=1,
            description="results of sysid, a folder or its conditions.parquet, relative to this file; a key that is"
            " not given is the only value that the file has",
        ),
    ] = None
    experiment: Annotated[Label | None, Field(description="of the file: its experiment")] = None
    subject: Annotated[Label | None, Field(description="of the file: one person; default: the mean over persons")] = (
        None
    )
    estimator: Annotated[str | None, Field(description="of the file: default output_error, if it is there")] = None
    subtract_apparatus: Annotated[
        Inertia | None, NotSweepable(), Field(description="inertia of the apparatus, where the file's includes it")
    ] = None

    _printed = field_validator("grip_n")(printed_beside_table)

    @model_validator(mode="after")
    def _one_order(self) -> "HandSpec":
        if (self.table is None) != (self.grip_n is None) and self.from_ is None:
            raise PydanticCustomError("two_keys", "must have both 'table' and 'grip_n', or neither")
        if (self.finger is None) != (self.fingerpad is None):
            raise PydanticCustomError("two_parts", "must have both 'finger' and 'fingerpad', or neither")
        if self.finger and (self.inertia or self.damping or self.stiffness):
            raise PydanticCustomError(
                "two_hands", "must have 'finger' and 'fingerpad', or inertia, damping and stiffness, not both"
            )
        return self

    @property
    def measured(self) -> str:
        """The key that says where a measured hand is from; empty for one given by its numbers."""
        return "from" if self.from_ is not None else "table" if self.table is not None else ""

    def identify(self, hand: plan.Hand) -> None:
        """Take the numbers of the file that the hand is from; until then it has none."""
        self._identified = hand

    def plain(self) -> plan.Hand:
        """The hand as plain values."""
        if self.from_ is not None:
            return self._identified
        if self.table is not None and self.grip_n is not None:
            from hknob_cli.printed import grasps

            by_grip = tuple((grasp.grip_n, plan.Hand(*grasp[1:])) for grasp in grasps(self.table))
            return plan.gripped(plan.Hand(by_grip=by_grip), self.grip_n)
        return plan.Hand(
            inertia=self.inertia,
            damping=self.damping,
            stiffness=self.stiffness,
            finger=self.finger,
            fingerpad=self.fingerpad,
        )


def hand_contradictions(spec: HandSpec | None, knob_inertia: float, axes: plan.Axes) -> list[tuple[Place, str]]:
    """What contradicts a hand from a table or file: other keys, grips it lacks, and a knob too light for it."""
    found: list[tuple[Place, str]] = []
    if spec is None or not spec.measured:
        if plan.GRIP in axes:
            found.append((("grid", plan.GRIP), "must be absent where the hand has no table and is from no file"))
        for key in _OF_A_FILE if spec else ():
            if getattr(spec, key) is not None:
                found.append((("scene", "hand", key), "must be absent where the hand is not 'from' a file"))
        return found
    where = "has a table" if spec.measured == "table" else "is from a file"
    for key in (*_GIVEN, *(_OF_A_FILE if spec.measured == "table" else ("table",))):
        if key in spec.model_fields_set and getattr(spec, key) is not None:
            found.append((("scene", "hand", key), f"must be absent where the hand {where}, which gives it"))
    hand = spec.plain()
    if hand.by_grip and plan.GRIP in axes:
        grips = [grip for grip, _ in hand.by_grip]
        whose = "Tables 1-5" if spec.table else "the file"
        allowed = f"a grip force of {whose}, {', '.join(f'{grip:g}' for grip in grips)}"
        for i, grip in enumerate(axes[plan.GRIP]):
            if not any(same_grip(grip, one) for one in grips):
                found.append((("grid", plan.GRIP, i), f"must be {allowed}, got {grip:g}"))
    return found + _too_light(spec, hand, knob_inertia, axes)


def _too_light(spec: HandSpec, hand: plan.Hand, knob_inertia: float, axes: plan.Axes) -> list[tuple[Place, str]]:
    """Grips that take more inertia away than the knob has."""
    knob = min(axes.get("knob.inertia", [knob_inertia]))
    grips = axes.get(plan.GRIP, [spec.grip_n or 0.0]) if "hand.inertia" not in axes else []
    place = ("grid", plan.GRIP) if plan.GRIP in axes else ("scene", "hand", "grip_n" if spec.grip_n else "from")
    found: list[tuple[Place, str]] = []
    for grip in grips:
        added = (plan.gripped(hand, grip) if hand.by_grip else hand).inertia
        if knob + added <= 0.0:
            whose = f"table {spec.table}" if spec.table else "the file"
            less = f"{whose} has {-added:g} kg*m^2 less than its apparatus without a hand"
            at = f"at {grip:g} N, " if grip else ""
            found.append((place, f"must leave an inertia above 0: {at}{less}, and the knob has {knob:g}"))
    return found


MOST_PEOPLE = 100_000
_DRAWN = ("people", "seed")
_PEOPLE_OF_A_FILE = ("experiment", "estimator", "subtract_apparatus", "spread")


def _population_exclusions(schema: dict[str, Any]) -> None:
    """Say in the JSON Schema which keys need or exclude one another."""
    schema["oneOf"] = [{"required": ["from"]}, {"required": ["table"]}]
    table = {**dict.fromkeys(_PEOPLE_OF_A_FILE, False), "grip_n": printed_grip_schema()}
    schema["dependentSchemas"] = {"table": {"required": ["grip_n"], "properties": table}}
    subjects = {"required": ["spread"], "properties": {"spread": {"const": "subjects"}}}
    schema |= {"if": subjects, "then": {"properties": dict.fromkeys(_DRAWN, False)}}


class PopulationSpec(Part):
    """People who turn the knob: every cell of the grid is swept for the hand of each."""

    model_config = ConfigDict(json_schema_extra=_population_exclusions)

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
            found += [
                (key, "must be absent where people are of a table") for key in _PEOPLE_OF_A_FILE if self._given(key)
            ]
        elif self.spread == "subjects":
            found += [(key, "must be absent where the people are the subjects") for key in _DRAWN if self._given(key)]
        return found

    def _given(self, key: str) -> bool:
        return key in self.model_fields_set
