"""What a proven orbit captures under a controller, and what it must not."""

import numpy as np
import pytest

from hknob_cli.controllers.batch_stepper import BatchStepper, State
from hknob_cli.controllers.sets import starts as the_starts
from hknob_cli.controllers.sets.captors import SURE, Captors, Point
from hknob_cli.controllers.sets.counting import Counting
from hknob_cli.controllers.sets.follow import Ends, Follower
from tests.controllers.sets.cells import CHANGES, COUNTING, PHASES, make_cell

NAMES = [name for name in COUNTING if not name.startswith("passivity")]  # whose energy has no orbit in these cells


def known_of(name: str, change: int = 0) -> tuple[BatchStepper, list[Point], Ends]:
    """The points of a cell's orbits, after every clock phase was followed."""
    remedy, batch, _ = make_cell(name, counts=512, change=CHANGES[change])
    kept: list[Follower] = []
    begin = Follower._begin

    def keep(self: Follower, *sets: np.ndarray) -> object:
        kept.append(self)
        return begin(self, *sets)  # type: ignore[arg-type]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Follower, "_begin", keep)
        ends = the_starts.follow_starts(remedy, batch.lanes, batch.knobs, PHASES)
    return BatchStepper(remedy, batch.lanes), kept[0].captors.points[0], ends[0]


def moved_from(point: Point, off: np.ndarray) -> State:
    """States ``off`` (rows, lanes) from a point, in its scale."""
    rows = point.rows[:, None] + off * point.scale[:, None]
    seen = None if point.seen is None else np.repeat(point.seen[:, None], off.shape[1], axis=1)
    return State(rows[0], rows[1], rows[2:], seen)


@pytest.mark.parametrize("name", NAMES)
def test_what_lies_within_reach_keeps_the_orbits_counts(name: str) -> None:
    """In random directions of position, velocity and memory, at nearly the whole distance, for 400 samples."""
    mover, points, ends = known_of(name, NAMES.index(name) % 2)
    assert ends.undecided == 0.0
    chance = np.random.default_rng(1)
    for point in points[:12]:
        free = np.flatnonzero(~point.frozen)
        some = 30
        off = np.zeros((len(point.rows), some + 1))
        off[free, :some] = chance.normal(size=(len(free), some))
        far = np.sqrt(np.einsum("il,ij,jl->l", off, point.form, off))
        off[:, :some] *= 0.999 * point.reach / far[:some]
        many = mover.take(np.zeros(some + 1, dtype=int))
        state = moved_from(point, off)
        for _ in range(400):
            step = many.step(state)
            for places in (state.x[None], () if step.looked is None else step.looked):
                for place in places:
                    counts = np.floor(place) if mover.lanes.sense[0] > 0.0 else np.ceil(place)
                    assert (counts == counts[-1]).all()
            for guard in step.guards:
                assert ((guard > 0.0) == (guard[-1] > 0.0)).all()
            state = step.state
        last = np.abs(state.x[:-1] - state.x[-1]).max()
        assert last < 1e-3 * max(1e-9, np.abs(off[0]).max() * point.scale[0]) or last < 0.5 * point.reach


def test_other_counts_or_memory_or_too_wide_a_set_are_not_captured() -> None:
    """The same position and velocity alone do not do."""
    _, points, _ = known_of("impulse, timed")
    captors = Captors(np.array([0.018]), Counting(1.0, outside=False))
    captors.enter(0, points[0])
    here = moved_from(points[0], np.zeros((3, 1)))
    one, none = np.zeros(1, dtype=int), np.zeros(1)
    deeper = points[0].deeper

    def captured(state: State, reach: float = 0.0) -> bool:
        return bool(captors.capture(one, state, none + reach, one, deeper)[0] >= 0)

    assert captured(here)
    assert not captured(here._replace(memory=here.memory + 1e-9))  # what is counted is equal, or it is another
    assert here.seen is not None
    assert not captured(here._replace(seen=here.seen - 1.0))
    assert not captured(here._replace(x=here.x + 1.01 * points[0].near))
    edge = points[0].reach / points[0].stretch
    assert captured(here, 0.999 * edge)
    assert not captured(here, 1.001 * edge)
    assert SURE < 1.0
