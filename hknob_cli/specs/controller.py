"""The kinds of controllers of the virtual wall, and the numbers of one, as a spec gives them and as they are used."""

from typing import Annotated, Any, Literal, NamedTuple

from hknob_cli.specs.quantity import (
    Acceleration,
    Bandwidth,
    Bounds,
    PositiveAngle,
    PositiveSeconds,
    Seconds,
    SignedDamping,
    SpeedLimit,
    declared,
)


class Kind(NamedTuple):
    """``law``: module and class in `controllers`; ``keys``: numbers that it has; ``needs``: those without a default.

    ``on_devices``: whether the wire has its law (`hardware.wire.codes.Law`), and so devices run it.
    """

    law: str
    keys: tuple[str, ...]
    needs: tuple[str, ...] = ()
    on_devices: bool = True


KINDS = {
    "bounded_lag": Kind("bounded_lag:BoundedLag", ("keep", "time_constant")),
    "first_order_hold": Kind("first_order_hold:FirstOrderHold", ("correct", "detections", "steps")),
    "half_sample": Kind("half_sample:HalfSample", ("velocity",)),
    "impulse_damping": Kind("impulse_damping:ImpulseDamping", ("pulse", "gain", "detections")),
    "matched_wall": Kind("matched_wall:MatchedWall", ("velocity",)),
    "passivity": Kind("passivity_control:PassivityControl", ("damping", "reset"), needs=("damping",)),
    "phase_damping": Kind("phase_damping:PhaseDamping", ("height", "degrees", "crossings", "estimate")),
    "stiffening": Kind("stiffening_wall:StiffeningWall", ("surface", "depth")),
    "velocity_damping": Kind(
        "velocity_damping:VelocityDamping",
        (
            *("damping", "velocity", "everywhere", "window", "low_pass", "cut_off"),
            *("time_out", "detections", "bandwidth", "acceleration", "angle"),
        ),
        needs=("damping",),
    ),
}
MODELLED = ("half_sample", "matched_wall")  # kinds whose numbers follow from the knob and the hand
# Kinds, and velocities, that are defined by counts, and how.
BY_COUNTS = {
    "bounded_lag": "it has a say over the torque of one count",
    "impulse_damping": "its pulse makes good when a count was crossed",
    "phase_damping": "its torque is a part of that of one count",
    "timed": "it times changes of the count",
    "adaptive": "its line is within a count of the readings",
    "kalman": "its gains follow from the rounding to counts",
}


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


_Share = Annotated[float, Bounds(strict=True, gt=0, le=1, allow_inf_nan=False)]
_UpTo100 = Annotated[float, Bounds(strict=True, gt=0, le=100, allow_inf_nan=False)]
_Degrees = Annotated[float, Bounds(strict=True, gt=0, le=360, allow_inf_nan=False)]
_Readings = Annotated[int, Bounds(strict=True, ge=1, le=1000)]
_Samples = Annotated[int, Bounds(strict=True, ge=1, le=64)]
_Flag = Annotated[bool, Bounds(strict=True)]


@declared(schema=_by_kind)
class Controller(NamedTuple):
    """What acts in place of the plain virtual spring, or beside it."""

    kind: Annotated[Literal[tuple(KINDS)], "which controller"]  # type: ignore[valid-type]
    velocity: Annotated[
        Literal["differenced", "sensor", "timed", "adaptive", "tracking", "kalman"],
        "where the velocity is from: counts, a sensor, the time between counts, a line, a tracking or Kalman filter",
    ] = "differenced"
    damping: Annotated[SignedDamping, "velocity_damping: virtual damping; passivity: the most that it adds"] = 0.0
    everywhere: Annotated[_Flag, "virtual damping outside the wall, too"] = False
    window: Annotated[_Samples, "samples over which the velocity is differenced; adaptive: at most"] = 1
    low_pass: Annotated[Seconds, "time constant of a low-pass on the velocity from counts; 0: none"] = 0.0
    time_out: Annotated[PositiveSeconds, "timed: time without a change of the count after which nothing moves"] = 0.1
    bandwidth: Annotated[Bandwidth, "tracking: bandwidth of the filter, critically damped"] = 1000.0
    acceleration: Annotated[Acceleration, "kalman: root mean square of the acceleration that it expects"] = 1000.0
    angle: Annotated[
        Literal["counted", "filtered"], "where the spring is: at the count, or at the angle of the velocity's filter"
    ] = "counted"
    cut_off: Annotated[SpeedLimit | None, "estimated speed above which the controller commands no torque"] = None
    correct: Annotated[_Flag, "add what the last prediction missed"] = True
    pulse: Annotated[_Share, "length of the pulse, in sample intervals"] = 0.025
    gain: Annotated[_UpTo100, "pulse over what the hold got wrong"] = 1.0
    detections: Annotated[
        _Readings, "encoder readings per sample interval, to time a crossing or a change, or to fit a line"
    ] = 1
    steps: Annotated[_Samples, "first_order_hold: torques in a sample interval, along the line"] = 1
    height: Annotated[_UpTo100, "torque of the damping wave, in torque steps of a count"] = 0.5
    degrees: Annotated[_Degrees, "phase after a crossing over which the wave acts"] = 360.0
    crossings: Annotated[Literal["in", "both"], "crossings that set the phase"] = "in"
    estimate: Annotated[Literal["last", "kalman"], "how the time of a cycle is estimated"] = "last"
    reset: Annotated[_Flag, "energy begins anew at a sample outside the wall with no count moved"] = True
    surface: Annotated[_Share, "part of the stiffness at the surface"] = 0.3
    depth: Annotated[PositiveAngle, "where the wall has all of its stiffness"] = 0.01
    keep: Annotated[_Share, "part of a count's torque step that acts at once"] = 0.2
    time_constant: Annotated[PositiveSeconds, "over which the rest of a step follows"] = 0.2

    @property
    def words(self) -> str:
        """Its kind and the numbers that this kind has, in SI units."""
        numbers = {key: getattr(self, key) for key in KINDS[self.kind].keys}
        shown = (f"{value:.6g}" if isinstance(value, float) else str(value).lower() for value in numbers.values())
        return ", ".join([self.kind, *(f"{key} {value}" for key, value in zip(numbers, shown, strict=True))])

    @property
    def counted(self) -> tuple[str, str]:
        """The key by which it is defined by counts, and how; empty where it only reads an angle."""
        for key in ("kind", "velocity"):
            if why := BY_COUNTS.get(getattr(self, key)):
                return key, why
        return ("detections", "readings in an interval find when a count changes") if self.detections > 1 else ("", "")

    @property
    def estimates(self) -> bool:
        """Whether the velocity is more than two counts or a sensor, or the angle is filtered."""
        return self.velocity not in ("differenced", "sensor") or self.angle == "filtered"
