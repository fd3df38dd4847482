"""Limit cycles drawn: settled ones in the phase plane and side by side, and every orbit, sized by its share.

In the phase plane the way in is faint and the cycle strong (Hasser, Fig. 72). Orbits are those of a few designs side by
side, or over one axis (Hasser, Fig. 68).
"""

from collections.abc import Sequence
from math import inf, pi
from typing import TYPE_CHECKING, Any

import numpy as np

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.grid import Row, axes_of, axis_label, nearest_rows
from hknob_cli.figures.numbers import mark_values, number
from hknob_cli.figures.panel import edges_between, key, scale_of
from hknob_cli.figures.recording import At, Of, Recording, one_recording, settled_period
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


ARROWS = 4  # along the cycle


@drawing
def phase_plane(
    evidence: ResultSet,
    of: Of,
    *,
    at: At | None = None,
    from_s: float | None = None,
    to_s: float | None = None,
    steady_s: float = 0.05,
    samples: bool = True,
    height: float = 4.0,
) -> "Figure":
    """Velocity (rad/s) over angle of one recording.

    The last ``steady_s`` (s) of the window are strong, what comes before faint; ``samples`` marks where the controller
    reads in the strong part. ``height`` in inches. Raises `MissingError`.
    """
    one = one_recording(evidence, of, at=at, from_s=from_s, to_s=to_s)
    begin = float(one.time[-1]) - steady_s
    steady = one.between(begin, None)
    if steady.time[0] == one.time[0]:
        raise MissingError(f"{steady_s:g} s of '{one.name}' are more than the window shown")
    unit = scale_of(one.angle)
    drawn = theme.figure(height, width=5.6)
    panel = drawn.subplots()
    before = one.time <= steady.time[0]
    panel.plot(
        unit.factor * one.angle[before], one.velocity[before], color="black", linewidth=0.8, alpha=0.45, label="way in"
    )
    panel.plot(unit.factor * steady.angle, steady.velocity, label="steady", **theme.series(0))
    if samples:
        dots: dict[str, Any] = {"color": theme.COLOURS[1], "marker": "o", "linestyle": "none", "markersize": 3.0}
        read = steady.samples
        panel.plot(unit.factor * steady.angle[read], steady.velocity[read], label="samples", **dots)
    _point(panel, steady, unit.factor)
    _rule(panel, one, unit.factor)
    panel.set_xlabel(f"angle, {unit.prefix}rad")
    panel.set_ylabel("velocity, rad/s")
    key(panel)
    return drawn


def _point(panel: "Axes", steady: Recording, factor: float) -> None:
    """Arrows in the direction of motion, at equal parts of one cycle."""
    peaks, _, up = steady.turns
    tops = peaks[up]
    if len(tops) < 2:
        return
    span = float(tops[1] - tops[0])
    for part in (np.arange(ARROWS) + 0.5) / ARROWS:
        times = tops[0] + span * (part + np.array([0.0, 0.02]))
        (x0, x1), (y0, y1) = (np.interp(times, steady.time, of) for of in (factor * steady.angle, steady.velocity))
        arrow: dict[str, Any] = {
            "arrowstyle": "-|>",
            "color": theme.COLOURS[0],
            "shrinkA": 0,
            "shrinkB": 0,
            "mutation_scale": 13,
        }
        panel.annotate("", (x1, y1), xytext=(x0, y0), arrowprops=arrow)


def _rule(panel: "Axes", one: Recording, factor: float) -> None:
    """The wall, shaded and with its edge dotted, and count edges; what is in view has a name in the key."""
    low, high = panel.get_xlim()
    if one.scene.wall.stiffness > 0.0:
        panel.axvspan(min(low, 0.0), 0.0, color="black", alpha=0.06, linewidth=0)
        name = "edge of the wall" if low < 0.0 < high else "_"
        panel.axvline(0.0, color="black", linewidth=1.1, linestyle=":", label=name)
    edges = edges_between(low, high, factor * one.quantum)
    for i, edge in enumerate(edges):
        name = "_" if i else "edge of a count"
        panel.axvline(edge, color="black", linewidth=0.8, alpha=0.6, linestyle=(0, (1, 2)), label=name)
    panel.set_xlim(low, high)


FLOOR_DB = 50.0  # below the strongest harmonic of all: fainter ones are not drawn


@drawing
def cycle_spectra(
    evidence: ResultSet,
    of: str | Sequence[str],
    *,
    names: Sequence[str] | None = None,
    at: At | None = None,
    shown_s: float = 0.05,
    highest_hz: float = 4000.0,
) -> "Figure":
    """Angle about its mean (mrad) over ``shown_s``, and the peak speed of each harmonic (mrad/s) up to ``highest_hz``.

    A row for each recording, which has settled to a proven cycle; all rows have the same scales. Harmonics fainter than
    the strongest of all by 50 dB are left out. Raises `MissingError`.
    """
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    from hknob_cli.recordings.spectrum import recorded_harmonics

    results = [of] if isinstance(of, str) else list(of)
    titles = list(names or results)
    if len(titles) != len(results):
        raise MissingError(f"{len(results)} recordings, but {len(titles)} names")
    periods = [settled_period(evidence, name, at=at) for name in results]
    motions = [recorded_harmonics(one.time, one.velocity, highest_hz=highest_hz) for one in periods]
    most = max(float(motion.speed_rad_s.max(initial=0.0)) for motion in motions)
    drawn = theme.figure(0.6 + 1.05 * len(results))
    panels = drawn.subplots(len(results), 2, squeeze=False, sharex="col", sharey="col", width_ratios=[1.25, 1.0])
    for i, ((left, right), title, one, motion) in enumerate(zip(panels, titles, periods, motions, strict=True)):
        length = one.time[-1] - one.time[0]
        repeats = int(np.ceil(shown_s / length)) + 1
        times = np.concatenate([one.time[:-1] - one.time[0] + k * length for k in range(repeats)])
        angles = np.tile(one.angle[:-1] - one.angle.mean(), repeats)
        left.plot(1e3 * times, 1e3 * angles, **{**theme.series(i), "linestyle": "-"})
        left.set_title(title, loc="left")
        kept = motion.speed_rad_s > most * 10.0 ** (-FLOOR_DB / 20.0)
        stems: dict[str, Any] = {"color": theme.COLOURS[i % len(theme.COLOURS)]}
        speed, floor = 1e3 * motion.speed_rad_s[kept], 1e3 * most * 10.0 ** (-FLOOR_DB / 20.0)
        right.vlines(motion.frequency_hz[kept], floor, speed, linewidth=0.9, **stems)
        right.plot(motion.frequency_hz[kept], speed, markersize=2.5, **{**theme.points(i), **stems})
    panels[0][0].set_xlim(0.0, 1e3 * shown_s)
    side = panels[0][1]
    side.set_xscale("log")
    side.set_yscale("log")
    side.set_xlim(10.0, highest_hz)
    side.xaxis.set_major_locator(LogLocator(subs=(1.0, 3.0)))
    side.xaxis.set_major_formatter(FuncFormatter(lambda value, _place: f"{value:g}"))
    side.xaxis.set_minor_formatter(NullFormatter())
    panels[-1][0].set_xlabel("time, ms")
    panels[-1][1].set_xlabel("frequency of the harmonic, Hz")
    drawn.supylabel("left: angle about its mean, mrad;  right: peak speed, mrad/s", fontsize=8)
    return drawn
