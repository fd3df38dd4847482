"""The ``perceive`` block of a sweep: will anyone feel or hear its limit cycles?"""

from typing import Annotated, Literal

from pydantic import Field

from hknob_cli.specs.part import Part
from hknob_cli.specs.perception import Perceive
from hknob_cli.specs.quantity import KnobRadius, SoundGain
from hknob_cli.specs.whole import WHOLE


class TouchSpec(Part):
    """Which published thresholds of touch, and how the harmonics of a cycle count."""

    thresholds: Annotated[
        Literal["pen_hold", "cylinder", "thenar", "thenar_1988"],
        Field(description="published set; docs/explanation/perception.md says what each was measured with"),
    ] = "pen_hold"
    combine: Annotated[
        Literal["most_effective", "power_sum"],
        Field(description="level of the harmonic that is felt best, or of all their powers over threshold"),
    ] = "most_effective"


class HearingSpec(Part):
    """Which equal-loudness contours."""

    edition: Annotated[Literal[2003, 2023], WHOLE, Field(description="edition of ISO 226")] = 2023


class PerceiveSpec(Part):
    """Levels of touch, torque steps and sound, of every proven cycle."""

    knob_radius: Annotated[KnobRadius, Field(description="where the skin is, from the axis")]
    touch: Annotated[TouchSpec, Field(default_factory=TouchSpec)]
    hearing: Annotated[HearingSpec, Field(default_factory=HearingSpec)]
    sound_gain: Annotated[
        SoundGain | None,
        Field(description="sound pressure at the ear per speed of the knob, as measured; null: relative levels"),
    ] = None
    extrapolate: Annotated[
        bool, Field(strict=True, description="go on outside the published ranges; where false, there is no value")
    ] = False

    def plain(self) -> Perceive:
        """The block as plain values."""
        return Perceive(
            knob_radius=self.knob_radius,
            thresholds=self.touch.thresholds,
            combine=self.touch.combine,
            sound_gain=self.sound_gain,
            edition=self.hearing.edition,
            extrapolate=self.extrapolate,
        )
