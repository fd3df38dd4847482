"""The notional optimisation: the worse of size and pitch, from 0 to 1 over the grid (Hasser, sec. 10.7, Fig. 70)."""

from math import log
from typing import TYPE_CHECKING

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.grid import Row, ends, grid
from hknob_cli.figures.heat import draw_key, draw_map, height_of, ramp
from hknob_cli.figures.mesh import draw_mesh
from hknob_cli.report.means import WORST
from hknob_cli.results.result_set import MissingError, ResultSet

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@drawing
def surface(
    evidence: ResultSet,
    of: str,
    *,
    across: str | None = None,
    down: str | None = None,
    at: Row | None = None,
    mesh: bool = False,
    log_pitch: bool = False,
) -> "Figure":
    """The larger of log peak to peak and frequency, both scaled to 0..1 over the grid; small is good.

    Both are those of the largest cycle of a cell.
    ``log_pitch``: log frequency, too. A letter says which of the two it is (s: size, p: pitch); the best cell of each
    row has a frame. For axes see `grid`. Raises `MissingError`.
    """
    from matplotlib.colors import Normalize

    size_of, pitch_of = WORST
    cells = grid(evidence[of], across=across, down=down, at=at, columns=WORST)
    sizes = [[log(value) if value > 0 else float("nan") for value in line] for line in cells.values(size_of)]
    pitches = [
        [(log(value) if log_pitch else value) if value > 0 else float("nan") for value in line]
        for line in cells.values(pitch_of)
    ]
    if not any(value == value for line in sizes for value in line):
        raise MissingError(f"'{of}' has no limit cycle")
    size, pitch = _scaled(sizes), _scaled(pitches)
    values = [[max(s, p) for s, p in zip(*both, strict=True)] for both in zip(size, pitch, strict=True)]
    texts = [
        [
            (" ".join(ends(cell)) if cell else "") if s != s else f"{max(s, p):.2f} {'s' if s >= p else 'p'}"
            for s, p, cell in zip(*line, strict=True)
        ]
        for line in zip(size, pitch, cells.cells, strict=True)
    ]
    best = set()
    for i, line in enumerate(values):
        found = [(value, j) for j, value in enumerate(line) if value == value]
        if found and len(line) > 1:
            best.add((i, min(found)[1]))
    mesh = mesh and min(len(cells.acrosses), len(cells.downs)) > 1
    norm = Normalize(0.0, 1.0)
    figure = theme.figure(height_of(cells, extra=1.45 if mesh else 1.0))
    outer = figure.add_gridspec(1, 2 if mesh else 1, width_ratios=[1.6, 1.0] if mesh else [1.0])
    axes = figure.add_subplot(outer[0])
    draw_map(axes, cells, values, texts, norm=norm, colours=ramp(), bold=best)
    draw_key(figure, axes, norm, ramp(), "worse of the two, 0 to 1", below=mesh)
    if mesh:
        draw_mesh(figure, outer[1], cells, values, norm=norm, log=False)
    pitch_is = "log frequency" if log_pitch else "frequency"
    said = f"s: size (log peak to peak) is the worse;  p: pitch ({pitch_is});  frame: best of its row"
    figure.supxlabel(said, fontsize=8)
    return figure


def _scaled(values: list[list[float]]) -> list[list[float]]:
    """Values from 0 to 1 over their range."""
    found = [value for line in values for value in line if value == value]
    low, span = min(found), (max(found) - min(found)) or 1.0
    return [[(value - low) / span for value in line] for line in values]
