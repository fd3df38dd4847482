"""Where the trials of a sweep begin: one start at every clock phase, some phases of it, or every start in a box."""

from typing import Annotated, Any

from pydantic import Discriminator, Field, Tag

from hknob_cli.spec.plan import Axes, Starts
from hknob_cli.spec.quantity import Angle, Velocity
from hknob_cli.spec.scene import Part, SceneSpec, given

RANDOM = 256  # drawn from ranges, where not all can be followed at once and the spec does not say how many
PHASES = 64  # of one start, sampled where the motions of a scene cannot be followed all at once

# Values of the scene with which sets of starts are not followed.
_UNCUT = (
    "knob.coulomb_torque",
    "wall.damping",
    "hand.finger",
    "actuator.time_constant",
    "actuator.torque_limit",
    "actuator.torque_step",
    "actuator.delay_samples",
)


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
            description="of ranges: starts drawn at random where a scene's starts cannot be followed all at once; null:"
            " such a scene is refused",
        ),
    ] = None

    @property
    def spans(self) -> bool:
        """Whether every start in a box is meant."""
        return isinstance(self.angle, tuple) or isinstance(self.velocity, tuple)

    def faults(self) -> list[tuple[tuple[str, ...], str]]:
        """What is wrong with a range: places in the spec, and why."""
        if not self.spans:
            why = "must be absent where angle and velocity are not ranges: there is nothing to draw from"
            return [(("starts", "random"), why)] if self.random is not None else []
        found: list[tuple[tuple[str, ...], str]] = []
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
            return Starts(*middle, self.random or PHASES, False, span, self.random or 0)
        assert isinstance(self.angle, float)
        assert isinstance(self.velocity, float)
        return Starts(self.angle, self.velocity, self.phases or PHASES, self.phases is not None)


def with_random(base: dict[str, Any]) -> dict[str, Any]:
    """A sweep's values whose starts, if they are ranges, are drawn where not all can be followed at once."""
    starts = base.get("starts")
    if not isinstance(starts, dict) or not any(
        _form(starts.get(name)) == "two values" for name in ("angle", "velocity")
    ):
        return base
    return {**base, "starts": {"random": RANDOM, **starts}}


def span_faults(scene: SceneSpec, axes: Axes, *, population: bool, random: bool) -> list[tuple[tuple[str, ...], str]]:
    """What in a scene keeps every start of a box from being followed at once; ``random``: some are drawn then."""
    why = "must be absent where starts are a range: sets of starts are followed without it; give starts.random"
    found: list[tuple[tuple[str, ...], str]] = []
    if not random:
        uncut = [path for path in _UNCUT if not (scene.controller and path == "actuator.torque_limit")]
        found += [(place, why) for path in uncut for place in given(scene, axes, path)]
    if scene.controller and not scene.controller.counts_alone and not random:
        found.append((("scene", "controller"), why))
    if scene.encoder == "none" and not random:
        found.append((("scene", "encoder"), "must not be none where starts are a range"))
    if scene.sampling == "continuous":
        found.append((("scene", "sampling"), "must not be continuous where starts are a range"))
    if not scene.hand and not population and not random:
        found.append((("starts",), "must be one start without a hand: nothing draws the knob back, and no set shrinks"))
    return found
