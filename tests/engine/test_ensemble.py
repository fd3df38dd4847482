"""Lanes of trials by hand: a push and a wall are all that acts, so that speeds change by the torque alone."""

from math import ceil, floor, inf, pi
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

from hknob_cli.engine import attractors, ensemble
from hknob_cli.engine.attractors import Engine
from hknob_cli.engine.budget import TrialBudget
from hknob_cli.engine.certificate import DIFFERENT, PROVEN
from hknob_cli.engine.ensemble import ROW, TrialRoom, advance, deepest, find, first_sample, near
from hknob_cli.engine.follow import CYCLE_CONTINUUM, CYCLE_ON_EDGE, CYCLE_PROVEN, GREW, REST_PROVEN
from hknob_cli.engine.loop import level_of, lower_edge, make_loop, upper_edge
from hknob_cli.engine.outcome import Outcome, Reason

# Without hand and damping: a push of 0.5 inwards, and 2 a count outwards of what was read, a quarter above its level.
GAMMA, KAPPA, OFFSET = 0.5, 2.0, 0.25
BELOW = 2.0 * 0.75 - 0.5  # at level -1


@pytest.mark.parametrize("split", [0.0, 0.25])
def test_lanes_fall_and_are_turned(split: float) -> None:
    """One far outside, whose levels are no torque; one whose older command is the wall's; one that reads it now."""
    loop = make_loop(0.0, 0.0, KAPPA, GAMMA, 1.0, OFFSET, split)
    x, v, line = [10.0, 0.5, -0.5], [0.0, 0.0, 0.0], [3.0, -1.0, 0.0] * (1 if split else 0)
    head = advance(x, v, line, 0, 1 if split else 0, 1, loop)
    assert head == 0
    accelerations = (
        ((-GAMMA, -GAMMA), (BELOW, -GAMMA), (-GAMMA, BELOW)) if split else ((-GAMMA,) * 2,) * 2 + ((BELOW,) * 2,)
    )
    for j, (older, newer) in enumerate(accelerations):
        speed = older * split
        place = (10.0, 0.5, -0.5)[j] + 0.5 * older * split * split
        rest = 1.0 - split
        assert x[j] == pytest.approx(place + speed * rest + 0.5 * newer * rest * rest, rel=1e-15)
        assert v[j] == pytest.approx(speed + newer * rest, rel=1e-15)
    if split:
        assert line == [0.0, 0.0, -1.0]


# Whole trials, one by one, by SciPy's exponential.

HAND = {"alpha": 0.16, "beta": 0.018, "kappa": 0.12}
CELLS = {  # push, sense of the encoder, its offset, delay; start
    "plain": (0.06, 1.0, 0.0, 0.0, 3.25, 0.0),
    "thrown": (0.1, 1.0, 0.25, 0.0, 40.0, -2.0),
    "ceil": (0.09, -1.0, 0.0, 0.0, 3.25, 0.5),
    "late": (0.1, 1.0, 0.5, 0.4, 3.25, 0.0),
    "two late": (0.06, 1.0, 0.0, 2.0, 3.25, 0.0),
    "two late, pushed": (0.15, 1.0, 0.0, 2.0, 3.25, 0.0),
    "later": (0.07, -1.0, 0.25, 1.3, 3.25, 0.0),
}
SAMPLES, LONGEST = 1800, 400
End = tuple[int, float, float, tuple[float, ...]]


def hold(span: float) -> Any:
    """What a hold does to (x, v) and the drive."""
    return expm(np.array([[0.0, 1.0, 0.0], [-HAND["beta"], -HAND["alpha"], 1.0], [0.0, 0.0, 0.0]]) * span)[:2]


def end_of(state: Any, name: str) -> End:
    """Period, deepest sample and levels under way there of the trial that is first sampled in a state."""
    push, sense, offset, delay, _, _ = CELLS[name]
    whole = int(delay)
    split = delay - whole
    late, soon = hold(split), hold(1.0 - split)
    levels, states = [0.0] * (whole + 1), []
    for _ in range(SAMPLES):
        x = state[0]
        level = min(floor(x) if sense > 0.0 else ceil(x), 0)
        levels.append(float(level))
        states.append((x, state[1]))
        for over, read in ((late, levels[-2 - whole]), (soon, levels[-1 - whole])):
            drive = -push - (HAND["kappa"] * (read + offset) if read < 0.0 else 0.0)
            state = over @ np.array([*state, drive])
    tail = np.array(states[-2 * LONGEST :])
    near = [n for n in range(1, LONGEST) if np.abs(tail[-LONGEST:] - tail[-LONGEST - n : -n]).max() < 1e-10]
    period = near[0]
    k = min(range(SAMPLES - period, SAMPLES), key=lambda one: states[one][0])
    under = whole + 1 if delay > 0.0 else 0
    return period, *states[k], tuple(levels[whole + 1 + k - under : whole + 1 + k])


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", CELLS)
def test_trials_end_as_they_do_one_by_one(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """In lanes, blocks of lanes and slices of blocks."""
    push, sense, offset, delay, x, v = CELLS[name]
    phases = 11
    wanted: list[End] = []
    for i in range(phases):
        begun = hold((i + 0.5) / phases) @ np.array([x, v, -push])
        wanted.append(end_of(begun, name))
    loop = make_loop(HAND["alpha"], HAND["beta"], HAND["kappa"], push, sense, offset, delay % 1.0)
    monkeypatch.setattr(attractors, "LANES", 3)
    monkeypatch.setattr(attractors, "SLICE", 7)
    found = Engine().search(loop, x=x, v=v, phases=phases, delay_line=int(delay) + 1 if delay else 0, max_samples=None)
    assert sum(one.trials for one in found.attractors) == phases
    for one in found.attractors:
        assert one.outcome in (Outcome.CYCLE, Outcome.REST)
        same = [
            end
            for end in wanted
            if end[0] == one.period
            and end[1:3] == (pytest.approx(one.x, abs=1e-9), pytest.approx(one.v, abs=1e-9))
            and end[3] == one.line
        ]
        assert len(same) == one.trials
    ranks = [one.trials for one in found.attractors]
    assert ranks == sorted(ranks, reverse=True)
    if name == "plain":  # of two ends only the first trial's has room
        assert len(ranks) == 2
        monkeypatch.setattr(attractors, "CAPACITY", 1)
        few = Engine().search(loop, x=x, v=v, phases=phases, delay_line=0, max_samples=None).attractors
        first = next(one.trials for one in found.attractors if one.period == wanted[0][0])
        assert {one.reason: one.trials for one in few} == {Reason.NONE: first, Reason.TOO_MANY: phases - first}


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_states_are_the_same_within_a_billionth(way: float) -> None:
    """Of 1 more than they are."""
    for a in (3.0, -3.0):
        assert near(a, a + way * 3.9e-9)
        assert not near(a, a + way * 4.1e-9)
    assert near(0.0, way * 1e-9)
    assert not near(0.0, way * 1.01e-9)


def test_an_end_is_found_by_all_that_tells_it() -> None:
    rows = [
        (CYCLE_PROVEN, 12, -1.5, 0.25),
        (CYCLE_PROVEN, 14, -1.5, 0.25),
        (REST_PROVEN, 1, -0.5, 0.0),
        (GREW, 0, 7.0, 8.0),
    ]
    table = [0.0] * (ROW * 4)
    for row, numbers in enumerate(rows):
        table[ROW * row : ROW * row + 4] = numbers
    for row, (fate, n, x, v) in enumerate(rows):
        assert find(fate, n, x, v, table, 4) == row
        assert find(fate, n, x, v, table, row) == row  # not there yet
    assert find(GREW, 0, -9.0, 0.0, table, 4) == 3
    others = (
        (CYCLE_PROVEN, 12, -1.5, 0.5),
        (CYCLE_PROVEN, 12, -1.0, 0.25),
        (CYCLE_PROVEN, 13, -1.5, 0.25),
        (REST_PROVEN, 12, -1.5, 0.25),
    )
    for other in others:
        assert find(*other, table, 4) == 4


def test_a_trial_flies_freely_until_its_first_sample() -> None:
    """Of 3 the first a sixth of an interval; the next begin a third later, also where a block of them ends."""
    loop, starts = make_loop(HAND["alpha"], HAND["beta"], HAND["kappa"], 0.06, 1.0, 0.25, 0.0), []
    for x, v in ((2.5, -0.5), (-1.5, 0.75)):
        assert first_sample(x, v, 3, loop) == pytest.approx(hold(1.0 / 6.0) @ np.array([x, v, -0.06]), rel=1e-13)
    engine = Engine()
    run = engine._ensemble

    def kernel(at: Any, phases: int, start: int, *more: Any) -> Any:
        starts.append((start, at))
        return run(at, phases, start, *more)

    engine._ensemble = kernel
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(attractors, "SLICE", 2)
        engine.search(loop, x=2.5, v=-0.5, phases=5, delay_line=0, max_samples=None)
    assert [start for start, _ in starts] == [0, 2, 4]
    for start, at in starts:
        assert at == pytest.approx(hold((start + 0.5) / 5) @ np.array([2.5, -0.5, -0.06]), rel=1e-13)


@pytest.mark.parametrize("name", ["plain", "late", "later"])
def test_an_orbit_of_several_turns_is_turned_to_its_deepest_sample(name: str) -> None:
    push, sense, offset, delay, x, v = CELLS[name]
    loop = make_loop(HAND["alpha"], HAND["beta"], HAND["kappa"], push, sense, offset, delay % 1.0)
    engine = Engine()
    orbit = engine.search(
        loop, x=x, v=v, phases=1, delay_line=int(delay) + 1 if delay else 0, max_samples=None
    ).attractors[0]
    xs, vs, _, _ = engine.trace(loop, orbit)
    levels = [*orbit.line, *(float(min(floor(at) if sense > 0.0 else ceil(at), 0)) for at in xs[:-1])]
    for begin in (0, 1, 5):
        for turns in (1, 2, 3):
            line = levels[begin : begin + len(orbit.line)]
            ring = line[1:] + line[:1]  # the oldest last
            head = len(ring) - 1 if ring else 0
            found = deepest(float(xs[begin]), float(vs[begin]), ring, head, turns * orbit.period, loop)
            assert found[:2] == (pytest.approx(orbit.x, abs=1e-9), pytest.approx(orbit.v, abs=1e-9))
            assert found[3] == orbit.period
            assert [ring[(found[2] + k) % len(ring)] for k in range(len(ring))] == list(orbit.line)


@pytest.mark.parametrize(("sense", "below", "above"), [(1.0, -2.0, -1.0), (-1.0, -3.0, -2.0)])
def test_a_level_reaches_from_edge_to_edge(sense: float, below: float, above: float) -> None:
    """Of -2, from its own edge up to the next, or down to it; that of 0 has no upper end."""
    assert (lower_edge(-2.0, sense), upper_edge(-2.0, sense)) == (below, above)
    assert (lower_edge(0.0, sense), upper_edge(0.0, sense)) == (below + 2.0, inf)
    middle = 0.5 * (below + above)
    assert level_of(middle, sense) == -2.0
    assert level_of(above if sense > 0.0 else below, sense) != -2.0
    assert level_of(5.5, sense) == 0.0


def test_an_orbit_closes_where_all_of_it_is_as_it_was() -> None:
    """Place, speed and levels under way, after a part of the samples that divides them."""
    free = make_loop(0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0)
    thrown = make_loop(0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0)
    turned = make_loop(0.0, pi * pi, 0.0, 0.0, 1.0, 0.0, 0.0)  # half a turn a sample
    assert deepest(10.0, 0.0, [], 0, 4, free) == (10.0, 0.0, 0, 1)
    assert deepest(10.0, 1.0, [], 0, 4, free) == (10.0, 1.0, 0, 4)  # it is as fast, and elsewhere
    assert deepest(10.0, 1.0, [], 0, 4, thrown)[3] == 4  # back after two samples, the other way
    assert deepest(0.5, 0.0, [], 0, 4, turned)[3] == 2
    assert deepest(0.5, 0.0, [], 0, 3, turned)[3] == 3
    ring = [-1.0, -2.0, 0.0]  # of no wall
    assert deepest(10.0, 0.0, ring, 0, 4, free) == (10.0, 0.0, 0, 4)
    assert ring == [-1.0, -2.0, 0.0]


def test_an_end_is_proven_where_it_is_new_and_kept_as_what_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    """A turn that was near is an orbit of all its turns; of what is not proven the state stays as it was found."""
    resting = (REST_PROVEN, 1, -0.5, 0.0)
    ends = [
        (CYCLE_PROVEN, 4, 1.0, 2.0),
        (CYCLE_PROVEN, 4, 1.0, 2.0),
        (CYCLE_PROVEN, 8, 3.0, 4.0),
        resting,
        (CYCLE_ON_EDGE, 6, 5.0, 6.0),
        (CYCLE_CONTINUUM, 7, 7.0, 8.0),
        (GREW, 0, 9.0, 1.0),
        resting,
    ]
    fates = iter(ends)
    asked: list[int] = []

    def certify(x: float, v: float, _ring: Any, _head: int, n: int, _loop: Any) -> Any:
        asked.append(n)
        status = DIFFERENT if n in (2, 3) else PROVEN  # half of 4, and of 6; it stays so of 6
        return status, x + 2.0**-40, v + 2.0**-41, 0.5, 0.25, 1e-12, 1e-13

    monkeypatch.setattr(ensemble, "follow", lambda *_: (*next(fates), 0, 10))
    monkeypatch.setattr(ensemble, "certify", certify)
    monkeypatch.setattr(ensemble, "deepest", lambda x, v, _ring, head, n, _loop: (x, v, head, n if n == 7 else n // 2))
    loop, table = make_loop(0.1, 0.1, 0.1, 0.1, 1.0, 0.0, 0.0), [0.0] * (ROW * 8)
    room = TrialRoom([0.0] * 3, [0.0] * 3, [], [], table, [])
    rows, overflow, samples, _ = ensemble.ensemble((1.0, 0.0), 8, 0, 8, TrialBudget(5, 100, True, 1e6), 0, room, loop)
    assert (rows, overflow, samples) == (6, 0, 8 * 15)
    numbers = [0.5, 0.25, 1e-12, 1e-13]
    assert [table[ROW * row : ROW * row + ROW] for row in range(6)] == [
        [CYCLE_PROVEN, 4, 1.0 + 2.0**-40, 2.0 + 2.0**-41, *numbers, 2.0, 30.0],
        [CYCLE_PROVEN, 4, 3.0 + 2.0**-40, 4.0 + 2.0**-41, *numbers, 1.0, 15.0],
        [REST_PROVEN, 1, -0.5, 0.0, *[0.0] * 4, 2.0, 30.0],
        [CYCLE_ON_EDGE, 6, 5.0, 6.0, *numbers, 1.0, 15.0],
        [CYCLE_CONTINUUM, 7, 7.0, 8.0, *numbers, 1.0, 15.0],
        [GREW, 0, 9.0, 1.0, *[0.0] * 4, 1.0, 15.0],
    ]
    assert asked == [2, 4, 2, 4, 4, 3, 6, 7]
