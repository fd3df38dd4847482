"""Every orbit, sized by its share: of a few designs side by side, and over one axis (Hasser, Fig. 68).

A few designs side by side: every orbit of each, by size and pitch (Hasser, sec. 10.5, Fig. 68).
"""

from math import inf, pi
from typing import TYPE_CHECKING

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.grid import Row, axes_of, axis_label, nearest_rows
from hknob_cli.figures.numbers import mark_values, number
from hknob_cli.report.table import short
from hknob_cli.results.columns import MEANS
from hknob_cli.results.result_set import MissingError, Result, ResultSet, Rows
from hknob_cli.specs.plan import COUNTS, RATE, Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SHORT = {"sample_rate_hz": "{} Hz", "counts_per_rev": "{} counts"}

_SIZES = ((0.75, 5.0, "three quarters or more of the trials"), (0.25, 3.4, "a quarter or more"), (0.0, 1.8, "fewer"))
_PANELS = {
    "frequency_hz": (1.0, "frequency, Hz"),
    "p2p_rad": (1e3, "peak to peak, mrad"),
    "period_samples": (1.0, "samples per cycle"),
}
_FEW = 8  # values of the axis that have a tick each
_RATIOS = (*range(2, 17), 18, *range(20, 60, 5), *range(60, 200, 20), 500, 1000)


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


@drawing
def staircase(
    evidence: ResultSet,
    of: str,
    *,
    over: str | None = None,
    at: Row | None = None,
    panels: tuple[str, ...] = ("frequency_hz", "p2p_rad"),
    unit_of_step: bool = False,
) -> "Figure":
    """Orbits over the axis ``over`` (by default the one that varies): frequency in Hz and peak to peak in mrad.

    Beside frequencies stand the samples per cycle, where all orbits have one sample rate.
    ``unit_of_step`` gives a bias torque in steps of the wall's torque between counts. ``at`` fixes further axes.
    Raises `MissingError`.
    """
    result = evidence[of]
    rows = [row for row in result.rows("orbits") if row["outcome"] == "cycle" and row["p2p_rad"] is not None]
    if not rows:
        raise MissingError(f"'{of}' has no limit cycle")
    rows = nearest_rows(rows, at)
    over = _one_axis(result, rows, over)
    steps = _steps(result.scene, rows, over) if unit_of_step else None
    factor, label = steps or (1.0, axis_label(result, over))
    figure = theme.figure(1.9 * len(panels) + 0.7)
    places = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    for axes, column in zip(places, panels, strict=True):
        _dots(axes, rows, over, column, factor)
        if column == "frequency_hz" and "period_samples" in rows[0]:
            _ratios(axes, rows)
    places[-1].set_xlabel(label)
    values = sorted({row[over] for row in rows})
    mark_values(places[-1], values, few=0 if steps else _FEW)
    handles, texts = places[0].get_legend_handles_labels()
    figure.legend(handles, texts, loc="outside lower center", ncols=3, title="share of the trials that reach the orbit")
    return figure


def _one_axis(result: Result, rows: Rows, over: str | None) -> str:
    """The axis asked for, else the one that varies, else the first. Raises `MissingError` where another varies, too."""
    names = axes_of(result, rows)
    varying = [name for name in names if len({row[name] for row in rows}) > 1]
    chosen = over or (varying or names)[0]
    if chosen not in names or set(varying) - {chosen}:
        raise MissingError(f"'{result.name}' varies over {', '.join(varying) or 'nothing'}: give 'over' and 'at'")
    return chosen


def _value(row: Row, column: str) -> float:
    if column == "period_samples":
        return float(row["period_samples"] / row["cycles_per_period"])
    return _PANELS[column][0] * float(row[column])


def _dots(axes: "Axes", rows: Rows, over: str, column: str, factor: float) -> None:
    above = inf
    for least, size, text in _SIZES:
        chosen = [row for row in rows if least <= row["basin_fraction"] < above]
        xs, ys = [factor * row[over] for row in chosen], [_value(row, column) for row in chosen]
        axes.plot(xs, ys, linestyle="none", marker="o", markersize=size, markeredgewidth=0, color=theme.COLOURS[0],
                  label=text)  # fmt: skip
        above = least
    axes.set_ylabel(_PANELS[column][1])
    axes.set_ylim(0.0, 1.12 * max(_value(row, column) for row in rows))


def _ratios(axes: "Axes", rows: Rows) -> None:
    """A second scale beside frequencies: samples per cycle, where all rows have one sample rate."""
    rates = {row.get(RATE) for row in rows}
    if len(rates) != 1 or None in rates:
        return
    rate = float(rates.pop() or 1.0)
    twin = axes.secondary_yaxis("right")
    low, high = axes.get_ylim()
    least = min(row["frequency_hz"] for row in rows)
    wanted = [rate / samples for samples in _RATIOS if 0.95 * least < rate / samples < high]
    places: list[float] = []
    for place in sorted(wanted, reverse=True):
        if not places or places[-1] - place > 0.09 * (high - low):
            places.append(place)
    twin.set_yticks(places, [f"{rate / place:g}" for place in places])
    twin.set_ylabel("samples per cycle")
    twin.spines["right"].set_visible(True)


def _steps(scene: Scene, rows: Rows, over: str) -> tuple[float, str] | None:
    """Factor from a torque to steps of the wall's torque, and the axis label; None for other axes."""
    if over != "bias.torque" or len({row.get(COUNTS) for row in rows}) != 1 or scene.gear:
        return None
    step = scene.wall.stiffness * 2.0 * pi / float(rows[0][COUNTS])
    return 1.0 / step, f"bias torque, in steps of the wall's torque (K\u0394\u03b8 = {1e3 * step:.4g} mN\u00b7m)"
