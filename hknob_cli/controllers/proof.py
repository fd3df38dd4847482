"""The proof of periodic motions under a controller, for many orbits at once, each of its own period.

Between two counts, and between two signs of a controller's guards, a sample is an affine map of the state (position,
velocity, memory), and so is a period of n samples while nothing switches. Copies beside the orbit give its derivative
A up to rounding, Newton's method the fixed point. With P = sum of (A^k)^T A^k the distance sqrt(d^T P d) of another
motion falls from period to period, and where it is so small that no sample of the period can reach a switch the
motion stays with the orbit for ever: the trial that found it is captured. What a controller has counted is equal in
both and stays so. Where P does not exist, or a switch is nearer than that, nothing is proven.
"""

from typing import NamedTuple

import numpy as np

from hknob_cli.controllers.batch_stepper import BatchStepper, State, take
from hknob_cli.controllers.contraction import contraction_form, fixed_point_step, frozen_rows, inverse_root, without
from hknob_cli.controllers.period_run import Path, PeriodRun, run_lap, trace_lap
from hknob_cli.controllers.plant_batch import Array, count_at

NUDGE = 1e-7  # of the copies beside an orbit, relative
ROUNDS = 2  # of Newton's method; the second where the first has changed what is counted on the way
STEPS = 2  # of Newton's method in a round
CLOSED = 1e-13  # relative; a better fixed point is not worth another step
ROUNDING = 1e-15  # of a value in a step, relative
SURE = 1e-9  # relative to the motion: what rounding may move a sample by, with all that follows from it


class Hold(NamedTuple):
    """What a proven orbit holds, of every lane, at the sample where its period begins.

    Every motion of the same ``frozen`` rows (lanes, rows) and of the same counts at the looks before stays with the
    orbit for ever, whose distance is below ``reach``: sqrt(d^T P d), d = (its rows - ``rows``) / ``scale``, both
    (rows, lanes), P = ``form`` (lanes, rows, rows).
    """

    rows: Array
    scale: Array
    form: Array
    frozen: np.ndarray
    reach: Array


class Orbits(NamedTuple):
    """Orbits, one a lane, of n samples each.

    ``proven``; ``contracts``: whether nearby motions approach it; ``off_edges``: whether no count edge is in the
    way of the proof; ``margin``: least distance of a sample or look to a
    count edge; ``closure``: what the position misses after a period; ``path`` the motion, of which the first n samples
    count; ``turn``: samples after which the orbit is back already, n or a divisor of it; ``hold``: what it captures.
    """

    proven: np.ndarray
    contracts: np.ndarray
    off_edges: np.ndarray
    margin: Array
    closure: Array
    path: Path
    turn: np.ndarray
    hold: Hold


class _Found(NamedTuple):
    orbits: Orbits
    guess: Array  # (rows, lanes)
    settled: np.ndarray  # whether the derivative is that of the orbit


def prove(mover: BatchStepper, found: State, period: np.ndarray) -> Orbits:
    """Orbits of ``period`` samples (lanes,) near the states ``found``, one a lane."""
    here = _attempt(mover, found, found.rows, period)
    orbits = here.orbits
    again = np.flatnonzero(~here.settled)
    for _ in range(ROUNDS - 1):
        if again.size == 0:
            break
        more = _attempt(mover.take(again), take(found, again), here.guess[:, again], period[again])
        _replace(orbits, again, more.orbits)
    return orbits


def _attempt(mover: BatchStepper, found: State, guess: Array, period: np.ndarray) -> _Found:
    """Newton's step from a ``guess`` (rows, lanes), and the proof of where it leads."""
    size, lanes = guess.shape
    scale = _scale(mover, guess)
    copies = np.repeat(np.arange(lanes), size + 1)
    beside = run_lap(mover.take(copies), _copies(guess, NUDGE * scale, found.seen, copies), period[copies])
    each = beside.end.rows.reshape(size, lanes, size + 1)
    slopes = ((each[:, :, 1:] - each[:, :, :1]) / (NUDGE * scale[:, :, None])).transpose(1, 0, 2)
    frozen = frozen_rows(slopes)
    slopes = without(slopes, frozen)
    missed = each[:, :, 0] - guess
    better, ahead = guess, each[:, :, 0]
    for _ in range(STEPS):  # the first leaves the rounding of the slopes, the second that of the motion
        step = fixed_point_step(slopes, np.where(frozen.T, 0.0, ahead - better) / scale) * scale
        better = np.where(frozen.T, ahead, better + step)
        lap, path = trace_lap(mover, State(better[0], better[1], better[2:], found.seen), period)
        ahead = lap.end.rows
        rest = (ahead - better) / scale
        if not (np.abs(rest) > CLOSED).any():
            break
    values = beside.values.reshape(*beside.values.shape[:2], lanes, size + 1)
    inside = np.arange(len(values))[:, None, None] < period
    unlike = _switched(mover, beside, values[..., :1], values[..., 1:]) & ~frozen
    moved_on = _switched(mover, beside, values[..., :1], lap.values[..., None])[..., 0]
    kept = (missed == 0.0) | ~frozen.T
    settled = ~((unlike.any(axis=-1) | moved_on) & inside).any(axis=(0, 1)) & kept.all(axis=0)
    noise = ROUNDING / NUDGE * (8.0 + np.sqrt(period)) * size
    form, contracts = contraction_form(slopes, noise)
    off = (found.rows - better) / scale
    amiss = _length(form, fixed_point_step(slopes, rest))
    reach = _length(form, off) + amiss
    size_of = 1.0 + np.abs(path.x).max(axis=0) + np.abs(path.drive + mover.lanes.gamma).max(axis=0) / mover.lanes.kappa
    slope = (values[..., 1:] - values[..., :1]) / NUDGE
    slope[np.broadcast_to(frozen, slope.shape)] = 0.0
    bend = _bend(inverse_root(form), slope)
    at = lap.values
    gap = np.abs(at)
    gap[:, : lap.places] = np.abs(at[:, : lap.places] - np.round(at[:, : lap.places]))
    with np.errstate(invalid="ignore"):
        clear = ((bend == 0.0) | (reach * bend + SURE * size_of < gap) | ~inside).all(axis=0)
    closed = (np.abs(rest) <= SURE).all(axis=0) & ((off.T == 0.0) & (rest.T == 0.0) | ~frozen).all(axis=1)
    counted = frozen[:, [2 + row for row in mover.remedy.counted]].all(axis=1)
    looks = True if lap.end.seen is None or found.seen is None else (lap.end.seen == found.seen).all(axis=0)
    margin = np.where(inside[:, 0], gap[:, : lap.places].min(axis=1), np.inf).min(axis=0)
    orbits = Orbits(
        proven=np.asarray(contracts & settled & clear.all(axis=0) & closed & counted & looks),
        contracts=contracts | ~settled,
        off_edges=clear[: lap.places].all(axis=0),
        margin=margin,
        closure=np.abs(lap.end.x - better[0]),
        path=path,
        turn=_turn(path.rows, period),
        hold=Hold(better, scale, form, frozen, _room(gap - SURE * size_of, bend, noise, inside) - amiss),
    )
    return _Found(orbits, better, settled)


def _scale(mover: BatchStepper, rows: Array) -> Array:
    """How large a change of each row is one of its kind, (rows, lanes)."""
    scale = 1.0 + np.abs(rows)
    lanes = mover.lanes
    scale[1] = np.abs(rows[1]) + scale[0] * np.minimum(1.0, np.sqrt(lanes.beta + lanes.kappa))
    return scale


def _copies(rows: Array, nudge: Array, seen: Array | None, copies: np.ndarray) -> State:
    """Each state, then copies of it with one of its rows nudged."""
    size, lanes = rows.shape
    wide = np.repeat(rows[:, :, None], size + 1, axis=2)
    for row in range(size):
        wide[row, :, row + 1] += nudge[row]
    flat = wide.reshape(size, lanes * (size + 1))
    return State(flat[0], flat[1], flat[2:], None if seen is None else seen[:, copies])


def _switched(mover: BatchStepper, lap: PeriodRun, one: Array, others: Array) -> np.ndarray:
    """Where ``others`` (samples, kinds, lanes, any) are on another side of a switch than ``one``."""
    sense, k = mover.lanes.sense[:, None], lap.places
    there = count_at(others[:, :k], sense) != count_at(one[:, :k], sense)
    return np.asarray(np.concatenate([there, (others[:, k:] > 0.0) != (one[:, k:] > 0.0)], axis=1))


def _length(form: Array, rows: Array) -> Array:
    """sqrt(d^T P d) of each lane."""
    return np.asarray(np.sqrt(np.maximum(np.einsum("il,lij,jl->l", rows, form, rows), 0.0)))


def _bend(root: Array, slope: Array) -> Array:
    """How far each value (samples, kinds, lanes) moves at most, over the distance of two motions."""
    samples, kinds, lanes, size = slope.shape
    flat = slope.transpose(2, 0, 1, 3).reshape(lanes, samples * kinds, size)
    with np.errstate(all="ignore"):
        found = flat @ root.transpose(0, 2, 1)
        return np.asarray(np.sqrt((found * found).sum(axis=2)).reshape(lanes, samples, kinds).transpose(1, 2, 0))


def _room(gap: Array, bend: Array, noise: Array, inside: np.ndarray) -> Array:
    """The largest distance of two motions at which no value (samples, kinds, lanes) goes further than its ``gap``.

    ``noise`` (lanes,): how wrong the slopes may be, which weigh no more than that, for P is at least the identity.
    """
    with np.errstate(all="ignore"):
        room = np.where((bend == 0.0) | ~inside, np.inf, gap / (bend + noise))
    return np.asarray(room.min(axis=(0, 1)))


def _turn(rows: Array, period: np.ndarray) -> np.ndarray:
    """The shortest of each period's divisors after which the lane is where it began."""
    found = period.copy()
    for n in np.unique(period):
        lanes = np.flatnonzero(period == n)
        begin = rows[0][:, lanes]
        for turn in sorted((d for d in range(1, int(n) // 2 + 1) if n % d == 0), reverse=True):
            back = (np.abs(rows[turn][:, lanes] - begin) <= SURE * (1.0 + np.abs(begin))).all(axis=0)
            found[lanes[back]] = turn
    return found


def _replace(orbits: Orbits, lanes: np.ndarray, more: Orbits) -> None:
    """Put the orbits of some of the lanes in place of what was there."""
    for name in ("proven", "contracts", "off_edges", "margin", "closure", "turn"):
        getattr(orbits, name)[lanes] = getattr(more, name)
    for old, new in zip(orbits.path, more.path, strict=True):
        old[: len(new), ..., lanes] = new
    orbits.hold.rows[:, lanes], orbits.hold.scale[:, lanes] = more.hold.rows, more.hold.scale
    for name in ("form", "frozen", "reach"):
        getattr(orbits.hold, name)[lanes] = getattr(more.hold, name)
