"""What trials under a controller settle to: orbits with their proof, rest, or the motion as far as it was followed."""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from hknob_cli.controllers.batch_stepper import BatchStepper, State, take
from hknob_cli.controllers.plant_batch import Array
from hknob_cli.controllers.proof import Orbits, prove
from hknob_cli.controllers.repeat import SearchBudget, find_repeats
from hknob_cli.engine.outcome import Outcome, Reason

# First a rough return, whose orbit Newton's method completes and the proof checks; for the rest a patient one.
EFFORTS = (
    SearchBudget(settle=5.0, patience=4.0, fewest=1024, near=1e-4),
    SearchBudget(settle=4.0, patience=24.0, fewest=8192, near=1e-8),
)
SAME = 1e-6  # of two orbits that are one, relative
AT_REST = 1e-9  # counts
WINDOW_S, WINDOW = 0.5, (256, 4096)  # of motion that does not repeat: time, and least and most samples
ROOM = 12_000_000  # numbers that a batch of proofs holds at once, roughly


class Settled(NamedTuple):
    """One end of trials of one cell.

    ``lane``: one of them; ``trials`` how many, or what share of all starts; ``period`` in samples, 0 where nothing
    repeats; ``x``, ``v`` (n m + 1), ``drive`` (n m): the motion over a period, or over a window where nothing repeats,
    in the m parts of each interval; ``begin``: position, velocity and memory at its first sample, and the counts at the
    looks before.
    """

    lane: int
    trials: float
    outcome: Outcome
    reason: Reason
    period: int = 0
    margin: float = 0.0
    closure: float = 0.0
    x: Array = np.empty(0)
    v: Array = np.empty(0)
    drive: Array = np.empty(0)
    begin: tuple[Array, Array | None] = (np.empty(0), None)


def settle(
    mover: BatchStepper,
    state: State,
    enter: Callable[[Settled], None],
    over: Callable[[], bool] = lambda: False,
    efforts: tuple[SearchBudget, ...] = EFFORTS,
) -> int:
    """Follow all lanes from ``state``, and ``enter`` the end of each; trial-samples taken."""
    going, samples = np.arange(len(state.x)), 0
    reason = Reason.NO_REPEAT
    for effort in efforts:
        with np.errstate(over="ignore", invalid="ignore"):
            found = find_repeats(mover.take(going), state, effort, over)
        samples += found.samples
        for lane in going[found.grew]:
            enter(Settled(int(lane), 1, Outcome.DIVERGED, Reason.GREW))
        done = found.grew.copy()
        for part in alike(found.period, (len(state.memory) + 3) * (len(mover.remedy.looks) + 5)):
            begin = take(found.state, part)
            orbits = prove(mover.take(going[part]), begin, found.period[part])
            for i, lane in enumerate(going[part]):
                if orbits.proven[i] or effort is efforts[-1]:
                    enter(_settled(mover, orbits, i, int(lane), begin.seen))
                    done[part[i]] = True
        going, state = going[~done], take(found.state, np.flatnonzero(~done))
        if len(going) == 0:
            return samples
        if over():
            reason = Reason.TIME_LIMIT
            break
    _windows(mover.take(going), state, going, enter, reason)
    return samples


def alike(period: np.ndarray, weight: int) -> Iterator[np.ndarray]:
    """Lanes that repeat, in batches of similar periods that need room for at most `ROOM` numbers, or of one lane."""
    order = np.argsort(period, kind="stable")
    order = order[period[order] > 0]
    while order.size:
        shortest = int(period[order[0]])
        count = int(np.searchsorted(period[order], shortest + max(16, shortest // 2), side="right"))
        longest = int(period[order[count - 1]])
        count = min(count, max(1, ROOM // (longest * weight)))
        yield order[:count]
        order = order[count:]


def count_end(ends: list[Settled], one: Settled) -> int:
    """Add trials to the end that they share, or as a new one; its number."""
    for i, other in enumerate(ends):
        if other.outcome is Outcome.UNDECIDED:
            continue
        if (other.outcome, other.period, other.reason) == (one.outcome, one.period, one.reason) and _same(other, one):
            ends[i] = other._replace(trials=other.trials + one.trials)
            return i
    ends.append(one)
    return len(ends) - 1


def _same(one: Settled, other: Settled) -> bool:
    """Whether two motions of one period are one orbit, wherever each begins."""
    if len(one.x) == 0:
        return True
    size = 1.0 + float(np.abs(one.x).max())
    return all(abs(float(of(one.x[:-1]) - of(other.x[:-1]))) <= SAME * size for of in (np.min, np.max, np.mean, np.std))


def _settled(mover: BatchStepper, orbits: Orbits, i: int, lane: int, seen: Array | None) -> Settled:
    period = int(orbits.turn[i])
    held = period * len(mover.remedy.parts)
    x, v = orbits.path.x[: held + 1, i].copy(), orbits.path.v[: held + 1, i].copy()
    still = period == 1 and float(np.ptp(x)) <= AT_REST * (1.0 + abs(float(x[0]))) and float(np.abs(v).max()) <= AT_REST
    return Settled(
        lane=lane,
        trials=1,
        outcome=Outcome.REST if still else Outcome.CYCLE,
        reason=_reason(mover, orbits, i, lane, still=still),
        period=period,
        margin=float(orbits.margin[i]),
        closure=float(orbits.closure[i]),
        x=x,
        v=v,
        drive=orbits.path.drive[:held, i].copy(),
        begin=(orbits.path.rows[0, :, i].copy(), None if seen is None else seen[:, i].copy()),
    )


def _reason(mover: BatchStepper, orbits: Orbits, i: int, lane: int, *, still: bool) -> Reason:
    if not orbits.contracts[i]:
        return Reason.CONTINUUM if mover.lanes.beta[lane] == 0.0 else Reason.EXPANDS
    if not mover.remedy.provable:
        return Reason.NOT_AFFINE
    if not orbits.proven[i] and orbits.off_edges[i]:
        return Reason.AT_SWITCH
    if not orbits.proven[i]:
        return Reason.REST_ON_EDGE if still else Reason.ON_EDGE
    return Reason.NONE


def _windows(
    mover: BatchStepper, state: State, at: np.ndarray, enter: Callable[[Settled], None], reason: Reason
) -> None:
    """Motion of lanes that did not repeat, over a window of time."""
    period_s = float(mover.lanes.period_s[0])
    count = int(np.clip(WINDOW_S / period_s, *WINDOW))
    xs, vs, drives = [], [], []
    for _ in range(count):
        step = mover.step(state)
        x, v = state.x, state.v
        for drive, flow in zip(step.drives, mover.flows, strict=True):
            xs.append(x)
            vs.append(v)
            drives.append(drive)
            y = drive - mover.lanes.beta * x
            x, v = x + (flow.s * v + flow.g * y), flow.f * v + flow.s * y
        state = step.state
    xs.append(state.x)
    vs.append(state.v)
    x, v, drive = np.stack(xs), np.stack(vs), np.stack(drives)
    for i, lane in enumerate(at):
        enter(Settled(int(lane), 1, Outcome.UNDECIDED, reason, x=x[:, i], v=v[:, i], drive=drive[:, i]))
