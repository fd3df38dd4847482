"""The K-B plane: stiffness over virtual damping of a wall, with the lines within which it is passive or stable."""

from typing import TYPE_CHECKING, Any

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.grid import axis_name
from hknob_cli.figures.numbers import is_geometric, log_ticks
from hknob_cli.report.table import short
from hknob_cli.results.result_set import MissingError, Result, ResultSet
from hknob_cli.specs.plan import COUNTS, RATE, Cell, scene_at
from hknob_cli.theory.laws import working_edge
from hknob_cli.theory.stiffness_limits import stiffness_limits

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

STIFFNESS, DAMPING = "wall.stiffness", "wall.damping"
_POINTS = 161  # of a line
_LINES = {
    "colgate_schenkel": "passive in any hand, no counts\n(Colgate & Schenkel)",
    "abbott_okamura": "passive in any hand, with\ncounts (Abbott & Okamura)",
    "gil_hulin": "stable in this hand, no counts\n(Gil & Hulin)",
    "exact": "stable in this hand, no counts,\nexact",
    "niemeyer": "friction holds over a count\n(Niemeyer)",
}
_CELLS = ("cell passive in any hand", "cell stable in this hand\n(Gil & Hulin)", "cell neither")


@drawing
def kb_plane(evidence: ResultSet, of: str, *, height: float = 4.4) -> "Figure":
    """Limits of a prediction over the wall's stiffness and damping as lines, and the verdict of each cell as a point.

    ``of``: a prediction of which only `wall.stiffness` and `wall.damping` vary. Below a line its limit holds. Limits
    that no stiffness satisfies have no line, and are named. Raises `MissingError`.
    """
    import numpy as np

    result = evidence[of]
    rows = result.rows("passivity")
    stiffness, damping = (sorted({row[axis] for row in rows}) for axis in _axes(result, rows))
    cell: Cell = {axis: rows[0][axis] for axis in result.axes}
    edge = working_edge(scene_at(result.scene, cell), cell)
    over = np.linspace(damping[0], damping[-1], _POINTS)
    figure = theme.figure(height)
    axes = figure.subplots()
    none = []
    for i, (name, line) in enumerate(stiffness_limits(edge, over.tolist())._asdict().items()):
        drawn = np.array(line)
        if not np.any(drawn > 0.0):
            none += [_LINES[name].replace("\n", " ")] if np.any(drawn == 0.0) else []
            continue
        axes.plot(over, drawn, **theme.series(i), label=_LINES[name])
    _draw_cells(axes, rows)
    _scale(axes, stiffness)
    axes.set_xlabel(axis_name(DAMPING))
    axes.set_ylabel(axis_name(STIFFNESS))
    said = [f"{short(cell[RATE], 6)} Hz, {cell[COUNTS]:g} counts. Below a line its limit holds."]
    said += [f"At no stiffness: {name}" for name in none]
    figure.supxlabel("\n".join(said), fontsize=8)
    figure.legend(loc="outside right upper", handlelength=3.0)
    return figure


def is_kb(axes: list[str]) -> bool:
    """Whether these axes, and no others, span the plane."""
    return sorted(axes) == [DAMPING, STIFFNESS]


def _axes(result: Result, rows: list[dict[str, Any]]) -> tuple[str, str]:
    wide = [axis for axis in result.axes if len({row[axis] for row in rows}) > 1]
    if not is_kb(wide) or result.is_design:
        raise MissingError(f"'{result.name}' is no grid over {STIFFNESS} and {DAMPING} alone")
    return STIFFNESS, DAMPING


def _draw_cells(axes: "Axes", rows: list[dict[str, Any]]) -> None:
    """A point a cell: filled, hollow, or a cross."""
    kinds = [0 if row["device_passive"] else 1 if row["gil_hulin"] else 2 for row in rows]
    for kind, marker in enumerate(("o", "o", "x")):
        mine = [row for row, one in zip(rows, kinds, strict=True) if one == kind]
        style: dict[str, Any] = {"color": "black", "marker": marker, "markersize": 3.5, "linestyle": "none"}
        if mine:
            places = [row[DAMPING] for row in mine], [row[STIFFNESS] for row in mine]
            axes.plot(*places, **style, fillstyle="none" if kind == 1 else "full", label=_CELLS[kind])


def _scale(axes: "Axes", stiffness: list[float]) -> None:
    """The stiffness of the cells, with a margin: by factors where they are, else from 0."""
    if stiffness[0] > 0.0 and is_geometric(stiffness):
        margin = (stiffness[-1] / stiffness[0]) ** 0.04
        axes.set_yscale("log")
        axes.set_ylim(stiffness[0] / margin, stiffness[-1] * margin)
        axes.set_yticks(*log_ticks(stiffness[0], stiffness[-1]))
        axes.set_yticks([], minor=True)
    else:
        margin = 0.04 * (stiffness[-1] - stiffness[0])
        axes.set_ylim(stiffness[0] - margin, stiffness[-1] + margin)
