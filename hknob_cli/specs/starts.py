"""Where the trials of a sweep begin: one start, at every clock phase or some, every start in a box, or every start."""

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from hknob_cli.specs.part import Part, Place
from hknob_cli.specs.plan import Starts
from hknob_cli.specs.quantity import Angle, Velocity

RANDOM = 256  # drawn from ranges, where not all can be followed at once and the spec does not say how many
PHASES = 64  # of one start, sampled where the motions of a scene cannot be followed all at once


def _form(value: Any) -> str:
    return "two values" if isinstance(value, list | tuple) else "one value"


AngleOrRange = Annotated[
    Annotated[Angle, Tag("one value")] | Annotated[tuple[Angle, Angle], Tag("two values")], Discriminator(_form)
]
VelocityOrRange = Annotated[
    Annotated[Velocity, Tag("one value")] | Annotated[tuple[Velocity, Velocity], Tag("two values")],
    Discriminator(_form),
]


class StartsSpec(Part):
    """Where the trials of a cell begin.

    One start means every clock phase of it, or as many as ``phases`` says. Two values of angle and velocity each mean
    every start between them, at a sample instant.
    """

    angle: Annotated[
        AngleOrRange,
        Field(
            description="knob angle at the start, above the wall where positive; [least, largest]: every one between"
        ),
    ] = 0.02
    velocity: Annotated[
        VelocityOrRange,
        Field(description="knob speed at the start; [least, largest]: every one between"),
    ] = 0.0
    phases: Annotated[
        int | None,
        Field(
            strict=True,
            ge=1,
            le=10_000_000,
            description="trials, whose first samples spread over an interval; null: every clock phase, exactly",
        ),
    ] = None
    random: Annotated[
        int | None,
        Field(
            strict=True,
            ge=1,
            le=1_000_000,
            description="of ranges: starts drawn at random in a cell whose starts cannot be followed all at once; null:"
            f" {RANDOM}",
        ),
    ] = None

    @property
    def spans(self) -> bool:
        """Whether every start in a box is meant."""
        return isinstance(self.angle, tuple) or isinstance(self.velocity, tuple)

    def faults(self) -> list[tuple[Place, str]]:
        """What is wrong with a range: places in the spec, and why."""
        if not self.spans:
            why = "must be absent where angle and velocity are not ranges: there is nothing to draw from"
            return [(("starts", "random"), why)] if self.random is not None else []
        found: list[tuple[Place, str]] = []
        for name in ("angle", "velocity"):
            value = getattr(self, name)
            if not isinstance(value, tuple):
                found.append(
                    (("starts", name), f"must be a range, [least, largest], as the other one is, got {value:g}")
                )
            elif not value[0] < value[1]:
                found.append((("starts", name), f"must have its least value first, got [{value[0]:g}, {value[1]:g}]"))
        if self.phases is not None:
            why = "must be absent where angle and velocity are ranges: every start is at a sample instant"
            found.append((("starts", "phases"), why))
        return found

    def plain(self) -> Starts:
        """The starts as plain values."""
        if isinstance(self.angle, tuple) and isinstance(self.velocity, tuple):
            span = (*self.angle, *self.velocity)
            middle = 0.5 * (span[0] + span[1]), 0.5 * (span[2] + span[3])
            random = self.random or RANDOM
            return Starts(*middle, random, False, span, random)
        assert isinstance(self.angle, float)
        assert isinstance(self.velocity, float)
        return Starts(self.angle, self.velocity, self.phases or PHASES, self.phases is not None)


def _kind(value: Any) -> str:
    return "every start" if isinstance(value, str) else "some starts"


AnyStarts = Annotated[
    Annotated[StartsSpec, Tag("some starts")] | Annotated[Literal["anywhere"], Tag("every start")],
    Discriminator(_kind),
    Field(description="one start, ranges of angle and velocity, or anywhere: every state at a sample instant"),
]


def kind_of_starts(starts: StartsSpec | str) -> str:
    """Which of `capabilities.STARTS` is meant."""
    if isinstance(starts, str):
        return "anywhere"
    return "ranges" if starts.spans else "one" if starts.phases is None else "phases"


def plain_starts(starts: StartsSpec | str) -> Starts:
    """The starts as plain values."""
    return Starts(0.0, 0.0, PHASES, False, anywhere=True) if isinstance(starts, str) else starts.plain()
