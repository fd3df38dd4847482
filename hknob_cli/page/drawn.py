"""The figures of a page: drawn, captions filled in, and clips of recorded cycles; many by several processes.

Sound clips of recorded cycles, all loud by one factor, so that they can be compared by ear.

What sounds is the knob's speed; what a device makes of it is not known here.
"""

import base64
import pickle
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hknob_cli.errors import MISSHAPEN, UsageError
from hknob_cli.figures import draw, drawing_of, theme
from hknob_cli.figures.recording import settled_period
from hknob_cli.page.book import Clip, Drawn
from hknob_cli.page.claims.checks import compute
from hknob_cli.results.result_set import MissingError, ResultSet
from hknob_cli.specs.stage_plans import FigurePlan, Listen, Sentence
from hknob_cli.spread.forks import Progress, by_processes

RATE_HZ = 16000
DURATION_S = 1.2

_NOTHING = re.compile(r"^-(0(\.0*)?)$")  # what rounds to nothing has no sign
FEW = 6  # figures, which one process has drawn before others have begun


@dataclass(frozen=True)
class Artist:
    """What draws some of the figures of a page, in whatever process."""

    figures: Sequence[FigurePlan]
    evidence: ResultSet
    mark: str

    def __call__(self, start: int, stop: int) -> bytes:
        """Figures ``start`` to ``stop``, pickled. Raises `UsageError` for options that a drawing does not take."""
        with theme.library_defaults():
            return pickle.dumps([_drawn(one, self.evidence, self.mark) for one in self.figures[start:stop]])


def draw_figures(
    figures: Sequence[FigurePlan], evidence: ResultSet, mark: str, *, jobs: int = 1, progress: Progress
) -> list[Drawn]:
    """The figures in order, by ``jobs`` processes. Raises `UsageError` for options that a drawing does not take."""
    for one in {figure.draw for figure in figures}:  # what is loaded before processes begin, they have
        drawing_of(one)
    artist = Artist(figures, evidence, mark)
    return by_processes(
        artist, len(figures), jobs=jobs if len(figures) >= FEW else 1, first=1, most=1, progress=progress,
        name=lambda one: f"figure {figures[one.start].id}",
    )  # fmt: skip


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


def _drawn(figure: FigurePlan, evidence: ResultSet, mark: str) -> Drawn:
    """A figure with its SVG; where a result is missing, with the reason instead."""
    of: Any = figure.of[0] if len(figure.of) == 1 else list(figure.of)
    svg, caption, missing = "", "", ""
    heard: tuple[Clip, ...] = ()
    try:
        caption = filled(figure.caption, evidence)
        with np.errstate(over="raise"):  # of numbers no picture has room for
            drawing = draw(figure.draw, evidence, of, figure.options)
            svg = theme.svg(drawing, name=figure.id, title=figure.alt, mark=mark)
        heard = clips(evidence, figure.listen)
    except MissingError as error:
        missing = str(error)
    except UsageError as error:
        raise UsageError(f"{figure.where or figure.id}: {error}") from error
    except MISSHAPEN as error:
        what = f"{figure.draw} of {', '.join(figure.of) or 'nothing'} cannot be drawn with {figure.options}"
        raise UsageError(f"{figure.where or figure.id}: {what}: {error}") from error
    return Drawn(figure.id, figure.title, caption, svg, figure.alt, figure.of, missing, heard)


def filled(sentence: Sentence, evidence: ResultSet) -> str:
    """A text with its numbers. Raises `MissingError` where one of them is missing."""
    values = {}
    for name, (check, arguments, scale, form) in sentence.values.items():
        try:
            value = compute(check, evidence, arguments)
        except MissingError:
            raise
        except UsageError as error:
            raise UsageError(f"{sentence.where}: {name}: {error}") from error
        if value is None:
            raise MissingError(f"{name} has no value")
        values[name] = _NOTHING.sub(r"\1", format(scale * value, form)).replace("-", "\N{MINUS SIGN}")
    return sentence.text.format(**values) if values else sentence.text
