"""The pictures that a page shows of each kind of result, in each of its shapes, where its spec lists no chapters.

A figure of one result as a page plans it: its anchor, title and caption.

The pictures that a page shows of an identification: of people, of bare knobs, of calibrations and of studies.
"""

from typing import Any

import pyarrow.compute as pc

from hknob_cli.figures.campaign import MOST
from hknob_cli.figures.cell_dots import MOST as MOST_DOTS
from hknob_cli.figures.grid import MOST_WRITTEN
from hknob_cli.figures.theory import is_kb
from hknob_cli.figures.what_matters import can_tell
from hknob_cli.report.large import varying
from hknob_cli.report.sweep_words import perceived_levels
from hknob_cli.results.columns import differs
from hknob_cli.results.result_set import CAMPAIGN, Result
from hknob_cli.specs.plan import PERSON
from hknob_cli.specs.stage_plans import FigurePlan, Sentence

_WHOLE = ("inertia_kg_m2", "damping_nm_s_per_rad", "stiffness_nm_per_rad")
_PERSONS = "Every person over grip force: inertia of hand and apparatus, damping, stiffness, damping ratio."
_VALUES = "Every condition by every estimator; bars are the deviations and errors of the table."
_BIAS = "Mean estimate less truth, in per cent of the truth, over how much there is of each cause."
MOST_CASES = 8  # of a trial of remedies that have a picture each
_NOTICED = "Of the most noticeable orbit of each cell, against published thresholds."
_MEAN = "Mean of the trials of a cell that cycle, where others than the largest cycle attract, too."
_WORST = "Of the largest cycle of each cell; cells where trials come to rest or stay undecided say so."
_PEOPLE = "How many people have at most so large a limit cycle, and, of those for whom it buzzes, so high a pitch."
_BASINS = "In the colour of the cycle that a start ends in; dots are samples of the cycles."
_ATTRACTORS = "The range of the angle in each, its size and pitch, and the share of the trials that end there."
_ORBITS = "A dot for each orbit, sized by its share of the trials."
_LINES = "A cell at rest is at 0."
_ROWS = "A row a cell."
_SHARES = "How many of the cells, in per cent, have at most so large a value."
_TRIALS = "Of the trial of each cell that buzzes most; a trial without a sustained buzz is at rest."
_MATTERS = "The axes, the one that explains most of the size of limit cycles first."
_LARGEST = "Of several cycles in a cell the largest."
_AGAINST = "Difference of the peak to peak from that of the sweep, in per cent of the sweep's."
_PITCHES = "Difference of the frequency from that of the sweep, in per cent of the sweep's."
_PLANE = "Where the wall is passive in any hand, and stable in this one."
_CASE = "A marker a hand; the remedy that leaves least, of the hand that it helps least, is uppermost."
_TRIED = (
    "Dots are medians over the cells that buzz, lines reach from the least to the largest: filled as measured, hollow "
    "as computed. The remedy with the smallest buzz is uppermost."
)
_REMEDIES = "Over all cells and hands: dots are medians, lines reach from the least to the largest."
_DESIGNS = "Left and low is better. The line joins the designs that nothing as cheap and as stiff is felt less than."


def planned(result: Result, draw: str, what: str, caption: str, **options: Any) -> FigurePlan:
    """The plan of a drawing of a result; ``what`` it shows names it, so that no two figures are alike in that."""
    slug = "".join(letter if letter.isalnum() else "-" for letter in f"{result.name}-{what}".lower()).strip("-")
    title = f"{result.name}: {what}"
    return FigurePlan(f"fig-{slug}", draw, (result.name,), options, title, Sentence(caption), title)


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


def figures_of(result: Result) -> tuple[FigurePlan, ...]:
    """The pictures of a result, at least one where it has any row. Raises `MissingError`."""
    kinds = {
        "sweep": _sweep,
        "dfa": lambda one: _analysis(one, "dfa", "method", _LARGEST),
        "predict": lambda one: _analysis(one, "predict", "law", ""),
        "remedies": _remedies,
        "design": _design,
        "bench": _bench,
        "sysid": sysid_figures,
        CAMPAIGN: _campaign,
    }
    return tuple(kinds[result.stage](result)) if result.stage in kinds else ()


def _wide(result: Result, file: str) -> list[str]:
    """Axes with several values."""
    if large := result.parted(file):
        return varying(large, result.axes)
    table = result.table(file)
    return [axis for axis in result.axes if len(set(table.column(axis).to_pylist())) > 1]


def _is_map(result: Result, wide: list[str]) -> bool:
    """Whether a result is a map over two axes: these vary, and every combination of them is a cell."""
    return len(wide) == 2 and not result.is_design


def _sweep(result: Result) -> list[FigurePlan]:
    wide = _wide(result, "cells")
    columns = result.columns("cells")
    if PERSON in result.axes:
        figures = [planned(result, "population", "people", _PEOPLE)]
    elif "growth_j_per_s2" in columns:
        figures = _grown(result, wide)
    elif not wide and "orbits.parquet" not in result.files:
        figures = [_every_cell(result, "cells")]
    elif not wide:
        figures = [planned(result, "attractors", "every attractor", _ATTRACTORS)]
    elif _is_map(result, wide):
        figures = _maps(result, _WORST)
    elif len(wide) == 1:
        figures = _over_one_axis(result)
    else:
        figures = _over_many(result, "what matters", {})
    if "basins.parquet" in result.files:
        figures.append(planned(result, "basins", "where each start ends", _BASINS))
    if "trajectories.parquet" in result.files:
        figures.append(planned(result, "time_response", "motion", "Angle and torque over time."))
    return figures


def _grown(result: Result, wide: list[str]) -> list[FigurePlan]:
    """Growth over the grid, and as lines with the standard error of the mean (Hasser, Figs 29, 30)."""
    column = {"column": "growth_j_per_s2"}
    figures = []
    lines = len(wide) == 1 or _is_map(result, wide)
    if len(wide) != 1:
        draw = "grid_map" if lines else "cell_dots"
        figures = [planned(result, draw, "growth of energy", "Mean of the trials.", **column)]
    if lines:
        error = {"error": "growth_std_j_per_s2", "trials": "growth_fits"}
        figures.append(planned(result, "grid_lines", "growth by axis", "Bars are standard errors.", **column, **error))
    return figures


def _maps(result: Result, caption: str) -> list[FigurePlan]:
    """Maps of the largest cycle, which have the means written in or beside them, and of the levels."""
    rows = result.rows("cells")
    figures = [
        planned(result, "grid_map", "peak to peak", caption, column="p2p_max_rad"),
        planned(result, "grid_map", "frequency", caption, column="frequency_at_max_hz"),
    ]
    if differs(rows) and max(len({row[axis] for row in rows}) for axis in result.axes) > MOST_WRITTEN:
        figures.append(planned(result, "grid_map", "mean peak to peak", _MEAN, column="p2p_rad"))
    return figures + [
        planned(result, "grid_map", level.head.removesuffix(" dB"), _NOTICED, column=level.column, log=False)
        for level in perceived_levels(rows)
    ]


def _over_one_axis(result: Result) -> list[FigurePlan]:
    orbits = result.rows("orbits") if "orbits.parquet" in result.files else []
    cycles = any(row["outcome"] == "cycle" and row["p2p_rad"] for row in orbits)
    levels = perceived_levels(result.rows("cells"))
    return [
        planned(result, "staircase", "every orbit", _ORBITS)
        if cycles
        else planned(result, "axis_lines", "peak to peak and frequency", _LINES),
        *(
            planned(result, "axis_lines", level.head.removesuffix(" dB"), _NOTICED, column=level.column)
            for level in levels
        ),
    ]


def _over_many(result: Result, what: str, where: dict[str, Any]) -> list[FigurePlan]:
    """What matters, where enough cells tell; every cell, where they are few or nothing else is drawn."""
    figures = []
    if can_tell(result, where):
        figures = [planned(result, "what_matters", what, _MATTERS, **({"where": where} if where else {}))]
    large = result.parted("cells")
    if not figures or (not large and result.table("cells").num_rows <= MOST_DOTS):
        figures.append(_every_cell(result, "cells"))
    return figures


def _every_cell(result: Result, file: str) -> FigurePlan:
    if result.parted(file):
        few = False
    else:
        axes = [result.table(file).column(axis).to_pylist() for axis in result.axes]
        few = len(set(zip(*axes, strict=True))) <= MOST_DOTS
    return planned(result, "cell_dots", "every cell", _ROWS if few else _SHARES)


def _analysis(result: Result, file: str, choice: str, caption: str) -> list[FigurePlan]:
    """Sizes and pitches by method or law, and what they differ from the sweep that they are compared with."""
    wide = _wide(result, file)
    names = list(dict.fromkeys(result.table(file).column(choice).to_pylist()))
    compared = "p2p_difference" in result.columns(file)
    if len(wide) == 1:
        return [planned(result, "axis_lines", "peak to peak and frequency", _LINES)]
    if not _is_map(result, wide):
        telling = [name for name in names if len(wide) > 1 and can_tell(result, {choice: name})]
        figures = [
            planned(result, "what_matters", f"what matters by {name}", _MATTERS, where={choice: name})
            for name in telling
        ]
        return figures or [_every_cell(result, file)]
    figures = (
        [planned(result, "kb_plane", "stiffness over damping", _PLANE)] if file == "predict" and is_kb(wide) else []
    )
    for name in names:
        by = {"where": {choice: name}}
        figures.append(planned(result, "grid_map", f"peak to peak by {name}", caption, column="p2p_rad", **by))
        if any(result.table(file).filter(pc.field(choice) == name)["frequency_hz"].is_valid().to_pylist()):
            figures.append(planned(result, "grid_map", f"frequency by {name}", caption, column="frequency_hz", **by))
        if compared:
            for what, column in (("", "p2p_difference"), ("frequency by ", "frequency_difference")):
                options = {"column": column, "scale": 100.0, "label": "difference, % of the sweep", "log": False}
                title = f"{what}{name} against the sweep"
                figures.append(planned(result, "grid_map", title, _AGAINST if not what else _PITCHES, **options, **by))
    return figures


def _remedies(result: Result) -> list[FigurePlan]:
    return [*cases_of(result), planned(result, "remedy_grid", "over the grid", _REMEDIES)]


def cases_of(result: Result) -> list[FigurePlan]:
    """Pictures of the first cases of a trial of remedies. Raises `MissingError`."""
    cases = list(dict.fromkeys(result.table("cases").column("case").to_pylist()))
    felt = "touch_change_db" in result.columns("cases")
    return [
        planned(result, "remedy_dots", f"at {case}", _CASE, case=case, **({"felt": True} if felt else {}))
        for case in cases[:MOST_CASES]
    ]


def _design(result: Result) -> list[FigurePlan]:
    return [planned(result, "design_costs", "cost against touch", _DESIGNS)]


def _bench(result: Result) -> list[FigurePlan]:
    return [
        planned(result, "error_time", "error against run time", "Left and low is better."),
        planned(result, "stability_table", "verdicts", "What each method made of each scene."),
    ]


def tried_of(result: Result) -> list[FigurePlan]:
    """The picture of the remedies that a campaign tried. Raises `MissingError`."""
    options = {"reference": result.reference}
    return [planned(result, "remedies_tried", "remedies, as measured and as computed", _TRIED, **options)]


def _campaign(result: Result) -> list[FigurePlan]:
    if result.has_pulses:
        key = result.table("samples").slice(0, 1).to_pylist()[0]
        options = {name: key[name] for name in ("subject", "experiment")}
        return [planned(result, "trial_thumbnails", "every pulse", "A panel a grip force.", **options)]
    if result.has_remedies:
        figures = tried_of(result)
        if "samples.parquet" in result.files and _few(result):
            motion = f"motion, {result.reference}"
            text = "The end of each trial of the reference."
            figures.append(planned(result, "campaign_thumbnails", motion, text, remedy=result.reference))
        return figures
    wide = _wide(result, "cells")
    if len(wide) == 2:
        figures = _maps(result, _TRIALS)
    else:
        draw = "axis_lines" if wide else "cell_dots"
        figures = [planned(result, draw, "peak to peak and frequency", _TRIALS)]
    if _few(result) and "samples.parquet" in result.files:
        figures.append(planned(result, "campaign_thumbnails", "motion", "The end of each trial."))
    return figures


def _few(result: Result) -> bool:
    """Whether a campaign has few enough rates and resolutions for thumbnails."""
    cells = result.rows("cells")
    return max(len({row[axis] for row in cells}) for axis in result.axes) <= MOST
