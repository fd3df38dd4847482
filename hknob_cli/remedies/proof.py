"""The proof of a periodic motion under a controller, for many orbits of one period at once.

Between two counts, and between two signs of a controller's guards, a sample is an affine map of the state (position,
velocity, memory), and so is a period of n samples while nothing switches. Perturbed copies beside the orbit give its
derivative A exactly but for rounding, Newton's method the fixed point. With P = sum of (A^k)^T A^k the distance
sqrt(d^T P d) of another motion falls from period to period, and where it is so small that no sample of the period can
reach a switch the motion stays with the orbit for ever: the trial that found it is captured. Where P does not exist, or
a switch is nearer than that, nothing is proven.
"""

from typing import NamedTuple

import numpy as np

from hknob_cli.remedies.lanes import Array
from hknob_cli.remedies.motion import Mover, State, Step

NUDGE = 1e-7  # of the perturbed copies, relative
NEWTON = 3  # steps at most; of an affine map the first is exact
CLOSED = 1e-12
SURE = 1e-9  # counts, relative to the position: what rounding may move a sample by


class Orbits(NamedTuple):
    """Orbits of one period n, one a lane.

    ``start``: state at the first sample; ``proven``; ``margin``: least distance of a sample or look to a count edge;
    ``closure``: what the position misses after a period; ``x``, ``v`` (n m + 1, lanes), ``drive`` (n m, lanes): the
    motion over the m parts of each interval. ``contracts``: whether nearby motions approach it. ``turn``: samples after
    which the orbit is back already, n or a divisor of it.
    """

    start: State
    proven: np.ndarray
    contracts: np.ndarray
    margin: Array
    closure: Array
    x: Array
    v: Array
    drive: Array
    turn: np.ndarray


class _Run(NamedTuple):
    steps: list[Step]
    first: State
    last: State


def prove(mover: Mover, found: State, period: int) -> Orbits:
    """Orbits of ``period`` samples near the states ``found``, one a lane."""
    lanes = len(found.x)
    size = 2 + len(found.memory)
    copies = np.repeat(np.arange(lanes), size + 1)
    wide = mover.take(copies)
    z = np.concatenate([found.x[None], found.v[None], found.memory])
    nudge = NUDGE * (1.0 + np.abs(z))
    for turn in range(NEWTON + 1):
        run = _run(wide, _copies(z, nudge, found.seen, copies), period)
        base, slopes = _split(_rows(run.last), nudge, lanes)
        if turn == NEWTON or (np.abs(base - z) <= CLOSED * (1.0 + np.abs(z))).all():
            break
        z = z + _solve(slopes, base - z)
    off = np.concatenate([found.x[None], found.v[None], found.memory]) - z
    form, contracts = _form(_without_latched(slopes, off))
    reach = np.sqrt(np.maximum(np.einsum("il,lij,jl->l", off, form, off), 0.0))
    root = np.linalg.inv(np.linalg.cholesky(form))  # P = L L^T; a functional r is bounded by |L^-1 r|
    margin = np.full(lanes, np.inf)
    safe = contracts & (np.abs(base - z) <= SURE * (1.0 + np.abs(z))).all(axis=0)
    for i, step in enumerate(run.steps):
        here = run.first if i == 0 else run.steps[i - 1].state
        watched = [here.x, *(step.looked if step.looked is not None else ())]
        sure = SURE * (1.0 + np.abs(here.x[:: size + 1]))
        for j, values in enumerate([*watched, *step.guards]):  # counts first, then guards
            at, rows = _split(values[None], nudge, lanes)
            distance = np.abs(at[0] - np.round(at[0])) if j < len(watched) else np.abs(at[0])
            if j < len(watched):
                margin = np.minimum(margin, distance)
            with np.errstate(invalid="ignore"):
                bend = np.sqrt(((root @ rows[:, 0, :, None])[..., 0] ** 2).sum(axis=1))
                safe &= (bend == 0.0) | (reach * bend + sure < distance)
    x, v, drive = _parts(mover, run, size + 1)
    return Orbits(
        start=_every(run.first, size + 1),
        proven=safe,
        contracts=contracts,
        margin=margin,
        closure=np.abs(base[0] - z[0]),
        x=x,
        v=v,
        drive=drive,
        turn=_turn(run, size + 1, period),
    )


def _rows(state: State) -> Array:
    return np.concatenate([state.x[None], state.v[None], state.memory])


def _copies(z: Array, nudge: Array, seen: Array | None, copies: np.ndarray) -> State:
    """Each state, then copies of it with one of its rows nudged."""
    size, lanes = z.shape
    wide = np.repeat(z[:, :, None], size + 1, axis=2)
    for row in range(size):
        wide[row, :, row + 1] += nudge[row]
    flat = wide.reshape(size, lanes * (size + 1))
    return State(flat[0], flat[1], flat[2:], None if seen is None else seen[:, copies])


def _run(mover: Mover, state: State, period: int) -> _Run:
    steps, first = [], state
    for _ in range(period):
        step = mover.step(state)
        steps.append(step)
        state = step.state
    return _Run(steps, first, state)


def _split(rows: Array, nudge: Array, lanes: int) -> tuple[Array, Array]:
    """Values of the base lanes (rows, lanes), and slopes by each state (lanes, rows, size)."""
    each = rows.reshape(len(rows), lanes, -1)
    base = each[:, :, 0]
    slopes = (each[:, :, 1:] - base[:, :, None]) / nudge.T[None]
    return base, slopes.transpose(1, 0, 2)


def _solve(slopes: Array, residual: Array) -> Array:
    """Newton's step, (size, lanes); by least squares where a direction is neutral."""
    size = slopes.shape[1]
    left = np.eye(size) - slopes
    with np.errstate(all="ignore"):
        usable = np.isfinite(left).all(axis=(1, 2))
        left[~usable] = np.eye(size)
        inverse = np.linalg.pinv(left, rcond=1e-10)
    step = np.asarray((inverse @ residual.T[..., None])[..., 0].T)
    step[:, ~usable] = 0.0
    return step


def _form(slopes: Array) -> tuple[Array, np.ndarray]:
    """P of each lane, (lanes, size, size), by doubling the sum; and where it exists."""
    power = slopes.copy()
    size = power.shape[1]
    form = np.broadcast_to(np.eye(size), power.shape).copy()
    alive = np.isfinite(power).all(axis=(1, 2))
    power[~alive] = 0.0
    for _ in range(40):
        form = form + power.transpose(0, 2, 1) @ form @ power
        power = power @ power
        wild = ~(np.abs(power).max(axis=(1, 2)) < 1e30)
        alive &= ~wild
        power[wild], form[wild] = 0.0, np.eye(size)
    alive &= np.abs(power).max(axis=(1, 2)) < 1e-6
    form[~alive] = np.eye(size)
    return form, alive


def _without_latched(slopes: Array, off: Array) -> Array:
    """Slopes without what is remembered unchanged, as a count or a time is: where it is equal it stays equal."""
    size = slopes.shape[1]
    same = (np.abs(slopes - np.eye(size)) <= 1e-9).all(axis=2) & (np.abs(off.T) <= 1e-12)
    found = slopes.copy()
    found[same] = 0.0
    found.transpose(0, 2, 1)[same] = 0.0
    return found


def _turn(run: _Run, stride: int, period: int) -> np.ndarray:
    """The shortest of the period's divisors after which the base lanes are where they began."""
    begin = _rows(_every(run.first, stride))
    found = np.full(begin.shape[1], period)
    for turn in sorted((d for d in range(1, period) if period % d == 0), reverse=True):
        there = _rows(_every(run.steps[turn - 1].state, stride))
        found[(np.abs(there - begin) <= SURE * (1.0 + np.abs(begin))).all(axis=0)] = turn
    return found


def _every(state: State, stride: int) -> State:
    return State(
        state.x[::stride],
        state.v[::stride],
        state.memory[:, ::stride],
        None if state.seen is None else state.seen[:, ::stride],
    )


def _parts(mover: Mover, run: _Run, stride: int) -> tuple[Array, Array, Array]:
    """The motion of the base lanes over every part of every interval."""
    xs, vs, drives = [], [], []
    at = _every(run.first, stride)
    x, v = at.x, at.v
    for step in run.steps:
        for drive, flow in zip(step.drives, mover.flows, strict=True):
            xs.append(x)
            vs.append(v)
            drives.append(drive[::stride])
            y = drives[-1] - mover.lanes.beta * x
            x, v = x + (flow.s * v + flow.g * y), flow.f * v + flow.s * y
        x, v = step.state.x[::stride], step.state.v[::stride]
    xs.append(x)
    vs.append(v)
    return np.stack(xs), np.stack(vs), np.stack(drives)
