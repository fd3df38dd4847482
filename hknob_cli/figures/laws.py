"""Closed laws beside the simulation: lines and points over one axis (Hasser, sec. 9.3, Figs 62-65).

How far the torque of one count can move a knob at each pitch is beside what is said and found of it (Hasser, Fig. 69).
"""

from textwrap import fill
from typing import TYPE_CHECKING

import numpy as np

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.grid import Grid, Layout, LinesLayout, column_label, grid
from hknob_cli.figures.numbers import log_ticks, mark_values, tick_labels
from hknob_cli.results.columns import WORST
from hknob_cli.results.result_set import MissingError, ResultSet

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LAWS = {"quantum_period": "the law C \u0394\u03b8 T"}


@drawing
def law_lines(
    evidence: ResultSet,
    of: str | list[str],
    *,
    law: str = "quantum_period",
    column: str = "p2p_rad",
    layout: LinesLayout,
    height: float = 3.8,
) -> "Figure":
    """A law of a prediction as lines over an axis, and the simulated values as points.

    ``of``: the prediction, and the sweep, unless the prediction has one beside it. Lines are faint outside the law's
    domain. Mean over the trials that cycle. Raises `MissingError`.
    """
    names = [of] if isinstance(of, str) else list(of)
    result = evidence[names[0]]
    beside = column if len(names) > 1 else f"sweep_{column}"
    cells = grid(result, Layout(*layout), where={"law": law}, columns=(column,))
    there: Grid | None = cells
    if len(names) > 1:
        same = Layout(cells.across or None, cells.down or None, layout.at)
        there = grid(evidence[names[1]], same, columns=(column,))
    elif cells.rows and beside not in cells.rows[0]:
        there = None
    name, factor = column_label(result, column)
    figure = theme.figure(height)
    axes = figure.subplots()
    computed = cells.values(column, factor)
    if not any(value == value for line in computed for value in line):
        raise MissingError(f"'{names[0]}' has no value of {column} by the law {law}")
    for i, (line, text) in enumerate(zip(computed, tick_labels(cells.downs), strict=True)):
        _line(axes, cells, i, line)
        axes.plot([], [], **theme.series(i), marker=theme.points(i)["marker"], markersize=5, label=text)
    if there is not None:
        for i, line in enumerate(there.values(beside, factor)):
            shown = [(x, y) for x, y in zip(there.acrosses, line, strict=True) if y == y and y > 0]
            axes.plot(*zip(*shown, strict=True) if shown else ([], []), markersize=5, **theme.points(i))
    values = [value for value in cells.acrosses if value is not None]
    mark_values(axes, values, few=10)
    axes.set_yscale("log")
    axes.set_yticks(*log_ticks(*axes.get_ylim()))
    axes.set_yticks([], minor=True)
    axes.set_xlabel(cells.names[0])
    axes.set_ylabel(name)
    what = [f"lines: {_LAWS.get(law, law.replace('_', ' '))}, thin outside its domain"]
    figure.supxlabel(";  ".join(what + (["points: simulated"] if there is not None else [])), fontsize=8)
    if cells.down:
        figure.legend(title=fill(cells.names[1], 20), loc="outside right upper", handlelength=3.4)
    return figure


def _line(axes: "Axes", cells: Grid, index: int, values: list[float]) -> None:
    """A row of the grid as a line, faint outside the law's domain."""
    style = theme.series(index)
    inside = [
        value if cell is not None and cell["in_domain"] else float("nan")
        for value, cell in zip(values, cells.cells[index], strict=True)
    ]
    axes.plot(cells.acrosses, values, **{**style, "linewidth": 0.8, "alpha": 0.6})
    axes.plot(cells.acrosses, inside, **style)


_MARGIN = 3.0  # factor of frequency that the line reaches beyond the points


@drawing
def torque_reach(
    evidence: ResultSet,
    of: list[str],
    *,
    names: list[str] | None = None,
    printed_hz: float | None = None,
    printed_rad: float | None = None,
) -> "Figure":
    """Peak to peak (mrad) over pitch (Hz): the most that +- half a count's torque gives the inertia, K q / (32 J f^2).

    The first ``of`` is a sweep of one cell, whose scene has the wall and the inertia; it and the others (sweeps and
    campaigns of one cell) are points, the largest cycle of each. ``printed_hz``, ``printed_rad``: what a text says.
    Raises `MissingError` where one is at rest.
    """
    from hknob_cli.specs.plan import scene_at
    from hknob_cli.theory.laws import working_edge

    points: list[tuple[str, float, float]] = []
    for name, said in zip(of, names or of, strict=True):
        cells = grid(evidence[name], columns=WORST).rows
        if len(cells) != 1 or not cells[0][WORST[0]]:
            raise MissingError(f"'{name}' is at rest, or of several cells")
        size, pitch = (float(cells[0][column]) for column in WORST)
        points.append((said, pitch, size))
    pitches = [pitch for _, pitch, _ in points] + ([printed_hz] if printed_hz else [])
    line = np.geomspace(min(pitches) / _MARGIN, max(pitches) * _MARGIN, 60)
    first = evidence[of[0]]
    cell = {axis: first.rows("cells")[0][axis] for axis in first.axes}
    edge = working_edge(scene_at(first.scene, cell), cell)
    at_one = edge.wall_stiffness * edge.quantum_rad / (32.0 * edge.inertia)  # a triangle of velocity, at 1 Hz
    drawn = theme.figure(3.3)
    panel = drawn.subplots()
    panel.plot(line, 1e3 * at_one / line**2, color="black", linewidth=1.2, label="half a count's torque, no losses")
    for i, (said, at_hz, p2p_rad) in enumerate(points):
        panel.plot([at_hz], [1e3 * p2p_rad], markersize=7, label=said, **theme.points(i))
    if printed_hz and printed_rad:
        reach = at_one / printed_hz**2
        panel.plot([printed_hz], [1e3 * printed_rad], markersize=13, marker="*", linestyle="none", color="black",
                   label="printed")  # fmt: skip
        panel.plot([printed_hz] * 2, [1e3 * reach, 1e3 * printed_rad], color="black", linestyle=":", linewidth=1.0)
        panel.text(1.05 * printed_hz, 1e3 * (reach * printed_rad) ** 0.5, f"{printed_rad / reach:.0f}-fold", fontsize=8)
    panel.set_xscale("log")
    panel.set_yscale("log")
    panel.set_xticks(*log_ticks(*panel.get_xlim()))
    panel.set_yticks(*log_ticks(*panel.get_ylim()))
    panel.set_xticks([], minor=True)
    panel.set_yticks([], minor=True)
    panel.set_xlabel("frequency, Hz")
    panel.set_ylabel("peak to peak, mrad")
    panel.legend(loc="lower left")
    return drawn
