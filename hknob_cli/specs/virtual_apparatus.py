"""The virtual apparatus in a spec: its rig and what is not ideal about it, its torque, and who holds its knob."""

from typing import Annotated, Literal

from pydantic import Field

from hknob_cli.specs.identification import InputPlan, VirtualPlan
from hknob_cli.specs.part import Part
from hknob_cli.specs.quantity import PositiveHertz, PositiveSeconds, Quantity, Seconds, Torque

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
