"""The bias of estimators by its cause: as studied by simulation, and as least squares alone make it."""

import numpy as np

from hknob_cli.errors import UsageError
from hknob_cli.identify.finger_network import hold_matrices
from hknob_cli.page.claims.checks import check
from hknob_cli.page.claims.checks.arithmetic import Names, bound
from hknob_cli.page.claims.checks.rows import one_number, rows_of
from hknob_cli.results.result_set import MissingError, ResultSet


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
