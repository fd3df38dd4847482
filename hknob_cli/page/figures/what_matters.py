"""What matters most over many axes, or in a design: one block of panels an axis, the one that explains most first."""

from math import ceil
from typing import TYPE_CHECKING

from hknob_cli.page import ink
from hknob_cli.page.figures import drawing
from hknob_cli.page.figures.grid import Row, axes_of, rows_of
from hknob_cli.results.evidence import Evidence, MissingError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_ACROSS = 3
_DOTS = 100  # cells drawn in a panel, which each take room in the file


@drawing
def what_matters(evidence: Evidence, of: str, *, where: Row | None = None, most: int = 6) -> "Figure":
    """Peak to peak, frequency, and the share at rest (or in domain) over each axis that varies, at most ``most``.

    Lines are medians, bands reach from 10 to 90 % of the cells that buzz, dots are some of them; "explains" is the
    share of the variance of the cells' places in order of size that lies between the bins of an axis (epsilon squared
    of Kruskal and Wallis). ``where`` chooses a method or law. Raises `MissingError` where too few cells have a size.
    """
    from hknob_cli.report.what_matters import axes_that_matter, columns_in
    from hknob_cli.report.what_matters import what_matters as found_in
    from hknob_cli.report.what_matters_picture import draw_blocks, note_of

    result = evidence[of]
    rows = rows_of(result, where)
    share = "at_rest_fraction" if "at_rest_fraction" in rows[0] else "in_domain"
    needed = ("p2p_rad", "frequency_hz", share)
    if lacking := [name for name in needed if name not in rows[0]]:
        raise MissingError(f"'{of}' has no column {', '.join(lacking)}")
    axes = axes_that_matter(axes_of(result, rows), list(rows[0]))
    columns = columns_in(rows, [*axes, *needed])
    matters = found_in(columns, axes, share=share)
    if not matters:
        raise MissingError(f"'{of}' has too few cells with a size to tell what matters")
    shown = matters[:most]
    across = min(_ACROSS, len(shown))
    figure = ink.figure(4.0 * ceil(len(shown) / across) + 0.6)
    draw_blocks(figure, {of: shown}, {of: columns}, across=across, scales=result.scales, share=share, dots=_DOTS)
    note = note_of(matters, "", 120)
    if hidden := len(matters) - len(shown):
        note += f"\nleft out: {hidden} that explain{'s' if hidden == 1 else ''} less"
    figure.supxlabel(note, fontsize=7)
    return figure
