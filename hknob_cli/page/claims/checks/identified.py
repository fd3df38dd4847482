"""What identification finds of hands and of the apparatus, beside what is printed; the grip that a push asks for.

The bias of estimators is by its cause: as studied by simulation, and as least squares alone make it.
"""

from math import sqrt
from typing import Any

import numpy as np

from hknob_cli.apparatus.experiment import setups
from hknob_cli.apparatus.hand import SecondOrder, follow, mechanism
from hknob_cli.apparatus.hand_recording import (
    PEAK_RAD,
    Rig,
    peak_per_torque,
    runs,
    scaled_input,
    scaled_pulse,
    unit_input,
)
from hknob_cli.apparatus.people import mean_hand
from hknob_cli.errors import UsageError
from hknob_cli.identify.fourth_order import hold_matrices
from hknob_cli.page.claims.checks import check, one_number, percent, rows_of
from hknob_cli.page.claims.checks.printed import Names, bound
from hknob_cli.printed import cell, table
from hknob_cli.results.result_set import MissingError, ResultSet, Where
from hknob_cli.specs.identification import InputPlan
from hknob_cli.specs.plan import placed
from hknob_cli.specs.squeeze import grip_of

_J, _B, _K, _RATIO = "inertia_kg_m2", "damping_nm_s_per_rad", "stiffness_nm_per_rad", "damping_ratio"
_STD = {
    _J: "inertia_std_kg_m2",
    _B: "damping_std_nm_s_per_rad",
    _K: "stiffness_std_nm_per_rad",
    _RATIO: "damping_ratio_std",
}
_CV = {
    _J: "inertia_cv_percent",
    _B: "damping_cv_percent",
    _K: "stiffness_cv_percent",
    _RATIO: "damping_ratio_cv_percent",
}
_KEYS = ("experiment", "subject", "grip_target_n", "estimator")
_APPARATUS = "apparatus_inertia_kg_m2"

Row = dict[str, Any]


def _conditions(evidence: ResultSet, result: str, estimator: str, level: str, where: Where | None = None) -> list[Row]:
    asked = {"level": level, "estimator": estimator, **(where or {})}
    return rows_of(evidence, result, "conditions", asked, needs=[*_STD, *_KEYS, "level"])


@check
def tables_within(
    evidence: ResultSet,
    result: str,
    estimator: str,
    quantities: list[str] | None = None,
    errors: float = 2.0,
    where: Where | None = None,
) -> float | None:
    """Share of the printed means of Tables 1-5, %, from which the identified ones differ by so many standard errors.

    Or less. A standard error is the printed deviation over the root of the number of persons identified. A value that
    could not be identified counts as outside. ``quantities`` are columns; by default J, B, K and the damping ratio.
    Inertia is of hand and apparatus.
    """
    persons: dict[tuple[str, float], int] = {}
    for row in _conditions(evidence, result, estimator, "subject", where):
        key = (row["experiment"], row["grip_target_n"])
        persons[key] = persons.get(key, 0) + 1
    inside = []
    for row in _conditions(evidence, result, estimator, "all", where):
        number, grip = int(row["experiment"]), row["grip_target_n"]
        own = {_J: row.get(_APPARATUS) or 0.0}
        for name in quantities or _STD:
            value = row[name]
            error = cell(number, grip, _STD[name]) / sqrt(persons[row["experiment"], grip])
            off = None if value is None else abs(value + own.get(name, 0.0) - cell(number, grip, name))
            inside.append(off is not None and off <= errors * error)
    return percent(inside)


@check
def variation_ratio(
    evidence: ResultSet,
    result: str,
    estimator: str,
    columns: list[str] | None = None,
    where: Where | None = None,
    statistic: str = "median",
) -> float | None:
    """A statistic of the identified coefficients of variation between persons over the printed ones, 1.

    ``columns``: by default J, B, K and the damping ratio.
    """
    found = []
    for row in _conditions(evidence, result, estimator, "all", where):
        for column in columns or _STD:
            if row[column] and row[f"{column}_std"] is not None:
                own = (row.get(_APPARATUS) or 0.0) if column == _J else 0.0
                printed = cell(int(row["experiment"]), row["grip_target_n"], _CV[column])
                found.append(100.0 * row[f"{column}_std"] / (row[column] + own) / printed)
    return one_number(found, statistic)


@check
def identified_change(
    evidence: ResultSet,
    result: str,
    to: str,
    column: str,
    estimator: str,
    level: str = "subject",
    where: Where | None = None,
    statistic: str = "mean",
) -> float | None:
    """A statistic of an identified value of one result over that of another, less 1, in %; like conditions compared.

    Inertia is of hand and apparatus on both sides. Raises `MissingError` where no condition is in both.
    """
    others = {tuple(row[name] for name in _KEYS): row for row in _conditions(evidence, to, estimator, level, where)}
    pairs = [
        (row, others[key])
        for row in _conditions(evidence, result, estimator, level, where)
        if (key := tuple(row[name] for name in _KEYS)) in others
    ]
    if not pairs:
        raise MissingError(f"no condition is both in '{result}' and in '{to}'")
    values = []
    for row, other in pairs:
        if row[column] is not None and other[column] is not None:
            one, two = (
                each[column] + ((each.get(_APPARATUS) or 0.0) if column == _J else 0.0) for each in (row, other)
            )
            values.append(100.0 * (one / two - 1.0))
    return one_number(values, statistic)


@check
def estimator_gain(
    evidence: ResultSet, result: str, estimator: str, to: str, against: str, column: str, where: Where | None = None
) -> float | None:
    """Mean size of the difference of one estimator from a third, over that of another; people and grips one by one.

    ``estimator`` and ``to`` are compared, each with ``against``, on the same recordings. Inertia is of hand and
    apparatus.
    """
    found = []
    for name in (estimator, to):
        own, other = (
            {tuple(row[key] for key in _KEYS[:3]): row for row in _conditions(evidence, result, one, "subject", where)}
            for one in (name, against)
        )
        pairs = [(own[key], other[key]) for key in own if key in other]
        sizes = [one[column] / two[column] - 1.0 for one, two in pairs if one[column] and two[column]]
        found.append(one_number(sizes, "mean_size"))
    first, second = found
    return None if first is None or not second else first / second


@check
def displaced_share(
    evidence: ResultSet, result: str, estimator: str, low: float, high: float, where: Where | None = None
) -> float | None:
    """Share of the blocks, %, in which the pulse of their grip turns the identified hand by ``low`` to ``high`` rad.

    The pulse of a grip is the same for all: what turns the printed mean hand by the middle of the printed range.
    """
    asked = {"estimator": estimator, **(where or {})}
    rows = rows_of(evidence, result, "trials", asked, needs=[_J, _B, _K, "experiment", "grip_target_n"])
    inside = []
    for row in rows:
        values = [row[name] for name in (_J, _B, _K)]
        if all(value is not None and value > 0.0 for value in values):
            hand = SecondOrder(values[0] + (row.get(_APPARATUS) or 0.0), *values[1:])
            peak = peak_per_torque(hand) * scaled_pulse(int(row["experiment"]), row["grip_target_n"]).torque_nm
            inside.append(low <= peak <= high)
    return percent(inside)


@check
def apparatus_error(
    evidence: ResultSet, result: str, estimator: str, where: Where | None = None, statistic: str = "mean"
) -> float | None:
    """A statistic of the identified inertia of the apparatus alone over the true one, less 1, in %."""
    true = setups()
    asked = {"estimator": estimator, **(where or {})}
    rows = rows_of(evidence, result, "trials", asked, needs=[_J, "subject"])
    return one_number(
        (100.0 * (row[_J] / true[row["subject"]] - 1.0) for row in rows if row[_J] is not None), statistic
    )


@check
def apparatus_share(
    evidence: ResultSet,
    result: str,
    estimator: str,
    column: str,
    where: Where | None = None,
    statistic: str = "largest_size",
) -> float | None:
    """A statistic of the damping or stiffness identified of the apparatus alone, in % of the lightest grasp's.

    That is the least value of the column in Tables 1-5. Values not told from zero are left out.
    """
    lightest = min(cell(number, float(row["grip_n"] or 0.0), column) for number in range(1, 6) for row in table(number))
    asked = {"estimator": estimator, **(where or {})}
    rows = rows_of(evidence, result, "trials", asked, needs=[column, "subject"])
    return one_number((100.0 * row[column] / lightest for row in rows if row[column] is not None), statistic)


@check
def asked_grip(evidence: ResultSet, result: str, push_nm: float, over_nm: float | None = None) -> float:
    """Grip force (N) at which the fingers of a scene's ``squeeze`` hold a push into its wall (Hasser, Chapter 11).

    ``over_nm``: over the grip force at another push. Raises `MissingError` for a result whose grip follows no push.
    """
    scene = evidence[result].scene
    if scene.squeeze is None:
        raise MissingError(f"the grip of '{result}' does not follow its push")
    found = grip_of(placed(scene, {"bias.torque": push_nm}))
    return found if over_nm is None else found / grip_of(placed(scene, {"bias.torque": over_nm}))


@check
def turned_power(
    _: ResultSet,
    kind: str,
    over: str,
    experiment: int,
    grip_n: float,
    duration_s: float = 0.5,
    sine_hz: float = 8.0,
    chirp_hz: tuple[float, float] = (1.0, 100.0),
) -> float:
    """Mean square of the angle by which one kind of input turns a printed hand over that of another (Hasser, sec. 2.1).

    Both turn it by the same angle at the most. A sine has the frequency ``sine_hz``.
    """
    hand, rig = mean_hand(experiment, grip_n), Rig.ideal()
    squares = []
    for one in (kind, over):
        first, last = (sine_hz, sine_hz) if one == "sine" else chirp_hz
        torque = scaled_input(InputPlan(one, duration_s, first, last, 0.002), hand, rig.interval_s, PEAK_RAD)
        body = mechanism(hand)
        squares.append(float(np.mean(follow(body, body.rest(0.0), runs(torque), rig.interval_s)[:, 0] ** 2)))
    return squares[0] / squares[1]


@check
def input_power(_: ResultSet, kind: str, over: str, duration_s: float = 0.5, chip_s: float = 0.002) -> float:
    """Mean square of an input of one kind over that of another, both of the same largest value (Hasser, sec. 2.1)."""
    first, second = (
        float(np.mean(unit_input(InputPlan(one, duration_s, 1.0, 100.0, chip_s), 1e-4) ** 2)) for one in (kind, over)
    )
    return first / second


@check
def bias_by(
    evidence: ResultSet,
    result: str,
    nuisance: str,
    level: float,
    parameters: list[str],
    estimator: str,
    grips: list[float] | None = None,
    statistic: str = "mean",
    change: bool = True,
) -> float | None:
    """A statistic of the bias of parameters at a level of a nuisance, in points of % of the truth, over grips.

    ``change``: less the bias at the least level of that nuisance, of its own; otherwise all of it. Raises
    `MissingError` where the study has no such level.
    """
    asked = {"nuisance": nuisance, "estimator": estimator, "parameter": parameters}
    needs = ["grip_n", "level", "bias_percent"]
    rows = rows_of(evidence, result, "bias", {**asked, **({"grip_n": grips} if grips else {})}, needs=needs)
    found = {(row["grip_n"], row["parameter"], row["level"]): row["bias_percent"] for row in rows}
    levels = sorted({key[2] for key in found})
    at = min(levels, key=lambda one: abs(one - level))
    if abs(at - level) > 5e-3 * abs(level):
        raise MissingError(
            f"'{result}' has no {nuisance} of {level:g}; it has {', '.join(f'{one:g}' for one in levels)}"
        )
    values = [
        value - (found[grip, parameter, levels[0]] if change else 0.0)
        for (grip, parameter, one), value in found.items()
        if one == at
    ]
    return one_number(values, statistic)


@check
def regularised_inertia(
    _: ResultSet, *, where: Names, noise_percent: float, pulse_s: float = 0.02, window_s: float = 0.03
) -> float:
    """Inertia, % of the true one, that least squares find where the acceleration alone has an error of its own.

    The error is white, ``noise_percent`` of the acceleration's own root mean square; velocity and displacement are
    exact, and the pulse is of 10,000 samples a second. Over many samples the error adds its power to that of the
    acceleration and nothing else. ``where``: J, B, K. Source: section 4.4, the equation with epsilon.
    """
    names = bound(where)
    if not {"J", "B", "K"} <= set(names):
        raise UsageError("regularised_inertia: where must give J, B and K")
    inertia, damping, stiffness = (names[name] for name in ("J", "B", "K"))
    rates = np.array([[0.0, 1.0], [-stiffness / inertia, -damping / inertia]])
    push = np.array([0.0, 1.0 / inertia])
    move, added = (one[0] for one in hold_matrices(rates, push, 1e-4))
    torque = np.where(np.arange(round(window_s / 1e-4)) < round(pulse_s / 1e-4), 1.0, 0.0)
    states = np.zeros((len(torque), 2))
    for i in range(1, len(torque)):
        states[i] = move @ states[i - 1] + added * torque[i - 1]
    acceleration = states @ rates[1] + push[1] * torque
    columns = np.column_stack([acceleration, states[:, 1], states[:, 0]])
    scale = np.sqrt(np.sum(columns * columns, axis=0))
    power = (columns / scale).T @ (columns / scale)
    power[0, 0] += (0.01 * noise_percent) ** 2
    found = np.linalg.solve(power, (columns / scale).T @ torque) / scale
    return float(100.0 * found[0] / inertia)
