"""All starts of cells with one controller, followed until proven orbits capture them."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from hknob_cli.controllers.batch_stepper import BatchStepper, State, take
from hknob_cli.controllers.plant_batch import Array
from hknob_cli.controllers.repeat import GREW, SearchBudget, time_constants
from hknob_cli.controllers.search import EFFORTS, Settled, count_end, settle
from hknob_cli.controllers.sets.captors import Captors, Point, make_points
from hknob_cli.controllers.sets.counting import Counting
from hknob_cli.controllers.sets.front import Cutter, Front
from hknob_cli.controllers.sets.shape import Shape
from hknob_cli.engine.outcome import Outcome, Reason

LOOK = 32  # samples between looks at what does not move much, has grown, or waits
FIRST = 5.0  # time constants, after which the end of a set's centre is looked for
SEEKERS = 64  # of the sets of a cell whose ends are looked for at first; then four times as many
SIDE_BY_SIDE = 16_384  # sets
NONE = Reason.NONE
NEARLY = (Reason.ON_EDGE, Reason.AT_SWITCH, Reason.REST_ON_EDGE)  # of an orbit that may be proven from nearer by
AT_ONCE = (SearchBudget(settle=0.0, patience=4.0, fewest=1024, near=1e-4), EFFORTS[1])


class Ends(NamedTuple):
    """What the starts of a cell settle to: ``trials`` of each is its share of them.

    ``undecided``: the share without a proven end; ``pieces``: sets that were followed to their end; ``samples``: taken.
    """

    ends: list[Settled]
    undecided: float
    pieces: int
    samples: int


class Limits(NamedTuple):
    """``samples`` that the sets of a cell may take in all, and how many may come to an end that is not proven.

    ``seekers``: sets of a cell whose ends may be looked for at once.
    """

    samples: int
    unproven: int
    seekers: int


class _Cell:
    """What is known of a cell."""

    def __init__(self) -> None:
        self.ends: list[Settled] = []
        self.shares: list[float] = []
        self.undecided, self.pieces, self.unproven = 0.0, 0, 0

    def enter(self, one: Settled) -> int:
        """Number of an end, entered where it is new."""
        number = count_end(self.ends, one._replace(trials=0.0))
        self.shares += [0.0] * (len(self.ends) - len(self.shares))
        return number

    def end(self, number: int, share: float, *, proven: bool) -> None:
        """A set has come to an end."""
        self.shares[number] += share
        self.pieces += 1
        if not proven:
            self.undecided += share
            self.unproven += 1

    def finish(self, samples: int) -> Ends:
        """All of it."""
        total = sum(self.shares)
        kept = [(one, share) for one, share in zip(self.ends, self.shares, strict=True) if share or one.reason is NONE]
        ends = [one._replace(trials=share / total) for one, share in kept]
        return Ends(ends, min(1.0, self.undecided), self.pieces, samples)


class Follower:
    """Follows sets of the cells of ``mover``, one lane each; ``over``: whether the time is over."""

    def __init__(self, mover: BatchStepper, limits: Limits, over: Callable[[], bool] = lambda: False) -> None:
        """Make ready."""
        lanes, remedy = mover.lanes, mover.remedy
        self.mover, self.limits, self.over = mover, limits, over
        self.counting = Counting(float(lanes.sense[0]), remedy.reads_outside)
        self.cutter = Cutter(mover, self.counting)
        self.captors = Captors(lanes.beta, self.counting)
        self.cells = [_Cell() for _ in lanes.beta]
        slowest = time_constants(mover)
        self.wait = np.maximum(64, np.ceil(FIRST * slowest)).astype(np.int64)
        self.budget = np.minimum(65_536, np.ceil(40.0 * slowest)).astype(np.int64) + 16_384
        self.samples = np.zeros(len(self.cells), dtype=np.int64)
        self.longest = np.zeros(len(self.cells), dtype=np.int64)  # of the periods found
        self.sought = np.zeros(len(self.cells), dtype=np.int64)  # times that ends were looked for
        self.waiting: list[Front] = []

    def follow(self, cell: np.ndarray, x: Array, v: Array, shape: Shape, radius: Array, error: Array) -> list[Ends]:
        """Ends of sets around ``x``, ``v`` at the first sample; the ends of each cell."""
        self.waiting = [self._begin(cell, x, v, shape, radius, error)]
        while self.waiting:
            self._run(self.waiting.pop())
        return [one.finish(int(samples)) for one, samples in zip(self.cells, self.samples, strict=True)]

    def _begin(self, cell: np.ndarray, x: Array, v: Array, shape: Shape, radius: Array, error: Array) -> Front:
        """The sets at the first sample, with their counts; memory is what it is for these."""
        looks = len(self.mover.remedy.looks)
        nothing = np.zeros((0, len(x)))
        zero = np.zeros(len(x), dtype=np.int64)
        front = Front(
            cell, State(x, v, nothing, None), np.zeros(len(x)), shape, radius, error, zero, self.wait[cell], zero
        )
        front, _ = self.cutter.meet(front)
        memory = self.mover.remedy.recall(self.mover.lanes.take(front.cell), front.count)
        seen = np.repeat(front.count[None], looks, axis=0) if looks else None
        front.state = State(front.state.x, front.state.v, memory, seen)
        return front

    def _run(self, front: Front) -> None:
        """Follow sets, which have been cut at this sample, to their ends; what there is no room for waits."""
        mover = self.mover.take(front.cell)
        i = 0
        while len(front):
            before, size, of = front.count, len(front), np.arange(len(front))
            if i > 0:
                front, of = self.cutter.meet(front)
            changed = len(front) != size or (of != np.arange(len(of))).any()
            falls = np.flatnonzero(front.count < before[of])
            left = self._captured(front, falls, deeper=True)
            if i % LOOK == 0:
                left &= self._captured(front, np.flatnonzero(left), deeper=False)
                left &= self._looked_at(front, left)
            if not left.all():
                front, changed = front.take(np.flatnonzero(left)), True
            if len(front) > SIDE_BY_SIDE:
                half = len(front) // 2
                self.waiting.append(front.take(np.arange(half)))
                front = front.take(np.arange(half, len(front)))
                changed = True
            if changed:
                mover = self.mover.take(front.cell)
            if len(front) == 0:
                return
            self.samples += np.bincount(front.cell, minlength=len(self.cells))
            front, of = self.cutter.step(front, mover)
            if len(of) != len(mover.lanes.alpha) or (of != np.arange(len(of))).any():
                mover = self.mover.take(front.cell)
            i += 1

    def _captured(self, front: Front, sets: np.ndarray, *, deeper: bool) -> np.ndarray:
        """Which sets go on, after those of ``sets`` that orbits capture are entered; a mask."""
        left = np.ones(len(front), dtype=bool)
        if sets.size:
            ends = self.captors.capture(front.cell, front.state, front.radius + front.error, sets, deeper)
            self._end(front, sets[ends >= 0], ends[ends >= 0], left, proven=True)
        return left

    def _end(self, front: Front, sets: np.ndarray, numbers: np.ndarray, left: np.ndarray, *, proven: bool) -> None:
        """Enter the ends of ``sets``, and take them out of those that are ``left``."""
        share = front.shape.share()
        for one, number in zip(sets.tolist(), numbers.tolist(), strict=True):
            self.cells[front.cell[one]].end(number, float(share[one]), proven=proven)
        left[sets] = False

    def _looked_at(self, front: Front, left: np.ndarray) -> np.ndarray:
        """Which of those ``left`` go on, after what has grown, has had its time, or waits was looked at; a mask."""
        left = left.copy()
        state = front.state
        self._give_up(front, left & ~(np.abs(state.x) + np.abs(state.v) < GREW), Reason.GREW, left)
        if self.over():
            self._give_up(front, left.copy(), Reason.TIME_LIMIT, left)
        spent = self.samples > self.limits.samples
        spent |= np.array([one.unproven > self.limits.unproven for one in self.cells])
        self._give_up(front, left & spent[front.cell], Reason.WORK_LIMIT, left)
        self._give_up(front, left & (front.taken > self.budget[front.cell]), Reason.NO_REPEAT, left)
        late = np.flatnonzero(left & (front.since >= front.wait))
        if late.size:
            self._seek(front, late, left)
        return left

    def _give_up(self, front: Front, which: np.ndarray, reason: Reason, left: np.ndarray) -> None:
        """End sets without a proof."""
        outcome = Outcome.DIVERGED if reason is Reason.GREW else Outcome.UNDECIDED
        for cell in np.unique(front.cell[which]):
            number = self.cells[cell].enter(Settled(0, 0.0, outcome, reason))
            sets = np.flatnonzero(which & (front.cell == cell))
            self._end(front, sets, np.full(len(sets), number), left, proven=False)

    def _seek(self, front: Front, late: np.ndarray, left: np.ndarray) -> None:
        """Find what the centres of sets end in, of some of each cell; the others go on waiting for these."""
        chosen = []
        for cell in np.unique(front.cell[late]):
            mine = late[front.cell[late] == cell]
            most = min(self.limits.seekers, SEEKERS * 4 ** int(self.sought[cell]))
            chosen.append(mine[np.unique(np.linspace(0, len(mine) - 1, most).astype(np.int64))])
            self.sought[cell] += 1
        sets = np.concatenate(chosen)
        mover = self.mover.take(front.cell[sets])
        found: dict[int, Settled] = {}
        taken = settle(mover, take(front.state, sets), lambda one: found.update({one.lane: one}), self.over, AT_ONCE)
        self.samples += taken // len(sets) * np.bincount(front.cell[sets], minlength=len(self.cells))
        found = self._proven_at_last(mover, found)
        new: dict[tuple[int, int], Settled] = {}
        for lane, one in sorted(found.items()):
            at, cell = int(sets[lane]), int(front.cell[sets[lane]])
            number = self.cells[cell].enter(one)
            if one.reason is not NONE:
                self._end(front, np.array([at]), np.array([number]), left, proven=False)
                continue
            # A motion that is known may be one of another memory, if a set has waited for it in vain before.
            again = front.wait[at] > self.wait[cell]
            if again or not any(point.end == number for point in self.captors.points[cell]):
                new.setdefault((cell, lane if again else -1 - number), one)
            self.longest[cell] = max(self.longest[cell], one.period)
            front.since[at], front.wait[at] = 0, 2 * max(int(front.wait[at]), one.period)
        # The others wait for what was found, which comes by once a period.
        front.since[late] = np.minimum(
            front.since[late], front.wait[late] - np.maximum(self.wait // 8 + LOOK, self.longest)[front.cell[late]]
        )
        if new:
            some = list(new.values())
            cells = [cell for cell, _ in new]
            ends = np.array([self.cells[cell].enter(one) for cell, one in zip(cells, some, strict=True)])
            for lane, point in _points_of(mover, some, ends, self.counting):
                self.captors.enter(cells[lane], point)

    def _proven_at_last(self, mover: BatchStepper, found: dict[int, Settled]) -> dict[int, Settled]:
        """The same ends, but proven where the orbit is, although its trial was too far away to be captured."""
        lanes = [lane for lane, one in found.items() if one.reason in NEARLY]
        if not lanes:
            return found
        proven = {
            lane for lane, _ in _points_of(mover, [found[lane] for lane in lanes], np.zeros(len(lanes)), self.counting)
        }
        return {
            **found,
            **{lane: found[lane]._replace(reason=NONE) for i, lane in enumerate(lanes) if i in proven},
        }


def _points_of(
    mover: BatchStepper, orbits: list[Settled], ends: np.ndarray, counting: Counting
) -> list[tuple[int, Point]]:
    """Points of orbits, whose lanes are of ``mover``, that are called ``ends``: number of the orbit, and point."""
    rows = np.stack([one.begin[0] for one in orbits], axis=1)
    seen = [one.begin[1] for one in orbits if one.begin[1] is not None]
    state = State(rows[0], rows[1], rows[2:], np.stack(seen, axis=1) if seen else None)
    at, period = mover.take(np.array([one.lane for one in orbits])), np.array([one.period for one in orbits])
    return make_points(at, state, period, ends, at.lanes.beta, counting)
