"""The optimisation by the senses: the more noticeable of touch and sound over the grid (Hasser, sec. 10.7, Fig. 70)."""

from typing import TYPE_CHECKING

from hknob_cli.figures import drawing
from hknob_cli.figures.grid import Layout, grid, notes
from hknob_cli.figures.heat import norm_of
from hknob_cli.figures.maps import draw_surface, ending
from hknob_cli.results.result_set import MissingError, ResultSet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FELT, HEARD = SENSES = "touch_db", "hearing_db"


@drawing
def sensory_surface(
    evidence: ResultSet,
    of: str,
    *,
    layout: Layout,
    mesh: bool = False,
) -> "Figure":
    """The larger of the levels of touch and of sound above their thresholds, dB, over two axes; small is good.

    A letter says which of the two it is (t: touch, h: hearing); the best cell of each row has a frame. Each level is
    that of the cell's most noticeable cycle. Raises `MissingError`, also where sound has no gain.
    """
    if HEARD not in evidence[of].table("cells").column_names:
        raise MissingError(f"the sound of '{of}' has no level: its perceive has no sound_gain and no sound_response")
    cells = grid(evidence[of], layout, columns=SENSES)
    felt, heard = (cells.values(column) for column in SENSES)
    values = [[_larger(*both) for both in zip(*lines, strict=True)] for lines in zip(felt, heard, strict=True)]
    flat = [value for line in values for value in line]
    if not any(value == value for value in flat):
        raise MissingError(f"'{of}' has no limit cycle")
    texts = [
        [
            f"{value:.0f} {'t' if touch == value else 'h'}" if value == value else ending(cell)
            for value, touch, cell in zip(*lines, strict=True)
        ]
        for lines in zip(values, felt, cells.cells, strict=True)
    ]
    label = "more noticeable of the two, dB above threshold"
    figure = draw_surface(cells, values, texts, norm=norm_of(flat, log=False), label=label, mesh=mesh, least=2)
    said = "t: touch is the more noticeable;  h: hearing;  frame: best of its row"
    figure.supxlabel(";  ".join(filter(None, [said, notes([cells], FELT)])), fontsize=8)
    return figure


def _larger(one: float, other: float) -> float:
    """The larger of two levels; of one that is known and one that is not (NaN), the known."""
    return one if other != other or one >= other else other
