"""Panels of inertia, damping, stiffness and damping ratio over grip force: what the pictures of grasps share."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from hknob_cli.figures import theme
from hknob_cli.figures.identification import APPARATUS, COLUMNS, rows_of
from hknob_cli.results.result_set import MissingError, Result, Rows

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
    from hknob_cli.printed.tables import table

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
