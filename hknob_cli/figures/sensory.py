"""The optimisation by the senses: the more noticeable of touch and sound over the grid (Hasser, sec. 10.7, Fig. 70)."""

from typing import TYPE_CHECKING

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.grid import Row, ends, grid, notes
from hknob_cli.figures.heat import draw_key, draw_map, height_of, norm_of, ramp
from hknob_cli.figures.maps import draw_mesh
from hknob_cli.results.result_set import MissingError, ResultSet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FELT, HEARD = SENSES = "touch_db", "hearing_db"


@drawing
def sensory_surface(
    evidence: ResultSet,
    of: str,
    *,
    across: str | None = None,
    down: str | None = None,
    at: Row | None = None,
    mesh: bool = False,
) -> "Figure":
    """The larger of the levels of touch and of sound above their thresholds, dB, over two axes; small is good.

    A letter says which of the two it is (t: touch, h: hearing); the best cell of each row has a frame. Each level is
    that of the cell's most noticeable cycle. For axes see `grid`. Raises `MissingError`, also where sound has no gain.
    """
    if HEARD not in evidence[of].table("cells").column_names:
        raise MissingError(f"the sound of '{of}' has no level: its perceive has no sound_gain and no sound_response")
    cells = grid(evidence[of], across=across, down=down, at=at, columns=SENSES)
    felt, heard = (cells.values(column) for column in SENSES)
    values = [[_larger(*both) for both in zip(*lines, strict=True)] for lines in zip(felt, heard, strict=True)]
    flat = [value for line in values for value in line]
    if not any(value == value for value in flat):
        raise MissingError(f"'{of}' has no limit cycle")
    texts = [
        [
            f"{value:.0f} {'t' if touch == value else 'h'}" if value == value else " ".join(ends(cell)) if cell else ""
            for value, touch, cell in zip(*lines, strict=True)
        ]
        for lines in zip(values, felt, cells.cells, strict=True)
    ]
    found = [[(value, j) for j, value in enumerate(line) if value == value] for line in values]
    best = {(i, min(line)[1]) for i, line in enumerate(found) if len(line) > 1}
    mesh = mesh and min(len(cells.acrosses), len(cells.downs)) > 1
    norm = norm_of(flat, log=False)
    figure = theme.figure(height_of(cells, extra=1.45 if mesh else 1.0))
    outer = figure.add_gridspec(1, 2 if mesh else 1, width_ratios=[1.6, 1.0] if mesh else [1.0])
    axes = figure.add_subplot(outer[0])
    draw_map(axes, cells, values, texts, norm=norm, colours=ramp(), bold=best)
    draw_key(figure, axes, norm, ramp(), "more noticeable of the two, dB above threshold", below=mesh)
    if mesh:
        draw_mesh(figure, outer[1], cells, values, norm=norm, log=False)
    said = "t: touch is the more noticeable;  h: hearing;  frame: best of its row"
    figure.supxlabel(";  ".join(filter(None, [said, notes([cells], FELT)])), fontsize=8)
    return figure


def _larger(one: float, other: float) -> float:
    """The larger of two levels; of one that is known and one that is not (NaN), the known."""
    return one if other != other or one >= other else other
