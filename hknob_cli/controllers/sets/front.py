"""Sets of states that are followed side by side, each by its centre, and how they are cut at count edges."""

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from hknob_cli.controllers.batch_stepper import BatchStepper, State, Step, take
from hknob_cli.controllers.plant_batch import Array
from hknob_cli.controllers.sets.counting import Counting
from hknob_cli.controllers.sets.shape import Shape
from hknob_cli.engine.certificate import EPSILON


@dataclass
class Front:
    """Sets, arrays (sets,): their ``cell``, ``state`` of their centres, ``count`` before, and their ``shape``.

    ``radius``: bound on the distance of their states from the centre, in the norm in which the free plant never grows;
    ``error``: bound on the centre's rounding, in the same; ``since``: samples in no known attractor; ``wait``: at how
    many one is looked for; ``taken``: samples in all.
    """

    cell: np.ndarray
    state: State
    count: Array
    shape: Shape
    radius: Array
    error: Array
    since: np.ndarray
    wait: np.ndarray
    taken: np.ndarray

    def __len__(self) -> int:
        return len(self.cell)

    def take(self, sets: np.ndarray) -> "Front":
        """Some of them, by index; copies."""
        return Front(
            **{one.name: getattr(self, one.name)[sets] for one in fields(self) if one.name not in ("state", "shape")},
            state=take(self.state, sets),
            shape=self.shape.take(sets),
        )

    def with_shape(self, shape: Shape) -> "Front":
        """The same with other shapes."""
        return replace(self, shape=shape)

    def join(self, other: "Front") -> "Front":
        """These, then others."""
        return Front(
            **{
                one.name: _both(getattr(self, one.name), getattr(other, one.name))
                for one in fields(self)
                if one.name != "shape"
            },
            shape=self.shape.join(other.shape),
        )


def _both(one: Any, other: Any) -> Any:
    if one is None:
        return None
    if isinstance(one, State):
        return State(*map(_both, one, other))
    return np.concatenate([one, other], axis=-1)


class Cutter:
    """Cuts sets, and moves them on; ``mover`` has one lane a cell."""

    def __init__(self, mover: BatchStepper, counting: Counting) -> None:
        """Of these cells."""
        self.mover, self.counting = mover, counting
        self.beta = mover.lanes.beta
        self._decay = decay_of(mover)

    def meet(self, front: Front) -> tuple[Front, np.ndarray]:
        """The sets with their counts at this sample, cut where they have several; and those before the cut, by index.

        The index is of each set that is now, of the one that it was.
        """
        state, reach = front.state, front.radius + front.error
        of, fresh, count = self._parted(front, 0.0, state.x, reach, radius=True)
        if fresh is None:
            return replace(front, count=count), np.arange(len(front))
        self._centre(fresh)
        whole = front.take(of[: len(of) - len(fresh)]).join(fresh)
        whole.count = count
        return whole, of

    def _parted(
        self, front: Front, after: float, at: Array, reach: Array, *, radius: bool
    ) -> tuple[np.ndarray, Front | None, Array]:
        """Counts of all sets where their centres are ``at``; those with several as parts of one count each, at the end.

        Which set each is of, the parts if any, and the counts.
        """
        count_at, shape = self.counting.at, front.shape
        low, high = count_at(at - reach), count_at(at + reach)
        every = np.arange(len(front))
        met = np.flatnonzero(low != high)
        if met.size == 0:
            return every, None, low
        least, most = shape.extent(met, after)
        slack = front.error[met] + shape.blur(met) + 8.0 * EPSILON * (np.abs(at[met]) + 1.0)
        count = low
        first, last = count_at(at[met] + least - slack), count_at(at[met] + most + slack)
        count[met] = first
        if radius:
            front.radius[met] = np.minimum(front.radius[met], shape.radius(met))
        astride = np.flatnonzero(first < last)
        if astride.size == 0:
            return every, None, count
        numbers = (last - first)[astride].astype(np.int64) + 1
        which = np.repeat(astride, numbers)
        told = first[which] + (np.arange(len(which)) - np.repeat(np.cumsum(numbers) - numbers, numbers))
        sets, room = met[which], slack[which]
        # One part after the other is cut, so that a part knows its count: parts of one set may be several.
        low_edge = self.counting.lower(told) - room - at[sets]
        high_edge = self.counting.upper(told) + room - at[sets]
        of, parts, number = _cut_all(shape, sets, after, low_edge, high_edge)
        fresh = front.take(of).with_shape(parts)
        fresh.error = fresh.error + shape.blur(of) + 8.0 * EPSILON * (np.abs(fresh.state.x) + 1.0)
        keep = np.delete(every, met[astride])
        return np.concatenate([keep, of]), fresh, np.concatenate([count[keep], told[number]])

    def _centre(self, front: Front) -> None:
        """Tell sets from centres in their middle."""
        every = np.arange(len(front))
        dx, dv = front.shape.recentre(every)
        root = np.sqrt(self.beta[front.cell])
        front.error = front.error + 4.0 * EPSILON * (np.abs(front.state.x) + np.abs(front.state.v) / root)
        front.state = front.state._replace(x=front.state.x + dx, v=front.state.v + dv)
        front.radius = front.shape.radius(every)

    def step(self, front: Front, mover: BatchStepper) -> tuple[Front, np.ndarray]:
        """One sample on, cut where looks of one set show several counts; and of which set before each is.

        ``mover`` has a lane for each set.
        """
        before, radius = front.state, front.radius
        step = mover.step(before, front.count)
        beta = mover.lanes.beta
        front = replace(
            front,
            state=step.state,
            error=front.error + step_error(before, step, beta, mover.lanes.gamma),
            radius=front.radius * self._decay[front.cell],
            since=front.since + 1,
            taken=front.taken + 1,
        )
        if step.looked is None:
            front.shape.advance()
            return front, np.arange(len(front))
        return self._look(front, step.looked, radius)

    def _look(self, front: Front, looked: Array, radius: Array) -> tuple[Front, np.ndarray]:
        """The counts at the looks of an interval, one look after the other; then on to the next sample.

        ``looked``: positions of centres, (looks, sets); ``radius`` at the sample before.
        """
        origin, parted = np.arange(len(front)), np.zeros(len(front), dtype=bool)
        seen, room = front.state.seen, radius + front.error
        assert seen is not None
        seen[:] = self.counting.at(looked - room)
        met = (seen != self.counting.at(looked + room)).any(axis=1)
        for k in np.flatnonzero(met):
            after = self.mover.remedy.looks[k]
            of, fresh, count = self._parted(front, after, looked[k], radius + front.error, radius=False)
            if fresh is not None:
                front = front.take(of[: len(of) - len(fresh)]).join(fresh)
                origin, looked, radius = origin[of], looked[:, of], radius[of]
                parted = np.concatenate([parted[of[: len(of) - len(fresh)]], np.ones(len(fresh), dtype=bool)])
            assert front.state.seen is not None
            front.state.seen[k] = count
        front.shape.advance()
        if parted.any():
            keep, again = np.flatnonzero(~parted), np.flatnonzero(parted)
            fresh = front.take(again)
            self._centre(fresh)
            front, origin = front.take(keep).join(fresh), origin[np.concatenate([keep, again])]
        return front, origin


def _cut_all(
    shape: Shape, sets: np.ndarray, after: float, low: Array, high: Array
) -> tuple[np.ndarray, Shape, np.ndarray]:
    """As `Shape.cut`, and to which of the ranges each part belongs."""
    one_by_one = shape.take(sets)
    number, parts = one_by_one.cut(np.arange(len(sets)), after, low, high)
    return sets[number], parts, number


def step_error(before: State, step: Step, beta: Array, gamma: Array) -> Array:
    """Bound on what rounding adds to the error of centres in one sample; as `engine.sets.ball.step_error`, each part.

    Memory and torques have no rounding: a controller is its program, in double precision.
    """
    pull = np.maximum.reduce([np.abs(drive) for drive in step.drives]) + 2.0 * gamma  # torque and push may cancel
    place = np.maximum(np.abs(before.x), np.abs(step.state.x))
    pace = np.maximum(np.abs(before.v), np.abs(step.state.v)) + pull + beta * place
    one = EPSILON * (4.0 * place + 24.0 * (1.0 + 1.0 / np.sqrt(beta)) * (pace + pull + beta * place))
    return np.asarray(len(step.drives) * one)


def decay_of(mover: BatchStepper) -> Array:
    """Bound on how much of a distance the free plant of each cell leaves after a sample; at most 1."""
    from hknob_cli.controllers.plant_batch import flow_over

    flow, beta = flow_over(mover.lanes, 1.0), mover.lanes.beta
    root = np.sqrt(beta)
    rows = [[1.0 - beta * flow.g, flow.s * root], [-root * flow.s, flow.f]]
    norms = np.linalg.norm(np.array(rows).transpose(2, 0, 1), ord=2, axis=(1, 2))
    return np.asarray(np.minimum(1.0, norms * (1.0 + 64.0 * EPSILON)))
