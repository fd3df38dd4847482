"""What was identified, a row a condition and estimator: every parameter with its error, of hands and of bare knobs."""

from typing import TYPE_CHECKING, NamedTuple

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.bias import NAMES
from hknob_cli.report.table import short
from hknob_cli.results.result_set import MissingError, ResultSet, Rows

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

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
