"""What a sweep is asked to say about touch and hearing: will anyone feel or hear its limit cycles?"""

from itertools import pairwise
from typing import Annotated, Literal, NamedTuple

from hknob_cli.specs.quantity import WHOLE, Bounds, KnobRadius, PositiveHertz, SoundGain, declared


@declared()
class Touch(NamedTuple):
    """Which published thresholds of touch, and how the harmonics of a cycle count."""

    thresholds: Annotated[
        Literal["pen_hold", "cylinder", "thenar", "thenar_1988"],
        "published set; docs/explanation/perception.md says what each was measured with",
    ] = "pen_hold"
    combine: Annotated[
        Literal["most_effective", "power_sum"],
        "level of the harmonic that is felt best, or of all their powers over threshold",
    ] = "most_effective"


@declared()
class Background(NamedTuple):
    """Steady noise at the ear, beside the knob's sound."""

    level_db: Annotated[
        float,
        Bounds(strict=True, ge=-20, le=140, allow_inf_nan=False),
        "sound pressure level from 20 Hz to 20 kHz, dB re 20 uPa, without weighting",
    ]
    spectrum: Annotated[Literal["white", "pink"], "equal power per Hz, or per octave"] = "pink"


@declared()
class Hearing(NamedTuple):
    """Which equal-loudness contours, and what else there is to hear."""

    edition: Annotated[Literal[2003, 2023], WHOLE, "edition of ISO 226"] = 2023
    background: Annotated[Background | None, "noise that masks the knob's sound; null: silence"] = None


@declared(unread=("others",))
class Perceive(NamedTuple):
    """Levels of touch, torque steps and sound, of every proven cycle."""

    knob_radius: Annotated[KnobRadius, "where the skin is, from the axis"]
    touch: Touch = Touch()
    hearing: Hearing = Hearing()
    sound_gain: Annotated[
        SoundGain | None, "sound pressure at the ear per speed of the knob, as measured; null: relative levels"
    ] = None
    sound_response: Annotated[
        tuple[tuple[PositiveHertz, SoundGain], ...],
        "[frequency, gain] each, by increasing frequency: a gain that changes with frequency, in place of sound_gain",
    ] = ()
    extrapolate: Annotated[
        bool, Bounds(strict=True), "go on outside the published ranges; where false, there is no value"
    ] = False
    others: tuple[str, ...] = ()  # sets of thresholds of touch by which each cycle is judged as well

    def wrong(self) -> str:
        """What is wrong with the gains; empty if nothing is."""
        points = self.sound_response
        if self.hearing.background and not self.gained:
            return (
                "hearing.background: must be absent without sound_gain or sound_response: a relative level has no mask"
            )
        if points and self.sound_gain is not None:
            return "sound_response: must be absent where sound_gain is given: it is in its place"
        if len(points) == 1:
            return "sound_response: must have two [frequency, gain] or more, got one; for one gain give sound_gain"
        for i, ((before, _), (frequency, _)) in enumerate(pairwise(points)):
            if not before < frequency:
                return f"sound_response: frequencies must increase, got {frequency:g} after {before:g} (point {i + 2})"
        return ""

    @property
    def gained(self) -> bool:
        """Whether sound has a level, and not only differences."""
        return self.sound_gain is not None or bool(self.sound_response)

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
