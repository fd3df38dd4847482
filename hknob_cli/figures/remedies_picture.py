"""The picture of a trial of remedies: at every case, how much smaller the buzz, at what pitch, and what it costs."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from hknob_cli.figures.sheet import save

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MARKS = "osD^vPX<>"


def draw_trial(rows: list[dict[str, Any]], *, title: str, path: Path) -> bool:
    """Draw cases.parquet's rows into ``path`` (PNG): a row of panels a case; False, drawing nothing, without a case.

    Raises `ComputationError` if the file cannot be written.
    """
    cases = list(dict.fromkeys(row["case"] for row in rows))
    if not cases:
        return False
    from matplotlib.figure import Figure

    names = list(dict.fromkeys(row["remedy"] for row in rows))
    felt = "touch_change_db" in rows[0]
    tall = (0.27 * len(names) + 1.3) * len(cases) + 0.8
    figure = Figure(figsize=(16.0 if felt else 13.0, tall), layout="constrained")
    widths = (3.0, 2.0, 2.0, *([2.2] if felt else []))
    panels = figure.subplots(len(cases), len(widths), squeeze=False, width_ratios=widths)
    for line, case in zip(panels, cases, strict=True):
        here = [row for row in rows if row["case"] == case]
        _panels(line, here, _ordered(here, names), case)
    handles, labels = panels[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=min(5, len(labels)), frameon=False)
    figure.suptitle(f"{title}: what each remedy leaves of the buzz")
    save(figure, path, stage="remedies", name=title)
    return True


def _ordered(rows: list[dict[str, Any]], names: list[str]) -> list[str]:
    """Remedies, the one with the least buzz of any hand last, so that it is on top."""

    def worst(name: str) -> float:
        sizes = [row["p2p_max_rad"] for row in rows if row["remedy"] == name]
        return max(float("inf") if size is None else size for size in sizes)

    return sorted(names, key=worst, reverse=True)


def _panels(line: "list[Axes]", rows: list[dict[str, Any]], names: list[str], case: str) -> None:
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    size, pitch, cost, *louder = line
    hands = list(dict.fromkeys(row["hand"] for row in rows))
    least = min((row["p2p_max_rad"] for row in rows if row["p2p_max_rad"]), default=1e-6)
    for i, hand in enumerate(hands):
        mine = {row["remedy"]: row for row in rows if row["hand"] == hand}
        spread = (i - 0.5 * (len(hands) - 1)) * 0.5 / max(1, len(hands))
        at = [y + spread for y in range(len(names))]
        style: dict[str, Any] = {
            "linestyle": "none",
            "marker": MARKS[i % len(MARKS)],
            "color": f"C{i}",
            "markersize": 4.5,
        }
        sizes = [mine[name]["p2p_max_rad"] for name in names]
        floor = 0.5e3 * least  # where those at rest are drawn, at the left edge
        drawn = [float("nan") if one is None else (1e3 * one or floor) for one in sizes]
        size.plot(drawn, at, label=hand, **style)
        means = [1e3 * (mine[name]["p2p_rad"] or float("nan")) for name in names]
        size.plot(means, at, **{**style, "marker": "|", "markersize": 7.0})
        pitch.plot([mine[name]["frequency_at_max_hz"] or float("nan") for name in names], at, **style)
        cost.plot([mine[name]["stiffness_kept"] or float("nan") for name in names], at, **style)
        cost.plot([mine[name]["knock_ratio"] or float("nan") for name in names], at, **{**style, "fillstyle": "none"})
        for axes in louder:
            for column, fill in (("touch_change_db", "full"), ("hearing_change_db", "none")):
                changes = [float("nan") if mine[name][column] is None else mine[name][column] for name in names]
                axes.plot(changes, at, **{**style, "fillstyle": fill})
    for axes in line:
        axes.set_yticks(range(len(names)), names if axes is size else [])
        axes.set_ylim(-0.6, len(names) - 0.4)
        axes.grid(alpha=0.3)
        if axes in louder:
            continue
        axes.set_xscale("log")
        axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if axes is not size else (1.0,)))
        axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _at: f"{value:g}"))
        axes.xaxis.set_minor_formatter(NullFormatter())
    size.axvline(0.7e3 * least, color="0.7", linewidth=0.8)
    size.set_xlabel("peak to peak of the largest cycle, mrad (tick: mean; left of the line: at rest)")
    size.set_title(case, loc="left", fontsize="medium")
    pitch.set_xlabel("its frequency, Hz")
    cost.set_xlabel("static stiffness (filled), knock depth (open)")
    for axes in louder:
        axes.axvline(0.0, color="0.3", linewidth=0.8)
        axes.set_xlabel("louder, dB: to skin (filled), to ear (open)")
