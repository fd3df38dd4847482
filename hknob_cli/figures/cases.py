"""A few designs side by side: every orbit of each, by size and pitch (Hasser, sec. 10.5, Fig. 68)."""

from typing import TYPE_CHECKING

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.grid import Row, axes_of
from hknob_cli.figures.numbers import number
from hknob_cli.report.matrix import short
from hknob_cli.report.means import MEANS
from hknob_cli.results.result_set import MissingError, ResultSet, Rows

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_SHORT = {"sample_rate_hz": "{} Hz", "counts_per_rev": "{} counts"}


@drawing
def cases(evidence: ResultSet, of: str | list[str], *, names: list[str] | None = None) -> "Figure":
    """Orbits of every cell of the results, a row a cell: peak to peak (mrad), and frequency (Hz); dots by basin share.

    The largest is written above its dot; a bar is the mean over the trials that cycle. Raises `MissingError` where none
    has a limit cycle.
    """
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    results = [of] if isinstance(of, str) else of
    rows: list[tuple[str, Row, Rows]] = []
    for result, name in zip((evidence[one] for one in results), names or results, strict=True):
        orbits = result.rows("orbits")
        axes = axes_of(result, orbits)
        for cell in result.rows("cells"):
            own = [row for row in orbits if all(row[axis] == cell[axis] for axis in axes)]
            place = ", ".join(_SHORT.get(axis, axis + " {}").format(short(cell[axis], 6)) for axis in axes)
            rows.append((f"{name}\n{place}", cell, own))
    if not any(cell["p2p_rad"] for _, cell, _ in rows):
        raise MissingError(f"{', '.join(results)}: no limit cycle")
    figure = theme.figure(0.5 * len(rows) + 0.9)
    panels = figure.subplots(1, 2, sharey=True)
    for axes_, largest, scale, label in (
        (panels[0], "p2p_max_rad", 1e3, "peak to peak, mrad"),
        (panels[1], "frequency_at_max_hz", 1.0, "frequency, Hz"),
    ):
        column = MEANS[largest]
        for y, (_, cell, orbits) in enumerate(reversed(rows)):
            for row in orbits:
                if row[column]:
                    size = 3.0 + 6.0 * row["basin_fraction"] ** 0.5
                    dot = {"color": theme.COLOURS[0], "markeredgewidth": 0, "markersize": size}
                    axes_.plot([scale * row[column]], [y], marker="o", **dot)
            if cell[column]:
                axes_.plot([scale * cell[column]], [y], marker="|", markersize=18, color="black", linestyle="none")
                worst = scale * cell[largest]
                axes_.annotate(
                    number(worst), (worst, y), textcoords="offset points", xytext=(0, 12), ha="center", fontsize=8
                )
            else:
                axes_.text(0.5, y, "rest", ha="center", va="center", fontsize=8, transform=axes_.get_yaxis_transform())
        axes_.set_xscale("log")
        axes_.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axes_.xaxis.set_major_formatter(FuncFormatter(lambda value, _place: f"{value:g}"))
        axes_.xaxis.set_minor_formatter(NullFormatter())
        axes_.set_xlabel(label)
        axes_.set_ylim(-0.6, len(rows) - 0.25)
        axes_.margins(x=0.25)
    panels[0].set_yticks(range(len(rows)), [text for text, _, _ in reversed(rows)], fontsize=8)
    figure.supxlabel(
        "a dot an orbit, larger the more trials reach it;  number: the largest;  bar: the mean of trials that cycle",
        fontsize=8,
    )
    return figure
