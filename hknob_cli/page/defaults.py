"""What a page says and shows where its spec lists neither sentences nor chapters: each result, by its kind."""

from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np

from hknob_cli.errors import MISSHAPEN, UsageError
from hknob_cli.page.figures.campaign_samples import MOST
from hknob_cli.report.large import varying
from hknob_cli.report.means import WORST
from hknob_cli.report.perceived import perceived_levels
from hknob_cli.report.what_matters import columns_of
from hknob_cli.results.evidence import CAMPAIGN, Evidence, MissingError, Result
from hknob_cli.spec.page_plan import ChapterPlan, FigurePlan, Sentence
from hknob_cli.spec.plan import PERSON

T = TypeVar("T")


def chapters_of(evidence: Evidence) -> tuple[ChapterPlan, ...]:
    """A chapter for each result, with the pictures that its tables allow. Raises `UsageError` for tables of others."""
    return tuple(_of(evidence[name], _chapter) for name in evidence.names)


def _of(result: Result, make: Callable[[Result], T]) -> T:
    """What is made of a result's tables, where they are as their stage writes them."""
    try:
        return make(result)
    except MISSHAPEN as error:
        text = f"the tables of '{result.name}' in {result.folder} are not as its stage writes them"
        raise UsageError(f"results: {text}: {error}") from error


def _chapter(result: Result) -> ChapterPlan:
    kinds = {
        "sweep": _sweep,
        "dfa": _methods,
        "predict": _laws,
        "bench": _bench,
        "sysid": _identified,
        CAMPAIGN: _campaign,
    }
    figures = kinds.get(result.stage, _none)(result)
    return ChapterPlan(f"{result.name} ({result.stage})", "", tuple(figures))


def _figure(result: Result, draw: str, what: str, caption: str, **options: Any) -> FigurePlan:
    slug = "".join(letter if letter.isalnum() else "-" for letter in f"{result.name}-{what}".lower()).strip("-")
    title = f"{result.name}: {what}"
    return FigurePlan(f"fig-{slug}", draw, (result.name,), options, title, Sentence(caption), title)


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
    figures = []
    wide = _wide(result, "cells")
    columns = result.columns("cells")
    if PERSON in result.axes:
        figures = [_figure(result, "population", "people", _PEOPLE)]
    elif _is_map(result, wide) and "p2p_max_rad" in columns:
        figures = [
            _figure(result, "grid_map", "peak to peak", _WORST, column="p2p_max_rad"),
            _figure(result, "grid_map", "frequency", _WORST, column="frequency_at_max_hz"),
            *(
                _figure(result, "grid_map", level.head.removesuffix(" dB"), _NOTICED, column=level.column, log=False)
                for level in perceived_levels(result.rows("cells"))
            ),
        ]
    elif _is_map(result, wide) and "growth_j_per_s2" in columns:
        figures = [_figure(result, "grid_map", "growth of energy", "Mean of the trials.", column="growth_j_per_s2")]
    elif len(wide) == 1 and "p2p_rad" in columns:
        figures = [
            _figure(result, "staircase", "every orbit", "A dot for each orbit, sized by its share of the trials.")
        ]
    elif len(wide) > 1 and "p2p_rad" in columns:
        figures = [_figure(result, "what_matters", "what matters", _MATTERS)]
    if "trajectories.parquet" in result.files:
        figures.append(_figure(result, "time_response", "motion", "Angle and torque over time."))
    return figures


def _methods(result: Result) -> list[FigurePlan]:
    wide = _wide(result, "dfa")
    methods = dict.fromkeys(result.table("dfa").column("method").to_pylist())
    if not _is_map(result, wide):
        return _matters(result, wide, "method", list(methods))
    return [
        _figure(result, "grid_map", f"peak to peak by {method}", _LARGEST, column="p2p_rad", where={"method": method})
        for method in methods
    ]


def _laws(result: Result) -> list[FigurePlan]:
    wide = _wide(result, "predict")
    laws = dict.fromkeys(result.table("predict").column("law").to_pylist())
    if not _is_map(result, wide):
        return _matters(result, wide, "law", list(laws))
    return [
        _figure(result, "grid_map", f"peak to peak by {law}", "", column="p2p_rad", where={"law": law}) for law in laws
    ]


def _matters(result: Result, wide: list[str], choice: str, names: list[str]) -> list[FigurePlan]:
    """What matters by each method or law, where more than one axis varies."""
    every = names if len(wide) > 1 else []
    return [
        _figure(result, "what_matters", f"what matters by {name}", _MATTERS, where={choice: name}) for name in every
    ]


def _bench(result: Result) -> list[FigurePlan]:
    return [
        _figure(result, "error_time", "error against run time", "Left and low is better."),
        _figure(result, "stability_table", "verdicts", "What each method made of each scene."),
    ]


def _identified(result: Result) -> list[FigurePlan]:
    figures = []
    if "conditions.parquet" in result.files:
        rows = [row for row in result.rows("conditions") if row["grip_target_n"] and row["inertia_kg_m2"] is not None]
        for experiment in dict.fromkeys(row["experiment"] for row in rows):
            best = next(row["estimator"] for row in reversed(rows) if row["experiment"] == experiment)
            options = {"experiment": experiment, "estimator": best, "printed": False}
            figures.append(_figure(result, "all_persons", f"experiment {experiment} by {best}", _PERSONS, **options))
    if "calibration_points.parquet" in result.files:
        quantities = {row["quantity"] for row in result.rows("calibration")}
        draw = "motor_calibration" if "torque constant" in quantities else "grip_cell"
        figures.append(_figure(result, draw, "calibration", "Readings, and the straight lines fitted to them."))
    if "hidden_inertia.parquet" in result.files:
        figures.append(_figure(result, "hidden_inertia", "hidden inertia", "What second-order fits take for inertia."))
    return figures


def _campaign(result: Result) -> list[FigurePlan]:
    figures = []
    if len(_wide(result, "cells")) == 2:
        figures = [
            _figure(result, "grid_map", "peak to peak", _TRIALS, column="p2p_max_rad"),
            _figure(result, "grid_map", "frequency", _TRIALS, column="frequency_at_max_hz"),
        ]
    cells = result.rows("cells")
    if max(len({row[axis] for row in cells}) for axis in result.axes) <= MOST:
        figures.append(_figure(result, "campaign_thumbnails", "motion", "The end of each trial."))
    return figures


def _none(_result: Result) -> list[FigurePlan]:
    return []


_NOTICED = "Of the most noticeable orbit of each cell, against published thresholds."
_WORST = "Of the largest cycle of each cell; cells where trials come to rest or stay undecided say so."
_PEOPLE = "How many people have at most so large a limit cycle, and, of those for whom it buzzes, so high a pitch."
_PERSONS = "Every person over grip force: inertia of hand and apparatus, damping, stiffness, damping ratio."
_TRIALS = "Of the trial of each cell that buzzes most; a trial without a sustained buzz is at rest."
_MATTERS = "The axes, the one that explains most of the size of limit cycles first."
_LARGEST = "Of several cycles in a cell the largest."


def sentences_of(evidence: Evidence) -> tuple[str, ...]:
    """A sentence for each sweep, and each campaign on a knob: how many cells, how large, what pitch, how surely."""
    return tuple(text for name in evidence.names if (text := _of(evidence[name], _sentence)))


def _sentence(result: Result) -> str:
    size, pitch = WORST
    names = (*WORST, "at_rest_fraction", "certified_fraction")
    try:
        parts = [columns_of(table, table.column_names) for table in result.tables("cells", names)]
    except MissingError:
        return ""
    column = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    count = len(next(iter(column.values()), ()))
    cells = f"{result.name}: {count} cell{'s' if count > 1 else ''}"
    resting = column.get("at_rest_fraction", np.zeros(count)) == 1.0
    moving = column[size] > 0.0 if size in column else np.zeros(count, dtype=bool)
    if not moving.any():
        return f"{cells}, the knob comes to rest in all." if count and resting.all() else ""
    sizes, pitches = 1e3 * column[size][moving], column[pitch][moving]
    proven = 1.0 if result.stage == CAMPAIGN else column["certified_fraction"].min()
    if not (np.isfinite(pitches).all() and np.isfinite(proven)):
        raise ValueError("of cells with a size some have no pitch, or are neither proven nor not")
    if result.stage == CAMPAIGN:
        surely = "recorded"
    else:
        every = proven == 1.0
        surely = "every trial proven" if every else f"at least {100 * proven:.0f} % of the trials of a cell proven"
    still = int(resting.sum())
    rest = f"; at rest in {still}" if still else ""
    return (
        f"{cells}: peak to peak from {sizes.min():.3g} to {sizes.max():.3g} mrad, "
        f"{pitches.min():.3g} to {pitches.max():.3g} Hz, by the largest cycle of a cell{rest}; {surely}."
    )
