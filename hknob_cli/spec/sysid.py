"""The identification's spec: what to identify, from which recordings, how they are prepared, and by which estimators."""

from typing import Annotated, Literal

from pydantic import Field

from hknob_cli.spec.plan import PreparePlan
from hknob_cli.spec.quantity import AddedInertia, PositiveSeconds, Seconds, Torque
from hknob_cli.spec.scene import Part
from hknob_cli.spec.sweep import Name

What = Literal["hand", "motor", "grip_cell", "apparatus"]
Estimator = Literal["least_squares", "least_squares_friction", "output_error", "output_error_friction", "fourth_order"]
Count = Annotated[int, Field(strict=True, ge=1, le=1000)]
Radius = Annotated[float, Field(gt=0, le=1.0, description="radius of the knob, m")]
_DEFAULT: tuple[Estimator, ...] = ("least_squares", "output_error")


class WindowSpec(Part):
    """What of a trial is kept, from before the onset of the pulse to after it."""

    before: PositiveSeconds = 0.002
    after: PositiveSeconds = 0.030


class PrepareSpec(Part):
    """How trials become motions (Hasser, sec. 4.2.3); each step is optional."""

    average: Annotated[bool, Field(description="average the trials of a condition in a block")] = True
    decimate: Annotated[
        int | None, Field(strict=True, ge=1, le=100, description="factor of smoothing; 1: none; null: down to 1 kHz")
    ] = None
    interpolate: Annotated[bool, Field(description="back to the recorded rate after smoothing")] = True
    window: Annotated[WindowSpec, Field(default_factory=WindowSpec)]

    def plain(self) -> PreparePlan:
        """As plain values."""
        return PreparePlan(self.average, self.decimate, self.interpolate, (self.window.before, self.window.after))


class RigSpec(Part):
    """The virtual apparatus; what is not given is as printed, `ideal` switches every nuisance off."""

    ideal: bool = False
    counts_per_rev: Annotated[int | None, Field(strict=True, ge=0, le=2**31, description="0: no quantisation")] = None
    coulomb_torque: Torque | None = None
    settling_time_constant: Seconds | None = None
    angle_noise: Annotated[float | None, Field(ge=0, le=1.0, description="rms, rad")] = None
    torque_error: Annotated[float | None, Field(gt=-1, le=10.0, description="share by which torque exceeds")] = None


class VirtualSpec(Part):
    """Recordings made by the virtual apparatus: people drawn from Tables 1 to 5, as many trials as printed."""

    experiments: Annotated[list[Annotated[int, Field(strict=True, ge=1, le=5)]], Field(min_length=1)] = [1, 2, 3, 4, 5]  # noqa: RUF012
    subjects: Annotated[
        Count | None, Field(description="in every experiment; null: 9 in the first, 5 in the others")
    ] = None
    blocks: Count = 3
    trials: Count = 3
    seed: Annotated[int, Field(strict=True, ge=0, le=2**31)] = 0
    grips: Annotated[
        list[float] | None, Field(min_length=1, description="targets of the grip force, N; null: all six")
    ] = None
    model: Annotated[Literal["second", "fourth"], Field(description="order of the hand")] = "second"
    rig: Annotated[RigSpec, Field(default_factory=RigSpec)]


class SysidSpec(Part):
    """Identify the hand on a knob, or a part of the apparatus, from recordings."""

    kind: Literal["sysid"]
    name: Annotated[Name, Field(description="names the results folder")]
    what: Annotated[What, Field(description="what is identified")] = "hand"
    recordings: Annotated[
        list[Annotated[str, Field(min_length=1)]] | None,
        Field(min_length=1, description="CSV or Parquet files, relative to this file"),
    ] = None
    virtual: Annotated[VirtualSpec | None, Field(description="record from the virtual apparatus instead")] = None
    keep_recordings: Annotated[bool, Field(description="write recordings.parquet, too")] = False
    counts_per_rev: Annotated[
        int | None, Field(strict=True, ge=1, le=2**31, description="of the encoder that recorded; null: not known")
    ] = None
    prepare: Annotated[PrepareSpec, Field(default_factory=PrepareSpec)]
    estimators: Annotated[list[Estimator], Field(min_length=1)] = list(_DEFAULT)  # noqa: RUF012
    coulomb_torque: Annotated[Torque, Field(description="friction known of the apparatus, for output_error")] = 0.0
    settling_time_constant: Annotated[Seconds, Field(description="lag known between command and torque")] = 0.0
    subtract_apparatus: Annotated[
        AddedInertia | dict[str, AddedInertia] | None,
        Field(description="inertia to subtract, one or by experiment; null: none"),
    ] = None
    knob_radius: Annotated[
        Radius | dict[str, Radius] | None,
        Field(description="for translational models, one or by experiment; null: none"),
    ] = None
