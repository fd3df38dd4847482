"""The finger that hides behind its pad: inertia of a second-order fit, over the ratio of finger to pad (sec. 4.4.1)."""

from typing import TYPE_CHECKING

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.bias import NAMES
from hknob_cli.results.result_set import ResultSet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ASSUMED = 10.0  # section 4.4.1: K1 = 10 K2, B1 = 10 B2


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
