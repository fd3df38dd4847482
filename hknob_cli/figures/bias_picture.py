"""The picture of the estimators' bias: parameters by causes, a line for each estimator and grip."""

from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from hknob_cli.figures.estimators import COLOURS, MARKERS, NAMES
from hknob_cli.figures.sheet import save
from hknob_cli.report.study import NUISANCES, PARAMETERS, Row

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_STYLES: tuple[Literal["-", "--", ":", "-."], ...] = ("-", "--", ":", "-.")
_SMALL_PERCENT = 1.0  # below this the scale of the bias is linear


def draw_bias(rows: list[Row], *, title: str, path: Path) -> None:
    """Draw into ``path`` (PNG); bars are standard deviations. Raises `ComputationError` if it cannot be written."""
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

    causes = list(dict.fromkeys(row["nuisance"] for row in rows))
    grips = list(dict.fromkeys(row["grip_n"] for row in rows))
    estimators = list(dict.fromkeys(row["estimator"] for row in rows))
    parameters = PARAMETERS[:3]
    figure = Figure(figsize=(1.6 + 2.9 * len(causes), 8.6), layout="constrained")
    panels = figure.subplots(len(parameters), len(causes), sharex="col", sharey="row", squeeze=False)
    for line, parameter in zip(panels, parameters, strict=True):
        for axes, cause in zip(line, causes, strict=True):
            of_panel = [row for row in rows if (row["nuisance"], row["parameter"]) == (cause, parameter)]
            for estimator in estimators:
                for grip, style in zip(grips, _STYLES * len(grips), strict=False):
                    of_line = [row for row in of_panel if (row["estimator"], row["grip_n"]) == (estimator, grip)]
                    _line(axes, of_line, NUISANCES[cause][1], estimator, style)
            axes.axhline(0.0, color="0.4", linewidth=0.8, zorder=0)
            axes.set_yscale("symlog", linthresh=_SMALL_PERCENT)
            axes.yaxis.set_major_formatter(lambda value, _place: f"{value:+g}" if value else "0")
            axes.grid(alpha=0.3)
        line[0].set_ylabel(f"bias of the {parameter}, %")
    for axes, cause in zip(panels[-1], causes, strict=True):
        _scale(axes, [NUISANCES[cause][1] * row["level"] for row in rows if row["nuisance"] == cause], cause)
        axes.set_xlabel(NUISANCES[cause][0].replace("*", "·"))
    handles = [Line2D([], [], color=COLOURS[one], marker=MARKERS[one], label=NAMES[one]) for one in estimators]
    handles += [
        Line2D([], [], color="0.3", linestyle=style, label=f"grip {grip:g} N")
        for grip, style in zip(grips, _STYLES * len(grips), strict=False)
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), frameon=False)
    figure.suptitle(f"{title}: mean error of each estimate and its standard deviation, one cause at a time")
    save(figure, path, stage="sysid", name=title)


def _line(axes: "Axes", rows: list[Row], scale: float, estimator: str, style: str) -> None:
    axes.errorbar(
        [scale * row["level"] for row in rows],
        [row["bias_percent"] for row in rows],
        [row["std_percent"] for row in rows],
        color=COLOURS[estimator],
        marker=MARKERS[estimator],
        markersize=4,
        linestyle=style,
        linewidth=1.2,
        elinewidth=0.8,
        alpha=0.9,
    )


def _scale(axes: "Axes", levels: list[float], cause: str) -> None:
    """A log axis, with 0 at its left; of the encoder the fine end is left, so that all get worse to the right."""
    some = sorted({level for level in levels if level > 0.0})
    if 0.0 in levels and some:
        axes.set_xscale("symlog", linthresh=some[0], linscale=0.5)
        axes.set_xlim(-0.15 * some[0], 1.5 * some[-1])
    elif len(some) > 1:
        axes.set_xscale("log")
    if cause == "counts_per_rev":
        axes.invert_xaxis()
    ticks: list[Any] = sorted(set(levels))
    axes.set_xticks(ticks, [f"{tick:,.0f}" if tick >= 1e4 else f"{tick:g}" for tick in ticks], rotation=45)
    axes.xaxis.set_minor_locator(_none())


def _none() -> Any:
    from matplotlib.ticker import NullLocator

    return NullLocator()
