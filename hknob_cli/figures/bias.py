"""How far off the estimators are, and why: bias by its cause, and the finger that hides behind its pad.

The finger that hides behind its pad: inertia of a second-order fit, over the ratio of finger to pad (sec. 4.4.1).
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from hknob_cli.figures import drawing, theme
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
            _draw(panel, rows, cause, parameter, estimators)
        line[0].set_ylabel(f"{parameter}, %")
    for panel, cause in zip(panels[-1], causes, strict=True):
        _rule(panel, [CAUSES[cause][1] * row["level"] for row in rows if row["nuisance"] == cause])
        panel.set_xlabel(CAUSES[cause][0])
    drawn.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside upper left", ncols=4, handlelength=3.0)
    drawn.align_ylabels(panels[:, 0])
    return drawn


def _draw(panel: "Axes", rows: Rows, cause: str, parameter: str, estimators: Sequence[str]) -> None:
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
