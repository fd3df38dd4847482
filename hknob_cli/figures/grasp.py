"""What a hand adds to a knob, over grip force: as printed and as identified, of grasps and of persons.

Identified persons over grip force: one with the spread of the blocks, and all of them (Hasser, Figs 9, 10).
"""

from collections.abc import Sequence
from statistics import fmean, stdev
from typing import TYPE_CHECKING, Any, NamedTuple

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.identification import APPARATUS, COLUMNS, rows_of
from hknob_cli.results.result_set import MissingError, Result, ResultSet, Rows

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

GRASPS = {
    1: "simple pinch, 17.8 mm",
    2: "key pinch, 17.8 mm",
    3: "simple pinch, 29.9 mm",
    4: "key pinch, 29.9 mm",
    5: "three fingers, 29.9 mm",
}
RADIUS = {1: 8.9e-3, 2: 8.9e-3, 3: 14.95e-3, 4: 14.95e-3, 5: 14.95e-3}  # of the knobs, m
TICKS = (0.7, 1.3, 2.4, 4.3, 7.8, 14.2)  # grip forces of the experiments, N, the first rounded
IDENTIFIED = "identified, of virtual people"
BESIDE = 1.07  # by which share identified values stand to the right of printed ones


class Quantity(NamedTuple):
    """Columns of mean and standard deviation as printed, symbol, unit, unit along the knob's surface, factor to it."""

    column: str
    printed_std: str
    symbol: str
    unit: str
    along: str
    factor: float


QUANTITIES = (
    Quantity("inertia_kg_m2", "inertia_std_kg_m2", "inertia J", "10\u207b\u2076 kg\u00b7m\u00b2", "kg", 1e6),
    Quantity(
        "damping_nm_s_per_rad",
        "damping_std_nm_s_per_rad",
        "damping B",
        "mN\u00b7m\u00b7s/rad",
        "N\u00b7s/m",
        1e3,
    ),
    Quantity("stiffness_nm_per_rad", "stiffness_std_nm_per_rad", "stiffness K", "N\u00b7m/rad", "N/m", 1.0),
    Quantity("damping_ratio", "damping_ratio_std", "damping ratio \u03b6", "", "", 1.0),
)


def scale_of(quantity: Quantity, number: int, *, translational: bool = False) -> float:
    """Factor from SI to what is drawn of a table's quantity; along the surface, over the squared radius."""
    return 1.0 / RADIUS[number] ** 2 if translational and quantity.unit else quantity.factor


def printed_rows(number: int) -> Rows:
    """Rows of a printed table of grasps. Raises `MissingError` for any other table."""
    from hknob_cli.printed import table

    if number not in GRASPS:
        raise MissingError(f"no grasps in table {number}; they are in tables {min(GRASPS)} to {max(GRASPS)}")
    return [dict(row) for row in table(number)]


def identified_rows(result: Result, file: str = "conditions", **asked: Any) -> Rows:
    """Fits by grip force, inertia of hand and apparatus together. Raises `MissingError` where there are none."""
    rows = rows_of(result, file, **asked)
    whole = [
        {**row, COLUMNS["inertia"]: row[COLUMNS["inertia"]] + (row.get(APPARATUS) or 0.0)}
        for row in rows
        if row["grip_target_n"] > 0.0
    ]
    return sorted(whole, key=lambda row: float(row["grip_target_n"]))


def draw_bars(
    panel: "Axes", force: list[float], mean: list[float], std: list[float], scale: float, number: int
) -> None:
    """One grasp, drawn alike in every figure; filled markers on the small knob, open ones on the larger, as printed."""
    filled = {} if RADIUS[number] < 10e-3 else {"markerfacecolor": "none"}
    style = theme.series(number - 1) | {"marker": theme.MARKERS[number - 1], "markersize": 4.5, **filled}
    panel.errorbar(
        force,
        [scale * value for value in mean],
        yerr=[scale * value for value in std],
        label=GRASPS[number],
        capsize=2.0,
        elinewidth=0.8,
        **style,
    )


def draw_identified(
    panel: "Axes", rows: Rows, column: str, scale: float, *, bars: bool = False, beside: float = BESIDE
) -> None:
    """Identified values as black crosses, with their standard deviations if ``bars``."""
    kept = [row for row in rows if row[column] is not None]
    panel.errorbar(
        [row["grip_target_n"] * beside for row in kept],
        [scale * row[column] for row in kept],
        yerr=[scale * (row[f"{column}_std"] or 0.0) for row in kept] if bars else None,
        label=IDENTIFIED,
        color="black",
        linestyle="none",
        marker="x",
        markersize=4.0,
        markeredgewidth=0.9,
        capsize=2.0,
        elinewidth=0.7,
    )


def rule_forces(panel: "Axes") -> None:
    """Grip forces of the experiments on a log axis."""
    from matplotlib.ticker import FixedFormatter, FixedLocator, NullLocator

    panel.set_xscale("log")
    panel.xaxis.set_major_locator(FixedLocator(TICKS))
    panel.xaxis.set_major_formatter(FixedFormatter([f"{force:g}" for force in TICKS]))
    panel.xaxis.set_minor_locator(NullLocator())


def finish(drawn: "Figure", panels: Sequence["Axes"], *, columns: int = 3) -> None:
    """Force axes, units, and the key of the first panel above all, a name once and the apparatus last."""
    for panel in panels:
        panel.set_ylim(bottom=0.0)
        rule_forces(panel)
    for panel in panels[2:]:
        panel.set_xlabel("grip force, N")
    drawn.legend(*told(panels[0]), loc="outside upper left", ncols=columns, handlelength=3.0)
    drawn.set_layout_engine("constrained", w_pad=0.08)
    drawn.align_ylabels(list(panels))


def told(panel: "Axes") -> tuple[list[Any], list[str]]:
    """Entries of the key: grasps as they come, then what was identified, then the apparatus; each once."""
    handles, labels = panel.get_legend_handles_labels()
    last = {IDENTIFIED: 1, "apparatus alone": 2}
    order = sorted(range(len(labels)), key=lambda i: last.get(labels[i], 0))
    once = [i for at, i in enumerate(order) if labels[i] not in [labels[j] for j in order[:at]]]
    return [handles[i] for i in once], [labels[i] for i in once]


def label_of(quantity: Quantity, *, translational: bool = False) -> str:
    """Label of an axis: symbol and unit."""
    shown = quantity.along if translational else quantity.unit
    return f"{quantity.symbol}, {shown}" if shown else quantity.symbol


Of = str | Sequence[str]

Line = list[tuple[float, float, float]]


@drawing
def grasp_parameters(
    evidence: ResultSet,
    of: Of = (),
    *,
    tables: Sequence[int] = (1, 2, 3, 4, 5),
    translational: bool = False,
    estimator: str = "output_error",
    bars: bool = False,
) -> "Figure":
    """Inertia, damping, stiffness and damping ratio over grip force, of Tables 1-5: mean and standard deviation.

    Inertia is of hand and apparatus; a line marks the apparatus alone (Table 10). ``translational``: over the radius
    squared, as the fingertips meet it: kg, N·s/m, N/m. ``of`` an identification: its means over persons by
    ``estimator`` are crosses beside the printed ones, with standard deviations if ``bars``. Raises `MissingError` for
    any other table, and where there are no such fits.
    """
    drawn = theme.figure(5.6)
    panels = list(drawn.subplots(2, 2, sharex=True).ravel())
    identified = {number: _means(evidence, of, number, estimator) for number in tables} if of else {}
    for panel, quantity in zip(panels, QUANTITIES, strict=True):
        for i, number in enumerate(tables):
            rows = printed_rows(number)
            scale = scale_of(quantity, number, translational=translational)
            # A little apart, so that error bars do not hide one another.
            aside = 1.025 ** (i - 0.5 * (len(tables) - 1))
            values = [row[quantity.column] for row in rows], [row[quantity.printed_std] for row in rows]
            draw_bars(panel, [row["grip_n"] * aside for row in rows], *values, scale, number)
            if number in identified:
                draw_identified(panel, identified[number], quantity.column, scale, bars=bars, beside=1.07 * aside)
        if quantity.column == "inertia_kg_m2":
            _rule_apparatus(panel, tables, translational=translational)
        panel.set_ylabel(label_of(quantity, translational=translational))
    finish(drawn, panels)
    return drawn


def _means(evidence: ResultSet, of: Of, number: int, estimator: str) -> list[dict[str, float]]:
    result = evidence[of if isinstance(of, str) else of[0]]
    return identified_rows(result, level="all", experiment=str(number), estimator=estimator)


def _rule_apparatus(panel: "Axes", tables: Sequence[int], *, translational: bool) -> None:
    from hknob_cli.printed import apparatus_inertia

    inertia = QUANTITIES[0]
    scales = {number: scale_of(inertia, number, translational=translational) for number in tables}
    for i, own in enumerate(dict.fromkeys(scales[number] * apparatus_inertia(number) for number in tables)):
        label = None if i else "apparatus alone"
        panel.axhline(own, color="black", linewidth=0.9, alpha=0.7, linestyle=(0, (6, 3)), label=label)


@drawing
def normalised_grasp(
    evidence: ResultSet, of: Of = (), *, tables: Sequence[int] = (1,), estimator: str = "output_error"
) -> "Figure":
    """Damping and stiffness over grip force, each divided by the middle of its range, mean and standard deviation.

    The middle is the mean of the least and the largest value, as in Fig. 12, whose other curves (Hajian, 1997) are not
    printed as numbers. ``of`` an identification: its means are crosses, over the middles of the printed ones. Raises
    `MissingError` for any table but 1-5.
    """
    drawn = theme.figure(3.0)
    panels = drawn.subplots(1, 2, sharex=True, sharey=True)
    for panel, quantity in zip(panels, QUANTITIES[1:3], strict=True):
        for number in tables:
            rows = printed_rows(number)
            force, values, spread = (
                [row[name] for row in rows] for name in ("grip_n", quantity.column, quantity.printed_std)
            )
            middle = [x / _middle(force) for x in force]
            draw_bars(panel, middle, values, spread, 1.0 / _middle(values), number)
            if of:
                found = _means(evidence, of, number, estimator)
                beside = 1.02 / _middle(force)
                draw_identified(panel, found, quantity.column, 1.0 / _middle(values), bars=True, beside=beside)
        # What the same share of force and of the parameter would be.
        panel.axline((0.0, 0.0), slope=1.0, color="black", linewidth=0.8, alpha=0.6, linestyle=(0, (4, 2)))
        panel.annotate("in proportion", (1.0, 0.85), xytext=(4, -6), textcoords="offset points", fontsize=8)
        panel.set_xlabel("grip force / its middle, 1")
        panel.set_ylabel(f"{quantity.symbol} / its middle, 1")
        panel.set_xlim(0.0, 2.1)
        panel.set_ylim(0.0, 2.1)
    if len(tables) > 1 or of:
        drawn.legend(*told(panels[0]), loc="outside upper left", ncols=3)
    return drawn


def _middle(values: list[float]) -> float:
    return 0.5 * (min(values) + max(values))


@drawing
def one_person(
    evidence: ResultSet, of: str, *, subject: str = "S1", experiment: str | int = 1, estimator: str = "output_error"
) -> "Figure":
    """Inertia, damping, stiffness and damping ratio of one person over grip force: mean, and deviation over blocks.

    Raises `MissingError` where there is no such person.
    """
    rows = identified_rows(evidence[of], "trials", subject=subject, experiment=str(experiment), estimator=estimator)
    drawn = theme.figure(4.8)
    panels = list(drawn.subplots(2, 2, sharex=True).ravel())
    for panel, quantity in zip(panels, QUANTITIES, strict=True):
        line = _over_blocks(rows, quantity.column)
        force, mean, spread = zip(*line, strict=True)
        panel.errorbar(
            force,
            [quantity.factor * value for value in mean],
            yerr=[quantity.factor * value for value in spread],
            label=f"{subject}, mean and standard deviation over blocks",
            marker="o",
            markersize=4.0,
            capsize=2.0,
            elinewidth=0.8,
            **theme.series(0),
        )
        panel.set_ylabel(label_of(quantity))
    finish(drawn, panels)
    return drawn


@drawing
def all_persons(
    evidence: ResultSet, of: str, *, experiment: str | int = 1, estimator: str = "output_error", printed: bool = True
) -> "Figure":
    """The same of every person of an experiment, a line each, with the printed mean of its table if ``printed``.

    Raises `MissingError` where there are none.
    """
    lines = _by_person(evidence[of], experiment, estimator)
    drawn = theme.figure(4.8)
    panels = list(drawn.subplots(2, 2, sharex=True).ravel())
    thin: dict[str, Any] = {"color": theme.COLOURS[0], "linewidth": 0.8, "alpha": 0.8, "marker": ".", "markersize": 3.0}
    for panel, quantity in zip(panels, QUANTITIES, strict=True):
        for i, rows in enumerate(lines.values()):
            kept = [row for row in rows if row[quantity.column] is not None]
            label = None if i else f"{len(lines)} people, a line each"
            force = [row["grip_target_n"] for row in kept]
            panel.plot(force, [quantity.factor * row[quantity.column] for row in kept], label=label, **thin)
        if printed:
            rows = printed_rows(int(experiment))
            values = [quantity.factor * row[quantity.column] for row in rows]
            wide: dict[str, Any] = {"color": "black", "linewidth": 1.4, "linestyle": (0, (4, 2))}
            panel.plot([row["grip_n"] for row in rows], values, label=f"printed mean, Table {experiment}", **wide)
        panel.set_ylabel(label_of(quantity))
    finish(drawn, panels)
    return drawn


def _by_person(result: Result, experiment: str | int, estimator: str) -> dict[str, list[dict[str, Any]]]:
    found: dict[str, list[dict[str, Any]]] = {}
    for row in identified_rows(result, level="subject", experiment=str(experiment), estimator=estimator):
        found.setdefault(row["subject"], []).append(row)
    return found


def _over_blocks(rows: list[dict[str, Any]], column: str) -> Line:
    """Grip force, mean and standard deviation over blocks (0 of a single one), by force."""
    groups: dict[float, list[float]] = {}
    for row in rows:
        if row[column] is not None:
            groups.setdefault(row["grip_target_n"], []).append(row[column])
    return [
        (force, fmean(values), stdev(values) if len(values) > 1 else 0.0) for force, values in sorted(groups.items())
    ]
