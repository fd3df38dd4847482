"""Identified persons over grip force: one with the spread of the blocks, and all of them (Hasser, Figs 9, 10)."""

from statistics import fmean, stdev
from typing import TYPE_CHECKING, Any

from hknob_cli.figures import drawing, theme
from hknob_cli.figures.grasp_panels import QUANTITIES, finish, identified_rows, label_of, printed_rows
from hknob_cli.results.result_set import Result, ResultSet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Line = list[tuple[float, float, float]]


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
