"""Which method is right where: a table of the verdicts of a bench, scene by method, a symbol for each setting."""

from textwrap import fill
from typing import TYPE_CHECKING, Any

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.error_time import STYLES
from hknob_cli.report.bench import VERDICTS
from hknob_cli.results.result_set import MissingError, ResultSet, Rows

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_OTHER_FRICTION = ("smoothed", "soft")
_SYMBOLS = dict(zip(VERDICTS, ("\u2713", "\u2248", "\u2260", "\u2715", "\u2013", "?"), strict=True))
_COLOURS = dict(zip(VERDICTS, ("#1f4e79", "#7fb0d8", "#f0c75e", "#f7ecd0", "#d9d9d9", "#ffffff"), strict=True))
_ROW = 0.4  # inches


@drawing
def stability_table(
    evidence: ResultSet, of: str, *, scenes: list[str] | None = None, methods: list[str] | None = None
) -> "Figure":
    """Verdicts of every scene and method: coloured and named by the best, a symbol a setting, the coarsest first.

    A second line of symbols is of smoothed or soft friction. Raises `MissingError`.
    """
    from matplotlib.patches import Patch, Rectangle

    rows = evidence[of].rows("bench")
    down = [name for name in dict.fromkeys(row["scene"] for row in rows) if scenes is None or name in scenes]
    across = [name for name in dict.fromkeys(row["method"] for row in rows) if methods is None or name in methods]
    if not down or not across:
        raise MissingError(f"'{of}' has no run of these scenes and methods")
    words = len(across) <= 8
    figure = theme.figure(_ROW * len(down) + 1.35)
    axes = figure.subplots()
    for i, scene in enumerate(reversed(down)):
        for j, method in enumerate(across):
            own = [row for row in rows if row["scene"] == scene and row["method"] == method]
            if not own:
                continue
            best = min((row["verdict"] for row in own), key=list(VERDICTS).index)
            axes.add_patch(Rectangle((j + 0.02, i + 0.03), 0.96, 0.94, facecolor=_COLOURS[best], edgecolor="none"))
            inked = theme.ON_DARK if best == "accurate" else theme.ON_LIGHT
            text = _symbols(own)
            if words:
                text = f"{best}\n{text.replace(chr(10), ' | ')}"
            axes.text(j + 0.5, i + 0.5, text, ha="center", va="center", fontsize=8, color=inked, linespacing=1.1)
    axes.set_xlim(0, len(across))
    axes.set_ylim(0, len(down))
    axes.grid(visible=False)
    labels = [STYLES[name].label if name in STYLES else name for name in across]
    names = [fill(label, 13) for label in labels] if words else [name.replace("_", " ") for name in across]
    turned: dict[str, Any] = {} if words else {"rotation": 50, "ha": "left", "rotation_mode": "anchor"}
    axes.set_xticks([j + 0.5 for j in range(len(across))], names, fontsize=8, **turned)
    axes.xaxis.tick_top()
    axes.set_yticks(
        [i + 0.5 for i in range(len(down))], [name.replace("_", " ") for name in reversed(down)], fontsize=8
    )
    axes.tick_params(length=0)
    for spine in axes.spines.values():
        spine.set_visible(False)
    there = [verdict for verdict in VERDICTS if any(row["verdict"] == verdict for row in rows)]
    handles = [Patch(facecolor=_COLOURS[verdict], label=f"{_SYMBOLS[verdict]}  {verdict}") for verdict in there]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), columnspacing=1.2)
    bar = " after the bar" if words else " in the second line"
    note = "a cell has the colour of its best verdict;  a symbol a setting, the coarsest first"
    if any(row["friction"] in _OTHER_FRICTION for row in rows):
        note += f",\n{bar.strip()}: with smoothed or soft friction"
    axes.xaxis.set_label_position("bottom")
    axes.set_xlabel(note, fontsize=8)
    return figure


def _symbols(rows: Rows) -> str:
    """A symbol for each setting, friction as it is first, then, in a second line, smoothed or soft."""
    lines = []
    for other in (False, True):
        own = [_SYMBOLS[row["verdict"]] for row in rows if (row["friction"] in _OTHER_FRICTION) == other]
        if own:
            lines.append((" " if len(own) < 4 else "").join(own))
    return "\n".join(lines)
