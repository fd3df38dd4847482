"""Results of an identification as drawings need them, how its estimators look, and its picture over grip force.

Estimators have the same colour, marker and name everywhere. The picture has the hand's parameters in small multiples
(Figs 11, 16, 20).
"""

from math import isfinite, nan
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from hknob_cli.apparatus.hand_recording import virtual_rig
from hknob_cli.figures import theme
from hknob_cli.figures.sheet import save
from hknob_cli.identify.motion import Motion
from hknob_cli.identify.prepare import Preparation, Prepared, conditions
from hknob_cli.identify.second_order import Plant
from hknob_cli.recordings.columns import UNNAMED
from hknob_cli.recordings.read import read
from hknob_cli.recordings.trial import Trial
from hknob_cli.results.result_set import MissingError, Result, Rows
from hknob_cli.specs.identification import SysidPlan
from hknob_cli.specs.source import Source
from hknob_cli.specs.sysid import validate_sysid

if TYPE_CHECKING:
    from matplotlib.axes import Axes

APPARATUS = "apparatus_inertia_kg_m2"
COLUMNS = {"inertia": "inertia_kg_m2", "damping": "damping_nm_s_per_rad", "stiffness": "stiffness_nm_per_rad"}


class Pulsed(NamedTuple):
    """A recorded condition as a motion, from the onset of its pulse on; ``start`` is the sample of the onset."""

    of: Prepared
    motion: Motion
    start: int


def plan_of(result: Result) -> SysidPlan:
    """What the identification that made a result was asked for. Raises `MissingError` for another kind of result."""
    if result.stage != "sysid":
        raise MissingError(f"'{result.name}' is not of an identification, but of {result.stage}")
    source = Source(result.name)
    source.value = {"kind": "sysid", **result.provenance["spec"]}
    return validate_sysid(source)


def rows_of(result: Result, file: str, **asked: Any) -> Rows:
    """Rows of a table with the values asked for (None: any), those with a whole second-order model.

    Raises `MissingError` if there is none.
    """
    chosen = {name: value for name, value in asked.items() if value is not None}
    table = result.table(file)
    if lacking := sorted({*chosen, *COLUMNS.values()} - set(table.column_names)):
        raise MissingError(f"no column {', '.join(lacking)} in {file} of '{result.name}'")
    found = [
        row
        for row in table.to_pylist()
        if all(row[name] == value for name, value in chosen.items())
        and all(row[column] is not None for column in COLUMNS.values())
    ]
    if not found:
        told = ", ".join(f"{name} {value}" for name, value in chosen.items())
        raise MissingError(f"no fit of '{result.name}' with {told or 'anything'}")
    return found


def plant_of(row: dict[str, Any]) -> Plant:
    """The second-order model of a row of fits, apparatus included, whether or not it was subtracted."""
    values = {name: row[column] for name, column in COLUMNS.items()}
    values["inertia"] += row.get(APPARATUS) or 0.0
    return Plant(**values, coulomb=row.get("coulomb_nm") or 0.0)


def recorded(result: Result, **asked: Any) -> list[Trial]:
    """Recorded trials with the keys asked for (None: any). Raises `MissingError` where none were kept."""
    file = "samples" if result.has_pulses else "recordings"
    result.table(file)  # says so where they were not kept
    chosen = {name: value for name, value in asked.items() if value is not None}
    trials = read([result.folder / f"{file}.parquet"])
    found = [one for one in trials if all(getattr(one.key, name) == value for name, value in chosen.items())]
    if not found:
        raise MissingError(f"no recording of '{result.name}' with {chosen}")
    return found


def pulsed(result: Result, *, smooth: bool, after_s: float = 0.03, **asked: Any) -> list[Pulsed]:
    """Averaged motions of the recorded conditions, prepared as the result's own; ``smooth``: as for least squares.

    Raises `MissingError` where there are none.
    """
    plan = plan_of(result)
    own = plan.prepare
    window = (own.window_s[0], after_s)
    how = Preparation(average=True, decimate=1, differentiate=False, window_s=window)
    if smooth:
        how = Preparation(decimate=own.decimate, window_s=window)
    counts = virtual_rig(plan).counts_per_rev or None if plan.virtual is not None else plan.counts_per_rev
    found = []
    for one in conditions(recorded(result, **asked), how, counts_per_rev=counts):
        if one.motion is not None:
            start = next(i for i, torque in enumerate(one.motion.torque_nm) if torque)
            found.append(Pulsed(one, one.motion, start))
    if not found:
        raise MissingError(f"no recording of '{result.name}' can be used")
    return found


# Okabe & Ito's palette, which the colour-blind can tell apart; the markers tell it once more.
COLOURS = {
    "least_squares": "#D55E00",
    "least_squares_friction": "#E69F00",
    "least_squares_acceleration": "#CC79A7",
    "output_error": "#0072B2",
    "output_error_friction": "#56B4E9",
    "fourth_order": "#009E73",
}
MARKERS = {
    "least_squares": "o",
    "least_squares_friction": "s",
    "least_squares_acceleration": "P",
    "output_error": "^",
    "output_error_friction": "v",
    "fourth_order": "D",
}
NAMES = {
    "least_squares": "least squares",
    "least_squares_friction": "least squares, friction",
    "least_squares_acceleration": "least squares, accelerometer",
    "output_error": "output error",
    "output_error_friction": "output error, friction",
    "fourth_order": "fourth order",
}


Row = dict[str, Any]
_PARAMETERS = (
    ("inertia_kg_m2", 1e7, "inertia, g·cm²"),
    ("damping_nm_s_per_rad", 1e3, "damping, mN·m·s/rad"),
    ("stiffness_nm_per_rad", 1e3, "stiffness, mN·m/rad"),
    ("damping_ratio", 1.0, "damping ratio"),
    ("coulomb_nm", 1e3, "friction, mN·m"),
    ("finger_stiffness_nm_per_rad", 1e3, "finger stiffness, mN·m/rad"),
    ("pad_stiffness_nm_per_rad", 1e3, "pad stiffness, mN·m/rad"),
)


def draw_hands(conditions: list[Row], *, title: str, path: Path) -> bool:
    """Draw into ``path`` (PNG): a row for each experiment, a column for each parameter, a line for each estimator.

    Bars: standard deviation over persons. Of knobs that nobody grips, each setup by its name, bars: standard error over
    blocks. False, and no file, where none of the parameters could be told. Raises `ComputationError` if the file cannot
    be written.
    """
    held = any(row["grip_target_n"] for row in conditions)
    rows = [row for row in conditions if row["level"] == ("all" if held else "subject")]
    parameters = [one for one in _PARAMETERS if any(_told(row, one[0]) for row in rows)]
    if not parameters:
        return False
    experiments = list(dict.fromkeys(row["experiment"] for row in rows))
    estimators = list(dict.fromkeys(row["estimator"] for row in rows))
    places: list[Any] = sorted({row["grip_target_n"] for row in rows})
    if not held:
        places = list(dict.fromkeys(row["subject"] for row in rows))
    figure = theme.figure(width=0.8 + 3.3 * len(parameters), height=1.6 + 2.3 * len(experiments))
    panels = figure.subplots(len(experiments), len(parameters), sharex=True, sharey="col", squeeze=False)
    for line, experiment in zip(panels, experiments, strict=True):
        for axes, (column, scale, _) in zip(line, parameters, strict=True):
            for i, estimator in enumerate(estimators):
                found = [row for row in rows if (row["experiment"], row["estimator"]) == (experiment, estimator)]
                shift = i - 0.5 * (len(estimators) - 1)
                _line(axes, found, column, scale, estimator, _places(found, places, held=held, shift=shift), held=held)
            axes.grid(alpha=0.3)
        if experiment == UNNAMED:
            continue
        line[0].annotate(
            f"experiment {experiment}" if held else str(experiment),
            (0.03, 0.97),
            xycoords="axes fraction",
            va="top",
            bbox={"boxstyle": "round", "facecolor": "white", "edgecolor": "0.8", "alpha": 0.8},
        )
    for axes, (_, _, name) in zip(panels[0], parameters, strict=True):
        axes.set_title(name, fontsize="medium")
    for axes in panels[-1]:
        _label(axes, places, held=held)
    handles, labels = panels[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), frameon=False)
    whose = "means over persons and their standard deviations" if held else "means over blocks and standard errors"
    figure.suptitle(f"{title}: {whose}")
    save(figure, path, stage="sysid", name=title)
    return True


def _told(row: Row, column: str) -> bool:
    """Whether a parameter was identified; one without any error was given."""
    return row.get(column) is not None and row.get(f"{column}_std") != 0.0


def _places(rows: list[Row], places: list[Any], *, held: bool, shift: float) -> list[float]:
    """Where rows are along the axis, a little apart by estimator, so that bars do not hide one another."""
    if held:
        return [row["grip_target_n"] * 1.03**shift for row in rows]
    return [places.index(row["subject"]) + 0.08 * shift for row in rows]


def _line(
    axes: "Axes", rows: list[Row], column: str, scale: float, estimator: str, where: list[float], *, held: bool
) -> None:
    values = [_scaled(row.get(column), scale) for row in rows]
    spreads = [_scaled(row.get(f"{column}_std"), scale) for row in rows]
    axes.errorbar(
        where,
        values,
        [spread if isfinite(spread) else 0.0 for spread in spreads],
        color=COLOURS[estimator],
        marker=MARKERS[estimator],
        markersize=5,
        linestyle="-" if held else "none",
        linewidth=1.2,
        elinewidth=0.8,
        capsize=2,
        label=NAMES[estimator],
    )


def _scaled(value: float | None, scale: float) -> float:
    return nan if value is None else scale * value


def _label(axes: "Axes", places: list[Any], *, held: bool) -> None:
    from matplotlib.ticker import NullLocator

    if not held:
        axes.set_xticks(range(len(places)), [str(place).replace("_", " ") for place in places], rotation=20)
        axes.margins(x=0.15)
        return
    if len(places) > 1:
        axes.set_xscale("log")
        axes.xaxis.set_minor_locator(NullLocator())
    else:
        axes.margins(x=3.0)  # of one grip the estimators stand together, not at the edges
    axes.set_xticks(places, [f"{place:g}" for place in places])
    axes.set_xlabel("grip force, N")
