"""A bench: error against run time, and which method is right where.

Methods are told apart by marker, families by colour and line style. A hollow marker is a method as it comes, a thin
line with small markers another treatment of friction. Runs without an error on the scale stand at the top.

Which method is right where: a table of the verdicts of a bench, scene by method, a symbol for each setting.
"""

from math import ceil
from textwrap import fill
from typing import TYPE_CHECKING, Any, NamedTuple

from hknob_cli.figures import drawing, theme
from hknob_cli.report.bench import VERDICTS
from hknob_cli.results.result_set import MissingError, ResultSet, Rows

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LEAST, LARGEST = 1e-17, 1e2  # errors between which the scale is
_OTHER_FRICTION = ("smoothed", "soft")
_ACCURATE = 1e-6
_OFF = 1e5  # where runs off the scale stand
_TEXTS = {1e-15: "10\u207b\u00b9\u2075", 1e-10: "10\u207b\u00b9\u2070", 1e-5: "10\u207b\u2075", 1.0: "1", _OFF: "none"}

_SYMBOLS = dict(zip(VERDICTS, ("\u2713", "\u2248", "\u2260", "\u2715", "\u2013", "?"), strict=True))
_COLOURS = dict(zip(VERDICTS, ("#1f4e79", "#7fb0d8", "#f0c75e", "#f7ecd0", "#d9d9d9", "#ffffff"), strict=True))
_ROW = 0.4  # inches


class Style(NamedTuple):
    """How the points of a method look."""

    marker: str
    line: str
    colour: str
    label: str


STYLES = {
    "exact": Style("*", "-", "black", "hknob, exact"),
    "rk23": Style("o", "-", "#0072B2", "SciPy RK23"),
    "rk45": Style("s", "-", "#0072B2", "SciPy RK45"),
    "dop853": Style("^", "-", "#0072B2", "SciPy DOP853"),
    "lsoda": Style("D", "--", "#D55E00", "SciPy LSODA"),
    "radau": Style("v", "--", "#D55E00", "SciPy Radau"),
    "bdf": Style("p", "--", "#D55E00", "SciPy BDF"),
    "euler": Style("<", ":", "#009E73", "semi-implicit Euler, compiled"),
    "midpoint": Style(">", ":", "#009E73", "implicit midpoint, compiled"),
    "rk4": Style("h", ":", "#009E73", "Runge-Kutta 4, compiled"),
    "mujoco_euler": Style("X", "-.", "#7A7A7A", "MuJoCo Euler"),
    "mujoco_implicitfast": Style("P", "-.", "#7A7A7A", "MuJoCo implicitfast"),
    "mujoco_rk4": Style("8", "-.", "#7A7A7A", "MuJoCo RK4"),
}


@drawing
def error_time(
    evidence: ResultSet, of: str, *, scenes: list[str] | None = None, methods: list[str] | None = None, columns: int = 3
) -> "Figure":
    """Largest error of the angle over the reference's swing, against processor time in s, log-log, a panel a scene.

    ``scenes`` and ``methods`` choose some; ``columns`` panels stand side by side. Raises `MissingError`.
    """
    result = evidence[of]
    rows = [row for row in result.rows("bench") if methods is None or row["method"] in methods]
    names = _asked(rows, "scene", scenes)
    if not names:
        raise MissingError(f"'{of}' has no run of these scenes and methods")
    verdicts = result.provenance["spec"].get("verdicts") or {}
    columns = min(columns, len(names)) if len(names) != 4 else 2
    down = ceil(len(names) / columns)
    figure = theme.figure((2.1 if columns < 3 else 1.65) * down + 1.15)
    panels = list(figure.subplots(down, columns, squeeze=False, sharex=True, sharey=True).flat)
    for axes, name in zip(panels, names, strict=False):
        own = [row for row in rows if row["scene"] == name]
        _panel(axes, own, accurate=float(verdicts.get("accurate", _ACCURATE)))
        axes.set_title(name.replace("_", " "), fontsize=8.5)
    for axes in panels[len(names) :]:
        axes.set_axis_off()
    for axes in panels[max(0, len(names) - columns) : len(names)]:
        axes.tick_params(labelbottom=True)
        axes.set_xlabel("processor time of a run, s", fontsize=8.5)
    figure.supylabel("largest error / swing", fontsize=9)
    _key(figure, [row for row in rows if row["scene"] in names])
    return figure


def _asked(rows: Rows, column: str, names: list[str] | None) -> list[str]:
    """Values of a column in their order; with ``names`` those among them."""
    return [one for one in dict.fromkeys(row[column] for row in rows) if names is None or one in names]


def _panel(axes: "Axes", rows: Rows, *, accurate: float) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_ylim(LEAST / 5.0, 30.0 * _OFF)
    axes.axhline(accurate, color="black", linestyle=":", linewidth=1.0)
    axes.axhline(LARGEST * 10.0, color="black", linewidth=0.5, alpha=0.4)
    for method, style in STYLES.items():
        for other in (True, False):
            of = [row for row in rows if row["method"] == method and (row["friction"] in _OTHER_FRICTION) == other]
            _line(axes, of, style, size=3.0 if other else 4.5, thin=other)
    axes.set_yticks(list(_TEXTS), list(_TEXTS.values()), fontsize=8)
    axes.tick_params(axis="y", which="minor", length=0)
    axes.tick_params(axis="x", labelsize=8)


def _line(axes: "Axes", rows: Rows, style: Style, *, size: float, thin: bool) -> None:
    points = []
    for row in rows:
        error = row["relative_error"]
        shown = error is not None and error == error and error <= LARGEST
        points.append((row["seconds"], max(error, LEAST) if shown else _OFF, row["setting"].startswith("default")))
    line = [(x, y) for x, y, default in points if y < _OFF and not default]
    if len(line) > 1:
        axes.plot(*zip(*line, strict=True), linestyle=style.line, linewidth=0.6 if thin else 1.0, color=style.colour)
    for hollow in (False, True):
        some = [(x, y) for x, y, default in points if default == hollow]
        if some:
            axes.plot(
                *zip(*some, strict=True), linestyle="none", marker=style.marker, markeredgewidth=0.8,
                markersize=1.7 * size if style.marker == "*" else size, markeredgecolor=style.colour,
                markerfacecolor="none" if hollow else style.colour, zorder=4 if style.marker == "*" else 3,
            )  # fmt: skip


def _key(figure: "Figure", rows: Rows) -> None:
    from matplotlib.lines import Line2D

    there = {row["method"] for row in rows}
    handles = [
        Line2D([], [], ls=style.line, linewidth=1.0, marker=style.marker, color=style.colour, label=style.label,
               markersize=8 if style.marker == "*" else 5)
        for method, style in STYLES.items() if method in there
    ]  # fmt: skip
    handles.append(Line2D([], [], linestyle=":", linewidth=1.0, color="black", label="accurate below"))
    if any(row["setting"].startswith("default") for row in rows):
        handles.append(Line2D([], [], linestyle="", marker="o", markerfacecolor="none", markersize=5, color="black",
                              label="hollow: as it comes"))  # fmt: skip
    if any(row["friction"] in _OTHER_FRICTION for row in rows):
        handles.append(Line2D([], [], linestyle="-", linewidth=0.6, marker="o", markersize=3, color="black",
                              label="small: smoothed or soft friction"))  # fmt: skip
    figure.legend(handles=handles, loc="outside lower center", ncols=3, handlelength=3.0)


@drawing
def stability_table(
    evidence: ResultSet, of: str, *, scenes: list[str] | None = None, methods: list[str] | None = None
) -> "Figure":
    """Verdicts of every scene and method: coloured and named by the best, a symbol a setting, the coarsest first.

    A second line of symbols is of smoothed or soft friction. Raises `MissingError`.
    """
    from matplotlib.patches import Patch

    rows = evidence[of].rows("bench")
    down, across = _asked(rows, "scene", scenes), _asked(rows, "method", methods)
    if not down or not across:
        raise MissingError(f"'{of}' has no run of these scenes and methods")
    words = len(across) <= 8
    figure = theme.figure(_ROW * len(down) + 1.35)
    axes = figure.subplots()
    for i, scene in enumerate(reversed(down)):
        for j, method in enumerate(across):
            if own := [row for row in rows if row["scene"] == scene and row["method"] == method]:
                _verdicts(axes, own, (j, i), words=words)
    axes.set_xlim(0, len(across))
    axes.set_ylim(0, len(down))
    axes.grid(visible=False)
    _name_methods(axes, across, words=words)
    axes.set_yticks(
        [i + 0.5 for i in range(len(down))], [name.replace("_", " ") for name in reversed(down)], fontsize=8
    )
    axes.tick_params(length=0)
    for spine in axes.spines.values():
        spine.set_visible(False)
    there = {row["verdict"] for row in rows}
    handles = [Patch(facecolor=_COLOURS[one], label=f"{_SYMBOLS[one]}  {one}") for one in VERDICTS if one in there]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), columnspacing=1.2)
    note = "a cell has the colour of its best verdict;  a symbol a setting, the coarsest first"
    if any(row["friction"] in _OTHER_FRICTION for row in rows):
        note += f",\n{'after the bar' if words else 'in the second line'}: with smoothed or soft friction"
    axes.xaxis.set_label_position("bottom")
    axes.set_xlabel(note, fontsize=8)
    return figure


def _verdicts(axes: "Axes", rows: Rows, place: tuple[int, int], *, words: bool) -> None:
    """The cell of a method and scene at its column and row: the best verdict's colour, and symbols."""
    from matplotlib.patches import Rectangle

    x, y = place
    best = min((row["verdict"] for row in rows), key=list(VERDICTS).index)
    axes.add_patch(Rectangle((x + 0.02, y + 0.03), 0.96, 0.94, facecolor=_COLOURS[best], edgecolor="none"))
    inked = theme.ON_DARK if best == "accurate" else theme.ON_LIGHT
    text = _symbols(rows)
    if words:
        text = f"{best}\n{text.replace(chr(10), ' | ')}"
    axes.text(x + 0.5, y + 0.5, text, ha="center", va="center", fontsize=8, color=inked, linespacing=1.1)


def _name_methods(axes: "Axes", methods: list[str], *, words: bool) -> None:
    """Names of methods above their columns: broken into lines, or turned where the columns are narrow."""
    labels = [STYLES[name].label if name in STYLES else name for name in methods]
    names = [fill(label, 13) for label in labels] if words else [name.replace("_", " ") for name in methods]
    turned: dict[str, Any] = {} if words else {"rotation": 50, "ha": "left", "rotation_mode": "anchor"}
    axes.set_xticks([j + 0.5 for j in range(len(methods))], names, fontsize=8, **turned)
    axes.xaxis.tick_top()


def _symbols(rows: Rows) -> str:
    """A symbol for each setting, friction as it is first, then, in a second line, smoothed or soft."""
    lines = []
    for other in (False, True):
        own = [_SYMBOLS[row["verdict"]] for row in rows if (row["friction"] in _OTHER_FRICTION) == other]
        if own:
            lines.append((" " if len(own) < 4 else "").join(own))
    return "\n".join(lines)
