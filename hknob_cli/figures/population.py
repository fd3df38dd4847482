"""People: how many of a population have at most so large a limit cycle, and so high a pitch, cells as lines."""

from typing import TYPE_CHECKING

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.grid import Row, axes_of, axis_label, rows_of
from hknob_cli.figures.numbers import tick_labels
from hknob_cli.report.population import by_cell, pitches, sizes
from hknob_cli.results.result_set import MissingError, ResultSet
from hknob_cli.specs.plan import PERSON

if TYPE_CHECKING:
    from matplotlib.figure import Figure


MOST_CURVES = 7


@drawing
def population(evidence: ResultSet, of: str, *, at: Row | None = None, height: float = 3.4) -> "Figure":
    """Cumulative distribution over people of peak to peak and of frequency, a line for each cell.

    ``at`` gives values of axes, the nearest of which are taken. Both are of a person's largest cycle: peak to peak of
    all people, 0 at rest; frequency of those for whom the knob buzzes. Of many cells a few are drawn. Raises
    `MissingError` where the result has no population.
    """
    result = evidence[of]
    rows = rows_of(result)
    axes = axes_of(result, rows)
    if PERSON not in axes:
        raise MissingError(f"'{of}' is a sweep of one hand, not of a population")
    for axis, value in (at or {}).items():
        if axis not in axes:
            raise MissingError(f"'{of}' has no axis {axis}; it has {', '.join(axes)}")
        nearest = min((row[axis] for row in rows), key=lambda found: abs(found - value))
        rows = [row for row in rows if row[axis] == nearest]
    wide = [axis for axis in axes if axis != PERSON and len({row[axis] for row in rows}) > 1]
    cells = thinned(by_cell(rows, axes))
    names = [tick_labels([cell[axis] for cell, _ in cells]) for axis in wide]
    figure = theme.figure(height)
    left, right = figure.subplots(1, 2, sharey=True)
    for i, (_, people) in enumerate(cells):
        label = ", ".join(texts[i] for texts in names) or None
        for panel, values, scale in ((left, sizes(people), 1e3), (right, pitches(people), 1.0)):
            xs, ys = cumulative(values, scale) if values else ([], [])
            panel.step(xs, ys, where="post", label=label if panel is left else None, **theme.series(i))
    left.set_ylabel("people who have at most this, %")
    left.set_xlabel("peak to peak, mrad (0: at rest)")
    right.set_xlabel("frequency, Hz, where it buzzes")
    for panel in (left, right):
        panel.set_ylim(0.0, 101.0)
    if wide:
        title = ", ".join(axis_label(result, axis) for axis in wide)
        figure.legend(title=title, loc="outside upper center", ncols=min(len(cells), 4), handlelength=3.2)
    return figure


def thinned(cells: list[tuple[Row, list[Row]]]) -> list[tuple[Row, list[Row]]]:
    """Cells spread over all, few enough to tell apart as curves; the first and the last among them."""
    last, most = len(cells) - 1, MOST_CURVES - 1
    return cells if last <= most else [cells[round(i * last / most)] for i in range(MOST_CURVES)]


def cumulative(values: list[float], scale: float) -> tuple[list[float], list[float]]:
    """Corners of the steps of the distribution of ordered values: values times ``scale``, and % that have at most it.

    A curve starts at 0 % at the least value, so that people who share it show as an upright line.
    """
    parts = [100.0 * (i + 1) / len(values) for i in range(len(values))]
    return [scale * value for value in values[:1] + values], [0.0, *parts]
