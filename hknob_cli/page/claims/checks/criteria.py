"""The criteria of stability of section 6.2, on the scene of a result, beside what its sweep does."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from hknob_cli.errors import UsageError
from hknob_cli.page.claims.checks import check
from hknob_cli.page.claims.checks.grid import exponent
from hknob_cli.page.claims.checks.rows import one_number, percent, rests, rows_of
from hknob_cli.results.result_set import ResultSet, Where
from hknob_cli.specs.plan import COUNTS, RATE

if TYPE_CHECKING:
    from hknob_cli.theory.criteria import Case, Criterion


def _cases(evidence: ResultSet, result: str, where: Where | None) -> "Iterator[tuple[dict[str, Any], Case]]":
    """The rows of a sweep's cells, each with what the criteria need of it."""
    from hknob_cli.specs.plan import scene_at
    from hknob_cli.theory.criteria import case_of
    from hknob_cli.theory.laws import working_edge

    for row in rows_of(evidence, result, "cells", where, needs=["at_rest_fraction"]):
        cell = {axis: row[axis] for axis in evidence[result].axes}
        scene = scene_at(evidence[result].scene, cell)
        # A continuous sensor is the limit of many counts.
        yield row, case_of(scene, working_edge(scene, {COUNTS: 2**31, **cell}))


def _word(name: str, case: "Case") -> "Criterion":
    from hknob_cli.theory.criteria import CRITERIA, judge

    if name not in CRITERIA:
        raise UsageError(f"criterion: must be one of {', '.join(CRITERIA)}, got '{name}'")
    return judge(name, case)


@check
def cycles_where_criterion(
    evidence: ResultSet, result: str, criterion: str, holds: bool, where: Where | None = None
) -> float | None:
    """Share of a sweep's cells, %, with any trial that cycles, of those where the wall without counts satisfies it.

    ``criterion``: tsypkin, tsai_colgate, miller, love_book or llewellyn; ``holds``: false for where it does not.
    """
    rows = [row for row, case in _cases(evidence, result, where) if _word(criterion, case).holds is holds]
    return percent(row["at_rest_fraction"] < 1.0 for row in rows)


@check
def criterion_over(
    evidence: ResultSet,
    result: str,
    criterion: str,
    over: str,
    where: Where | None = None,
    statistic: str = "least",
) -> float | None:
    """A statistic of the largest stiffness that one criterion allows over that of another, over the cells."""
    found = []
    for _, case in _cases(evidence, result, where):
        one, other = _word(criterion, case).stiffness, _word(over, case).stiffness
        if one is not None and other:
            found.append(one / other)
    return one_number(found, statistic)


@check
def criterion_with_damping(
    evidence: ResultSet,
    result: str,
    criterion: str,
    factor: float,
    where: Where | None = None,
    statistic: str = "mean",
) -> float | None:
    """The largest stiffness that a criterion allows with ``factor`` times the damping, over that as it is."""
    found = []
    for _, case in _cases(evidence, result, where):
        edge = case.edge
        less = edge._replace(damping=factor * edge.damping, knob_damping=factor * edge.knob_damping)
        one, other = _word(criterion, case._replace(edge=less)).stiffness, _word(criterion, case).stiffness
        if one is not None and other:
            found.append(one / other)
    return one_number(found, statistic)


@check
def damping_bounded(evidence: ResultSet, result: str, where: Where | None = None) -> float | None:
    """Share of the cells, %, where love_book bounds the virtual damping from below, above 0, and from above."""
    words = (_word("love_book", case) for _, case in _cases(evidence, result, where))
    return percent(bool(word.least_damping) and bool(word.most_damping) for word in words)


@check
def resting_stiffness_exponent(
    evidence: ResultSet, result: str, stiffness: str = "wall.stiffness", where: Where | None = None
) -> float | None:
    """Exponent of the largest stiffness up to which every trial rests, as a power of the sample rate.

    ``stiffness``: the axis. A rate at which the softest wall does not rest, or the stiffest does, is left out.
    """
    by: dict[float, list[tuple[float, bool]]] = {}
    for row in rows_of(evidence, result, "cells", where, needs=[RATE, stiffness, "at_rest_fraction"]):
        by.setdefault(row[RATE], []).append((row[stiffness], rests(row)))
    found = []
    for rate, walls in by.items():
        walls.sort()
        ends = next((i for i, (_, still) in enumerate(walls) if not still), 0)
        if ends:
            found.append((rate, walls[ends - 1][0]))
    return exponent(found)
