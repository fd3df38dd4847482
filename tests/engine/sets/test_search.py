"""Tests of `engine.sets.search`: the same list plain and compiled, complete only where it is, given up when told."""

import numpy as np
import pytest

from hknob_cli.engine.attractors import NeedsCompilerError, Patience, StoppedError
from hknob_cli.engine.jit import compiled
from hknob_cli.engine.loop import make_loop
from hknob_cli.engine.outcome import Outcome, Reason
from hknob_cli.engine.sets.search import SAMPLED, Box, SetEngine

from .loops import knob

BOX = Box(-8.0, 8.0, -3.0, 3.0)


@pytest.fixture(scope="module")
def engines() -> tuple[SetEngine, SetEngine]:
    """Interpreted and compiled."""
    return SetEngine(), SetEngine(compiled("sets"))


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_interpreter_and_compiler_find_the_same_to_the_last_bit(
    engines: tuple[SetEngine, SetEngine], sense: float
) -> None:
    """Arcs and polygons alike."""
    plain, fast = engines
    start = {"x": 2.0, "v": 0.0, "delay_line": 0, "max_samples": None}
    assert plain.search_phases(knob(sense), **start) == fast.search_phases(knob(sense), **start)
    boxed = [one.search_box(knob(sense), BOX, max_samples=None) for one in engines]
    assert boxed[0] == boxed[1]
    assert boxed[0].complete
    assert sum(one.trials for one in boxed[0].attractors) == SAMPLED


def test_every_start_there_is(engines: tuple[SetEngine, SetEngine]) -> None:
    """The same plain and compiled; whatever the box's list has is in this one."""
    found = [one.search_anywhere(knob(), max_samples=None) for one in engines]
    assert found[0] == found[1]
    assert found[0].complete
    assert found[0].grows is None
    assert found[0].region is not None
    boxed = engines[1].search_box(knob(), BOX, max_samples=None)
    listed = {(one.period, round(one.x, 9)) for one in found[0].attractors}
    assert {(one.period, round(one.x, 9)) for one in boxed.attractors} <= listed


def test_where_every_start_need_not_come_in_the_reason_is_said(engines: tuple[SetEngine, SetEngine]) -> None:
    """Undamped, unheld, too stiff, and no time: nothing is called complete."""
    for loop, outcome, reason in (
        (make_loop(0.0, 0.08, 0.5, 0.3, 1.0, 0.0, 0.0), Outcome.UNDECIDED, Reason.NO_DAMPING),
        (make_loop(0.3, 0.0, 0.5, 0.3, 1.0, 0.0, 0.0), Outcome.UNDECIDED, Reason.NO_STIFFNESS),
        (make_loop(0.0101, 0.159, 2.01, 0.3, 1.0, 0.0, 0.0), Outcome.DIVERGED, Reason.NONE),
        (make_loop(0.251, 0.128, 542.0, 0.3, 1.0, 0.0, 0.0), Outcome.UNDECIDED, Reason.NO_REGION),
    ):
        found = engines[1].search_anywhere(loop, max_samples=None)
        assert not found.complete
        assert found.region is None
        assert (found.grows is not None) == (outcome is Outcome.DIVERGED)
        assert [(one.outcome, one.reason) for one in found.attractors] == [(outcome, reason)]
    found = engines[1].search_anywhere(knob(), max_samples=None, seconds=0.0)
    assert not found.complete
    assert [one.reason for one in found.attractors] == [Reason.TIME_LIMIT]


def test_every_start_of_a_map_ends_in_a_listed_attractor(engines: tuple[SetEngine, SetEngine]) -> None:
    """The map and the counted shares agree, to the chance of both."""
    found = engines[1].search_box(knob(), BOX, max_samples=None)
    chance = np.random.default_rng(3)
    starts = np.column_stack([chance.uniform(-8.0, 8.0, 4000), chance.uniform(-3.0, 3.0, 4000)])
    ends = engines[1].map_starts(knob(), starts, found.attractors, max_samples=None)
    assert ends.min() >= 0
    for number, one in enumerate(found.attractors):
        share = one.trials / SAMPLED
        assert abs(np.mean(ends == number) - share) < 5.0 * np.sqrt(2.0 * share * (1.0 - share) / 4000) + 1e-3


def test_an_attractor_that_is_left_out_is_found_missing(engines: tuple[SetEngine, SetEngine]) -> None:
    """Starts that end elsewhere are told apart from those that end in the list."""
    found = engines[1].search_box(knob(), BOX, max_samples=None)
    assert len(found.attractors) > 1
    starts = np.array([[one.x, one.v] for one in found.attractors])
    ends = engines[1].map_starts(knob(), starts, found.attractors[:1], max_samples=None)
    assert ends.tolist() == [0] + [-1] * (len(found.attractors) - 1)


def test_what_nothing_damps_or_holds_is_not_followed(engines: tuple[SetEngine, SetEngine]) -> None:
    """The reason is said, and nothing is called complete."""
    for alpha, beta, reason in ((0.0, 0.08, Reason.NO_DAMPING), (0.3, 0.0, Reason.NO_STIFFNESS)):
        loop = make_loop(alpha, beta, 0.5, 0.3, 1.0, 0.0, 0.0)
        found = engines[0].search_box(loop, BOX, max_samples=None)
        assert not found.complete
        assert found.undecided == 1.0
        assert [one.reason for one in found.attractors] == [reason]
        assert engines[0].search_phases(loop, x=2.0, v=0.0, delay_line=0, max_samples=None) is None


def test_an_arc_over_too_many_edges_is_left_to_trials(engines: tuple[SetEngine, SetEngine]) -> None:
    """Of two thousand counts a sample no arc is cut."""
    start = {"x": 2000.0, "v": -4000.0, "delay_line": 0, "max_samples": None}
    assert engines[0].search_phases(knob(), **start) is None


def test_no_time_means_undecided_and_says_so(engines: tuple[SetEngine, SetEngine]) -> None:
    """The random starts that were not followed are counted, with the limit as their reason."""
    found = engines[0].search_box(knob(), BOX, max_samples=None, seconds=0.0)
    assert not found.complete
    assert found.undecided == 1.0
    assert [(one.outcome, one.reason, one.trials) for one in found.attractors] == [
        (Outcome.UNDECIDED, Reason.TIME_LIMIT, SAMPLED)
    ]


def test_few_samples_leave_starts_undecided(engines: tuple[SetEngine, SetEngine]) -> None:
    """A budget that no motion settles within: nothing is complete, and a bound on the rest is given."""
    found = engines[1].search_box(knob(), BOX, max_samples=20)
    assert not found.complete
    assert 0.0 < found.undecided <= 1.0


def test_a_search_is_given_up_when_told() -> None:
    """Before the first slice."""
    with pytest.raises(StoppedError):
        SetEngine(stopped=lambda: True).search_box(knob(), BOX, max_samples=None)


def test_phases_end_with_their_time_and_when_told() -> None:
    """Between two slices: those left are undecided, with the limit as their reason; a late limit changes nothing."""
    start = {"x": 2.0, "v": 0.0, "delay_line": 0, "max_samples": None}
    found = SetEngine().search_phases(knob(), **start, seconds=0.0)
    assert found is not None
    assert not found.complete
    assert [(one.outcome, one.reason, one.trials) for one in found.attractors] == [
        (Outcome.UNDECIDED, Reason.TIME_LIMIT, 1.0)
    ]
    assert SetEngine().search_phases(knob(), **start, seconds=1e5) == SetEngine().search_phases(knob(), **start)
    with pytest.raises(StoppedError):
        SetEngine(stopped=lambda: True).search_phases(knob(), **start)


def test_the_interpreter_hands_over_phases_that_take_it_too_long() -> None:
    """Too many samples of a motion, or too much time."""
    start = {"x": 2.0, "v": 0.0, "delay_line": 0, "max_samples": None}
    for patience in (Patience(samples=20), Patience(seconds=0.0)):
        with pytest.raises(NeedsCompilerError):
            SetEngine(patience=patience).search_phases(knob(), **start)
