"""When a computed number agrees with a printed one."""

from typing import Annotated, Self

from pydantic import Field, model_validator

from hknob_cli.specs.scene import Part

Real = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]


class Bounds(Part):
    """An interval of computed values, about the printed value or absolute. What is not given does not bind."""

    within: Annotated[Positive | None, Field(description="largest difference from the printed value")] = None
    within_percent: Annotated[Positive | None, Field(description="the same, in % of the printed value")] = None
    at_least: Real | None = None
    at_most: Real | None = None

    @model_validator(mode="after")
    def _binds(self) -> Self:
        if all(value is None for value in (self.within, self.within_percent, self.at_least, self.at_most)):
            raise ValueError("must give at least one of within, within_percent, at_least, at_most")
        return self

    @property
    def relative(self) -> bool:
        """Whether a printed value is needed."""
        return self.within is not None or self.within_percent is not None

    def hold(self, computed: float, printed: float | None) -> bool:
        """Whether a computed value lies within; a bound itself does, up to rounding in the last digits."""
        slack = 1e-9 * max(abs(computed), abs(printed or 0.0))
        if printed is not None:
            off = abs(computed - printed) - slack
            if self.within is not None and off > self.within:
                return False
            if self.within_percent is not None and off > 0.01 * self.within_percent * abs(printed):
                return False
        if self.at_least is not None and computed < self.at_least - slack:
            return False
        return self.at_most is None or computed <= self.at_most + slack
