"""The design of a grid in a spec: points that fill the ranges of the axes, in place of every combination of values."""

from typing import Annotated, Any

from pydantic import ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

from hknob_cli.specs.part import Part
from hknob_cli.specs.quantity import MayBeFloat
from hknob_cli.specs.unit_points import HALTON, LATIN, MOST_POINTS, RANDOM, SOBOL, Points

_METHODS = (SOBOL, HALTON, LATIN, RANDOM)


_Sobol = Annotated[int, Field(strict=True, ge=1, le=MOST_POINTS[SOBOL]), MayBeFloat]
_Latin = Annotated[int, Field(strict=True, ge=1, le=MOST_POINTS[LATIN]), MayBeFloat]
_Many = Annotated[int, Field(strict=True, ge=1, le=MOST_POINTS[RANDOM]), MayBeFloat]


def _one_method(schema: dict[str, Any]) -> None:
    """Say in the JSON Schema that there is one method."""
    schema["oneOf"] = [{"required": [method]} for method in _METHODS]


class PointsSpec(Part):
    """Points that fill the ranges of the axes: how many, by exactly one method (scipy.stats.qmc; random: numpy)."""

    model_config = ConfigDict(json_schema_extra=_one_method)

    sobol: Annotated[
        _Sobol | None, Field(description="points of a scrambled Sobol sequence; a power of two is best")
    ] = None
    halton: Annotated[_Many | None, Field(description="points of a scrambled Halton sequence")] = None
    latin_hypercube: Annotated[_Latin | None, Field(description="points of a Latin hypercube")] = None
    random: Annotated[_Many | None, Field(description="points drawn independently")] = None
    seed: Annotated[int, Field(strict=True, ge=0, le=2**32 - 1, description="the same points by it")] = 1

    @model_validator(mode="after")
    def _one(self) -> "PointsSpec":
        given = [name for name in _METHODS if getattr(self, name) is not None]
        if len(given) != 1:
            text = f"must have exactly one of {', '.join(_METHODS)}, got {' and '.join(given) or 'none'}"
            raise PydanticCustomError("one_of", "{text}", {"text": text})
        return self

    def plain(self, scales: dict[str, str]) -> Points:
        """The design as plain values; ``scales``: log or lin of each axis that is a range."""
        method = next(name for name in _METHODS if getattr(self, name) is not None)
        return Points(method, int(getattr(self, method)), self.seed, scales)
