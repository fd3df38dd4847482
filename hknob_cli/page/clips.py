"""Sound clips of recorded cycles, all loud by one factor, so that they can be compared by ear.

What sounds is the knob's speed; what a device makes of it is not known here.
"""

import base64
from collections.abc import Sequence

from hknob_cli.figures.recording import settled_period
from hknob_cli.page.book import Clip
from hknob_cli.results.result_set import ResultSet
from hknob_cli.specs.page_plan import Listen

RATE_HZ = 16000
DURATION_S = 1.2
MOST_BYTES = 60_000  # of a clip in the page


def clips(evidence: ResultSet, wanted: Sequence[Listen]) -> tuple[Clip, ...]:
    """WAV clips of the cycles that trials end in, as data: addresses. Raises `MissingError`.

    The loudest takes half of full scale, and sets the factor from speed to sample of all.
    """
    from hknob_cli.perception import sound
    from hknob_cli.recordings.spectrum import recorded_harmonics

    motions = []
    for one in wanted:
        period = settled_period(evidence, one.of, at=dict(one.at))
        motions.append(recorded_harmonics(period.time, period.velocity, highest_hz=0.5 * RATE_HZ))
    factor = min(
        (sound.clip(*motion, duration_s=DURATION_S, rate_hz=RATE_HZ).factor for motion in motions), default=1.0
    )
    found = []
    for one, motion in zip(wanted, motions, strict=True):
        made = sound.clip(*motion, duration_s=DURATION_S, rate_hz=RATE_HZ, factor=factor)
        data = base64.b64encode(sound.wav_bytes(made)).decode("ascii")
        found.append(Clip(one.name, f"data:audio/wav;base64,{data}"))
    return tuple(found)
