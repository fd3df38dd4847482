"""Recorded motions: contacts with the wall, when the torque switches, and bounces one by one."""

import itertools
from math import floor, pi
from statistics import median
from typing import NamedTuple

from hknob_cli.errors import UsageError
from hknob_cli.page.claims.checks import check, one_number, percent, rows_of
from hknob_cli.results.result_set import ResultSet, Where
from hknob_cli.specs.plan import COUNTS, RATE

_NEEDS = ("time_s", "event", "angle_rad", "velocity_rad_s", "torque_nm")


class Point(NamedTuple):
    """One row of a recording, SI units; ``torque``: just after this instant."""

    time: float
    event: str
    angle: float
    velocity: float
    torque: float


def motion(evidence: ResultSet, result: str, where: Where | None = None) -> list[Point]:
    """The recorded motion of one trial, the first. Raises `MissingError`."""
    rows = rows_of(evidence, result, "trajectories", where, needs=[*_NEEDS, "trial"])
    return [Point(*(row[name] for name in _NEEDS)) for row in rows if row["trial"] == rows[0]["trial"]]


def trials(evidence: ResultSet, result: str, where: Where | None) -> list[list[Point]]:
    """The recorded motion of every trial. Raises `MissingError`."""
    found: dict[int, list[Point]] = {}
    for row in rows_of(evidence, result, "trajectories", where, needs=[*_NEEDS, "trial"]):
        found.setdefault(row["trial"], []).append(Point(*(row[name] for name in _NEEDS)))
    return list(found.values())


@check
def contacts(evidence: ResultSet, result: str, where: Where | None = None) -> float:
    """Number of times a recorded knob enters the wall."""
    track = motion(evidence, result, where)
    inside = [point.angle < 0.0 for point in track]
    return inside[0] + sum(now and not before for before, now in itertools.pairwise(inside))


@check
def left_after(evidence: ResultSet, result: str, seconds: float, where: Where | None = None) -> float | None:
    """Peak to peak of what is left of a motion so many seconds after first contact, over its depth in the wall, %."""
    track = motion(evidence, result, where)
    first = next((point.time for point in track if point.angle < 0.0), None)
    if first is None:
        return None
    left = [point.angle for point in track if point.time >= first + seconds]
    return 100.0 * (max(left) - min(left)) / -min(point.angle for point in track) if left else None


@check
def reading_offset(evidence: ResultSet, result: str, statistic: str = "mean") -> float | None:
    """Depth that a recorded wall's torque answers, less the depth of the knob, in counts; over the time in the wall.

    ``statistic``: `mean` over time, or `least`. For a controller without a sample clock.
    """
    rows = rows_of(evidence, result, "trajectories", needs=[*_NEEDS, COUNTS])
    quantum, stiffness = 2.0 * pi / rows[0][COUNTS], evidence[result].scene.wall.stiffness
    track = motion(evidence, result)
    pairs = [(now, then) for now, then in itertools.pairwise(track) if now.torque > 0.0]
    if statistic != "mean":
        offsets = (now.torque / stiffness + point.angle for now, then in pairs for point in (now, then))
        found = one_number(offsets, statistic)
        return None if found is None else found / quantum
    total = sum(then.time - now.time for now, then in pairs)
    middles = ((now, then, now.torque / stiffness + 0.5 * (now.angle + then.angle)) for now, then in pairs)
    return sum((then.time - now.time) * middle for now, then, middle in middles) / (quantum * total) if pairs else None


@check
def staircase_asymmetry(evidence: ResultSet, result: str) -> float | None:
    """Largest distance, counts, between the angles of a torque step on the way into and out of a recorded wall."""
    rows = rows_of(evidence, result, "trajectories", needs=[*_NEEDS, COUNTS])
    quantum, stiffness = 2.0 * pi / rows[0][COUNTS], evidence[result].scene.wall.stiffness
    track = motion(evidence, result)
    ways: tuple[dict[int, float], dict[int, float]] = ({}, {})
    for before, now in itertools.pairwise(track):
        if abs(now.torque - before.torque) > 0.5 * stiffness * quantum:
            step = round(max(now.torque, before.torque) / (stiffness * quantum))
            ways[now.velocity > 0.0].setdefault(step, now.angle)
    both = ways[0].keys() & ways[1].keys()
    return one_number((abs(ways[0][step] - ways[1][step]) / quantum for step in both), "largest")


class Switch(NamedTuple):
    """A change of torque: at a sample?, angle past the edge over the peak to peak (signed), delay in sample periods."""

    at_sample: bool
    distance: float
    delay: float


@check
def switches_at_samples(evidence: ResultSet, result: str, after: float, where: Where | None = None) -> float | None:
    """Share of the torque's changes, %, that happen at a sample; ``after``: s, when the motion is steady."""
    return percent(switch.at_sample for switch in _switches(evidence, result, after, where))


@check
def switch_distance(
    evidence: ResultSet, result: str, after: float, statistic: str = "least", where: Where | None = None
) -> float | None:
    """How far past the count edge the torque changes, % of peak to peak; ``after``: s, when the motion is steady."""
    return one_number((100.0 * one.distance for one in _switches(evidence, result, after, where)), statistic)


@check
def switch_delay(
    evidence: ResultSet, result: str, after: float, statistic: str = "mean", where: Where | None = None
) -> float | None:
    """Time from the crossing of a count edge to the change of torque, in sample periods, over all recorded trials.

    Crossings are interpolated between rows; ``after``: s, when the motion is steady.
    """
    return one_number((one.delay for one in _switches(evidence, result, after, where)), statistic)


def _switches(evidence: ResultSet, result: str, after: float, where: Where | None) -> list[Switch]:
    row = rows_of(evidence, result, "trajectories", where, needs=[RATE, COUNTS])[0]
    quantum, rate = 2.0 * pi / row[COUNTS], row[RATE]
    found: list[Switch] = []
    for whole in trials(evidence, result, where):
        track = [point for point in whole if point.time >= after]
        size = max(point.angle for point in track) - min(point.angle for point in track)
        for i in range(1, len(track)):
            if track[i].torque != track[i - 1].torque:
                crossing = _crossing(track, i, quantum)
                if crossing:
                    at, edge = crossing
                    delay, distance = (track[i].time - at) * rate, abs(track[i].angle - edge) / size
                    found.append(Switch(track[i].event == "sample", distance, delay))
    return found


def _crossing(track: list[Point], end: int, quantum: float) -> tuple[float, float] | None:
    """Time and angle of the last crossing of a count edge before row ``end``."""
    for i in range(end, 0, -1):
        a, b = track[i - 1], track[i]
        low, high = floor(a.angle / quantum), floor(b.angle / quantum)
        if low != high:
            edge = max(low, high) * quantum
            return a.time + (b.time - a.time) * (edge - a.angle) / (b.angle - a.angle), edge
    return None


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
