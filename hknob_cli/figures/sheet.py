"""What ``--plot`` writes: figures as one picture (PNG), whole or not at all, that says what it was drawn for."""

import contextlib
import io
from collections.abc import Sequence
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING, Any

from hknob_cli.errors import ComputationError
from hknob_cli.figures import draw
from hknob_cli.figures.theme import literal
from hknob_cli.results.files import create, put_in_place
from hknob_cli.results.provenance import KEYWORD, source_text
from hknob_cli.results.result_set import MissingError, One, Result
from hknob_cli.results.store import partial
from hknob_cli.specs.stage_plans import FigurePlan

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DPI = 130
_ACROSS = 2  # figures beside one another
_TITLE = 40  # pixels of height
_LINE, _LETTER = 32, 14  # pixels of the answer: height of a line, and width of a letter


def write_sheet(result: Result, planned: Sequence[FigurePlan], *, path: Path, answer: str = "") -> bool:
    """Draw figures of a result, each under its title, two in a row, into ``path`` (PNG); False if it has none of them.

    ``answer``: a sentence or two above them. Raises `ComputationError` if the file cannot be written.
    """
    figure = sheet_of(result, planned, answer)
    if figure is not None:
        save(figure, path, stage=result.stage, name=result.name)
    return figure is not None


def sheet_of(result: Result, planned: Sequence[FigurePlan], answer: str = "") -> "Figure | None":
    """Figures of a result, each under its title, two in a row, below an answer; None if it has none of them."""
    drawn = []
    for one in planned:
        with contextlib.suppress(MissingError):
            drawn.append((one.title, draw(one.draw, One(result), result.name, one.options)))
    return _beside(drawn, answer) if drawn else None


def save(figure: "Figure", path: Path, *, stage: str, name: str) -> None:
    """Write a figure, whole or not at all, with what it was drawn for (PNG).

    Raises `ComputationError` if the file cannot be written.
    """
    half = partial(path)
    try:
        with create(half) as stream:
            _render(figure, stream, metadata={KEYWORD: source_text(stage, name)})
        put_in_place(half, path)
    except OSError as error:
        raise ComputationError(f"{path}: cannot be written: {error.strerror or error}") from None
    finally:
        half.unlink(missing_ok=True)


def _render(figure: "Figure", stream: Any, **options: Any) -> None:
    with literal(figure):
        figure.savefig(stream, dpi=DPI, format="png", facecolor="white", **options)


def _beside(figures: "Sequence[tuple[str, Figure]]", answer: str) -> "Figure":
    """Figures as one, in rows of two, each at its own size under its title, below an answer in words."""
    from matplotlib.figure import Figure
    from matplotlib.image import imread

    def pixels(figure: "Figure") -> Any:
        stream = io.BytesIO()
        _render(figure, stream)
        stream.seek(0)
        return imread(stream)

    images = [(title, pixels(figure)) for title, figure in figures]
    rows = [images[i : i + _ACROSS] for i in range(0, len(images), _ACROSS)]
    wide = max(sum(image.shape[1] for _, image in row) for row in rows)
    heights = [_TITLE + max(image.shape[0] for _, image in row) for row in rows]
    said = wrap(answer, wide // _LETTER)
    top = sum(heights)  # pixels from below, as pictures are placed
    high = top + (_LINE * len(said) + _TITLE if said else 0)
    whole = Figure(figsize=(wide / DPI, high / DPI))
    for number, line in enumerate(said):
        place = 1.0 - (0.75 * _TITLE + number * _LINE) / high
        whole.text(0.25 * _TITLE / wide, place, line, ha="left", va="center", fontsize=13)
    for row, height in zip(rows, heights, strict=True):
        left = 0
        for title, image in row:
            place = (top - 0.5 * _TITLE) / high
            whole.text((left + 0.5 * image.shape[1]) / wide, place, title, ha="center", va="center", fontsize=10)
            whole.figimage(image, left, top - _TITLE - image.shape[0])
            left += image.shape[1]
        top -= height
    return whole
