"""What a sweep is asked to say about touch and hearing: will anyone feel or hear its limit cycles?"""

from typing import Annotated, Literal, NamedTuple

from hknob_cli.specs.declared import declared
from hknob_cli.specs.quantity import WHOLE, Bounds, KnobRadius, SoundGain


@declared()
class Touch(NamedTuple):
    """Which published thresholds of touch, and how the harmonics of a cycle count."""

    thresholds: Annotated[
        Literal["pen_hold", "cylinder", "thenar", "thenar_1988"],
        "published set; docs/perception.md says what each was measured with",
    ] = "pen_hold"
    combine: Annotated[
        Literal["most_effective", "power_sum"],
        "level of the harmonic that is felt best, or of all their powers over threshold",
    ] = "most_effective"


@declared()
class Hearing(NamedTuple):
    """Which equal-loudness contours."""

    edition: Annotated[Literal[2003, 2023], WHOLE, "edition of ISO 226"] = 2023


@declared(unread=("others",))
class Perceive(NamedTuple):
    """Levels of touch, torque steps and sound, of every proven cycle."""

    knob_radius: Annotated[KnobRadius, "where the skin is, from the axis"]
    touch: Touch = Touch()
    hearing: Hearing = Hearing()
    sound_gain: Annotated[
        SoundGain | None, "sound pressure at the ear per speed of the knob, as measured; null: relative levels"
    ] = None
    extrapolate: Annotated[
        bool, Bounds(strict=True), "go on outside the published ranges; where false, there is no value"
    ] = False
    others: tuple[str, ...] = ()  # sets of thresholds of touch by which each cycle is judged as well

    @property
    def thresholds(self) -> str:
        """Name of the set of thresholds of touch."""
        return self.touch.thresholds

    @property
    def combine(self) -> str:
        """How the harmonics of a cycle count for touch."""
        return self.touch.combine

    @property
    def edition(self) -> int:
        """Edition of ISO 226."""
        return self.hearing.edition
