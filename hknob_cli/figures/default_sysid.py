"""The pictures that a page shows of an identification: of people, of bare knobs, of calibrations and of studies."""

from typing import Any

from hknob_cli.figures.planned_figure import planned
from hknob_cli.results.result_set import Result
from hknob_cli.specs.page_plan import FigurePlan

_WHOLE = ("inertia_kg_m2", "damping_nm_s_per_rad", "stiffness_nm_per_rad")
_PERSONS = "Every person over grip force: inertia of hand and apparatus, damping, stiffness, damping ratio."
_VALUES = "Every condition by every estimator; bars are the deviations and errors of the table."
_BIAS = "Mean estimate less truth, in per cent of the truth, over how much there is of each cause."


def sysid_figures(result: Result) -> list[FigurePlan]:
    """The pictures of all that there is. Raises `MissingError`."""
    figures = []
    if "conditions.parquet" in result.files:
        figures += _conditions(result)
    if "calibration_points.parquet" in result.files:
        quantities = {row["quantity"] for row in result.rows("calibration")}
        draw = "motor_calibration" if "torque constant" in quantities else "grip_cell"
        figures.append(planned(result, draw, "calibration", "Readings, and the straight lines fitted to them."))
    if "bias.parquet" in result.files:
        figures += _biases(result)
    if "hidden_inertia.parquet" in result.files:
        figures.append(planned(result, "hidden_inertia", "hidden inertia", "What second-order fits take for inertia."))
    return figures


def _conditions(result: Result) -> list[FigurePlan]:
    """Persons over grip force where there are several grips; every condition with its errors."""
    rows = result.rows("conditions")
    figures = []
    whole = [
        row
        for row in rows
        if row["level"] == "subject" and row["grip_target_n"] and all(row[name] is not None for name in _WHOLE)
    ]
    for experiment in dict.fromkeys(row["experiment"] for row in whole):
        best = next(row["estimator"] for row in reversed(whole) if row["experiment"] == experiment)
        if len({row["grip_target_n"] for row in whole if row["experiment"] == experiment}) > 1:
            options = {"experiment": experiment, "estimator": best, "printed": False}
            figures.append(planned(result, "all_persons", f"experiment {experiment} by {best}", _PERSONS, **options))
    if any(row[name] is not None for row in rows for name in row if name.endswith("inertia_kg_m2")):
        figures.append(planned(result, "identified_values", "what was identified", _VALUES))
    return figures


def _biases(result: Result) -> list[FigurePlan]:
    """Curves of each grip force, of the causes and parameters that the study has."""
    rows = result.rows("bias")
    figures = []
    for grip in dict.fromkeys(row["grip_n"] for row in rows):
        mine = [row for row in rows if row["grip_n"] == grip]
        causes = list(dict.fromkeys(row["nuisance"] for row in mine))
        there = {(row["nuisance"], row["parameter"]) for row in mine}
        parameters = [
            name
            for name in dict.fromkeys(row["parameter"] for row in mine)
            if all((cause, name) in there for cause in causes)
        ]
        options: dict[str, Any] = {"causes": causes, "parameters": parameters, "grip_n": grip}
        options["estimators"] = list(dict.fromkeys(row["estimator"] for row in mine))
        figures.append(planned(result, "bias_curves", f"bias at {grip:g} N", _BIAS, **options))
    return figures
