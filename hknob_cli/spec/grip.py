"""A grip force of the printed hand models: one of those that Tables 1-5 have a row for."""

from math import isclose
from typing import Annotated, Any

from pydantic import Field, GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import PydanticCustomError, core_schema

from hknob_cli.spec.quantity import Unit


def printed_grips() -> list[float]:
    """Grip forces (N) of Tables 1-5, which are the same in each."""
    from hknob_cli.printed.hands import grasps

    return [grasp.grip_n for grasp in grasps(1)]


class _OfATable:
    """Annotation of a grip force (N): as printed, or a fault that says which are."""

    def check(self, value: float) -> float:
        grips = printed_grips()
        for grip in grips:
            if isclose(value, grip, rel_tol=1e-9):
                return grip
        allowed = ", ".join(f"{grip:g}" for grip in grips)
        raise PydanticCustomError("grip", "must be a grip force of Tables 1-5, {allowed}", {"allowed": allowed})

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> core_schema.CoreSchema:
        return core_schema.no_info_after_validator_function(self.check, handler(source))

    def __get_pydantic_json_schema__(
        self, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        return {**handler(schema), "enum": printed_grips()}


Grip = Annotated[float, Field(strict=True, allow_inf_nan=False), _OfATable(), Unit("N")]
