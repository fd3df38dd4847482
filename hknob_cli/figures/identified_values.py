"""What was identified, with its error, and how far off the estimators are, by its cause.

The finger that hides behind its pad: inertia of a second-order fit, over the ratio of finger to pad (sec. 4.4.1).
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from hknob_cli.figures import drawing, theme
from hknob_cli.report.table import short
from hknob_cli.results.result_set import MissingError, ResultSet, Rows

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

NAMES = {
    "least_squares": "least squares",
    "least_squares_friction": "least squares with friction",
    "output_error": "output error",
    "output_error_friction": "output error with friction",
}
CAUSES = {
    "noise_rad": ("angle noise, mrad", 1e3),
    "coulomb_nm": ("friction, mN\u00b7m", 1e3),
    "lag_s": ("lag, \u00b5s", 1e6),
    "counts_per_rev": ("counts per revolution, 10\u00b3", 1e-3),
    "decimation": ("smoothing factor", 1.0),
}
LINEAR_PERCENT = 1.0  # up to which the scale of the bias is linear, beyond it logarithmic

ASSUMED = 10.0  # section 4.4.1: K1 = 10 K2, B1 = 10 B2


@drawing
def bias_curves(
    evidence: ResultSet,
    of: str,
    *,
    grip_n: float = 0.71,
    causes: Sequence[str] = ("noise_rad", "coulomb_nm", "lag_s", "decimation"),
    parameters: Sequence[str] = ("inertia", "damping", "stiffness"),
    estimators: Sequence[str] = ("least_squares", "output_error", "output_error_friction"),
) -> "Figure":
    """Bias (%) of each parameter, a row each, over each cause, a column each, a line an estimator; at one grip.

    Bars are standard deviations. Raises `MissingError` where the study has no such grip, cause or parameter.
    """
    rows = [row for row in evidence[of].rows("bias") if abs(row["grip_n"] - grip_n) < 1e-6]
    drawn = theme.figure(0.8 + 1.45 * len(parameters))
    panels = drawn.subplots(len(parameters), len(causes), squeeze=False, sharex="col", sharey="row")
    for line, parameter in zip(panels, parameters, strict=True):
        for panel, cause in zip(line, causes, strict=True):
            _draw_bias(panel, rows, cause, parameter, estimators)
        line[0].set_ylabel(f"{parameter}, %")
    for panel, cause in zip(panels[-1], causes, strict=True):
        _rule(panel, [CAUSES[cause][1] * row["level"] for row in rows if row["nuisance"] == cause])
        panel.set_xlabel(CAUSES[cause][0])
    drawn.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside upper left", ncols=4, handlelength=3.0)
    drawn.align_ylabels(panels[:, 0])
    return drawn


def _draw_bias(panel: "Axes", rows: Rows, cause: str, parameter: str, estimators: Sequence[str]) -> None:
    from matplotlib.ticker import FuncFormatter

    if cause not in CAUSES:
        raise MissingError(f"no cause {cause}; there are {', '.join(CAUSES)}")
    found = [row for row in rows if (row["nuisance"], row["parameter"]) == (cause, parameter)]
    if not found:
        raise MissingError(f"the study has no bias of the {parameter} by {cause} at this grip")
    for i, estimator in enumerate(estimators):
        own = [row for row in found if row["estimator"] == estimator]
        style: dict[str, Any] = theme.series(i) | {"marker": theme.MARKERS[i], "markersize": 3.5}
        panel.errorbar(
            [CAUSES[cause][1] * row["level"] for row in own],
            [row["bias_percent"] for row in own],
            yerr=[row["std_percent"] for row in own],
            label=NAMES.get(estimator, estimator),
            elinewidth=0.7,
            **style,
        )
    panel.axhline(0.0, color="black", linewidth=0.7, alpha=0.6)
    panel.set_yscale("symlog", linthresh=LINEAR_PERCENT)
    panel.yaxis.set_major_formatter(FuncFormatter(_signed))


def _signed(value: float, _place: int) -> str:
    return f"{value:+g}".replace("-", "\N{MINUS SIGN}") if value else "0"


def _rule(panel: "Axes", levels: list[float]) -> None:
    """Ticks at the levels; a linear stretch at the left where one of them is 0."""
    from matplotlib.ticker import NullLocator

    some = sorted(set(levels))
    positive = [level for level in some if level > 0.0]
    if positive and some[0] == 0.0:
        panel.set_xscale("symlog", linthresh=positive[0], linscale=0.5)
        panel.set_xlim(-0.2 * positive[0], 1.4 * positive[-1])
    elif positive:
        panel.set_xscale("log")
    panel.set_xticks(some, [f"{level:g}" for level in some], rotation=45)
    panel.xaxis.set_minor_locator(NullLocator())


@drawing
def hidden_inertia(evidence: ResultSet, of: str) -> "Figure":
    """Inertia (g·cm²) that second-order fits find, over the stiffness of the finger beside its pad's, a line a fit.

    Ruled: the knob's own, and that of knob and finger together. At the right, on a log scale, what of it is beyond the
    knob's own; dotted J1/(1 + r)^2, of a finger that moves 1/(1 + r) of what the knob does. Raises `MissingError`.
    """
    import numpy as np
    from matplotlib.ticker import FuncFormatter

    rows = evidence[of].rows("hidden_inertia")
    knob, finger = (1e7 * rows[0][f"{name}_inertia_kg_m2"] for name in ("knob", "finger"))
    ratios = np.geomspace(min(row["ratio"] for row in rows), max(row["ratio"] for row in rows), 60)
    drawn = theme.figure(3.4)
    panels = drawn.subplots(1, 2, sharex=True)
    for panel, less in zip(panels, (0.0, knob), strict=True):
        for i, estimator in enumerate(dict.fromkeys(row["estimator"] for row in rows)):
            own = sorted((row for row in rows if row["estimator"] == estimator), key=lambda row: float(row["ratio"]))
            style = theme.series(i) | {"marker": theme.MARKERS[i], "markersize": 4.0}
            values = [1e7 * row["inertia_kg_m2"] - less for row in own]
            panel.plot([row["ratio"] for row in own], values, label=NAMES.get(estimator, estimator), **style)
        law = knob - less + finger / (1.0 + ratios) ** 2
        panel.plot(ratios, law, color="black", linewidth=1.0, linestyle=":", label="knob + finger / (1 + ratio)\u00b2")
        panel.axvline(ASSUMED, color="black", linewidth=0.7, alpha=0.4)
        panel.set_xscale("log")
        panel.xaxis.set_major_formatter(FuncFormatter(lambda value, _place: f"{value:g}"))
        panel.set_xlabel("stiffness and damping of the finger / of its pad, 1")
    for level, name in ((knob, "knob alone"), (knob + finger, "knob and finger")):
        panels[0].axhline(level, color="black", linewidth=0.9, alpha=0.7, linestyle=(0, (6, 3)))
        panels[0].annotate(name, (0.98, level), xycoords=("axes fraction", "data"), xytext=(0, 3), ha="right",
                           textcoords="offset points", fontsize=8)  # fmt: skip
    panels[0].margins(y=0.12)
    panels[0].annotate("as the text assumes", (ASSUMED, 0.85), xycoords=("data", "axes fraction"), xytext=(4, 0),
                       textcoords="offset points", fontsize=8, va="top")  # fmt: skip
    panels[0].set_ylabel("identified inertia, g\u00b7cm\u00b2")
    panels[1].set_ylabel("of it beyond the knob's own, g\u00b7cm\u00b2")
    panels[1].set_yscale("log")
    drawn.legend(*panels[0].get_legend_handles_labels(), loc="outside upper left", ncols=3)
    return drawn


MOST = 30  # rows


class _Parameter(NamedTuple):
    """A column, how it is written, and the factor from SI."""

    column: str
    label: str
    factor: float


_PARAMETERS = (
    _Parameter("inertia_kg_m2", "inertia, g\u00b7cm\u00b2", 1e7),
    _Parameter("damping_nm_s_per_rad", "damping,\nmN\u00b7m\u00b7s/rad", 1e3),
    _Parameter("stiffness_nm_per_rad", "stiffness,\nN\u00b7m/rad", 1.0),
    _Parameter("damping_ratio", "damping\nratio", 1.0),
    _Parameter("coulomb_nm", "friction,\nmN\u00b7m", 1e3),
    _Parameter("finger_inertia_kg_m2", "finger: inertia,\ng\u00b7cm\u00b2", 1e7),
    _Parameter("finger_damping_nm_s_per_rad", "finger: damping,\nmN\u00b7m\u00b7s/rad", 1e3),
    _Parameter("finger_stiffness_nm_per_rad", "finger: stiffness,\nN\u00b7m/rad", 1.0),
    _Parameter("pad_damping_nm_s_per_rad", "pad: damping,\nmN\u00b7m\u00b7s/rad", 1e3),
    _Parameter("pad_stiffness_nm_per_rad", "pad: stiffness,\nN\u00b7m/rad", 1.0),
)
_ACROSS = 5


@drawing
def identified_values(evidence: ResultSet, of: str) -> "Figure":
    """Every parameter of every condition, with its error, a panel a parameter; bars are those of conditions.parquet.

    Conditions are means over persons where there are several, else those of the one person, or of each bare knob. Of
    more than 30 rows the first are drawn. Raises `MissingError` where nothing was identified.
    """
    rows = evidence[of].rows("conditions")
    people = {row["subject"] for row in rows if row["level"] == "subject"}
    held = any(row["grip_target_n"] for row in rows)
    level = "all" if held and len(people) > 1 else "subject"
    chosen = [row for row in rows if row["level"] == level] or rows
    parameters = [one for one in _PARAMETERS if any(row.get(one.column) is not None for row in chosen)]
    if not parameters:
        raise MissingError(f"nothing was identified in '{of}'")
    shown = chosen[:MOST]
    lines = 1 + (len(parameters) - 1) // _ACROSS
    across = min(_ACROSS, len(parameters))
    figure = theme.figure((0.22 * len(shown) + 1.0) * lines + 0.2)
    panels = figure.subplots(lines, across, sharey=True, squeeze=False).ravel()
    for panel, one in zip(panels, parameters, strict=False):
        _draw(panel, one, shown)
    for panel in panels[len(parameters) :]:
        panel.set_axis_off()
    names = [_name(row, chosen) for row in reversed(shown)]
    panels[0].set_yticks(range(len(shown)), names, fontsize=7.5)
    panels[0].set_ylim(-0.6, len(shown) - 0.4)
    if len(shown) < len(chosen):
        figure.supxlabel(f"the first {len(shown)} of {len(chosen)} conditions", fontsize=8)
    return figure


def _draw(panel: "Axes", one: _Parameter, rows: Rows) -> None:
    """A parameter of each row, the first uppermost, with its error."""
    known = [(y, row) for y, row in enumerate(reversed(rows)) if row.get(one.column) is not None]
    values = [one.factor * row[one.column] for _, row in known]
    errors = [one.factor * (row[f"{one.column}_std"] or 0.0) for _, row in known]
    style = theme.points(0) | {"markersize": 4.5}
    panel.errorbar(values, [y for y, _ in known], xerr=errors, capsize=2.0, elinewidth=0.8, **style)
    panel.set_xlabel(one.label)
    panel.locator_params(axis="x", nbins=4)
    panel.tick_params(axis="x", labelsize=7.5)
    panel.margins(x=0.15)
    if values and all(value >= 0.0 for value in values):
        panel.set_xlim(0.0, 1.12 * max(map(sum, zip(values, errors, strict=True))) or 1.0)


def _name(row: dict[str, str | float | None], rows: Rows) -> str:
    """A condition by what tells it from the others: experiment, subject, grip, estimator."""
    parts = {
        "experiment": f"{row['experiment']}" if row["experiment"] else "",
        "subject": str(row["subject"] or ""),
        "grip_target_n": f"{short(float(row['grip_target_n'] or 0.0))} N" if row["grip_target_n"] else "",
        "estimator": NAMES.get(str(row["estimator"]), str(row["estimator"]).replace("_", " ")),
    }
    telling = [text for key, text in parts.items() if text and (len({one[key] for one in rows}) > 1)]
    return ", ".join(telling) or parts["estimator"]
