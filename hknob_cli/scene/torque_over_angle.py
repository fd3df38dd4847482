"""Torque over the measured angle: wall, profile, detents, end stops and dead zone as one table, or as a curve.

A count stands for one angle, so it has one torque. Where a pattern goes round the knob, its place in the turn is
computed with whole numbers: a count that lies half way between two detents does so exactly.

A continuous sensor has no counts: nothing is summed up in a table, and each part is a function of the angle, the
engine's curve.
"""

from math import gcd, inf, isfinite, lcm, pi
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from hknob_cli.engine.general.torque_curve import (
    CENTRE,
    DETENT,
    FAR,
    HALF,
    HEAD,
    HIGH,
    HIGHEST,
    LOW,
    LOWEST,
    MIDDLE,
    MOST,
    POINTS,
    SHAPE,
    SINE,
    SPACING,
    SPAN,
    SPRING,
    SPRUNG,
    STEPPED,
    STOP,
    TRIANGLE,
    ZONE,
)
from hknob_cli.errors import ComputationError
from hknob_cli.specs.over_angle import OVER_ANGLE, DeadZone, Detents, EndStops, Profile, ways_round
from hknob_cli.specs.plan import Scene

Array = NDArray[np.float64]
Counts = NDArray[np.int64]

MOST_ENTRIES = 2**22  # of a table, 100 MB
NEAR = 1e-9  # of a count: what lies so near to a step is on it


class Piece(NamedTuple):
    """Part of a torque over the angle: N·m at every count of a window.

    ``low``, ``high``: counts between which it is irregular; ``below``, ``above``: stiffness of the springs outside of
    these, N·m/rad; ``turn``: counts after which it repeats outside of these, 1 for a constant or a spring.
    """

    torque: Array
    low: float = 0.0
    high: float = 0.0
    below: float = 0.0
    above: float = 0.0
    turn: int = 1


class Clock(NamedTuple):
    """Counts of a revolution, the angle of one (rad), and what is added to a count for the angle it reports."""

    counts: int
    quantum_rad: float
    offset: float


class Parts(Protocol):
    """What has torques over the angle: a scene, or a campaign on a knob."""

    @property
    def profile(self) -> Profile | None:
        """Torque point by point."""

    @property
    def detents(self) -> Detents | None:
        """Places of rest."""

    @property
    def end_stops(self) -> EndStops | None:
        """Springs outside of a range."""

    @property
    def dead_zone(self) -> DeadZone | None:
        """A spring outside of a zone."""


def is_shaped(scene: Scene) -> bool:
    """Whether a scene has a torque over the angle other than its wall."""
    return any(getattr(scene, name) for name in OVER_ANGLE)


def table_of(scene: Parts, clock: Clock, *, kappa: float, unit_nm: float) -> Array:
    """The table of parts of which there is one, as `engine.general.torque_table` has it.

    ``kappa``: of the wall, as an acceleration; ``unit_nm``: torque of a unit acceleration. Raises `ComputationError`
    where the table would be too long.
    """
    makers = [
        (scene.profile, profile_piece),
        (scene.detents, detent_piece),
        (scene.end_stops, stop_piece),
        (scene.dead_zone, zone_piece),
    ]
    there = [(part, maker) for part, maker in makers if part]
    none = np.zeros(0, dtype=np.int64)
    extents = [maker(part, none, clock) for part, maker in there]  # type: ignore[operator]
    turn = lcm(*(one.turn for one in extents))
    low = min(-1.0, *(one.low for one in extents)) - 2.0 * turn - 2.0
    high = max(0.0, *(one.high for one in extents)) + 2.0 * turn + 2.0
    if not (high - low) < MOST_ENTRIES:
        raise ComputationError(
            f"at {clock.counts} counts the torque over the angle takes a table of {high - low:.3g} counts, at most "
            f"{MOST_ENTRIES}: choose fewer counts, or nearer ends"
        )
    window = np.arange(int(low), int(high) + 1, dtype=np.int64)
    command = np.where(window < 0, -kappa * (window + clock.offset), 0.0)
    for part, maker in there:
        command = command + maker(part, window, clock).torque / unit_nm  # type: ignore[operator]
    per_count = clock.quantum_rad / unit_nm
    below = -turn * (kappa + per_count * sum(one.below for one in extents))
    above = -turn * per_count * sum(one.above for one in extents)
    lows, highs = _runs(command, int(window[0]), turn, below, above)
    return np.concatenate([[float(window[0]), float(turn), below, above], command, lows, highs])


def _runs(command: Array, first: int, turn: int, below: float, above: float) -> tuple[Array, Array]:
    """For each count the lowest and the highest of the run that it is in; infinite where the table goes on with it."""
    longer = np.concatenate([command[:turn] - 2 * below, command[:turn] - below, command])
    longer = np.concatenate([longer, command[-turn:] + above, command[-turn:] + 2 * above])
    begins = np.concatenate([[True], longer[1:] != longer[:-1]])
    starts = np.flatnonzero(begins)
    ends = np.append(starts[1:], len(longer)) - 1
    which = np.cumsum(begins) - 1
    lows, highs = starts.astype(np.float64), ends.astype(np.float64)
    lows, highs = lows + (first - 2 * turn), highs + (first - 2 * turn)
    lows[0], highs[-1] = -inf, inf
    inner = which[2 * turn : 2 * turn + len(command)]
    return lows[inner], highs[inner]


def _phase(counts: Counts, clock: Clock, *, times: int, turns: int, centre: float) -> Array:
    """Place of each count in a pattern, 0 at ``centre``, that goes ``times`` round in ``turns`` revolutions."""
    whole = (counts * times) % (clock.counts * turns)
    span = clock.counts * turns / times
    place: Array = whole / (clock.counts * turns) + (clock.offset - centre / clock.quantum_rad) / span
    return place


def profile_piece(part: Profile, counts: Counts, clock: Clock) -> Piece:
    """A torque that is given point by point."""
    angles, torques = np.array(part.points, dtype=np.float64).T
    places: Array
    at: Array
    if part.periodic:
        span = float(angles[-1] - angles[0])
        times, turns = ways_round(span) or (1, 1)
        phase = _phase(counts, clock, times=times, turns=turns, centre=float(angles[0]))
        near = NEAR * times / (clock.counts * turns)
        places = (angles - angles[0]) / span
        at = phase - np.floor(phase + near)
        turn = clock.counts * turns // gcd(clock.counts * turns, times)
        piece = Piece(np.zeros(0), turn=turn)
    else:
        places = np.asarray(angles / clock.quantum_rad, dtype=np.float64)
        at, near = np.asarray(counts + clock.offset, dtype=np.float64), NEAR
        piece = Piece(np.zeros(0), low=float(np.floor(places[0])) - 1.0, high=float(np.ceil(places[-1])) + 1.0)
    if part.interpolation == "stepped":
        found = np.searchsorted(places, at + near, side="right") - 1
        return piece._replace(torque=torques[np.maximum(found, 0)])
    return piece._replace(torque=np.interp(at, places, torques))


def detent_piece(part: Detents, counts: Counts, clock: Clock) -> Piece:
    """Places of rest at equal distances, each with a torque towards it."""
    spacing = part.spacing or 2.0 * pi / (part.per_revolution or 1)
    ways = (part.per_revolution, 1) if part.per_revolution else ways_round(spacing)
    if ways and ways[1] == 1:
        phase = _phase(counts, clock, times=ways[0], turns=1, centre=part.centre)
    else:
        phase = np.asarray(((counts + clock.offset) * clock.quantum_rad - part.centre) / spacing, dtype=np.float64)
    away = phase - np.floor(phase + 0.5 + NEAR * clock.quantum_rad / spacing)
    torque: Array = -part.torque * _shape(part, np.clip(away, -0.5, 0.5), spacing)
    if part.range is None:
        times = ways[0] if ways else 1
        return Piece(torque, turn=clock.counts // gcd(clock.counts, times))
    low, high = (angle / clock.quantum_rad for angle in part.range)
    at = counts + clock.offset
    inside = (at >= low - NEAR) & (at <= high + NEAR)
    return Piece(torque * inside, low=float(np.floor(low)) - 1.0, high=float(np.ceil(high)) + 1.0)


def _shape(part: Detents, away: Array, spacing: float) -> Array:
    """The pull of a detent, 1 at the most; ``away``: distance from it in spacings, at most a half either way."""
    size = np.abs(away)
    if part.shape == "sine":
        pull: Array = np.sin(2.0 * pi * away)
        return pull
    if part.shape == "triangle":
        return np.sign(away) * np.minimum(4.0 * size, 2.0 - 4.0 * size)
    zone = 0.5 * part.dead_zone / spacing
    return np.sign(away) * np.maximum(0.0, size - zone) / (0.5 - zone)


def stop_piece(part: EndStops, counts: Counts, clock: Clock) -> Piece:
    """Springs outside of a range."""
    at = (counts + clock.offset) * clock.quantum_rad
    low, high = (-inf if part.low is None else part.low), (inf if part.high is None else part.high)
    torque = part.stiffness * (np.maximum(low - at, 0.0) - np.maximum(at - high, 0.0))
    ends = [float(np.rint(angle / clock.quantum_rad)) for angle in (low, high) if abs(angle) < inf]
    return Piece(
        torque,
        low=min(ends) - 2.0,
        high=max(ends) + 2.0,
        below=0.0 if part.low is None else part.stiffness,
        above=0.0 if part.high is None else part.stiffness,
    )


def zone_piece(part: DeadZone, counts: Counts, clock: Clock) -> Piece:
    """A spring back to a zone in which there is no torque."""
    away = (counts + clock.offset) * clock.quantum_rad - part.centre
    over = np.sign(away) * np.maximum(np.abs(away) - 0.5 * part.width, 0.0)
    most = inf if part.torque is None else part.torque
    torque = -np.clip(part.stiffness * over, -most, most)
    endless = part.torque is None or part.stiffness == 0.0
    far = 0.5 * part.width + (0.0 if endless else most / part.stiffness)
    spring = part.stiffness if endless else 0.0
    return Piece(
        torque,
        low=float(np.floor((part.centre - far) / clock.quantum_rad)) - 2.0,
        high=float(np.ceil((part.centre + far) / clock.quantum_rad)) + 2.0,
        below=spring,
        above=spring,
    )


SHAPES = {"sine": SINE, "triangle": TRIANGLE, "spring": SPRUNG}


def curve_of(scene: Parts, *, quantum_rad: float, unit_nm: float) -> Array:
    """The curve of parts of which there is one, as `engine.general.torque_curve` has it.

    ``quantum_rad``: angle of a count; ``unit_nm``: torque of a unit acceleration.
    """
    points = len(scene.profile.points) if scene.profile else 0
    curve = np.zeros(HEAD + 2 * points)
    curve[[SPACING, HIGH, HIGHEST]] = 1.0, inf, inf
    curve[[LOW, LOWEST]] = -inf
    if scene.profile:
        _add_profile(curve, scene.profile, quantum_rad, unit_nm)
    if scene.detents:
        _add_detents(curve, scene.detents, quantum_rad, unit_nm)
    if scene.end_stops:
        _add_stops(curve, scene.end_stops, quantum_rad, unit_nm)
    if scene.dead_zone:
        _add_zone(curve, scene.dead_zone, quantum_rad, unit_nm)
    places = [*curve[[CENTRE, LOW, HIGH, LOWEST, HIGHEST, MIDDLE, HALF]], *curve[HEAD : HEAD + points]]
    curve[FAR] = max(abs(float(place)) for place in places if isfinite(place))
    return curve


def _add_profile(curve: Array, part: Profile, quantum: float, unit: float) -> None:
    count = len(part.points)
    angles, torques = np.array(part.points, dtype=np.float64).T
    curve[HEAD : HEAD + count], curve[HEAD + count :] = angles / quantum, torques / unit
    curve[POINTS], curve[STEPPED] = count, part.interpolation == "stepped"
    if part.periodic:
        times, turns = ways_round(float(angles[-1] - angles[0])) or (1, 1)
        curve[SPAN] = 2.0 * pi * turns / times / quantum


def _add_detents(curve: Array, part: Detents, quantum: float, unit: float) -> None:
    spacing = part.spacing or 2.0 * pi / (part.per_revolution or 1)
    curve[DETENT], curve[SHAPE] = part.torque / unit, SHAPES[part.shape]
    curve[SPACING], curve[CENTRE], curve[ZONE] = spacing / quantum, part.centre / quantum, part.dead_zone / quantum
    if part.range is not None:
        curve[[LOW, HIGH]] = part.range[0] / quantum, part.range[1] / quantum


def _add_stops(curve: Array, part: EndStops, quantum: float, unit: float) -> None:
    curve[STOP] = part.stiffness * quantum / unit
    curve[LOWEST] = -inf if part.low is None else part.low / quantum
    curve[HIGHEST] = inf if part.high is None else part.high / quantum


def _add_zone(curve: Array, part: DeadZone, quantum: float, unit: float) -> None:
    curve[SPRING], curve[MIDDLE] = part.stiffness * quantum / unit, part.centre / quantum
    curve[HALF], curve[MOST] = 0.5 * part.width / quantum, inf if part.torque is None else part.torque / unit
