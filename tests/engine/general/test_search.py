"""What a search asks of its trials, and what it makes of their ends: by hand, with trials that do not run."""

from math import inf
from typing import Any

import pytest

from hknob_cli.engine import follow
from hknob_cli.engine.attractors import Attractor, Patience, Search
from hknob_cli.engine.budget import settling_samples
from hknob_cli.engine.general import search as module
from hknob_cli.engine.general.search import GeneralEngine
from hknob_cli.engine.general.torque_range import TorqueRange
from hknob_cli.engine.outcome import Outcome, Reason
from hknob_cli.scene.general_knob import GeneralKnob

from .bodies import knob


class Trials:
    """Takes the place of the compiled loop: notes what is asked, and ends all trials in one way."""

    def __init__(self, fate: int = follow.REST_PROVEN) -> None:
        self.fate = fate
        self.state = (0.0, 0.0)
        self.batches: list[tuple[int, int]] = []
        self.budget: Any = None

    def __call__(self, state: Any, batch: Any, budget: Any, trial: Any, body: Any, wall: Any) -> tuple[int, int]:
        self.batches.append((batch.first, batch.stop))
        self.budget = budget
        trial.counts[0] = 1
        trial.table[0] = self.fate
        trial.states[:2] = self.state
        trial.table[6] += batch.stop - batch.first
        return 0, 5 * (batch.stop - batch.first)


def searched(trials: Trials, one: GeneralKnob, start: list[float], *, patience: int = 10**9, **more: Any) -> Search:
    """The result of a search with such trials."""
    engine = GeneralEngine(patience=Patience(patience))
    engine._run_trials = trials  # type: ignore[assignment]
    numbers = {"rate": 0.01, "phases": 4, "delay_line": 0, "max_samples": None, **more}
    return engine.search(one.body, one.wall, start, **numbers)


def test_a_trial_has_grown_a_million_times_beyond_its_scale() -> None:
    """Start, static depth, or how far a hand lets it coast: speed over the root of its stiffness."""
    one = knob()
    body = one.body
    assert body.ratio == 0.0
    for start, scale in (
        ([100.0, 0.0], 100.0),
        ([0.0, 100.0], 100.0 / body.beta**0.5),
        ([0.0, 0.0], max(1.0, body.push / (one.wall.kappa + body.beta))),
    ):
        trials = Trials()
        searched(trials, one, start)
        assert trials.budget.limit == pytest.approx(1e6 * scale, rel=1e-14)


def test_a_knob_that_nothing_holds_spins_past_so_many_turns(monkeypatch: pytest.MonkeyPatch) -> None:
    """256 of a torque that repeats, and as far as damping lets it coast; without damping a million scales."""
    one = knob(hand={"inertia": 3e-7, "damping": 3.45e-4}, wall={"stiffness": 0.0}, bias={"torque": 0.0})
    assert 0.0 < one.body.alpha < 1.0
    monkeypatch.setattr(GeneralEngine, "torques", staticmethod(lambda wall: TorqueRange(-1.0, 1.0, 1000.0, 40.0)))
    trials = Trials(follow.GREW)
    # Without a spring it coasts for 1000 samples in a scale.
    (end,) = searched(trials, one, [0.0, 0.125]).attractors
    assert trials.budget.limit == pytest.approx(125.0 + 256.0 * 1000.0 + 0.125 / one.body.alpha, rel=1e-14)
    assert (end.outcome, end.reason) == (Outcome.DIVERGED, Reason.SPINS)
    monkeypatch.setattr(GeneralEngine, "torques", staticmethod(lambda wall: TorqueRange(-1.0, 1.0, 0.0, 40.0)))
    (end,) = searched(trials, one, [0.0, 0.125]).attractors
    assert trials.budget.limit == 1e6 * 125.0
    assert (end.outcome, end.reason, end.trials) == (Outcome.DIVERGED, Reason.GREW, 4)


def test_the_interpreter_follows_no_longer_than_its_patience() -> None:
    """A tenth of the plain loop's, after the samples that pass."""
    one = knob()
    skip = settling_samples(0.01, 100_000)
    assert skip == 1000
    for patience, samples, final in ((20_000, 2000 + skip, False), (10**9, 100_000, True)):
        trials = Trials()
        searched(trials, one, [0.0, 0.0], patience=patience, max_samples=100_000)
        assert (trials.budget.skip, trials.budget.samples, trials.budget.final) == (skip, samples, final)


def test_slices_grow_by_four_while_they_are_quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """And shrink to a tenth of a second where trials take long; each trial runs once."""
    for seconds, wanted in ((2.0**-10, [8, 32, 128, 512, 320]), (0.25, [8, 3, 1])):
        clock = iter(range(10**6, 2 * 10**6))
        monkeypatch.setattr(module, "perf_counter", lambda clock=clock, seconds=seconds: seconds * next(clock))
        trials = Trials()
        found = searched(trials, knob(), [0.0, 0.0], phases=1000)
        sizes = [stop - first for first, stop in trials.batches]
        assert sizes[: len(wanted)] == wanted
        assert sum(sizes) == found.attractors[0].trials == 1000
        assert found.samples == 5000


def test_each_of_several_starts_is_a_trial_at_a_sample(monkeypatch: pytest.MonkeyPatch) -> None:
    trials, starts = Trials(), [[float(k), 0.0] for k in range(3)]
    searched(trials, knob(), [2.0, 0.0], phases=3, several=starts)
    assert trials.batches == [(0, 1)] * 3


def test_compiled_code_is_given_arrays() -> None:
    """A law's torque over the angle stays what it is; lists would be copied in each call."""
    seen: list[Any] = []

    def charted(state: Any, before: Any, line: Any, period: int, body: Any, wall: Any, pad: Any, pieces: Any) -> int:
        seen.append(wall)
        pieces.spans[0] = period
        return 1

    one = knob()
    table = one.wall._replace(table=module.np.array([0.0, 1.0, -1.0, -1.0, 0.5, 0.5, 0.5]))
    names = ("general.run_trials", "general.chart_period", "general.parting_rate", "find_leak")
    orbit = Attractor(Outcome.CYCLE, Reason.NONE, 1.0, period=3)
    for engine, kind in ((GeneralEngine(dict.fromkeys(names, charted)), module.np.ndarray), (GeneralEngine(), list)):
        engine._chart = charted  # type: ignore[assignment]
        found = engine.chart(one.body, table, orbit)
        assert found is not None
        assert found.spans.tolist() == [3.0]
        assert type(seen.pop().table) is kind


def test_too_many_pieces_are_no_chart() -> None:
    """Where rows are full there are sixteen times as many, up to the most that there may be."""
    rooms: list[int] = []

    def full(*given: Any) -> int:
        rooms.append(len(given[-1].spans))
        return rooms[-1]

    engine = GeneralEngine()
    engine._chart = full  # type: ignore[assignment]
    one = knob()
    assert engine.chart(one.body, one.wall, Attractor(Outcome.CYCLE, Reason.NONE, 1.0, period=3)) is None
    assert rooms == [112, 1792, 28_672, 458_752]
    assert 16 * rooms[-1] > 4 * module.MOST_PIECES >= rooms[-1]


COGGED = {"hand": {"inertia": 3e-7, "damping": 3.45e-4}, "wall": {"stiffness": 0.0}}


def test_cogging_holds_a_knob_as_friction_does() -> None:
    """A push of 1 mN m is more than friction of 0.2, and less than that and cogging of 0.9."""
    for cogging, leaves in ((0.0, True), (7e-4, True), (9e-4, False)):
        one = knob(**COGGED, cogging={"torque": cogging, "per_revolution": 12})
        (end,) = searched(Trials(), one, [0.0, 0.0]).attractors
        assert (end.reason is Reason.LEAVES) is leaves


def test_a_knob_that_cogs_races_or_spins(monkeypatch: pytest.MonkeyPatch) -> None:
    """Spins, where a torque over the angle drives it on and on; else it has grown."""
    one = knob(**COGGED, cogging={"torque": 9e-4, "per_revolution": 12})
    for turn, reason in ((1000.0, Reason.SPINS), (0.0, Reason.RACES)):
        over = TorqueRange(-inf, inf, turn, 40.0)
        monkeypatch.setattr(GeneralEngine, "torques", staticmethod(lambda wall, over=over: over))
        (end,) = searched(Trials(follow.GREW), one, [0.0, 0.125]).attractors
        assert end.reason is reason


def test_what_is_undecided_beside_parts_can_be_followed_further() -> None:
    """It keeps the state of a trial; nobody asks for that of a knob without such parts."""
    plain = knob()
    cogged = knob(cogging={"torque": 9e-4, "per_revolution": 12})
    clock = plain._replace(wall=plain.wall._replace(clock=module.np.array([0.0, 0.5, 0.5, 7.0, 0.0, 1.0])))
    for one, kept in ((plain, False), (cogged, True), (clock, True)):
        trials = Trials(follow.UNSETTLED)
        trials.state = (3.5, -0.25)
        (end,) = searched(trials, one, [0.0, 0.0]).attractors
        assert end.outcome is Outcome.UNDECIDED
        assert (end.x, end.v) == ((3.5, -0.25) if kept else (0.0, 0.0))


def test_an_end_with_a_period_has_an_orbit() -> None:
    row = [float(follow.CYCLE_PROVEN), 12.0, 0.25, 0.125, 1e-12, 1e-13, 5.0, 0.0, 0.0, -1.0]
    found = module.attractor_of(row, [-1.5, 0.25, 9.0], [2.0, 3.0], Reason.NO_REPEAT)
    assert found == Attractor(
        Outcome.CYCLE, Reason.NONE, 5.0, 12, -1.5, 0.25, (2.0, 3.0), 0.25, 0.125, 1e-12, 1e-13, (9.0,), -1.0
    )
    assert module.attractor_of([row[0], 0.0, *row[2:]], [-1.5, 0.25], [], Reason.NO_REPEAT).period == 0
    resting = module.attractor_of(
        [float(follow.REST_PROVEN), 1.0, *row[2:7], -2.0, 1.0, -1.0], [-1.25, 0.0], [], Reason.NO_REPEAT
    )
    assert (resting.edge, resting.span) == (0.25, (-2.0, 1.0))


def test_what_is_too_fine_is_not_run() -> None:
    trials = Trials()
    found = searched(trials, knob(), [1e300, 0.0])
    assert [(end.outcome, end.reason, end.trials) for end in found.attractors] == [
        (Outcome.UNDECIDED, Reason.TOO_FINE, 4)
    ]
    assert (found.samples, trials.batches) == (0, [])


def test_a_spring_far_out_holds_as_the_walls_does(monkeypatch: pytest.MonkeyPatch) -> None:
    """A push comes to rest where wall, hand and that spring hold it."""
    one = knob()
    spring = 3.0 * (one.wall.kappa + one.body.beta)
    found = TorqueRange(-1.0, 1.0, 0.0, 0.0, spring)
    monkeypatch.setattr(GeneralEngine, "torques", staticmethod(lambda wall: found))
    trials = Trials()
    searched(trials, one._replace(body=one.body._replace(push=100.0)), [0.0, 0.0])
    assert trials.budget.limit == pytest.approx(1e6 * 25.0 / (one.wall.kappa + one.body.beta), rel=1e-12)


def test_no_trial_begins_when_the_time_is_over(monkeypatch: pytest.MonkeyPatch) -> None:
    """Those that are left have no end."""

    class Rings:
        def __init__(self, *_: Any) -> None:
            self.asked = 0

        def __enter__(self) -> "Rings":
            return self

        def __exit__(self, *_: object) -> None:
            pass

        @property
        def over(self) -> bool:
            self.asked += 1
            return self.asked > 1

    monkeypatch.setattr(module, "Alarm", Rings)
    trials = Trials()
    found = searched(trials, knob(), [0.0, 0.0], phases=20, seconds=1.0)
    assert trials.batches == [(0, 8)]
    ends = {end.reason: end.trials for end in found.attractors}
    assert ends == {Reason.NONE: 8, Reason.TIME_LIMIT: 12}


@pytest.mark.parametrize(("x", "edge"), [(-1.375, 0.375), (-0.625, 0.375), (2.125, 0.125), (-1.5, 0.5)])
def test_a_rest_is_as_far_from_an_edge_as_from_the_next_whole_number(x: float, edge: float) -> None:
    row = [float(follow.REST_PROVEN), 1.0, *[0.25] * 5, -2.0, 1.0, -1.0]
    assert module.attractor_of(row, [x, 0.0], [], Reason.NO_REPEAT).edge == edge
