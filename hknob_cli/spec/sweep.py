"""The sweep's spec: a scene, a grid, and how trials start."""

from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from hknob_cli.spec.grid import Grid
from hknob_cli.spec.plan import Axes, Starts, SweepPlan
from hknob_cli.spec.quantity import Angle, Velocity
from hknob_cli.spec.scene import Part, SceneSpec

# Scene values that the exact engine does not have yet.
ABSENT = {
    "knob.coulomb_torque": "Coulomb friction",
    "wall.damping": "virtual damping",
    "actuator.time_constant": "actuator lag",
    "actuator.torque_limit": "a torque limit",
    "actuator.torque_step": "a torque step",
}

Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]*$", max_length=80)]


class StartsSpec(Part):
    """Where the trials of a cell begin, and how many sample clocks are tried."""

    angle: Annotated[Angle, Field(description="knob angle at the start, above the wall where positive")] = 0.02
    velocity: Annotated[Velocity, Field(description="knob speed at the start")] = 0.0
    phases: Annotated[
        int, Field(strict=True, ge=1, le=10_000_000, description="trials, whose first samples spread over an interval")
    ] = 64


class LimitsSpec(Part):
    """Bounds on the work."""

    max_samples: Annotated[
        int | None,
        Field(strict=True, ge=100, le=2**30, description="samples a trial may take; null: by the plant's slowest mode"),
    ] = None


class SweepSpec(Part):
    """Simulate every cell of a grid to its proven limit cycles."""

    kind: Literal["sweep"]
    name: Annotated[Name, Field(description="names the results folder; letters, digits, '.', '_', '-'")]
    scene: SceneSpec
    grid: Grid
    starts: Annotated[StartsSpec, Field(default_factory=StartsSpec)]
    limits: Annotated[LimitsSpec, Field(default_factory=LimitsSpec)]

    ABSENT: ClassVar[dict[str, str]] = ABSENT

    def plan(self, axes: Axes, units: dict[str, str], values: dict[str, Any]) -> SweepPlan:
        """The spec as plain values, its axes resolved."""
        return SweepPlan(
            name=self.name,
            scene=self.scene.plain(),
            axes=axes,
            units=units,
            starts=Starts(self.starts.angle, self.starts.velocity, self.starts.phases),
            max_samples=self.limits.max_samples,
            values=values,
        )
