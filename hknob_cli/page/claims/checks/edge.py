"""Quantities of the wall's edge: the relay between two counts, from the physical constants of a result's scene.

Stability limits and friction, beside what a sweep does.
"""

from math import atan2, exp, log, pi, sin, sqrt
from typing import TYPE_CHECKING, Any

from hknob_cli.errors import UsageError
from hknob_cli.page.claims.checks import check, one_number, percent, rows_of
from hknob_cli.results.result_set import ResultSet, Where, matching
from hknob_cli.specs.plan import COUNTS

if TYPE_CHECKING:
    from hknob_cli.theory.laws import WorkingEdge

_STEPS = 4096


def edge_of(evidence: ResultSet, result: str, row: dict[str, Any]) -> "WorkingEdge":
    """Inertia, damping, stiffness, torque step, ... of the cell of a row (SI units)."""
    from hknob_cli.specs.plan import scene_at
    from hknob_cli.theory.laws import working_edge

    cell = {axis: row[axis] for axis in evidence[result].axes}
    return working_edge(scene_at(evidence[result].scene, cell), cell)


@check
def relay_gain(evidence: ResultSet) -> float:  # noqa: ARG001 - it needs no result
    """Amplitude of the fundamental of a relay's output over its level, N(A) A / M, by quadrature over a sine."""
    phases = ((i + 0.5) * 2.0 * pi / _STEPS for i in range(_STEPS))
    return sum((1.0 if sin(phase) > 0.0 else -1.0) * sin(phase) for phase in phases) * 2.0 / _STEPS


@check
def plant_steepness(evidence: ResultSet, result: str, where: Where | None = None) -> float | None:
    """Mean exponent of the plant's magnitude as a power of frequency, at the cycles that one harmonic predicts."""
    found = []
    for row in rows_of(evidence, result, "dfa", {"method": "df1", **(where or {})}, needs=["frequency_hz"]):
        if row["frequency_hz"]:
            edge, omega = edge_of(evidence, result, row), 2.0 * pi * row["frequency_hz"]
            near = [log(abs(_plant(edge, omega * exp(step)))) for step in (-1e-4, 1e-4)]
            found.append((near[1] - near[0]) / 2e-4)
    return one_number(found, "mean")


def _plant(edge: "WorkingEdge", omega: float) -> complex:
    return 1.0 / complex(edge.hand_stiffness - edge.inertia * omega**2, edge.damping * omega)


@check
def net_torque(evidence: ResultSet, result: str, side: str, where: Where | None = None) -> float | None:
    """Torque of wall and push, just ``outside`` or ``inside`` the edge, in torque steps K q; mean of the cells.

    That is the plant's input u of sec. 7.2 with the push in it; positive: out of the wall.
    """
    if side not in ("outside", "inside"):
        raise UsageError(f"side: must be outside or inside, got '{side}'")
    rows = rows_of(evidence, result, "cells", where, needs=[])
    wall = 1.0 if side == "inside" else 0.0
    return one_number((wall - edge_of(evidence, result, row).balance for row in rows), "mean")


@check
def law_constant(evidence: ResultSet, result: str, law: str) -> float | None:
    """C of p2p = C q T, 1/s, from the scene.

    ``law``: `describing_function` 2 K / (pi b), `energy_balance` 3 K / (4 b).
    """
    factors = {"describing_function": 2.0 / pi, "energy_balance": 0.75}
    if law not in factors:
        raise UsageError(f"law: must be one of {', '.join(factors)}, got '{law}'")
    scene = evidence[result].scene
    damping = scene.knob.damping + (scene.hand.damping if scene.hand else 0.0)
    return factors[law] * scene.wall.stiffness / damping if damping > 0.0 else None


@check
def fitted_constant(
    evidence: ResultSet, result: str, where: Where | None = None, statistic: str = "median"
) -> float | None:
    """A statistic of p2p / (q T) over the cells that cycle, 1/s: C as the sweep has it."""
    rows = rows_of(evidence, result, "cells", where, needs=["p2p_rad"])
    edges = [(row["p2p_rad"], edge_of(evidence, result, row)) for row in rows if row["p2p_rad"]]
    return one_number((p2p / (edge.quantum_rad * edge.period_s) for p2p, edge in edges), statistic)


@check
def from_one_case(
    evidence: ResultSet, result: str, case: Where, where: Where | None = None, statistic: str = "mean_size"
) -> float | None:
    """A statistic of (C q T - p2p) / p2p, %, over the cells that cycle, with C from the cell that ``case`` names."""
    constant = fitted_constant(evidence, result, case, "mean")
    if constant is None:
        return None
    rows = rows_of(evidence, result, "cells", where, needs=["p2p_rad"])
    edges = [(row["p2p_rad"], edge_of(evidence, result, row)) for row in rows if row["p2p_rad"]]
    return one_number(
        (100.0 * (constant * edge.quantum_rad * edge.period_s / p2p - 1.0) for p2p, edge in edges), statistic
    )


@check
def swing_at(evidence: ResultSet, result: str, frequency_hz: float, where: Where | None = None) -> float | None:
    """Peak to peak, rad, that a torque of ±K q / 2 can move the scene's inertia at a frequency: K q / (32 J f²).

    The torque is a square wave and nothing else acts, so the velocity is triangular; a push off the middle, damping or
    friction change the waveform, hardly the order of magnitude.
    """
    rows = rows_of(evidence, result, "cells", where, needs=[])
    edges = [edge_of(evidence, result, row) for row in rows]
    return one_number(
        (edge.wall_stiffness * edge.quantum_rad / (32.0 * edge.inertia * frequency_hz**2) for edge in edges), "mean"
    )


@check
def pitch_of_swing(evidence: ResultSet, result: str, p2p_rad: float, where: Where | None = None) -> float | None:
    """Frequency, Hz, at which a torque of ±K q / 2 moves the inertia by that peak to peak: `swing_at` inverted."""
    at_one = swing_at(evidence, result, 1.0, where)
    return None if at_one is None or p2p_rad <= 0.0 else sqrt(at_one / p2p_rad)


@check
def beyond_reach(
    evidence: ResultSet, result: str, frequency_hz: float, p2p_rad: float, where: Where | None = None
) -> float | None:
    """A peak to peak over the one that `swing_at` gives at that frequency."""
    reach = swing_at(evidence, result, frequency_hz, where)
    return p2p_rad / reach if reach else None


@check
def damped_natural_frequency(
    evidence: ResultSet,
    result: str,
    damping_factor: float = 1.0,
    inertia_factor: float = 1.0,
    where: Where | None = None,
) -> float | None:
    """Damped natural frequency of the knob in the wall with so many times its damping and inertia, over that as it is.

    The inertia is that of knob and hand together.
    """
    edge = edge_of(evidence, result, rows_of(evidence, result, "cells", where, needs=[])[0])

    def pitch(damping: float, inertia: float) -> float:
        square = (edge.wall_stiffness + edge.hand_stiffness) / inertia - (0.5 * damping / inertia) ** 2
        return sqrt(max(square, 0.0))

    before = pitch(edge.damping, edge.inertia)
    return pitch(damping_factor * edge.damping, inertia_factor * edge.inertia) / before if before else None


@check
def size_at_delay(
    evidence: ResultSet, result: str, factor: float, where: Where | None = None, statistic: str = "mean"
) -> float | None:
    """Size of the cycle of one harmonic with ``factor`` times the delay of the scene, over that with 1.

    The printed condition is solved for either delay: plant and delay lag by half a turn. A statistic of the cells.
    """
    found = []
    for row in rows_of(evidence, result, "dfa", {"method": "df1", **(where or {})}, needs=["amplitude_rad"]):
        if row["amplitude_rad"]:
            edge = edge_of(evidence, result, row)
            omegas = (_half_turn(edge, times * edge.delay_s) for times in (factor, 1.0))
            late, nominal = (abs(_plant(edge, omega)) for omega in omegas)
            found.append(late / nominal)
    return one_number(found, statistic)


def _half_turn(edge: "WorkingEdge", delay: float) -> float:
    """Angular frequency, rad/s, at which plant and delay together lag by half a turn; the lag grows with frequency."""

    def lag(omega: float) -> float:
        return atan2(edge.damping * omega, edge.hand_stiffness - edge.inertia * omega**2) + omega * delay

    low, high = 0.0, 1.0
    while lag(high) < pi:
        high *= 2.0
    for _ in range(80):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if lag(middle) < pi else (low, middle)
    return 0.5 * (low + high)


@check
def cycles_where_limit(
    evidence: ResultSet, result: str, limit: str, holds: bool, where: Where | None = None
) -> float | None:
    """Share of a sweep's cells, %, with any trial that cycles, of those where a limit holds (or does not).

    ``limit``: `colgate_schenkel` or `abbott_okamura`, passivity by the knob's own damping; the same names followed by
    `_with_hand`, by that of knob and hand; `gil_hulin`, `niemeyer`.
    """
    from hknob_cli.specs.plan import scene_at
    from hknob_cli.theory.laws import working_edge
    from hknob_cli.theory.passivity import LIMITS, verdict

    if limit not in LIMITS:
        raise UsageError(f"limit: must be one of {', '.join(LIMITS)}, got '{limit}'")
    found = []
    for row in rows_of(evidence, result, "cells", where, needs=["at_rest_fraction"]):
        cell = {axis: row[axis] for axis in evidence[result].axes}
        # A continuous sensor is the limit of many counts.
        full = {COUNTS: 2**31, **cell}
        if verdict(working_edge(scene_at(evidence[result].scene, cell), full)).limits[limit].holds == holds:
            found.append(row)
    return percent(row["at_rest_fraction"] < 1.0 for row in found)


@check
def friction_that_ends(
    evidence: ResultSet, result: str, column: str = "knob.coulomb_torque", where: Where | None = None
) -> float | None:
    """Least Coulomb friction from which on every trial rests, over all pushes of the grid, in torque steps K q."""
    rows = rows_of(evidence, result, "cells", where, needs=[column, "at_rest_fraction"])
    moving = [row[column] for row in matching(rows, {"at_rest_fraction": {"below": 1.0}})]
    most = max(moving, default=-1.0)
    least = min((row[column] for row in rows if row[column] > most), default=None)
    return None if least is None else least / edge_of(evidence, result, rows[0]).torque_step


@check
def counts_that_end(evidence: ResultSet, result: str, where: Where | None = None) -> float | None:
    """Fewest counts per revolution of the grid from which on every trial of every cell rests."""
    rows = rows_of(evidence, result, "cells", where, needs=[COUNTS, "at_rest_fraction"])
    most = max((row[COUNTS] for row in matching(rows, {"at_rest_fraction": {"below": 1.0}})), default=-1)
    return min((row[COUNTS] for row in rows if row[COUNTS] > most), default=None)
