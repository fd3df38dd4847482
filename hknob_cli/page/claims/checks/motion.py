"""Recorded motions: contacts with the wall, what is left of them, and when the torque switches."""

import itertools
from math import floor, pi
from typing import NamedTuple

from hknob_cli.page.claims.checks import check
from hknob_cli.page.claims.checks.rows import one_number, percent, rows_of
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
