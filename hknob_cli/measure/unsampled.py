"""A trial without a sample clock, measured in SI: where it ends, how soon, and its exact motion on the way."""

from collections.abc import Callable, Mapping
from math import inf, isfinite, nan, sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hknob_cli.engine.budget import FINEST
from hknob_cli.engine.outcome import Outcome, Reason
from hknob_cli.engine.propagator import hold_coefficients
from hknob_cli.engine.unsampled import settling
from hknob_cli.engine.unsampled.state_machine import (
    Unsampled,
    acceleration,
    heading,
    piece_drive,
    piece_stiffness,
    place,
    potential,
    rest_range,
    wall_potential,
)
from hknob_cli.errors import ComputationError
from hknob_cli.scene.plain_knob import UnsampledKnob

Array = NDArray[np.float64]
Functions = Mapping[str, Callable[..., Any]]

PEAKS = 1000  # bounces over which the energy of an undamped motion is watched
CHATTER = 1e-6  # counts: a recording ends chatter over an edge that gets no further from it
_EPSILON = 2.0**-52


class UnsampledTrial(NamedTuple):
    """End and measures of one trial; NaN where the outcome has none.

    Peak-to-peak is peak minus trough, and with it minimum, maximum, RMS and frequency are of the motion that a trial
    ends in: a period of an undamped one, all 0 but the angle at rest. ``contact_s``: first contact with the wall;
    ``settling_s``: from the start until the remaining motion stays within one count (1 % of the first bounce without
    an encoder). ``bounces``: times the knob left the wall, ``events``: count edges and turning points met, both until
    it had settled. ``energy_drift``: largest departure of the energy at a peak of an undamped motion from that at the
    start, relative to the energy above rest. Work of the wall and losses are from the start to rest, by the balance of
    energy; 0 for a period.
    """

    outcome: Outcome
    reason: Reason
    p2p_rad: float = nan
    min_rad: float = nan
    max_rad: float = nan
    rms_rad: float = nan
    frequency_hz: float = nan
    cycles: int = 0
    contact_s: float = nan
    settling_s: float = nan
    bounces: int = 0
    events: int = 0
    energy_drift: float = nan
    wall_work_j: float = nan
    damping_loss_j: float = nan
    friction_loss_j: float = nan

    @property
    def certified(self) -> bool:
        """Whether the outcome is proven."""
        return self.reason is Reason.NONE


def settle(
    knob: UnsampledKnob,
    *,
    angle_rad: float,
    velocity_rad_s: float,
    max_events: int,
    max_peaks: int = PEAKS,
    functions: Functions | None = None,
) -> UnsampledTrial:
    """Follow one trial to its end, or through ``max_events`` events; an undamped one through ``max_peaks`` bounces.

    ``functions``: the engine compiled, by name; the interpreter if None.
    """
    loop = knob.loop
    x, v = knob.position(angle_rad), knob.speed(velocity_rad_s)
    energy = 0.5 * v * v + potential(x, loop)
    if _reach(x, v, loop) >= FINEST:
        return UnsampledTrial(Outcome.UNDECIDED, Reason.TOO_FINE)
    low, high = rest_range(loop)
    single = isfinite(low) and isfinite(high) and high - low <= 16.0 * _EPSILON * (1.0 + abs(low))
    follow = functions["unsampled.settle_motion"] if functions else settling.settle_motion
    fate, end, events, bounces, contact, settled, path, top, bottom, drift = follow(
        x, v, loop.counted, single, max_events, max_peaks, loop
    )
    met = UnsampledTrial(
        Outcome.UNDECIDED,
        Reason.EVENT_LIMIT,
        contact_s=contact * knob.unit_s if contact < inf else nan,
        bounces=int(bounces),
        events=int(events),
    )
    if fate == settling.GOES_AWAY:
        return met._replace(outcome=Outcome.DIVERGED, reason=Reason.LEAVES)
    if fate == settling.OUT_OF_EVENTS:
        return met
    if fate == settling.BOUNCES_ON:
        moments = functions["unsampled.swing_moments"] if functions else settling.swing_moments
        middle = 0.5 * (top + bottom)
        half, bottom, first, second = moments(top, middle, loop)
        mean = first / half
        return met._replace(
            outcome=Outcome.CYCLE,
            reason=Reason.CONSERVATIVE,
            p2p_rad=(top - bottom) * knob.unit_rad,
            min_rad=knob.angle_rad(bottom),
            max_rad=knob.angle_rad(top),
            rms_rad=sqrt(max(second / half - mean * mean, 0.0)) * knob.unit_rad,
            frequency_hz=0.5 / (half * knob.unit_s),
            cycles=1,
            energy_drift=drift / (energy - potential(low, loop)),
            wall_work_j=0.0,
            damping_loss_j=0.0,
            friction_loss_j=0.0,
        )
    rest = 0.5 * (low + high) if single else end
    lost = energy - potential(rest, loop)
    rubbed = loop.phi * path if loop.alpha > 0.0 else lost if loop.phi > 0.0 else 0.0
    theta = knob.angle_rad(rest)
    return met._replace(
        outcome=Outcome.REST,
        reason=Reason.REST_ON_EDGE if single and _is_doubtful(rest, loop) else Reason.NONE,
        p2p_rad=0.0,
        min_rad=theta,
        max_rad=theta,
        rms_rad=0.0,
        frequency_hz=0.0,
        settling_s=settled * knob.unit_s,
        wall_work_j=(wall_potential(x, loop) - wall_potential(rest, loop)) * knob.energy_j,
        damping_loss_j=(lost - rubbed) * knob.energy_j if loop.alpha > 0.0 else 0.0,
        friction_loss_j=rubbed * knob.energy_j,
    )


def _reach(x: float, v: float, loop: Unsampled) -> float:
    """Largest position that a motion is likely to meet, roughly."""
    spring = loop.kappa + loop.beta
    static = loop.gamma / spring if spring > 0.0 else 0.0
    swing_to = sqrt(2.0 * max(v * v, loop.gamma * abs(x)) / spring) if spring > 0.0 else 0.0
    return max(abs(x), abs(static), abs(v), swing_to)


def _is_doubtful(rest: float, loop: Unsampled) -> bool:
    """Whether rounding decides if the only rest point lies on a count edge or beside it."""
    if loop.counted == 0.0 or loop.kappa == 0.0:
        return False
    bound = 8.0 * _EPSILON * (loop.kappa * (abs(rest) + 1.0) + abs(loop.gamma) + loop.beta * abs(rest) + loop.phi)
    if rest <= 0.0 and rest == round(rest):
        falls, rises = acceleration(-rest, rest, 1.0, loop), acceleration(1.0 - rest, rest, -1.0, loop)
        return not falls < -bound < bound < rises
    nearest = min(round(rest), 0)
    return loop.beta * abs(rest - nearest) <= bound


class Motion(NamedTuple):
    """The exact motion of one trial up to ``duration_s``, told by its events.

    ``rows``, shape (events + 1, 6): time, piece, edge, position beside the edge, velocity, direction (0: at rest), just
    after each event; the first is the start.
    """

    knob: UnsampledKnob
    duration_s: float
    rows: Array

    @property
    def time_s(self) -> Array:
        """Times of the events."""
        return self.rows[:, 0] * self.knob.unit_s

    @property
    def angle_rad(self) -> Array:
        """Angle at each event."""
        return (self.rows[:, 2] + self.rows[:, 3] + self.knob.shift) * self.knob.unit_rad

    @property
    def velocity_rad_s(self) -> Array:
        """Velocity at each event."""
        return self.rows[:, 4] * (self.knob.unit_rad / self.knob.unit_s)

    @property
    def torque_nm(self) -> Array:
        """Torque of the wall just after each event."""
        return np.array([self._torque(row, row[2] + row[3]) for row in self.rows])

    def at(self, times_s: Array) -> tuple[Array, Array, Array]:
        """Angle (rad), velocity (rad/s) and wall torque (N·m) at ``times_s``, shape (n,), within the duration.

        Raises `ValueError` for a time outside it.
        """
        times = np.asarray(times_s, dtype=float)
        if times.size and not (times.min() >= 0.0 and times.max() <= self.duration_s):
            raise ValueError(f"times must lie between 0 and {self.duration_s:g} s")
        knob, loop = self.knob, self.knob.loop
        out = np.empty((3, len(times)))
        index = np.searchsorted(self.time_s, times, side="right") - 1
        for i, (row, time) in enumerate(zip(self.rows[index], times / knob.unit_s, strict=True)):
            t, n, edge, u, v, way = (float(value) for value in row)
            if way != 0.0:
                y = acceleration(n, edge + u, way, loop)
                s, g, f = hold_coefficients(loop.alpha, piece_stiffness(n, loop), max(time - t, 0.0))
                u, v = u + (s * v + g * y), f * v + s * y
            x = edge + u
            out[:, i] = knob.angle_rad(x), v * knob.unit_rad / knob.unit_s, self._torque(row, x)
        return out[0], out[1], out[2]

    def _torque(self, row: Array, x: float) -> float:
        """Wall torque at ``x`` in a row's piece; at rest on an edge the mean of what it switches between."""
        loop = self.knob.loop
        n, edge, u, way = float(row[1]), float(row[2]), float(row[3]), float(row[5])
        if loop.counted == 0.0:
            wall = max(-loop.kappa * x, 0.0)
        elif way == 0.0 and u == 0.0:
            above, below = (piece_drive(m, loop) + loop.gamma for m in (-edge, 1.0 - edge))
            wall = min(max(loop.gamma + loop.beta * edge, above), below)
        else:
            wall = piece_drive(n, loop) + loop.gamma
        return wall * self.knob.torque_nm


def events(
    knob: UnsampledKnob,
    *,
    angle_rad: float,
    velocity_rad_s: float,
    duration_s: float,
    chatter_counts: float = CHATTER,
    max_events: int = 2_000_000,
    functions: Functions | None = None,
    look: Callable[[], None] = lambda: None,
) -> Motion:
    """Exact motion of a trial up to ``duration_s``.

    Chatter over a count edge that ends in rest on it is rest as soon as it stays within ``chatter_counts`` of the
    edge. ``look`` is called whenever the motion has grown to twice as long, and may end it by raising. Raises
    `ComputationError` where there are more than ``max_events`` events, or its numbers overflow.
    """
    loop = knob.loop
    x, v = knob.position(angle_rad), knob.speed(velocity_rad_s)
    until = duration_s / knob.unit_s
    if not isfinite((1.0 + abs(x) + abs(v)) * until * until):
        raise ComputationError("the scene's numbers overflow")
    low, high = rest_range(loop)
    single = isfinite(low) and isfinite(high) and high - low <= 16.0 * _EPSILON * (1.0 + abs(low))
    n, edge, u = place(x, v, loop)
    way = 1.0 if v > 0.0 else -1.0
    if v == 0.0:
        n, way = heading(n, edge, u, loop)
    record = functions["unsampled.record_motion"] if functions else settling.record_motion
    ending = settling.Ending(until, single, low, chatter_counts)
    rows = np.zeros((256, 6))
    rows[0] = 0.0, n, edge, u, v, way
    filled, done = 1, way == 0.0
    while not done:
        if filled == len(rows):
            look()
            rows = np.concatenate([rows, np.zeros_like(rows)])
        state = tuple(rows[filled - 1].tolist())
        filled, done = record(state, ending, loop, rows.reshape(-1), filled, len(rows))
        if filled - 1 > max_events:  # the first row is the start
            raise ComputationError(f"more than {max_events} events in {duration_s:g} s")
    return Motion(knob=knob, duration_s=duration_s, rows=rows[:filled].copy())
