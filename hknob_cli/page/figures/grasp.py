"""What a hand adds to a knob, over grip force: printed means and deviations (Hasser, Figs 11, 12, 18-21)."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from hknob_cli.page import ink
from hknob_cli.page.figures import drawing
from hknob_cli.results.evidence import Evidence, MissingError

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

# Columns of mean and standard deviation, symbol, unit, unit along the surface of the knob, factor to the unit.
_PANELS = (
    ("inertia_kg_m2", "inertia_std_kg_m2", "inertia J", "10\u207b\u2076 kg\u00b7m\u00b2", "kg", 1e6),
    ("damping_nm_s_per_rad", "damping_std_nm_s_per_rad", "damping B", "mN\u00b7m\u00b7s/rad", "N\u00b7s/m", 1e3),
    ("stiffness_nm_per_rad", "stiffness_std_nm_per_rad", "stiffness K", "N\u00b7m/rad", "N/m", 1.0),
    ("damping_ratio", "damping_ratio_std", "damping ratio \u03b6", "", "", 1.0),
)


@drawing
def grasp_parameters(
    _evidence: Evidence, _of: Any = None, *, tables: Sequence[int] = (1, 2, 3, 4, 5), translational: bool = False
) -> "Figure":
    """Inertia, damping, stiffness and damping ratio over grip force, of Tables 1-5: mean and standard deviation.

    Inertia is of hand and apparatus; a line marks the apparatus alone (Table 10). ``translational``: over the radius
    squared, as the fingertips meet it: kg, N·s/m, N/m. Raises `MissingError` for any other table.
    """
    from hknob_cli.printed.hands import apparatus_inertia

    drawn = ink.figure(5.6)
    panels = drawn.subplots(2, 2, sharex=True).ravel()
    for panel, (mean, std, symbol, unit, along, factor) in zip(panels, _PANELS, strict=True):
        for i, number in enumerate(tables):
            rows = _rows(number)
            moved = translational and bool(unit)
            scale = 1.0 / RADIUS[number] ** 2 if moved else factor
            # A little apart, so that error bars do not hide one another.
            force = [row["grip_n"] * 1.025 ** (i - 0.5 * (len(tables) - 1)) for row in rows]
            _draw_bars(panel, force, [row[mean] for row in rows], [row[std] for row in rows], scale, number)
        if mean == "inertia_kg_m2":
            scales = {number: 1.0 / RADIUS[number] ** 2 if translational else factor for number in tables}
            alone = dict.fromkeys(scales[number] * apparatus_inertia(number) for number in tables)
            for i, own in enumerate(alone):
                label = None if i else "apparatus alone"
                panel.axhline(own, color="black", linewidth=0.9, alpha=0.7, linestyle=(0, (6, 3)), label=label)
        shown = along if translational else unit
        panel.set_ylabel(f"{symbol}, {shown}" if shown else symbol)
        panel.set_ylim(bottom=0.0)
        _rule_forces(panel)
    for panel in panels[2:]:
        panel.set_xlabel("grip force, N")
    drawn.legend(*_told(panels[0]), loc="outside upper left", ncols=3, handlelength=3.0)
    drawn.set_layout_engine("constrained", w_pad=0.08)
    drawn.align_ylabels(list(panels))
    return drawn


@drawing
def normalised_grasp(_evidence: Evidence, _of: Any = None, *, tables: Sequence[int] = (1,)) -> "Figure":
    """Damping and stiffness over grip force, each divided by the middle of its range, mean and standard deviation.

    The middle is the mean of the least and the largest value, as in Fig. 12, whose other curves (Hajian, 1997) are not
    printed as numbers. Raises `MissingError` for any table but 1-5.
    """
    drawn = ink.figure(3.0)
    panels = drawn.subplots(1, 2, sharex=True, sharey=True)
    for panel, (mean, std, symbol, _, _, _) in zip(panels, _PANELS[1:3], strict=True):
        for number in tables:
            rows = _rows(number)
            force, values, spread = ([row[name] for row in rows] for name in ("grip_n", mean, std))
            middle = [x / _middle(force) for x in force]
            _draw_bars(panel, middle, values, spread, 1.0 / _middle(values), number)
        # What the same share of force and of the parameter would be.
        panel.axline((0.0, 0.0), slope=1.0, color="black", linewidth=0.8, alpha=0.6, linestyle=(0, (4, 2)))
        panel.annotate("in proportion", (1.0, 0.85), xytext=(4, -6), textcoords="offset points", fontsize=8)
        panel.set_xlabel("grip force / its middle, 1")
        panel.set_ylabel(f"{symbol} / its middle, 1")
        panel.set_xlim(0.0, 2.1)
        panel.set_ylim(0.0, 2.1)
    if len(tables) > 1:
        drawn.legend(*_told(panels[0]), loc="outside upper left", ncols=3)
    return drawn


def _middle(values: list[float]) -> float:
    return 0.5 * (min(values) + max(values))


def _rows(number: int) -> list[dict[str, Any]]:
    from hknob_cli.printed.tables import table

    if number not in GRASPS:
        raise MissingError(f"no grasps in table {number}; they are in tables {min(GRASPS)} to {max(GRASPS)}")
    return [dict(row) for row in table(number)]


def _draw_bars(
    panel: "Axes", force: list[float], mean: list[float], std: list[float], scale: float, number: int
) -> None:
    """One grasp, drawn alike in every figure; filled markers on the small knob, open ones on the larger, as printed."""
    filled = {} if RADIUS[number] < 10e-3 else {"markerfacecolor": "none"}
    style = ink.series(number - 1) | {"marker": ink.MARKERS[number - 1], "markersize": 4.5, **filled}
    panel.errorbar(
        force,
        [scale * value for value in mean],
        yerr=[scale * value for value in std],
        label=GRASPS[number],
        capsize=2.0,
        elinewidth=0.8,
        **style,
    )


def _rule_forces(panel: "Axes") -> None:
    from matplotlib.ticker import FixedFormatter, FixedLocator, NullLocator

    panel.set_xscale("log")
    panel.xaxis.set_major_locator(FixedLocator(TICKS))
    panel.xaxis.set_major_formatter(FixedFormatter([f"{force:g}" for force in TICKS]))
    panel.xaxis.set_minor_locator(NullLocator())


def _told(panel: "Axes") -> tuple[list[Any], list[str]]:
    """Entries of the key, the grasps before the line of the apparatus."""
    handles, labels = panel.get_legend_handles_labels()
    order = sorted(range(len(labels)), key=lambda i: labels[i] == "apparatus alone")
    return [handles[i] for i in order], [labels[i] for i in order]
