"""What ``--plot`` writes: figures as one picture (PNG), whole or not at all, that says what it was drawn for."""

import io
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hknob_cli.errors import ComputationError
from hknob_cli.figures import draw
from hknob_cli.figures.held import One
from hknob_cli.figures.literal import literal
from hknob_cli.results.place import create
from hknob_cli.results.png import KEYWORD, source_text
from hknob_cli.results.result_set import Result
from hknob_cli.results.store import partial
from hknob_cli.specs.page_plan import FigurePlan

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DPI = 130
_ACROSS = 2  # figures beside one another


def draw_sheet(result: Result, planned: Sequence[FigurePlan], *, path: Path) -> None:
    """Draw figures of a result, each under its title, side by side into ``path`` (PNG).

    Raises `MissingError` where the result lacks what one needs, `ComputationError` if the file cannot be written.
    """
    drawn = []
    for one in planned:
        figure = draw(one.draw, One(result), result.name, one.options)
        figure.suptitle(one.title)
        drawn.append(figure)
    save(drawn[0] if len(drawn) == 1 else _beside(drawn), path, stage=result.stage, name=result.name)


def save(figure: "Figure", path: Path, *, stage: str, name: str) -> None:
    """Write a figure, whole or not at all, with what it was drawn for (PNG).

    Raises `ComputationError` if the file cannot be written.
    """
    half = partial(path)
    try:
        with create(half) as stream:
            _render(figure, stream, metadata={KEYWORD: source_text(stage, name)})
        half.replace(path)
    except OSError as error:
        raise ComputationError(f"{path}: cannot be written: {error.strerror or error}") from None
    finally:
        half.unlink(missing_ok=True)


def _render(figure: "Figure", stream: Any, **options: Any) -> None:
    with literal(figure):
        figure.savefig(stream, dpi=DPI, format="png", facecolor="white", **options)


def _beside(figures: Iterable["Figure"]) -> "Figure":
    """Figures as one, in rows of two, each at its own size."""
    from matplotlib.figure import Figure
    from matplotlib.image import imread

    def pixels(figure: "Figure") -> Any:
        stream = io.BytesIO()
        _render(figure, stream)
        stream.seek(0)
        return imread(stream)

    images = [pixels(figure) for figure in figures]
    rows = [images[i : i + _ACROSS] for i in range(0, len(images), _ACROSS)]
    wide = max(sum(image.shape[1] for image in row) for row in rows)
    tall = sum(max(image.shape[0] for image in row) for row in rows)
    whole = Figure(figsize=(wide / DPI, tall / DPI))
    top = tall
    for row in rows:
        left = 0
        for image in row:
            whole.figimage(image, left, top - image.shape[0])
            left += image.shape[1]
        top -= max(image.shape[0] for image in row)
    return whole
