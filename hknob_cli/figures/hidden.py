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

    Ruled: the knob's own, and that of knob and finger together. Raises `MissingError`.
    """
    from matplotlib.ticker import FuncFormatter

    rows = evidence[of].rows("hidden_inertia")
    drawn = theme.figure(3.2)
    panel = drawn.subplots()
    for i, estimator in enumerate(dict.fromkeys(row["estimator"] for row in rows)):
        own = sorted((row for row in rows if row["estimator"] == estimator), key=lambda row: float(row["ratio"]))
        style = theme.series(i) | {"marker": theme.MARKERS[i], "markersize": 4.0}
        panel.plot(
            [row["ratio"] for row in own],
            [1e7 * row["inertia_kg_m2"] for row in own],
            label=NAMES.get(estimator, estimator),
            **style,
        )
    knob, finger = (1e7 * rows[0][f"{name}_inertia_kg_m2"] for name in ("knob", "finger"))
    rules = ((knob, "knob alone"), (knob + finger, "knob and finger"))
    for (level, name), dash in zip(rules, ((0, (6, 3)), (0, (1, 2))), strict=True):
        panel.axhline(level, color="black", linewidth=0.9, alpha=0.7, linestyle=dash, label=name)
    panel.axvline(ASSUMED, color="black", linewidth=0.7, alpha=0.4)
    panel.annotate(
        "as the text assumes",
        (ASSUMED, 0.85),
        xycoords=("data", "axes fraction"),
        xytext=(4, 0),
        textcoords="offset points",
        fontsize=8,
        va="top",
    )
    panel.set_xscale("log")
    panel.xaxis.set_major_formatter(FuncFormatter(lambda value, _place: f"{value:g}"))
    panel.set_xlabel("stiffness and damping of the finger / of its pad, 1")
    panel.set_ylabel("identified inertia, g\u00b7cm\u00b2")
    panel.legend(loc="center right", bbox_to_anchor=(1.0, 0.6))
    return drawn
