"""Where the wall's energy comes from: parts of its work in limit cycles, and in single contacts."""

import itertools
from math import floor

from hknob_cli.errors import UsageError
from hknob_cli.page.claims.checks import check, one_number, rows_of
from hknob_cli.page.claims.checks.edge import edge_of
from hknob_cli.page.claims.checks.motion import motion
from hknob_cli.results.result_set import ResultSet, Rows, Where

PARTS = ("late_entry_j", "late_exit_j", "staircase_j")


@check
def leak_share(
    evidence: ResultSet, result: str, parts: list[str], where: Where | None = None, statistic: str = "mean"
) -> float | None:
    """Share of the wall's work in a cycle, %, by ``parts``: late_entry_j, late_exit_j, staircase_j; over the orbits."""
    if unknown := sorted(set(parts) - set(PARTS)):
        raise UsageError(f"parts: unknown {', '.join(unknown)}; there are {', '.join(PARTS)}")
    rows = _cycles(evidence, result, where)
    return one_number((100.0 * sum(row[part] for part in parts) / row["wall_work_j"] for row in rows), statistic)


@check
def least_leak_share(evidence: ResultSet, result: str, where: Where | None = None) -> float | None:
    """Least share of the wall's work in a cycle, %, that any of entry, exit and staircase has in any orbit."""
    return one_number((leak_share(evidence, result, [part], where, "least") for part in PARTS), "least")


@check
def work_over_loss(evidence: ResultSet, result: str, where: Where | None = None) -> float | None:
    """Largest size of (work of the wall - losses) / work over a cycle, of all orbits, %."""
    rows = _cycles(evidence, result, where)
    return one_number(
        (
            100.0 * (row["wall_work_j"] - row["damping_loss_j"] - row.get("friction_loss_j", 0.0)) / row["wall_work_j"]
            for row in rows
        ),
        "largest_size",
    )


@check
def orbits_at_wall(evidence: ResultSet, result: str, where: Where | None = None) -> float | None:
    """Share of the trials that cycle, %, whose cycle crosses the wall's edge, 0."""
    rows = _cycles(evidence, result, where)
    total = sum(row["basin_fraction"] for row in rows)
    there = sum(row["basin_fraction"] for row in rows if row["min_rad"] < 0.0 < row["max_rad"])
    return float(100.0 * there / total)


@check
def orbits_over_edges(evidence: ResultSet, result: str, most: int, where: Where | None = None) -> float | None:
    """Share of the trials that cycle, %, whose cycle crosses at most so many count edges."""
    rows = _cycles(evidence, result, where)
    total = sum(row["basin_fraction"] for row in rows)
    few = 0.0
    for row in rows:
        quantum = edge_of(evidence, result, row).quantum_rad
        if floor(row["max_rad"] / quantum) - floor(row["min_rad"] / quantum) <= most:
            few += row["basin_fraction"]
    return float(100.0 * few / total)


def _cycles(evidence: ResultSet, result: str, where: Where | None) -> Rows:
    needs = ["wall_work_j", "damping_loss_j", *PARTS, "basin_fraction"]
    return rows_of(evidence, result, "orbits", {"outcome": "cycle", **(where or {})}, needs=needs)


@check
def contact_gain(evidence: ResultSet, result: str, where: Where | None = None) -> float | None:
    """Energy that the wall adds in the recorded contact, J."""
    track = motion(evidence, result, where)
    return sum(now.torque * (then.angle - now.angle) for now, then in itertools.pairwise(track))


@check
def contact_gain_ratio(evidence: ResultSet, result: str, to: str, same_motion: bool = False) -> float | None:
    """Energy the wall adds in a recorded contact, over that of the scene ``to``.

    ``same_motion``: that of ``to`` along the motion of ``result``, its torque -K angle held from sample to sample, as
    sec. 9.1 estimates.
    """
    added = contact_gain(evidence, result)
    other = _held_gain(evidence, result, to) if same_motion else contact_gain(evidence, to)
    return added / other if added is not None and other else None


@check
def extra_on_exit(evidence: ResultSet, result: str, after: float = 0.0, where: Where | None = None) -> float | None:
    """Share of the work that counts add to a recorded motion, %, which they add outside the wall: on exit.

    They add the work of the recorded torque less that of -K angle, held from sample to sample, along the same
    motion; of the first trial, from ``after``, s, on.
    """
    stiffness = evidence[result].scene.wall.stiffness
    without, whole, outside = 0.0, 0.0, 0.0
    for now, then in itertools.pairwise(motion(evidence, result, where)):
        if now.event == "sample":
            without = max(0.0, -stiffness * now.angle)
        if now.time >= after:
            extra = now.torque - without
            whole += extra * (then.angle - now.angle)
            outside += extra * (max(then.angle, 0.0) - max(now.angle, 0.0))
    return 100.0 * outside / whole if whole > 0.0 else None


def _held_gain(evidence: ResultSet, result: str, to: str) -> float:
    stiffness = evidence[to].scene.wall.stiffness
    torque, added = 0.0, 0.0
    track = motion(evidence, result)
    for now, then in itertools.pairwise(track):
        if now.event == "sample":
            torque = max(0.0, -stiffness * now.angle)
        added += torque * (then.angle - now.angle)
    return added
