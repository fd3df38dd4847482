"""Cutting sets of starts loses no state: each trial is, at every sample, in a set that has the trial's own counts."""

from typing import Any

import numpy as np
import pytest

from hknob_cli.controllers.batch_stepper import BatchStepper, State
from hknob_cli.controllers.plant_batch import flow_over, moved
from hknob_cli.controllers.sets import starts as the_starts
from hknob_cli.controllers.sets.follow import Ends, Follower
from hknob_cli.controllers.sets.front import Cutter, Front
from hknob_cli.controllers.sets.polygons import Polygons
from hknob_cli.specs.plan import Starts
from tests.controllers.sets.cells import BOX, CHANGES, COUNTING, PHASES, make_cell, phases_of

SAMPLES = {"phases": 100, "box": 30}
SLACK = 1e-9  # of a trial's own rounding, counts


def first_front(name: str, starts: Starts, change: dict[str, Any]) -> tuple[BatchStepper, Cutter, Front, Any]:
    """All starts of a cell at the first sample, cut by its counts."""
    remedy, batch, _ = make_cell(name, starts, counts=256 if starts.span else 1024, change=change)
    kept: list[Any] = []

    def keep(self: Follower, *sets: Any) -> list[Ends]:
        kept.extend([self, self._begin(*sets)])
        return []

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Follower, "follow", keep)
        the_starts.follow_starts(remedy, batch.lanes, batch.knobs, starts)
    return kept[0].mover, kept[0].cutter, kept[1], batch


def trials_of(starts: Starts, batch: Any, some: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """States of trials at the first sample, and their phases."""
    knob, lanes = batch.knobs[0], batch.lanes.take(np.zeros(some, dtype=int))
    if starts.span:
        chance = np.random.default_rng(5)
        low, high, slowest, fastest = starts.span
        angle, speed = chance.uniform((low, slowest), (high, fastest), (some, 2)).T
        angle[:2], speed[:2] = (low, high), (slowest, fastest)
        x = np.array([knob.position(one) for one in angle])
        return x, np.array([knob.speed(one) for one in speed]), np.empty(0)
    phases = phases_of(some, 6)
    x, v = np.full(some, knob.position(starts.angle)), np.full(some, knob.speed(starts.velocity))
    return *moved(x, v, -lanes.gamma, lanes.beta, flow_over(lanes, phases)), phases


def holds(front: Front, one: int, phase: float | None, off: np.ndarray, beta: float) -> bool:
    """Whether a set holds the state of a trial, told from its centre."""
    shape, error = front.shape, SLACK + front.error[one]
    if phase is not None:
        return bool(shape.low[one] - 1e-9 <= phase <= shape.high[one] + 1e-9)  # type: ignore[attr-defined]
    assert isinstance(shape, Polygons)
    corners = shape.now(np.array([one]))[0][: shape.count[one]]
    to = np.roll(corners, -1, axis=0) - corners
    length = np.hypot(*to.T)
    some = length > 0.0
    normal = np.stack([-to[:, 1], to[:, 0]], axis=1)[some] / length[some, None]
    side = np.einsum("ij,ij->i", off - corners[some], normal)
    room = error * max(1.0, beta**0.5)
    return bool((side >= -room).all() or (side <= room).all())


@pytest.mark.parametrize("kind", SAMPLES)
@pytest.mark.parametrize("name", COUNTING)
def test_every_trial_stays_in_a_set_with_its_counts_and_memory(name: str, kind: str) -> None:
    """Of random starts of one start's phases and of a box; encoders and a torque limit go round."""
    starts = BOX if kind == "box" else PHASES
    change = CHANGES[COUNTING.index(name) % len(CHANGES)]
    mover, cutter, front, batch = first_front(name, starts, change)
    some = 12 if starts.span else 40
    x, v, phases = trials_of(starts, batch, some)
    beta = float(batch.lanes.beta[0])
    trial_mover = mover.take(np.zeros(some, dtype=int))
    state = trial_mover.start(x, v)
    told = cutter.counting.told
    cuts = len(front)
    for _ in range(SAMPLES[kind]):
        front, _ = cutter.meet(front)
        cuts = max(cuts, len(front))
        count = cutter.counting.at(state.x)
        like = front.count[None, :] == count[:, None]
        like &= (front.state.memory[:, None, :] == state.memory[:, :, None]).all(axis=0)
        if state.seen is not None:
            like &= (told(front.state.seen)[:, None, :] == told(state.seen)[:, :, None]).all(axis=0)
        off = np.stack([state.x[:, None] - front.state.x, state.v[:, None] - front.state.v], axis=2)
        far = np.sqrt(off[:, :, 0] ** 2 + off[:, :, 1] ** 2 / beta)
        like &= far <= front.radius + front.error + SLACK
        for i in range(some):
            phase = float(phases[i]) if len(phases) else None
            assert any(holds(front, one, phase, off[i, one], beta) for one in np.flatnonzero(like[i]))
        front, _ = cutter.step(front, mover.take(front.cell))
        state = trial_mover.step(state).state
    assert cuts > 1  # there was something to cut


def test_a_controller_that_does_not_read_outside_acts_alike_there() -> None:
    """Any count outside the wall gives the same torque and memory, whatever is remembered."""
    chance = np.random.default_rng(7)
    for name in COUNTING:
        remedy, batch, _ = make_cell(name)
        lanes = np.zeros(40, dtype=int)
        mover = BatchStepper(remedy, batch.lanes.take(lanes))
        state = mover.start(chance.uniform(-9.0, 9.0, 40), chance.normal(size=40))
        for _ in range(30):
            state = mover.step(state).state
        same = State(*(None if one is None else one[..., np.zeros(40, dtype=int)] for one in state))
        steps = mover.step(same, np.repeat(np.arange(0.0, 5.0), 8))
        alike = bool((np.ptp(steps.drives, axis=1) == 0.0).all() and (np.ptp(steps.state.memory, axis=1) == 0.0).all())
        assert alike or remedy.reads_outside, name


def test_sets_hold_still_where_no_edge_is_met() -> None:
    """A small set far from edges is not cut, and its radius never grows."""
    remedy, batch, _ = make_cell("bounded lag", BOX)
    mover = BatchStepper(remedy, batch.lanes)
    cutter = Cutter(mover, Follower(mover, the_starts.BOXES).counting)
    plants = the_starts.Plants(batch.lanes.alpha, batch.lanes.beta)
    small = the_starts.box_polygons(plants, np.array([1e-3]), np.array([1e-4]))
    zero = np.zeros(1, dtype=np.int64)
    x, v = np.array([3.5]), np.array([0.0])
    state = mover.start(x, v)
    front = Front(zero, state, np.zeros(1), small, small.radius(zero), np.zeros(1), zero, zero, zero)
    radius = float(front.radius[0])
    for _ in range(10):
        front, of = cutter.meet(front)
        assert of.tolist() == [0]
        front, _ = cutter.step(front, mover)
        assert front.radius[0] <= radius
        radius = float(front.radius[0])
    assert front.error[0] > 0.0


def test_sets_are_cut_once_a_sample(monkeypatch: pytest.MonkeyPatch) -> None:
    """What a controller remembers of the first count is the count that acts: no sliver has another."""
    remedy, batch, _ = make_cell("damping, differenced", BOX, counts=256)
    step, seen = Cutter.step, []

    def check(self: Cutter, front: Front, mover: BatchStepper) -> Any:
        if front.taken.max() == 0:
            seen.append((front.state.memory[0] == front.count + batch.lanes.offset[0]).all())
        return step(self, front, mover)

    monkeypatch.setattr(Cutter, "step", check)
    the_starts.follow_starts(remedy, batch.lanes, batch.knobs, BOX)
    assert seen == [True]
