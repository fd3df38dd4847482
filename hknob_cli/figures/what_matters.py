"""What matters most over many axes, or in a design: one block of panels an axis, the one that explains most first."""

from collections.abc import Sequence
from math import ceil
from typing import TYPE_CHECKING

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.grid import Row, axes_of, rows_of
from hknob_cli.report.means import ONE, WORST
from hknob_cli.results.result_set import MissingError, Result, ResultSet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from hknob_cli.report.what_matters import Columns

_ACROSS = 3
_DOTS = 100  # cells drawn in a panel, which each take room in the file


@drawing
def what_matters(evidence: ResultSet, of: str, *, where: Row | None = None, most: int = 6) -> "Figure":
    """Peak to peak, frequency, and the share at rest (or in domain) over each axis that varies, at most ``most``.

    A cell is judged by its largest cycle; one in which all trials rest is the least.

    Lines are medians, bands reach from 10 to 90 % of the cells that buzz, dots are some of them; "explains" is the
    share of the variance of the cells' places in order of size that lies between the bins of an axis (epsilon squared
    of Kruskal and Wallis). ``where`` chooses a method or law. Raises `MissingError` where too few cells have a size.
    """
    from hknob_cli.figures.what_matters_picture import draw_blocks, note_of
    from hknob_cli.report.what_matters import what_matters as found_in

    result = evidence[of]
    axes, columns, share = _cells(result, where)
    matters = found_in(columns, axes, share=share)
    if not matters:
        raise MissingError(f"'{of}' has too few cells with a size to tell what matters")
    shown = matters[:most]
    across = min(_ACROSS, len(shown))
    figure = theme.figure(4.0 * ceil(len(shown) / across) + 0.6)
    draw_blocks(figure, {of: shown}, {of: columns}, across=across, scales=result.scales, share=share, dots=_DOTS)
    note = note_of(matters, "", 120)
    if hidden := len(matters) - len(shown):
        note += f"\nleft out: {hidden} that explain{'s' if hidden == 1 else ''} less"
    if (large := result.parted("cells")) and (looked_at := len(columns[share])) < large.num_rows:
        note += f"\nof {looked_at:,} of {large.num_rows:,} cells, from all over them"
    figure.supxlabel(note, fontsize=7)
    return figure


def can_tell(result: Result, where: Row | None = None) -> bool:
    """Whether enough cells have a size to tell what matters."""
    from hknob_cli.report.what_matters import what_matters as found_in

    axes, columns, share = _cells(result, where)
    return bool(found_in(columns, axes, share=share))


def _cells(result: Result, where: Row | None) -> tuple[list[str], "Columns", str]:
    """Axes that may matter, columns of the cells, or of some of very many, and which of them is a share."""
    from hknob_cli.report.large import matters_at_large
    from hknob_cli.report.what_matters import axes_that_matter, columns_in

    if large := result.parted("cells"):
        _refuse_lacking(result, large.column_names, (*WORST, "at_rest_fraction"))
        return *matters_at_large(large, result.axes), "at_rest_fraction"
    rows = rows_of(result, where)
    share = "at_rest_fraction" if "at_rest_fraction" in rows[0] else "in_domain"
    needed = (*(WORST if share == "at_rest_fraction" else ONE), share)
    _refuse_lacking(result, list(rows[0]), needed)
    axes = axes_that_matter(axes_of(result, rows), list(rows[0]))
    return axes, columns_in(rows, [*axes, *needed]), share


def _refuse_lacking(result: Result, names: Sequence[str], needed: Sequence[str]) -> None:
    """Raise `MissingError` where ``names`` lack a column that is ``needed`` beside the axes."""
    if lacking := [name for name in needed if name not in names]:
        raise MissingError(f"'{result.name}' has no column {', '.join(lacking)}")
