"""Bounces of recorded cycles, one by one: how large, how fast, and which of them are out of the ordinary."""

import itertools
from math import floor, pi
from statistics import median
from typing import NamedTuple

from hknob_cli.errors import UsageError
from hknob_cli.page.claims.checks import check
from hknob_cli.page.claims.checks.motion import Point, trials
from hknob_cli.page.claims.checks.rows import one_number, percent, rows_of
from hknob_cli.results.result_set import ResultSet, Where
from hknob_cli.specs.plan import COUNTS, RATE

ERRANT = 2.0  # times the median bounce of a trial: above it a bounce is errant


class Bounce(NamedTuple):
    """From one peak to the next: how long (s), from the mean of both peaks to the trough (rad), and whether errant."""

    seconds: float
    size: float
    errant: bool


@check
def bounce_frequency(evidence: ResultSet, result: str, after: float, where: Where | None = None) -> float | None:
    """Frequency, Hz, of the bounces that are not errant: their number over the time that they take; all trials.

    ``after``: s, when the motion is steady. A bounce is errant if it is larger than twice the median of its trial.
    """
    usual = [one for trial in _bounces(evidence, result, after, where) for one in trial if not one.errant]
    return len(usual) / sum(one.seconds for one in usual) if usual else None


@check
def errant_trials(evidence: ResultSet, result: str, after: float, where: Where | None = None) -> float | None:
    """Share of the trials, %, that have errant bounces; ``after``: s, when the motion is steady."""
    return percent(any(one.errant for one in trial) for trial in _bounces(evidence, result, after, where))


@check
def errant_rate(
    evidence: ResultSet, result: str, after: float, runs: bool = False, where: Where | None = None
) -> float | None:
    """Errant bounces a second: how many follow the first of a trial, over the time from it to the last; all trials.

    ``after``: s, when the motion is steady. ``runs``: errant bounces in a row count as one.
    """
    count, seconds = 0, 0.0
    for trial in _bounces(evidence, result, after, where):
        begins = [0.0, *itertools.accumulate(one.seconds for one in trial)]
        before = [False, *(one.errant for one in trial)]
        found = [
            begin for one, begin, last in zip(trial, begins, before, strict=False) if one.errant and not (runs and last)
        ]
        count += max(0, len(found) - 1)
        seconds += found[-1] - found[0] if found else 0.0
    return count / seconds if seconds else None


@check
def worst_crossing(evidence: ResultSet, result: str, after: float, where: Where | None = None) -> float | None:
    """How late, in sample periods, the crossing is seen that leads to a trial's largest excursion.

    Mean over the trials that have errant bounces. An excursion is the farthest from a count edge between two crossings
    of it; crossings are interpolated between rows. ``after``: s, when the motion is steady.
    """
    row = rows_of(evidence, result, "trajectories", where, needs=[RATE, COUNTS])[0]
    quantum, rate = 2.0 * pi / row[COUNTS], row[RATE]
    tracks = _steady(evidence, result, after, where)
    some = [track for track in tracks if any(one.errant for one in judged(_turns(track)))]
    return one_number(
        (None if (late := worst_delay(track, quantum)) is None else late * rate for track in some), "mean"
    )


@check
def bounce_spread(
    evidence: ResultSet, result: str, after: float, statistic: str = "mean", where: Where | None = None
) -> float | None:
    """Largest over least bounce of a trial that is above a tenth of its largest; a statistic over the trials.

    ``after``: s, when the motion is steady.
    """
    sizes = [[one.size for one in trial] for trial in _bounces(evidence, result, after, where)]
    kept = [[size for size in trial if size > 0.1 * max(trial)] for trial in sizes]
    return one_number((max(trial) / min(trial) for trial in kept if trial), statistic)


@check
def phase_plane_aspect(
    evidence: ResultSet,
    result: str,
    against: str,
    after: float,
    against_after: float | None = None,
    where: Where | None = None,
) -> float | None:
    """Height over width of the phase plane's picture, over that of another result; mean over the trials.

    That is the range of velocity over the range of angle. ``after``: s, when the motion is steady, of the other result
    ``against_after``. Above 1: more slender, that is faster.
    """
    starts = {result: after, against: after if against_after is None else against_after}
    first, second = (
        one_number((_aspect(track) for track in _steady(evidence, name, starts[name], where)), "mean")
        for name in (result, against)
    )
    return None if first is None or not second else first / second


def _aspect(track: list[Point]) -> float | None:
    angles, speeds = [point.angle for point in track], [point.velocity for point in track]
    width = max(angles) - min(angles)
    return (max(speeds) - min(speeds)) / width if width > 0.0 else None


def worst_delay(track: list[Point], quantum: float) -> float | None:
    """Time, s, from the crossing before the largest excursion to the next sample; None without one."""
    samples = [point.time for point in track if point.event == "sample"]
    crossings: list[tuple[float, float, float]] = []  # when, of which edge, and how far the knob then goes
    for a, b in itertools.pairwise(track):
        low, high = sorted(floor(point.angle / quantum) for point in (a, b))
        if low != high:
            edge = high * quantum
            at = a.time + (b.time - a.time) * (edge - a.angle) / (b.angle - a.angle)
            crossings.append((at, edge, 0.0))
        if crossings:
            at, edge, far = crossings[-1]
            crossings[-1] = (at, edge, max(far, abs(b.angle - edge)))
    if not crossings:
        return None
    worst = max(crossings, key=lambda crossing: crossing[2])[0]
    return next((time - worst for time in samples if time >= worst), None)


def _steady(evidence: ResultSet, result: str, after: float, where: Where | None) -> list[list[Point]]:
    """The recorded trials from ``after`` on. Raises `UsageError` where that is later than all of a trial."""
    found = [[point for point in track if point.time >= after] for track in trials(evidence, result, where)]
    if any(len(track) < 2 for track in found):
        raise UsageError(f"after: '{result}' is not recorded after {after:g} s")
    return found


def _bounces(evidence: ResultSet, result: str, after: float, where: Where | None) -> list[list[Bounce]]:
    """Bounces of every recorded trial."""
    return [judged(_turns(track)) for track in _steady(evidence, result, after, where)]


def _turns(track: list[Point]) -> list[tuple[float, float, bool]]:
    """Times (s) and angles (rad) of peaks and troughs, and whether each is a peak.

    Between rows acceleration is taken as constant.
    """
    found = []
    for a, b in itertools.pairwise(track):
        if a.velocity * b.velocity < 0.0 or (a.velocity != 0.0 and b.velocity == 0.0):
            later = (b.time - a.time) * a.velocity / (a.velocity - b.velocity)
            found.append((a.time + later, a.angle + 0.5 * a.velocity * later, a.velocity > 0.0))
    return found


def judged(turns: list[tuple[float, float, bool]]) -> list[Bounce]:
    """Bounces between peaks, each with what it is beside the median of all."""
    tops = [i for i, (_, _, peak) in enumerate(turns) if peak]
    spans = [(turns[i], min(angle for _, angle, _ in turns[i : j + 1]), turns[j]) for i, j in itertools.pairwise(tops)]
    plain = [(end[0] - begin[0], 0.5 * (begin[1] + end[1]) - low) for begin, low, end in spans]
    usual = median([size for _, size in plain]) if plain else 0.0
    return [Bounce(seconds, size, size > ERRANT * usual) for seconds, size in plain]
