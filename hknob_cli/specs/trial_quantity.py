"""Numbers of a trial on a knob, within what a target takes (docs/reference/wire.md) or a person can do."""

from typing import Annotated, Any

from pydantic import Field

from hknob_cli.specs.quantity import Unit


def _within(unit: str, **bounds: Any) -> Any:
    return Annotated[float, Field(strict=True, allow_inf_nan=False, **bounds), Unit(unit)]


Force = _within("N", gt=0, le=100)
ForceNoise = _within("N", ge=0, le=10)
WallStiffness = _within("N*m/rad", ge=0, le=1000)
WallDamping = _within("N*m*s/rad", ge=0, le=1000)
TorqueLimit = _within("N*m", gt=0, le=10)
SpeedLimit = _within("rad/s", gt=0, le=1e4)
Watchdog = _within("s", ge=0.001, le=0.05)
Minutes = _within("s", gt=0, le=900)
SomeSeconds = _within("s", ge=0, le=60)
AngleNoise = _within("rad", ge=0, le=0.1)
TimeNoise = _within("s", ge=0, le=0.1)
Share = Annotated[float, Field(strict=True, ge=0, le=0.5)]
