"""What a spec of an identification simulates: its virtual apparatus, and studies of its estimators."""

from typing import Annotated, Any, Literal

from pydantic import Field, field_validator
from pydantic_core import PydanticCustomError

from hknob_cli.errors import Fault
from hknob_cli.specs.grid import AxisError, AxisSpec, LogAxis, levels
from hknob_cli.specs.hand import Grip, printed_grips, same_grip, unprinted
from hknob_cli.specs.identification import BiasPlan, HiddenPlan, InputPlan, StudyPlan, VirtualPlan
from hknob_cli.specs.part import Part
from hknob_cli.specs.quantity import WHOLE, Inertia, PositiveHertz, PositiveSeconds, Quantity, Seconds, Torque, Unit
from hknob_cli.specs.source import Source

Count = Annotated[int, Field(strict=True, ge=1, le=1000)]
Number = Annotated[int, Field(strict=True, ge=1, le=5)]
Noise = Annotated[float, Quantity("rad", ge=0, le=1.0)]


class RigSpec(Part):
    """The virtual apparatus; what is not given is as printed, and ``ideal`` switches every nuisance off."""

    ideal: bool = False
    counts_per_rev: Annotated[int | None, Field(strict=True, ge=0, le=2**31, description="0: no quantisation")] = None
    coulomb_nm: Annotated[Torque | None, Field(description="Coulomb friction of motor and bearings")] = None
    amplifier_s: Annotated[Seconds | None, Field(description="time constant of the amplifier's lag")] = None
    angle_noise_rad: Annotated[Noise | None, Field(description="rms, before the encoder rounds")] = None
    torque_error: Annotated[float | None, Field(gt=-1, le=10.0, description="share by which torque exceeds")] = None
    torque_noise_nm: Annotated[Torque | None, Field(description="rms of a torque sensor; null: there is none")] = None
    acceleration_noise: Annotated[
        float | None,
        Quantity("rad/s^2", ge=0, le=1e6),
        Field(description="rms of an accelerometer; null: there is none"),
    ] = None
    torque_sees_friction: Annotated[
        bool | None, Field(strict=True, description="the sensor carries the motor, and reads the torque less friction")
    ] = None


class InputSpec(Part):
    """The torque on the virtual apparatus in place of the pulse; each trial is then of a continuous excitation."""

    kind: Annotated[
        Literal["step", "ramp", "sine", "chirp", "noise", "prbs"],
        Field(description="ramp: from 0 up; prbs: a pseudorandom binary sequence; noise: Gaussian"),
    ]
    duration: Annotated[float, Quantity("s", ge=0.02, le=10.0), Field(description="of the input")] = 0.5
    from_hz: Annotated[PositiveHertz, Field(description="of a sine, or of a chirp at its beginning")] = 1.0
    to_hz: Annotated[PositiveHertz, Field(description="of a chirp at its end")] = 100.0
    chip: Annotated[PositiveSeconds, Field(description="time for which noise and prbs hold a value")] = 0.002

    def plain(self) -> InputPlan:
        """As plain values."""
        return InputPlan(self.kind, self.duration, self.from_hz, self.to_hz, self.chip)


class VirtualSpec(Part):
    """Recordings made on the virtual apparatus: people drawn from Tables 1 to 5, as many trials as printed."""

    experiments: Annotated[list[Number], Field(min_length=1, default_factory=lambda: [1, 2, 3, 4, 5])]
    subjects: Annotated[Count | None, Field(description="in each experiment; null: 9 in the first, else 5")] = None
    blocks: Count = 3
    trials: Count = 3
    seed: Annotated[int, Field(strict=True, ge=0, le=2**31)] = 0
    grips: Annotated[list[float] | None, Field(min_length=1, description="grip forces, N; null: all six")] = None
    model: Annotated[Literal["second", "fourth"], Field(description="order of the hand")] = "second"
    rig: Annotated[RigSpec, Field(default_factory=RigSpec)]
    input: Annotated[InputSpec | None, Field(description="the torque; null: a pulse of 20 ms")] = None

    def plain(self) -> VirtualPlan:
        """As plain values."""
        rig = {name: value for name, value in self.rig if name != "ideal" and value is not None}
        return VirtualPlan(
            experiments=tuple(dict.fromkeys(self.experiments)),  # once each: a trial twice is no evidence
            subjects=self.subjects,
            blocks=self.blocks,
            trials=self.trials,
            seed=self.seed,
            grips=tuple(dict.fromkeys(self.grips)) if self.grips else None,
            model=self.model,
            ideal=self.rig.ideal,
            rig=rig,
            input=self.input.plain() if self.input else None,
        )


MOST_LEVELS = 1000  # of a nuisance, or ratios: each is a campaign of its own
Table = Annotated[Literal[1, 2, 3, 4, 5], WHOLE, Field(description="whose printed mean hands are the truth")]
_SMALL = Field(strict=True, ge=0, le=0.1, allow_inf_nan=False)
_KINDS: dict[str, Any] = {
    "noise_rad": Annotated[float, _SMALL, Unit("rad")],
    "coulomb_nm": Annotated[float, _SMALL, Unit("N*m")],
    "lag_s": Annotated[float, _SMALL, Unit("s")],
    "counts_per_rev": Annotated[int, Field(strict=True, ge=0, le=2**31)],
    "decimation": Annotated[int, Field(strict=True, ge=1, le=100)],
}
_WHOLE = (_KINDS["counts_per_rev"], _KINDS["decimation"])
_RATIO = Annotated[float, Field(gt=0, le=1e6, allow_inf_nan=False, strict=True)]


class NuisanceSpec(Part):
    """Levels of what goes wrong, one at a time, the rest at its best; only what is listed is studied."""

    noise_rad: Annotated[AxisSpec | None, Field(description="rms noise of the angle, rad")] = None
    coulomb_nm: Annotated[AxisSpec | None, Field(description="Coulomb friction, N*m")] = None
    lag_s: Annotated[AxisSpec | None, Field(description="time constant of the amplifier's lag, s")] = None
    counts_per_rev: Annotated[AxisSpec | None, Field(description="counts of the encoder; 0: no quantisation")] = None
    decimation: Annotated[AxisSpec | None, Field(description="factor of smoothing; 1: none")] = None


class BiasSpec(Part):
    """Known hands pulsed many times, estimated, and compared with what they are."""

    table: Table = 1
    grips: Annotated[list[Grip], Field(min_length=1, default_factory=lambda: [0.71, 14.2])]
    repeats: Annotated[int, Field(strict=True, ge=2, le=100_000, description="conditions of each level")] = 50
    seed: Annotated[int, Field(strict=True, ge=0, le=2**31)] = 1
    nuisances: Annotated[NuisanceSpec | None, Field(description="null: all, at levels of their own")] = None

    @field_validator("grips")
    @classmethod
    def _printed(cls, value: list[float]) -> list[float]:
        return [_row(grip) for grip in value]


class HiddenSpec(Part):
    """Second-order fits of a hand whose finger is so many times stiffer than its pad (Hasser, sec. 4.4.1)."""

    table: Table = 1
    grip_n: Annotated[Grip, Field(description="grip force of the row that finger and pad have in series")] = 14.2
    finger_inertia: Inertia = 3e-7
    ratios: Annotated[
        AxisSpec,
        Field(
            description="stiffness and damping of the finger over those of its pad; by default 13 from 1 to 1000",
            default_factory=lambda: LogAxis(log=(1.0, 1000.0, 13)),
        ),
    ]

    @field_validator("grip_n")
    @classmethod
    def _printed(cls, value: float) -> float:
        return _row(value)


class StudySpec(Part):
    """What is asked about the estimators; needs no recordings."""

    bias: Annotated[BiasSpec | None, Field(description="bias and spread of each estimator by its cause")] = None
    hidden_inertia: Annotated[HiddenSpec | None, Field(description="the finger that hides behind its pad")] = None


def plan_study(source: Source, spec: StudySpec) -> tuple[StudyPlan, list[Fault]]:
    """A study as plain values, and its faults."""
    faults: list[Fault] = []
    if spec.bias is None and spec.hidden_inertia is None:
        faults.append(source.fault(("study",), "must have bias, hidden_inertia, or both", at_key=True))
    bias = hidden = None
    if spec.bias is not None:
        chosen: dict[str, tuple[float, ...]] = {}
        place: tuple[str, ...] = ("study", "bias", "nuisances")
        for name, axis in spec.bias.nuisances or ():
            if axis is not None:
                chosen[name], more = _levels(source, (*place, name), axis, _KINDS[name])
                faults += more
        if spec.bias.nuisances is not None and not chosen:
            faults.append(source.fault(place, f"must list one of: {', '.join(_KINDS)}", at_key=True))
        grips = tuple(dict.fromkeys(spec.bias.grips))
        bias = BiasPlan(spec.bias.table, grips, spec.bias.repeats, spec.bias.seed, chosen)
    if spec.hidden_inertia is not None:
        asked = spec.hidden_inertia
        ratios, more = _levels(source, ("study", "hidden_inertia", "ratios"), asked.ratios, _RATIO)
        faults += more
        hidden = HiddenPlan(asked.table, asked.grip_n, asked.finger_inertia, ratios)
    return StudyPlan(bias, hidden), faults


def _levels(source: Source, place: tuple[str, ...], axis: Any, kind: Any) -> tuple[tuple[float, ...], list[Fault]]:
    """Levels of a nuisance, or ratios; steps between whole numbers are rounded to some."""
    try:
        found = levels(axis, kind)
    except AxisError as error:
        return (), [source.fault((*place, *error.steps), str(error))]
    if len(found) > MOST_LEVELS:
        return (), [source.fault(place, f"must have at most {MOST_LEVELS} values, got {len(found)}")]
    return (tuple(map(float, map(round, found))) if kind in _WHOLE else found), []


def _row(grip_n: float) -> float:
    """The printed grip force that is meant. Raises `PydanticCustomError` if there is none."""
    if wrong := unprinted(grip_n):
        raise PydanticCustomError("grip", "{reason}", {"reason": wrong})
    return next(one for one in printed_grips() if same_grip(one, grip_n))
