"""A controller of the virtual wall other than the plain spring: which, and its numbers."""

from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Field

from hknob_cli.specs.controller_plan import KINDS, Controller
from hknob_cli.specs.part import Part, Place
from hknob_cli.specs.quantity import PositiveAngle, PositiveSeconds, SignedDamping


def _by_kind(schema: dict[str, Any]) -> None:
    """Say in the JSON Schema which keys go with which kind."""
    every = sorted({key for kind in KINDS.values() for key in kind.keys})
    schema["allOf"] = [
        {
            "if": {"properties": {"kind": {"const": name}}},
            "then": {
                "properties": dict.fromkeys((key for key in every if key not in kind.keys), False),
                **({"required": list(kind.needs)} if kind.needs else {}),
            },
        }
        for name, kind in KINDS.items()
    ]


_Share = Annotated[float, Field(strict=True, gt=0, le=1, allow_inf_nan=False)]
_UpTo100 = Annotated[float, Field(strict=True, gt=0, le=100, allow_inf_nan=False)]
_Degrees = Annotated[float, Field(strict=True, gt=0, le=360, allow_inf_nan=False)]
_UNLESS = Controller("")  # what a key is that is not given


class ControllerSpec(Part):
    """What acts in place of the plain virtual spring, or beside it."""

    model_config = ConfigDict(json_schema_extra=_by_kind)

    kind: Annotated[Literal[tuple(KINDS)], Field(description="which controller")]  # type: ignore[valid-type]
    velocity: Annotated[
        Literal["differenced", "sensor"], Field(description="where the velocity is from: two counts, or a sensor")
    ] = "differenced"
    damping: Annotated[
        SignedDamping, Field(description="velocity_damping: virtual damping; passivity: the most that it adds")
    ] = _UNLESS.damping
    everywhere: Annotated[bool, Field(strict=True, description="virtual damping outside the wall, too")] = (
        _UNLESS.everywhere
    )
    correct: Annotated[bool, Field(strict=True, description="add what the last prediction missed")] = _UNLESS.correct
    pulse: Annotated[_Share, Field(description="length of the pulse, in sample intervals")] = _UNLESS.pulse
    gain: Annotated[_UpTo100, Field(description="pulse over what the hold got wrong")] = _UNLESS.gain
    detections: Annotated[
        int, Field(strict=True, ge=1, le=1000, description="encoder readings per sample interval, to time a crossing")
    ] = _UNLESS.detections
    height: Annotated[_UpTo100, Field(description="torque of the damping wave, in torque steps of a count")] = (
        _UNLESS.height
    )
    degrees: Annotated[_Degrees, Field(description="phase after a crossing over which the wave acts")] = _UNLESS.degrees
    crossings: Annotated[Literal["in", "both"], Field(description="crossings that set the phase")] = "in"
    estimate: Annotated[Literal["last", "kalman"], Field(description="how the time of a cycle is estimated")] = "last"
    reset: Annotated[
        bool, Field(strict=True, description="energy begins anew at a sample outside the wall with no count moved")
    ] = _UNLESS.reset
    surface: Annotated[_Share, Field(description="part of the stiffness at the surface")] = _UNLESS.surface
    depth: Annotated[PositiveAngle, Field(description="where the wall has all of its stiffness")] = _UNLESS.depth
    keep: Annotated[_Share, Field(description="part of a count's torque step that acts at once")] = _UNLESS.keep
    time_constant: Annotated[PositiveSeconds, Field(description="over which the rest of a step follows")] = (
        _UNLESS.time_constant
    )

    def plain(self) -> Controller:
        """The controller as plain values."""
        return Controller(**dict(self))


def controller_contradictions(spec: ControllerSpec, axes: dict[str, Any]) -> list[tuple[Place, str]]:
    """Numbers that its kind does not have or lacks."""
    keys = KINDS[spec.kind].keys
    found: list[tuple[Place, str]] = []
    allowed = ", ".join(keys)
    for key in spec.model_fields_set - {"kind", *keys}:
        found.append((("scene", "controller", key), f"must be absent where kind is {spec.kind}, which has {allowed}"))
    for name in axes:
        part, _, key = name.partition(".")
        if part == "controller" and key not in keys:
            found.append((("grid", name), f"must be absent where kind is {spec.kind}, which has {allowed}"))
    values = axes.get("controller.damping", [spec.damping])
    if spec.kind == "velocity_damping" and "controller.damping" not in axes and "damping" not in spec.model_fields_set:
        found.append((("scene", "controller"), "must have damping where kind is velocity_damping"))
    if spec.kind == "passivity" and min(values) <= 0.0:
        place = ("grid", "controller.damping") if "controller.damping" in axes else ("scene", "controller")
        found.append((place, "must have a damping > 0 where kind is passivity: the most that it adds"))
    return sorted(found, key=lambda one: [str(step) for step in one[0]])
