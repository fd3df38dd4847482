"""Where the trials of a sweep begin: one start at every clock phase, some phases of it, or every start in a box."""

from typing import Annotated, Any

from pydantic import Discriminator, Field, Tag

from hknob_cli.spec.plan import Axes, Starts
from hknob_cli.spec.quantity import Angle, Velocity
from hknob_cli.spec.scene import Part, SceneSpec, given

PHASES = 64  # of one start, sampled where the motions of a scene cannot be followed all at once

# With friction, sets of starts are followed only without these.
_UNRUBBED = ("hand.finger", "actuator.time_constant")

# And with which their basins are not mapped.
_UNMAPPED = (
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

    @property
    def spans(self) -> bool:
        """Whether every start in a box is meant."""
        return isinstance(self.angle, tuple) or isinstance(self.velocity, tuple)

    def faults(self) -> list[tuple[tuple[str, ...], str]]:
        """What is wrong with a range: places in the spec, and why."""
        if not self.spans:
            return []
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
            return Starts(0.5 * (span[0] + span[1]), 0.5 * (span[2] + span[3]), PHASES, False, span)
        assert isinstance(self.angle, float)
        assert isinstance(self.velocity, float)
        return Starts(self.angle, self.velocity, self.phases or PHASES, self.phases is not None)


def span_faults(scene: SceneSpec, axes: Axes, *, population: bool) -> list[tuple[tuple[str, ...], str]]:
    """What in a scene keeps every start of a box from being followed at once."""
    why = "must be absent where starts are a range: sets of starts are followed without it; give one start"
    found: list[tuple[tuple[str, ...], str]] = []
    if given(scene, axes, "knob.coulomb_torque"):
        rubbed = "must be absent where starts are a range and the knob has friction; give one start"
        found += [(place, rubbed) for path in _UNRUBBED for place in given(scene, axes, path)]
    if scene.controller:
        found.append((("scene", "controller"), why))
    if scene.encoder == "none":
        found.append((("scene", "encoder"), "must not be none where starts are a range"))
    if scene.sampling == "continuous":
        found.append((("scene", "sampling"), "must not be continuous where starts are a range"))
    if not scene.hand and not population:
        found.append((("starts",), "must be one start without a hand: nothing draws the knob back, and no set shrinks"))
    return found


def map_faults(scene: SceneSpec, axes: Axes) -> list[tuple[tuple[str, ...], str]]:
    """What in a scene keeps the basins of a box of starts from being mapped."""
    why = "must be absent where basins are mapped: a map tells starts by angle and velocity alone"
    return [(place, why) for path in _UNMAPPED for place in given(scene, axes, path)]
